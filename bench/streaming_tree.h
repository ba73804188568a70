// What a frame of a big city asks of selection: a quadtree of any size, made in memory, and the
// views that a frame has of it.
#pragma once

#include "geo/view.h"
#include "streaming/tileset.h"

#include <cstddef>
#include <string>
#include <vector>

namespace gnomon::bench {

enum class VolumeKind { Boxes, Regions };
const char* nameOf(VolumeKind kind);

// A city on a square, its leaves 128 m wide: filled level by level until there are so many tiles
// (less than four more). The errors are those of the built-in place: 4 m above the leaves, doubling
// upwards. Every tile has content, replaced by its children's; all of it counts as loaded.
Result<TileTree> cityTree(std::size_t tiles, VolumeKind kind);

// The camera's view, then those of four cascades, as a frame has them.
struct FrameViews {
    std::string name;
    std::vector<View> views;
    double maximumScreenSpaceError = 16.0;
};
// From the street, from over the roofs, and of the whole city to the last leaf, which visits every
// tile that there is.
std::vector<FrameViews> cityViews(const TileTree& tree);

} // namespace gnomon::bench
