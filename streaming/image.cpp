#include "streaming/image.h"

#include "streaming/source.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <webp/decode.h>

#include <array>
#include <cstring>
#include <optional>

namespace gnomon {

namespace {

using Span = std::span<const std::byte>;

struct Size {
    std::uint32_t width = 0, height = 0;
};

unsigned at(Span bytes, std::size_t i) {
    return std::to_integer<unsigned>(bytes[i]);
}

bool startsWith(Span bytes, std::size_t offset, const char* text, std::size_t length) {
    return bytes.size() >= offset + length && std::memcmp(bytes.data() + offset, text, length) == 0;
}

std::uint32_t bigEndian32(Span b, std::size_t i) {
    return at(b, i) << 24 | at(b, i + 1) << 16 | at(b, i + 2) << 8 | at(b, i + 3);
}

std::array<std::uint32_t, 256> makeCrcTable() {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t n = 0; n < 256; ++n) {
        std::uint32_t c = n;
        for (int k = 0; k < 8; ++k) {
            c = c & 1u ? 0xedb88320u ^ (c >> 1) : c >> 1;
        }
        table[n] = c;
    }
    return table;
}

std::uint32_t crc32(Span bytes) {
    static const std::array<std::uint32_t, 256> table = makeCrcTable();
    std::uint32_t crc = 0xffffffffu;
    for (const std::byte b : bytes) {
        crc = table[(crc ^ std::to_integer<std::uint32_t>(b)) & 0xffu] ^ (crc >> 8);
    }
    return ~crc;
}

// The chunks that carry the picture, checked; the others (profiles, text, times) only feed more of
// libpng with what we would not use.
Bytes essentialPng(Span bytes) {
    Bytes out(bytes.begin(), bytes.begin() + 8);
    std::size_t offset = 8;
    bool data = false;
    while (bytes.size() - offset >= 12) {
        const std::uint64_t length = bigEndian32(bytes, offset);
        if (length > bytes.size() - offset - 12) {
            break;
        }
        const std::size_t whole = std::size_t(length) + 12;
        const Span chunk = bytes.subspan(offset, whole);
        if (crc32(chunk.subspan(4, std::size_t(length) + 4)) != bigEndian32(chunk, whole - 4)) {
            throw BadContent{"PNG image with a wrong checksum"};
        }
        const bool end = startsWith(chunk, 4, "IEND", 4);
        data = data || startsWith(chunk, 4, "IDAT", 4);
        for (const char* kept : {"IHDR", "PLTE", "tRNS", "IDAT", "IEND"}) {
            if (startsWith(chunk, 4, kept, 4)) {
                out.insert(out.end(), chunk.begin(), chunk.end());
            }
        }
        if (end && data) {
            return out;
        }
        offset += whole;
    }
    throw BadContent{"PNG image cut short"};
}

std::optional<Size> pngSize(Span b) {
    if (b.size() < 33 || !startsWith(b, 12, "IHDR", 4)) {
        return {};
    }
    return Size{bigEndian32(b, 16), bigEndian32(b, 20)};
}

// Marker segments up to the first start of frame.
std::optional<Size> jpegSize(Span b) {
    std::size_t i = 2;
    while (i + 9 < b.size()) {
        if (at(b, i) != 0xff) {
            return {};
        }
        const unsigned marker = at(b, i + 1);
        if (marker == 0xff) {
            ++i;
            continue;
        }
        const bool frame =
            marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (frame) {
            return Size{at(b, i + 7) << 8 | at(b, i + 8), at(b, i + 5) << 8 | at(b, i + 6)};
        }
        const std::size_t length = at(b, i + 2) << 8 | at(b, i + 3);
        i += 2 + length;
    }
    return {};
}

// libjpeg makes up what is missing, so a file cut short is found by its end mark.
bool jpegEnds(Span b) {
    for (std::size_t i = b.size(); i >= 2; --i) {
        if (at(b, i - 2) == 0xff && at(b, i - 1) == 0xd9) {
            return true;
        }
    }
    return false;
}

// The library's words, which may go over several lines.
[[noreturn]] void refuse(const char* plugin, std::string words) {
    while (!words.empty() && (words.back() == '\n' || words.back() == ' ')) {
        words.pop_back();
    }
    for (char& c : words) {
        c = static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
    throw BadContent{std::string(plugin) + " image: " + words.substr(0, 200)};
}

// What the libraries hold of the whole picture beside the pixels that are asked for, in bytes a
// pixel: of an interlaced PNG all samples, of a JPEG in several scans all coefficients (16 bits
// each).
std::uint64_t pngScratch(Span b) {
    const bool interlaced = at(b, 28) != 0;
    return interlaced ? 8 : 0; // four samples of 16 bits at most
}

std::uint64_t jpegScratch(Span b) {
    constexpr std::uint64_t kMostComponents = 4;
    std::size_t scans = 0;
    for (std::size_t i = 0; i + 1 < b.size(); ++i) {
        scans += at(b, i) == 0xff && at(b, i + 1) == 0xda;
    }
    // A progressive JPEG may go over its whole picture again and again, for some 50 bytes a time.
    // No encoder's script has more than a few dozen scans. (Counted too: a thumbnail's.)
    constexpr std::size_t kMostScans = 100;
    if (scans > kMostScans) {
        throw BadContent{"JPEG image of " + std::to_string(scans) + " scans; at most " +
                         std::to_string(kMostScans) + " are read"};
    }
    return scans > 1 ? 2 * kMostComponents : 0;
}

struct Format {
    const char* plugin;
    std::optional<Size> (*size)(Span);
    std::uint64_t (*scratchBytesPerPixel)(Span);
};

Format formatOf(Span bytes) {
    switch (sniffImage(bytes)) {
    case ImageFormat::Png:
        return {"png", pngSize, pngScratch};
    case ImageFormat::Jpeg:
        return {"jpeg", jpegSize, jpegScratch};
    default:
        throw BadContent{"image is neither PNG, JPEG nor WebP"};
    }
}

void checkSize(const Size& size, std::size_t fileBytes) {
    const std::uint64_t decoded = std::uint64_t(size.width) * size.height * 4;
    const std::string named = std::to_string(size.width) + " x " + std::to_string(size.height);
    if (size.width < 1 || size.height < 1 || size.width > unsigned(kMaxImageSide) ||
        size.height > unsigned(kMaxImageSide)) {
        throw BadContent{"image of " + named + " pixels; 1 to " + std::to_string(kMaxImageSide) +
                         " a side are read"};
    }
    // One plain colour packs a thousandfold honestly; only where it would hurt is it a bomb.
    constexpr std::uint64_t kHarmless = std::uint64_t(16) << 20, kMaxRatio = 200;
    if (decoded > kHarmless && decoded / kMaxRatio > fileBytes) {
        throw BadContent{"image of " + named + " pixels in only " + std::to_string(fileBytes) +
                         " bytes"};
    }
}

const char* wordsOf(VP8StatusCode status) {
    switch (status) {
    case VP8_STATUS_NOT_ENOUGH_DATA:
    case VP8_STATUS_SUSPENDED:
        return "cut short";
    case VP8_STATUS_UNSUPPORTED_FEATURE:
        return "of a kind that is not supported";
    case VP8_STATUS_OUT_OF_MEMORY:
        return "that does not fit into memory";
    default:
        return "that is malformed";
    }
}

void checkWebp(VP8StatusCode status) {
    if (status != VP8_STATUS_OK) {
        throw BadContent{std::string("WebP image ") + wordsOf(status)};
    }
}

// By libwebp itself: OpenImageIO gives its colours multiplied by their alpha, whatever it is asked.
Image decodeWebp(Span bytes, ByteBudget& budget) {
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    WebPDecoderConfig config;
    if (!WebPInitDecoderConfig(&config)) {
        throw BadContent{"WebP images cannot be read by this build"};
    }
    checkWebp(WebPGetFeatures(data, bytes.size(), &config.input));
    if (config.input.has_animation) {
        throw BadContent{"animated WebP image, which is not supported"};
    }
    const Size size{std::uint32_t(config.input.width), std::uint32_t(config.input.height)};
    checkSize(size, bytes.size());
    const std::uint64_t pixels = std::uint64_t(size.width) * size.height;
    budget.take(pixels, 4, "image");
    ByteBudget during = budget;
    during.take(pixels, 5, "image"); // its own pixels when lossless, and a plane of alpha
    Image image{config.input.width, config.input.height, {}};
    image.rgba.resize(std::size_t(pixels) * 4);
    config.output.colorspace = MODE_RGBA; // not premultiplied
    config.output.is_external_memory = 1;
    config.output.u.RGBA.rgba = image.rgba.data();
    config.output.u.RGBA.stride = image.width * 4;
    config.output.u.RGBA.size = image.rgba.size();
    const VP8StatusCode status = WebPDecode(data, bytes.size(), &config);
    WebPFreeDecBuffer(&config.output);
    checkWebp(status);
    return image;
}

// Grey, grey and alpha, RGB or RGBA to RGBA, from the last pixel to the first, in place.
void widen(std::vector<std::uint8_t>& rgba, std::size_t pixels, int channels) {
    for (std::size_t i = pixels; i-- > 0;) {
        std::array<std::uint8_t, 4> in{0, 0, 0, 255};
        std::memcpy(in.data(), &rgba[i * std::size_t(channels)], std::size_t(channels));
        const std::uint8_t alpha = channels == 2 ? in[1] : channels == 4 ? in[3] : 255;
        if (channels < 3) {
            in[1] = in[2] = in[0];
        }
        in[3] = alpha;
        std::memcpy(&rgba[i * 4], in.data(), 4);
    }
}

} // namespace

ImageFormat sniffImage(Span bytes) {
    if (startsWith(bytes, 0, "\x89PNG\r\n\x1a\n", 8)) {
        return ImageFormat::Png;
    }
    if (startsWith(bytes, 0, "\xff\xd8\xff", 3)) {
        return ImageFormat::Jpeg;
    }
    if (startsWith(bytes, 0, "RIFF", 4) && startsWith(bytes, 8, "WEBP", 4)) {
        return ImageFormat::Webp;
    }
    if (startsWith(bytes, 0, "\xabKTX 20\xbb\r\n\x1a\n", 12)) {
        return ImageFormat::Ktx2;
    }
    return ImageFormat::Unknown;
}

Image decodeImage(Span bytes, ByteBudget& budget) {
    if (sniffImage(bytes) == ImageFormat::Webp) {
        return decodeWebp(bytes, budget);
    }
    const Format format = formatOf(bytes);
    const std::optional<Size> size = format.size(bytes);
    if (!size) {
        throw BadContent{std::string(format.plugin) + " image without a readable header"};
    }
    checkSize(*size, bytes.size());
    const std::uint64_t pixelCount = std::uint64_t(size->width) * size->height;
    budget.take(pixelCount, 4, "image");
    ByteBudget during = budget;
    during.take(pixelCount * format.scratchBytesPerPixel(bytes), 1, "image");

    Bytes cleaned;
    if (sniffImage(bytes) == ImageFormat::Png) {
        cleaned = essentialPng(bytes);
        bytes = cleaned;
    } else if (sniffImage(bytes) == ImageFormat::Jpeg && !jpegEnds(bytes)) {
        throw BadContent{"JPEG image cut short"};
    }

    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
    OIIO::Filesystem::IOProxy* proxy = &memory;
    OIIO::ImageSpec config, spec;
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    config.attribute("oiio:UnassociatedAlpha", 1); // glTF's alpha is not premultiplied
    const auto input = OIIO::ImageInput::create(format.plugin);
    if (!input) {
        throw BadContent{std::string(format.plugin) + " images cannot be read by this build"};
    }
    input->threads(1); // the callers have threads of their own
    const std::string name = std::string("memory.") + format.plugin;
    if (!input->open(name, spec, config)) {
        refuse(format.plugin, input->geterror());
    }
    if (spec.width != int(size->width) || spec.height != int(size->height) || spec.depth > 1 ||
        spec.nchannels < 1 || spec.nchannels > 4) {
        throw BadContent{std::string(format.plugin) + " image that contradicts its own header"};
    }
    Image image{spec.width, spec.height, {}};
    const std::size_t pixels = std::size_t(spec.width) * std::size_t(spec.height);
    image.rgba.resize(pixels * 4);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, image.rgba.data())) {
        refuse(format.plugin, input->geterror());
    }
    if (spec.nchannels < 4) {
        widen(image.rgba, pixels, spec.nchannels);
    }
    return image;
}

} // namespace gnomon
