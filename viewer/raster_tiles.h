// A raster of heights as a small tileset in memory, a block of cells a tile: what shows terrain
// until it is streamed. Two triangles a cell between the centres of its pixels; none where a corner
// has no data.
#pragma once

#include "streaming/source.h"
#include "viewer/scene.h"
#include "viewer/scene_placement.h"

#include <memory>
#include <string>
#include <vector>

namespace gnomon {

// No more triangles than this: larger rasters are shown by every second, third… pixel.
inline constexpr std::uint64_t kMostRasterTriangles = 4'000'000;

struct RasterTiles {
    std::shared_ptr<const Source> source;
    std::string path; // of the tileset in it
    std::string crs;  // the raster's, or the one given
    int columns = 0, rows = 0;
    std::vector<Problem> notes; // what was taken for granted
};

// `placing` gives what the file lacks: its system (--crs), what its heights are above, how far to
// raise it.
Result<RasterTiles> rasterTiles(const std::string& path, const PlacingOptions& placing,
                                std::uint64_t mostTriangles = kMostRasterTriangles);

} // namespace gnomon
