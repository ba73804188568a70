// Which tiles these views need: a pure function of the tree (and its load states) and the views. No
// I/O, no clock, no GL; the same input gives the same selection.
//
// Depth first, one pass, the worst view wins. REPLACE never shows a hole: until everything below is
// ready, the tile itself is drawn. After Schütz, "cesium-native selection", and 3D Tiles 1.1.
// Tiles with nothing of their own to show (no content, failed content, a tileset or subtree to be
// read) are looked through: what lies below stands for them.
#pragma once

#include "geo/view.h"
#include "streaming/tileset.h"

#include <span>
#include <vector>

namespace gnomon {

struct SelectOptions {
    double maximumScreenSpaceError = 16.0;
    // Also loads coarser tiles to stand in until the finer ones are there: for a window. A capture
    // waits for the finished picture and wants nothing else.
    bool loadAncestors = false;
};

struct LoadRequest {
    TileIndex tile = kNoTile;
    double priority = 0.0; // smaller is more urgent
};

struct Selection {
    std::vector<TileIndex> draw;   // ready tiles with a mesh, ascending
    std::vector<TileIndex> wanted; // what the finished picture shows, ready or not, ascending
    std::vector<LoadRequest> load; // most urgent first; empty when the views are complete
    std::vector<TileIndex> failed; // wanted, but failed for good, ascending
    // `draw` depth first in the files' own order, which does not depend on what was read before.
    std::vector<TileIndex> drawDepthFirst;
    std::uint32_t visited = 0; // tiles looked at

    bool complete() const { return load.empty(); }
};

// At most 32 views. The first is the camera's: a tile with a viewerRequestVolume is there, also for
// the lights, only while that eye is inside of it.
inline constexpr std::size_t kMaxViews = 32;
Selection select(const TileTree& tree, std::span<const View> views, const SelectOptions& options);

} // namespace gnomon
