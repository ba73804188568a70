#include "tests/faults/served_file.h"

#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <zlib.h>

namespace gnomon::test {

namespace {

constexpr int kGzip = 15 + 16; // zlib: the largest window, gzip's head and tail around it
constexpr int kNoWrapping = -15;

// One member of deflate's state; ends with `flush`.
std::string deflated(const std::string& bytes, int windowBits, int flush) {
    z_stream stream{};
    if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, windowBits, 9, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::runtime_error("zlib");
    std::string out(deflateBound(&stream, uLong(bytes.size())) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = uInt(out.size());
    deflate(&stream, flush);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

void append32(std::string& out, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        out += char(value >> (8 * i) & 0xff);
}

// Each block is flushed fully, so that it stands for itself and can be repeated.
std::string makeBomb() {
    constexpr std::size_t kBlock = std::size_t(16) << 20;
    constexpr int kBlocks = 256;
    const std::string zeros(kBlock, '\0');
    const std::string block = deflated(zeros, kNoWrapping, Z_FULL_FLUSH);
    std::string out("\x1f\x8b\x08\0\0\0\0\0\0\xff", 10);
    for (int i = 0; i < kBlocks; ++i)
        out += block;
    out += deflated("", kNoWrapping, Z_FINISH);
    const uLong one = crc32(0, reinterpret_cast<const Bytef*>(zeros.data()), uInt(kBlock));
    uLong all = one;
    for (int i = 1; i < kBlocks; ++i)
        all = crc32_combine(all, one, z_off_t(kBlock));
    append32(out, std::uint32_t(all));
    append32(out, std::uint32_t(kBlock * kBlocks)); // modulo 2^32, as the format says
    return out;
}

std::string typeOf(const std::filesystem::path& path) {
    static const std::unordered_map<std::string, std::string> kTypes = {
        {".json", "application/json"}, {".glb", "model/gltf-binary"},
        {".gltf", "model/gltf+json"},  {".png", "image/png"},
        {".jpg", "image/jpeg"},        {".terrain", "application/vnd.quantized-mesh"}};
    const auto found = kTypes.find(path.extension().string());
    return found == kTypes.end() ? "application/octet-stream" : found->second;
}

} // namespace

std::string packedAsGzip(const std::string& bytes) {
    return deflated(bytes, kGzip, Z_FINISH);
}

const std::string& gzipBomb() {
    static const std::string bomb = makeBomb();
    return bomb;
}

const std::string& ServedFile::packed() {
    std::call_once(once_, [&] { packed_ = packedAsGzip(bytes); });
    return packed_;
}

std::shared_ptr<ServedFile> ServedFiles::find(const std::string& path) {
    const std::filesystem::path full = folder_ / path;
    std::error_code error;
    if (!std::filesystem::is_regular_file(full, error))
        return nullptr;
    const auto changed = std::filesystem::last_write_time(full, error);
    const auto size = std::filesystem::file_size(full, error);
    const std::lock_guard lock(mutex_);
    Known& known = known_[path];
    if (known.file && known.changed == changed && known.size == size)
        return known.file;
    auto file = std::make_shared<ServedFile>();
    std::ostringstream text;
    text << std::ifstream(full, std::ios::binary).rdbuf();
    file->bytes = std::move(text).str();
    file->type = typeOf(full);
    const uLong sum =
        crc32(0, reinterpret_cast<const Bytef*>(file->bytes.data()), uInt(file->bytes.size()));
    char tag[64];
    // Weak: the packed and the plain file share it.
    std::snprintf(tag, sizeof tag, "W/\"%08lx-%zu\"", (unsigned long)sum, file->bytes.size());
    file->tag = tag;
    known = {changed, size, file};
    return file;
}

} // namespace gnomon::test
