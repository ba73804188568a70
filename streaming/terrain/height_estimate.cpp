#include "streaming/terrain/height_estimate.h"

#include "streaming/terrain/height_error.h"

#include <glm/common.hpp>

#include <cmath>

namespace gnomon {

namespace {

// Single cells of the coarse level, looked at in full.
constexpr int kLooks = 64;

// Visits all residues of any count: a full period of Weyl's sequence by the golden ratio.
std::size_t spread(std::size_t i, std::size_t count) {
    const double x = double(i) * 0.6180339887498949;
    return std::min(std::size_t((x - std::floor(x)) * double(count)), count - 1);
}

Failure lookAtCells(const Raster& raster, const HeightLevels& levels, const CoarseHeights& coarse,
                    std::vector<double>& usual) {
    const LevelGrid& grid = coarse.grid;
    std::vector<glm::ivec2> whole; // cells with data at all corners
    for (int y = 0; y < grid.down.cells(); ++y)
        for (int x = 0; x < grid.across.cells(); ++x)
            if (!std::isnan(coarse.at(x, y) + coarse.at(x + 1, y) + coarse.at(x, y + 1) +
                            coarse.at(x + 1, y + 1)))
                whole.emplace_back(x, y);
    for (std::size_t i = 0; i < std::size_t(kLooks) && !whole.empty(); ++i) {
        const glm::ivec2 cell = whole[spread(i + 1, whole.size())];
        const glm::ivec2 first(grid.across.position(cell.x), grid.down.position(cell.y));
        const glm::ivec2 last(grid.across.position(cell.x + 1), grid.down.position(cell.y + 1));
        const glm::ivec2 size = last - first + 1;
        if (size.x < 2 || size.y < 2)
            continue;
        const Result<std::vector<float>> heights = raster.read(first.x, first.y, size.x, size.y);
        if (!heights)
            return heights.error();
        const HeightWindow window{first, size, heights->data()};
        const bool complete = isComplete(window, first, last);
        for (int level = 1; level <= coarse.level; ++level) {
            TileHeights found;
            addError(window, levels, level, first, last, complete, found);
            double& most = usual[std::size_t(level)];
            most = std::max(most, double(found.error));
        }
    }
    return {};
}

// Tiles smaller than those of the coarse samples' own first level: from the samples in them.
LevelTiles fromSamples(const HeightLevels& levels, const CoarseHeights& coarse, int level) {
    LevelTiles out;
    out.count = levels.tiles(level);
    out.tiles.resize(std::size_t(out.count.x) * std::size_t(out.count.y));
    const HeightWindow window{
        {0, 0}, {coarse.grid.across.samples(), coarse.grid.down.samples()}, coarse.heights.data()};
    const int cells = kTileCells >> (coarse.level - level);
    const glm::ivec2 most = window.size - 1;
    for (int y = 0; y < out.count.y; ++y)
        for (int x = 0; x < out.count.x; ++x)
            out.at({x, y}) = heightsIn(window, glm::min(glm::ivec2(x, y) * cells, most),
                                       glm::min(glm::ivec2(x + 1, y + 1) * cells, most));
    return out;
}

} // namespace

Result<HeightEstimate> estimateHeights(const Raster& raster, const HeightLevels& levels,
                                       const CoarseHeights& coarse) {
    const int top = levels.top();
    HeightEstimate out;
    out.usualError.assign(std::size_t(std::max(top, coarse.level)) + 1, 0.0);
    if (const Failure wrong = lookAtCells(raster, levels, coarse, out.usualError))
        return *wrong;
    // The coarse samples as a raster of their own: its levels are ours from coarse.level up.
    const glm::ivec2 size(coarse.grid.across.samples(), coarse.grid.down.samples());
    const HeightLevels above{size};
    const HeightScan scan = scanWindow({{0, 0}, size, coarse.heights.data()}, above, above.top());
    const double unseen = out.usualError[std::size_t(coarse.level)];
    for (int level = 0; level <= top; ++level) {
        if (level < kWholeTileLevel) {
            out.levels.emplace_back();
            continue;
        }
        const bool scanned = level >= coarse.level;
        LevelTiles tiles = scanned ? scan.levels[std::size_t(level - coarse.level)]
                                   : fromSamples(levels, coarse, level);
        for (TileHeights& tile : tiles.tiles) {
            if (!(tile.low <= tile.high))
                continue;
            tile.surface = true; // somewhere between the samples, perhaps
            tile.error =
                float(scanned ? double(tile.error) + unseen : out.usualError[std::size_t(level)]);
            tile.low -= float(unseen);
            tile.high += float(unseen);
            out.usualError[std::size_t(level)] =
                std::max(out.usualError[std::size_t(level)], double(tile.error));
        }
        out.levels.push_back(std::move(tiles));
    }
    std::size_t data = 0;
    for (const float h : coarse.heights)
        data += std::isnan(h) ? 0 : 1;
    out.dataShare = double(data) / double(coarse.heights.size());
    return out;
}

} // namespace gnomon
