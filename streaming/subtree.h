// A subtree file of implicit tiling (3D Tiles 1.1, and the 3DTILES_implicit_tiling extension before
// it): which tiles, contents and child subtrees there are. Binary ("subt") or plain JSON.
#pragma once

#include "streaming/source.h"
#include "streaming/tileset.h"

#include <functional>
#include <span>

namespace gnomon {

// One bit an element, least significant first, or the same answer for all.
struct Availability {
    std::vector<std::byte> bits; // empty when constant
    bool constant = false;

    bool operator[](std::uint64_t i) const {
        return bits.empty() ? constant : ((unsigned(bits[i / 8]) >> (i % 8)) & 1u) != 0;
    }
    // Among the first `count`.
    std::uint64_t available(std::uint64_t count) const;
};

struct Subtree {
    Availability tiles;                 // by level, in Morton order (x lowest) within a level
    std::vector<Availability> contents; // one for each content a tile may have
    Availability children;              // child subtrees, in Morton order
};

// Tiles in a subtree, and child subtrees below it; nullopt where the tiles' bits alone would take
// more than kMaxSubtreeBits.
struct SubtreeSize {
    std::uint64_t tiles = 0, children = 0;
};
inline constexpr std::uint64_t kMaxSubtreeBits = std::uint64_t(1) << 26; // 8 MB of availability
std::optional<SubtreeSize> subtreeSize(Subdivision subdivision, std::int64_t levels);
inline constexpr unsigned childrenOf(Subdivision s) {
    return s == Subdivision::Octree ? 8 : 4;
}

// `readUri` reads an external buffer the file names; without it external buffers are an error.
Result<Subtree> parseSubtree(std::span<const std::byte> bytes, const std::string& path,
                             Subdivision subdivision, unsigned levels,
                             const std::function<Result<Bytes>(const std::string& uri)>& readUri);

} // namespace gnomon
