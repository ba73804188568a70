// One look at all heights of a raster, or of a window of it: what each tile of each level spans,
// by how much it differs from the raster itself, and a coarse copy to cut coarse tiles from.
#pragma once

#include "streaming/terrain/height_levels.h"
#include "streaming/terrain/raster.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

namespace gnomon {

struct TileHeights {
    float low = std::numeric_limits<float>::infinity();
    float high = -std::numeric_limits<float>::infinity();
    // The largest difference between the tile's surface and the raster's (linear on its finest
    // triangles) where both are.
    float error = 0.0f;
    bool rim = false;     // somewhere one of the two has ground and the other has not
    bool surface = false; // the raster has a triangle there
    void add(const TileHeights& other);
};

// The tiles of one level in a window.
struct LevelTiles {
    glm::ivec2 first{0, 0}, count{0, 0};
    std::vector<TileHeights> tiles; // row by row

    TileHeights& at(glm::ivec2 tile) { return tiles[indexOf(tile)]; }
    const TileHeights& at(glm::ivec2 tile) const { return tiles[indexOf(tile)]; }
    std::size_t indexOf(glm::ivec2 tile) const {
        return std::size_t(tile.y - first.y) * std::size_t(count.x) + std::size_t(tile.x - first.x);
    }
};

// Samples of one level, of the whole raster.
struct CoarseHeights {
    int level = 0;
    LevelGrid grid;
    std::vector<float> heights;

    float at(int column, int row) const {
        return heights[std::size_t(row) * std::size_t(grid.across.samples()) + std::size_t(column)];
    }
};

struct HeightScan {
    std::vector<LevelTiles> levels; // from 0
    CoarseHeights coarse;           // empty after a scan of a window
    std::uint64_t pixelsWithData = 0;
};

// At most this many samples are kept: 24 MiB.
inline constexpr std::int64_t kMostCoarseSamples = std::int64_t(6) << 20;
int coarseLevel(const HeightLevels& levels);

// The whole raster, `threads` at a time. `progress` is called on this thread.
Result<HeightScan> scanHeights(const Raster& raster, const HeightLevels& levels, unsigned threads,
                               const std::function<void(double)>& progress);
// A piece of a raster in memory, from a tile's first pixel to a tile's last: levels 0 to `level`.
struct HeightWindow;
HeightScan scanWindow(const HeightWindow& window, const HeightLevels& levels, int level);
// What lies in one tile of `level`, levels 0 to `level` of it.
Result<HeightScan> scanTile(const Raster& raster, const HeightLevels& levels, int level,
                            glm::ivec2 tile);

} // namespace gnomon
