// The nodes and triangles of a flood result as its surface takes them, in patches that become a
// mesh each.
//
// A grid's values stand for whole cells, so around its nodes runs a ring of further ones, half a
// cell out, which have the values of their neighbours: the surface then covers all that the cells
// do.
#pragma once

#include "streaming/flood/flood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace gnomon {

using NodeTriangle = std::array<std::uint32_t, 3>;

class WaterNodes {
  public:
    explicit WaterNodes(const FloodGeometry& geometry);

    std::size_t size() const { return size_; }
    glm::dvec2 lonLat(std::uint32_t node) const; // degrees; NaN: lies nowhere
    // From a value a node of the file's to one a node of the surface's.
    template <class T>
    std::vector<T> spread(const std::vector<T>& values) const;
    double cellArea(std::uint32_t node) const; // the ring's is its neighbours'

    struct Patch {
        glm::ivec2 low{0}, high{0};           // cells of a grid
        std::size_t first = 0, triangles = 0; // of a mesh
        glm::dvec2 middle{0}, reach{0};       // degrees, half of what it covers
    };
    const std::vector<Patch>& patches() const { return patches_; }
    // Counter-clockwise seen from above. A grid's cells are halved so that one corner that is wet,
    // or dry, alone is cut off, and two wet ones across from each other are joined: shores run
    // alike in all directions, and a river one cell wide holds together.
    template <class IsWet, class Visit>
    void eachTriangle(const Patch& patch, const IsWet& isWet, const Visit& visit) const;

  private:
    void makeGridPatches();
    void makeMeshPatches();
    void split(std::size_t from, std::size_t to);
    void measure(Patch& patch) const;
    void findSense();
    double cellMetres() const;

    const FloodGeometry& geometry_;
    int columns_ = 0, rows_ = 0; // with the ring; 0: a mesh
    bool reversed_ = false;      // rows turn counter-clockwise from columns
    bool complete_ = true;       // all nodes lie somewhere
    std::size_t size_ = 0;
    std::vector<NodeTriangle> triangles_; // of a mesh, patch by patch
    std::vector<Patch> patches_;
};

template <class T>
std::vector<T> WaterNodes::spread(const std::vector<T>& values) const {
    if (columns_ == 0)
        return values;
    std::vector<T> out;
    out.reserve(size_);
    const int inner = columns_ - 2;
    for (int row = 0; row < rows_; ++row) {
        const T* line =
            values.data() + std::size_t(std::clamp(row - 1, 0, rows_ - 3)) * std::size_t(inner);
        out.push_back(line[0]);
        out.insert(out.end(), line, line + inner);
        out.push_back(line[inner - 1]);
    }
    return out;
}

template <class IsWet, class Visit>
void WaterNodes::eachTriangle(const Patch& patch, const IsWet& isWet, const Visit& visit) const {
    if (columns_ == 0) {
        for (std::size_t i = patch.first; i < patch.first + patch.triangles; ++i)
            visit(triangles_[i]);
        return;
    }
    const auto exists = [&](const NodeTriangle& t) {
        return complete_ || (std::isfinite(lonLat(t[0]).x) && std::isfinite(lonLat(t[1]).x) &&
                             std::isfinite(lonLat(t[2]).x));
    };
    const auto width = std::uint32_t(columns_);
    for (int row = patch.low.y; row < patch.high.y; ++row)
        for (int column = patch.low.x; column < patch.high.x; ++column) {
            const std::uint32_t a = std::uint32_t(row) * width + std::uint32_t(column);
            // Around the cell, counter-clockwise.
            std::array corners{a, a + 1, a + width + 1, a + width};
            if (!reversed_)
                std::swap(corners[1], corners[3]);
            const bool wet0 = isWet(corners[0]), wet1 = isWet(corners[1]);
            const bool wet2 = isWet(corners[2]), wet3 = isWet(corners[3]);
            // One alone makes the sum odd; then exactly one of the two diagonals joins unlike
            // corners, and the other halves.
            const bool alone = wet0 ^ wet1 ^ wet2 ^ wet3;
            const bool across = wet1 && wet3 && !wet0 && !wet2;
            const bool other = alone ? wet0 != wet2 : across;
            const auto at = [&](std::size_t i) { return corners[i + (other ? 1 : 0)]; };
            const std::uint32_t last = other ? corners[0] : corners[3];
            const NodeTriangle first{at(0), at(1), at(2)}, second{at(0), at(2), last};
            if (exists(first))
                visit(first);
            if (exists(second))
                visit(second);
        }
}

} // namespace gnomon
