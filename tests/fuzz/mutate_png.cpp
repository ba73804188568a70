// PNG: a chunk changes, its length and checksum follow. Else libFuzzer's own.
#include "tests/fuzz/mutate.h"

#include <vector>

#include <zlib.h>

namespace gnomon::fuzz {
namespace {

constexpr const char* kMagic = "\x89PNG\r\n\x1a\n";

std::uint32_t bigEndian(const std::string& text, std::size_t at) {
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i)
        word = word << 8 | static_cast<unsigned char>(text[at + i]);
    return word;
}

void putBig(std::string& out, std::uint32_t word) {
    for (int shift = 24; shift >= 0; shift -= 8)
        out.push_back(char(word >> shift & 0xffu));
}

// Type and data of each chunk.
std::vector<std::string> chunksOf(const std::string& png) {
    std::vector<std::string> chunks;
    for (std::size_t at = 8; at + 12 <= png.size();) {
        const std::size_t size = std::min<std::size_t>(bigEndian(png, at), png.size() - at - 12);
        chunks.push_back(png.substr(at + 4, 4 + size));
        at += 12 + size;
    }
    return chunks;
}

std::string inflated(const std::string& data) {
    std::string out(std::size_t(1) << 18, '\0');
    uLongf size = out.size();
    const int code = uncompress(reinterpret_cast<Bytef*>(out.data()), &size,
                                reinterpret_cast<const Bytef*>(data.data()), data.size());
    out.resize(code == Z_OK ? size : 0);
    return out;
}

std::string deflated(const std::string& data) {
    std::string out(compressBound(data.size()), '\0');
    uLongf size = out.size();
    compress2(reinterpret_cast<Bytef*>(out.data()), &size,
              reinterpret_cast<const Bytef*>(data.data()), data.size(), 1);
    out.resize(size);
    return out;
}

std::string mutatedPng(const std::string& png, std::size_t most, Random& random) {
    std::vector<std::string> chunks = chunksOf(png);
    if (chunks.empty())
        return mutatedBytes(png, most);
    const std::size_t i = random() % chunks.size();
    const std::size_t room = chunks[i].size() + 64;
    if (oneIn(random, 8)) {
        chunks.insert(chunks.begin() + std::ptrdiff_t(i), chunks[random() % chunks.size()]);
    } else if (chunks[i].starts_with("IDAT") && !oneIn(random, 3)) {
        const std::string pixels = inflated(chunks[i].substr(4));
        chunks[i] = "IDAT" + deflated(mutatedBytes(pixels, pixels.size() + 64));
    } else {
        chunks[i] = chunks[i].substr(0, 4) + mutatedBytes(chunks[i].substr(4), room);
    }
    std::string out(kMagic, 8);
    for (const std::string& chunk : chunks) {
        putBig(out, std::uint32_t(chunk.size() - 4));
        out += chunk;
        putBig(out, std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(chunk.data()),
                                        uInt(chunk.size()))));
    }
    return out;
}

} // namespace
} // namespace gnomon::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed) {
    using namespace gnomon::fuzz;
    Random random(seed);
    const std::string file(reinterpret_cast<const char*>(data), size);
    const bool png = file.starts_with(std::string(kMagic, 8)) && !oneIn(random, 4);
    return giveBack(png ? mutatedPng(file, maxSize, random) : mutatedBytes(file, maxSize), data,
                    maxSize);
}
