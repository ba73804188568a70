// By how much the coarse surfaces of a piece of a raster differ from its finest.
#pragma once

#include "streaming/terrain/height_scan.h"

#include <span>

namespace gnomon {

// A part of the raster in memory, row by row.
struct HeightWindow {
    glm::ivec2 first{0, 0}, size{0, 0};
    const float* heights = nullptr;

    const float* row(int y) const {
        return heights + std::ptrdiff_t(y - first.y) * size.x - first.x; // index by column
    }
    float at(int x, int y) const { return row(y)[x]; }
};

// Low, high, surface of the pixels [first, last] and how many of them have data.
TileHeights heightsIn(const HeightWindow& window, glm::ivec2 first, glm::ivec2 last);
bool isComplete(const HeightWindow& window, glm::ivec2 first, glm::ivec2 last);
// `error` and `rim` of level `level` within the pixels [first, last]: a tile of level 0. The cells
// of `level` that it touches must lie in the window. `complete`: no pixel of those lacks data.
void addError(const HeightWindow& window, const HeightLevels& levels, int level, glm::ivec2 first,
              glm::ivec2 last, bool complete, TileHeights& out);

} // namespace gnomon
