// Which tiles these views need: a pure function of the tree (and its load states) and the views. No
// I/O, no clock, no GL; the same input gives the same selection.
//
// Depth first, one pass, the worst view wins. REPLACE never shows a hole: until everything below is
// ready, the tile itself is drawn. After Schütz, "cesium-native selection", and 3D Tiles 1.1.
#pragma once

#include "geo/view.h"
#include "streaming/tileset.h"

#include <span>
#include <vector>

namespace gnomon {

struct SelectOptions {
    double maximumScreenSpaceError = 16.0;
};

struct LoadRequest {
    TileIndex tile = kNoTile;
    double priority = 0.0; // smaller is more urgent
};

struct Selection {
    std::vector<TileIndex> draw;   // ready tiles with a mesh, ascending
    std::vector<LoadRequest> load; // most urgent first; empty when the views are complete
    std::vector<TileIndex> failed; // wanted, but failed for good, ascending
    std::uint32_t visited = 0;     // tiles looked at

    bool complete() const { return load.empty(); }
};

Selection select(const TileTree& tree, std::span<const View> views, const SelectOptions& options);

} // namespace gnomon
