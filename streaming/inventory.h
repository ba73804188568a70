// All there is in a tileset, for `gnomon info`: reads every subtree and external tileset and
// decodes every content once, keeping none of it.
#pragma once

#include "streaming/loader.h"

#include <functional>
#include <map>
#include <set>

namespace gnomon {

struct Inventory {
    std::uint64_t tiles = 0;
    std::uint32_t subtrees = 0, externals = 0;
    std::map<std::string, std::uint64_t> contents; // by format, only those that could be decoded
    std::vector<FailedTile> failures;              // unreadable or unusable
    std::uint32_t levels = 0;
    std::set<Refine> refine;
    std::optional<Region> bounds; // of the decoded vertices; none when not near the Earth's surface
    // Sums over the contents.
    std::uint64_t triangles = 0, duplicates = 0, degenerate = 0, invalid = 0, closedTriangles = 0;
    std::uint64_t components = 0, closedComponents = 0;
    std::uint64_t decodedBytes = 0;
    glm::dvec3 areaVector{0.0};
    std::set<std::string> extensions, copyrights;
    // What the contents tell of their features, by class (batch tables: ""): how many rows, over
    // all tiles, and the properties, in the order they were first met.
    struct Features {
        std::uint64_t rows = 0;
        std::vector<std::string> properties;
    };
    std::map<std::string, Features> features;
    std::vector<std::string> warnings; // the tileset's, then the contents' by tile
};

using Progress = std::function<void(std::size_t done, std::size_t total)>;

// Reads all subtrees and external tilesets, round by round. The error is for a tree that is too
// large to be read whole; a file that fails is in failures().
Failure expandAll(StreamedTileset& tileset);
Inventory takeInventory(StreamedTileset& tileset, const Progress& progress);

} // namespace gnomon
