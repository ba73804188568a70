#include "streaming/terrain/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

namespace gnomon {

bool isGzip(std::span<const std::byte> bytes) {
    return bytes.size() >= 2 && bytes[0] == std::byte(0x1f) && bytes[1] == std::byte(0x8b);
}

Result<Bytes> gunzip(std::span<const std::byte> bytes, std::size_t mostBytes,
                     const std::string& name) {
    z_stream stream{};
    constexpr int kGzipOnly = 16 + MAX_WBITS;
    if (inflateInit2(&stream, kGzipOnly) != Z_OK)
        return Error{name, "zlib does not start", ErrorKind::Transient};
    Bytes out;
    int status = bytes.size() <= std::numeric_limits<uInt>::max() ? Z_OK : Z_DATA_ERROR;
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    while (status == Z_OK && out.size() < mostBytes) {
        constexpr std::size_t kFirst = std::size_t(1) << 16;
        const std::size_t done = out.size();
        out.resize(std::min(mostBytes, std::max({kFirst, 4 * bytes.size(), 2 * done})));
        const std::size_t room =
            std::min<std::size_t>(out.size() - done, std::numeric_limits<uInt>::max());
        stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
        stream.avail_out = uInt(room);
        status = inflate(&stream, Z_NO_FLUSH);
        out.resize(done + room - stream.avail_out);
        if (status == Z_OK && stream.avail_in == 0 && stream.avail_out > 0)
            status = Z_BUF_ERROR; // no more to come
    }
    inflateEnd(&stream);
    if (status == Z_OK)
        return Error{name, "unpacks to more than " + std::to_string(mostBytes >> 20) + " MiB"};
    if (status != Z_STREAM_END)
        return Error{name, status == Z_BUF_ERROR ? "is compressed and cut short"
                                                 : "is compressed, but not as gzip should be"};
    return out;
}

} // namespace gnomon
