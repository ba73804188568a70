// Rows and columns of nodes brought from the coordinates of their file onto the Earth.
#pragma once

#include "streaming/flood/flood.h"

#include <glm/vec2.hpp>

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

// Which pixels of a file are nodes: all, or of a large file every `step`-th, each for a block of
// step by step pixels with it in their middle.
struct GridThinning {
    // More are too many to be shown as they rise.
    static constexpr std::size_t kMostNodes = 4'000'000;

    int step = 1, first = 0; // pixel of node i: first + i * step
    int columns = 0, rows = 0;

    static GridThinning of(int width, int height);
    std::string note(int width, int height) const; // "" when all are taken
    // Two nodes each way, all of them in the file: not so for what is very long and narrow.
    bool fits(int width, int height) const {
        return columns >= 2 && rows >= 2 && first < width && first < height;
    }
    std::size_t nodes() const { return std::size_t(columns) * std::size_t(rows); }
};

struct GridPlaces {
    std::vector<glm::dvec2> lonLat; // degrees; NaN: lies nowhere
    std::vector<float> lift;        // to a height as the file has it: the geoid's and the user's
    std::vector<float> eastOfX;     // radians counter-clockwise from east to the file's x axis
    std::vector<float> cellArea;    // square metres on the Earth
};

// `positions(column, row)` in `crs`. With `even`, positions run evenly over the grid, and places
// between are interpolated where that is exact to a thousandth of a cell.
Result<GridPlaces> placeGrid(const std::string& path, int columns, int rows,
                             const std::function<glm::dvec2(int, int)>& positions, bool even,
                             const std::string& crs, const FloodOptions& options);

} // namespace gnomon
