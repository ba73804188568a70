// The nearest neighbours of each of a set of points, by a k-d tree (Bentley, "Multidimensional
// binary search trees used for associative searching", 1975).
#pragma once

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gnomon {

inline constexpr std::size_t kNeighbours = 8;

struct Neighbour {
    double squaredMetres = 0.0;
    std::uint32_t point = 0;
};

// Nearest first; `count` < kNeighbours only where there are not that many other points.
struct Neighbours {
    std::array<Neighbour, kNeighbours> nearest;
    std::size_t count = 0;
};

class NeighbourTree {
  public:
    // `points` are finite, fewer than 2^32 - 1, and outlive the tree.
    explicit NeighbourTree(const std::vector<glm::dvec3>& points);

    Neighbours of(std::uint32_t point) const;
    // The points in an order in which those one after the other are near each other.
    const std::vector<std::uint32_t>& order() const { return order_; }

  private:
    struct Range {
        std::uint32_t first, end;
    };
    int split(const Range& range);

    const std::vector<glm::dvec3>& points_;
    std::vector<std::uint32_t> order_; // the median of a range is its node
    std::vector<std::uint8_t> axis_;   // of the node at that place
};

} // namespace gnomon
