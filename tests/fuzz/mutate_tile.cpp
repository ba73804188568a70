// Tiles: a part of them changes (a header's table, a GLB's JSON or binary chunk, a tile within a
// cmpt), and the lengths around it follow. Now and then they do not.
#include "tests/fuzz/mutate.h"

#include <cstring>
#include <vector>

namespace gnomon::fuzz {
namespace {

std::string mutatedTile(const std::string& tile, std::size_t most, Random& random);

std::uint32_t word(const std::string& text, std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, text.data() + at, sizeof value);
    return value;
}

std::string bytesOfWord(std::uint32_t value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

bool isJson(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    return first != std::string::npos && text[first] == '{';
}

std::string mutatedPart(const std::string& part, std::size_t most, Random& random) {
    return isJson(part) ? mutatedJson(part, most, random) : mutatedBytes(part, most);
}

// JSON changes more often than what it describes.
std::string mutatedGlb(const std::string& glb, std::size_t most, Random& random) {
    if (glb.size() < 20)
        return mutatedBytes(glb, most);
    const std::size_t jsonSize = std::min<std::size_t>(word(glb, 12), glb.size() - 20);
    std::string json = glb.substr(20, jsonSize), bin;
    const std::size_t second = 20 + jsonSize;
    const bool hasBin = second + 8 <= glb.size();
    if (hasBin)
        bin = glb.substr(second + 8);
    if (!hasBin || !oneIn(random, 3))
        json = mutatedJson(json, std::min(json.size() + 256, most), random);
    else
        bin = mutatedBytes(bin, std::min(bin.size() + 64, most));
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string out = "JSON" + json;
    if (hasBin)
        out += bytesOfWord(std::uint32_t(bin.size())) + std::string("BIN\0", 4) + bin;
    return "glTF" + bytesOfWord(2) + bytesOfWord(std::uint32_t(out.size() + 16)) +
           bytesOfWord(std::uint32_t(json.size())) + out;
}

// b3dm, i3dm and pnts: four tables whose lengths follow each other, then the rest.
std::string mutatedTables(const std::string& tile, std::size_t header, std::size_t most,
                          Random& random) {
    if (tile.size() < header)
        return mutatedBytes(tile, most);
    std::vector<std::string> parts;
    std::size_t at = header;
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t size = std::min<std::size_t>(word(tile, 12 + 4 * i), tile.size() - at);
        parts.push_back(tile.substr(at, size));
        at += size;
    }
    std::string rest = tile.substr(at);
    const std::size_t chosen = random() % 6;
    const std::size_t room = std::min<std::size_t>(most, 1 << 12);
    if (chosen < 4)
        parts[chosen] = mutatedPart(parts[chosen], room, random);
    else
        rest = mutatedTile(rest, most, random);
    std::string out;
    for (const std::string& part : parts)
        out += bytesOfWord(std::uint32_t(part.size()));
    out += tile.substr(28, header - 28);
    for (const std::string& part : parts)
        out += part;
    out += rest;
    return tile.substr(0, 8) + bytesOfWord(std::uint32_t(out.size() + 12)) + out;
}

std::string mutatedComposite(const std::string& tile, std::size_t most, Random& random) {
    std::vector<std::string> tiles;
    for (std::size_t at = 16; at + 12 <= tile.size();) {
        const std::size_t size = std::clamp<std::size_t>(word(tile, at + 8), 12, tile.size() - at);
        tiles.push_back(tile.substr(at, size));
        at += size;
    }
    if (tile.size() < 16 || tiles.empty())
        return mutatedBytes(tile, most);
    const std::size_t chosen = random() % tiles.size();
    if (oneIn(random, 6))
        tiles.push_back(oneIn(random, 2) ? tile : tiles[chosen]);
    else
        tiles[chosen] = mutatedTile(tiles[chosen], most, random);
    std::string inside;
    for (const std::string& inner : tiles)
        inside += inner;
    return tile.substr(0, 8) + bytesOfWord(std::uint32_t(16 + inside.size())) +
           bytesOfWord(std::uint32_t(tiles.size())) + inside;
}

std::string mutatedTile(const std::string& tile, std::size_t most, Random& random) {
    if (oneIn(random, 5))
        return mutatedBytes(tile, most);
    if (tile.starts_with("glTF"))
        return mutatedGlb(tile, most, random);
    if (tile.starts_with("b3dm") || tile.starts_with("pnts"))
        return mutatedTables(tile, 28, most, random);
    if (tile.starts_with("i3dm"))
        return mutatedTables(tile, 32, most, random);
    if (tile.starts_with("cmpt"))
        return mutatedComposite(tile, most, random);
    return mutatedPart(tile, most, random);
}

} // namespace
} // namespace gnomon::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t maxSize, unsigned seed) {
    using namespace gnomon::fuzz;
    Random random(seed);
    const std::string tile(reinterpret_cast<const char*>(data), size);
    return giveBack(mutatedTile(tile, maxSize, random), data, maxSize);
}
