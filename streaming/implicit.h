// Implicit tiling inside the tree: what a tile's `implicitTiling` says, and the volumes it implies.
#pragma once

#include "streaming/tileset.h"

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

// Coordinates stay below 2^31.
inline constexpr std::uint32_t kMaxImplicitLevels = 31;

struct ImplicitTiling {
    Subdivision subdivision = Subdivision::Quadtree;
    unsigned subtreeLevels = 1;
    std::uint32_t availableLevels = 1;
    std::string subtreeUri;               // templates, relative to `documentPath`
    std::vector<std::string> contentUris; // one for each content a tile may have
    std::string documentPath;
    BoundingVolume rootVolume; // a box or a region
    double rootGeometricErrorMetres = 0.0;
    // The root's volume in a curved frame's own coordinates, where the tree has one.
    std::optional<BoundingVolume> flatVolume = {};
};

// The tile's part of the root's volume: halves in each direction at each level, heights only in an
// octree. From the root at once, so that no error adds up over the levels.
BoundingVolume implicitVolume(const BoundingVolume& rootVolume, Subdivision subdivision,
                              std::uint32_t level, std::uint32_t x, std::uint32_t y,
                              std::uint32_t z);

} // namespace gnomon
