// The levels of detail of a grid of heights: level L takes every 2^L-th pixel, and the last one, so
// that all levels cover the same ground and each is part of the one below. A tile is
// kTileCells cells a side, less at the far edges. Two triangles a cell; the diagonal runs from
// (column + 1, row) to (column, row + 1) at every level, so that the finest triangles cut the
// coarser ones up and the largest difference lies at a pixel.
#pragma once

#include <glm/vec2.hpp>

#include <algorithm>

namespace gnomon {

inline constexpr int kTileCells = 128;

// One axis of the grid at one level: where its samples lie, in pixels.
struct LevelAxis {
    int pixels = 2, step = 1;

    // Samples, the last pixel included.
    int samples() const { return cells() + 1; }
    int cells() const { return (pixels - 1 + step - 1) / step; }
    int position(int sample) const { return sample >= cells() ? pixels - 1 : sample * step; }
    int tiles() const { return (cells() + kTileCells - 1) / kTileCells; }
};

struct LevelGrid {
    LevelAxis across, down;
};

struct HeightLevels {
    glm::ivec2 pixels{2, 2};

    LevelGrid at(int level) const { return {{pixels.x, 1 << level}, {pixels.y, 1 << level}}; }
    glm::ivec2 tiles(int level) const {
        const LevelGrid grid = at(level);
        return {grid.across.tiles(), grid.down.tiles()};
    }
    // The level of one tile.
    int top() const {
        int level = 0;
        while (tiles(level) != glm::ivec2(1, 1))
            ++level;
        return level;
    }
    // Of tile (x, y): its first and last pixels.
    struct Span {
        glm::ivec2 first, last;
    };
    Span span(int level, glm::ivec2 tile) const {
        const LevelGrid grid = at(level);
        return {
            {grid.across.position(tile.x * kTileCells), grid.down.position(tile.y * kTileCells)},
            {grid.across.position((tile.x + 1) * kTileCells),
             grid.down.position((tile.y + 1) * kTileCells)}};
    }
};

} // namespace gnomon
