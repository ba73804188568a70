// For rasters too large to be read at opening: what tiles span and how far off they are, from their
// coarse samples and a few looks at the whole.
#pragma once

#include "streaming/terrain/height_scan.h"

namespace gnomon {

// Tiles of this level are looked at as a whole once they are needed: 2048 x 2048 pixels.
inline constexpr int kWholeTileLevel = 4;

struct HeightEstimate {
    std::vector<LevelTiles> levels; // from kWholeTileLevel up; empty below
    std::vector<double> usualError; // by level: the largest seen
    double dataShare = 0;
};

Result<HeightEstimate> estimateHeights(const Raster& raster, const HeightLevels& levels,
                                       const CoarseHeights& coarse);

} // namespace gnomon
