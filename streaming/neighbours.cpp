#include "streaming/neighbours.h"

#include <algorithm>
#include <numeric>

namespace gnomon {

namespace {

constexpr std::uint32_t kLeaf = 12; // points that are looked at one by one

std::uint32_t middleOf(std::uint32_t first, std::uint32_t end) {
    return first + (end - first) / 2;
}

double squaredDistance(const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 d = a - b;
    return d.x * d.x + d.y * d.y + d.z * d.z;
}

void insert(Neighbours& found, double squared, std::uint32_t point) {
    std::size_t at = found.count < kNeighbours ? found.count++ : kNeighbours - 1;
    for (; at > 0 && found.nearest[at - 1].squaredMetres > squared; --at) {
        found.nearest[at] = found.nearest[at - 1];
    }
    found.nearest[at] = {squared, point};
}

bool isNearer(const Neighbours& found, double squared) {
    return found.count < kNeighbours || squared < found.nearest[kNeighbours - 1].squaredMetres;
}

} // namespace

NeighbourTree::NeighbourTree(const std::vector<glm::dvec3>& points)
    : points_(points), order_(points.size()), axis_(points.size(), 0) {
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Range> open{{0, std::uint32_t(points.size())}};
    while (!open.empty()) {
        const Range range = open.back();
        open.pop_back();
        if (range.end - range.first <= kLeaf) {
            continue;
        }
        const int axis = split(range);
        const std::uint32_t middle = middleOf(range.first, range.end);
        axis_[middle] = std::uint8_t(axis);
        open.push_back({middle + 1, range.end});
        open.push_back({range.first, middle});
    }
}

// Puts the median along the widest axis in the middle, which it returns.
int NeighbourTree::split(const Range& range) {
    glm::dvec3 min = points_[order_[range.first]], max = min;
    for (std::uint32_t i = range.first; i < range.end; ++i) {
        min =
            glm::dvec3(std::min(min.x, points_[order_[i]].x), std::min(min.y, points_[order_[i]].y),
                       std::min(min.z, points_[order_[i]].z));
        max =
            glm::dvec3(std::max(max.x, points_[order_[i]].x), std::max(max.y, points_[order_[i]].y),
                       std::max(max.z, points_[order_[i]].z));
    }
    const glm::dvec3 extent = max - min;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                     : extent.y >= extent.z                       ? 1
                                                                  : 2;
    const auto at = [&](std::uint32_t i) { return order_.begin() + i; };
    std::nth_element(at(range.first), at(middleOf(range.first, range.end)), at(range.end),
                     [&](std::uint32_t a, std::uint32_t b) {
                         const double u = points_[a][axis], v = points_[b][axis];
                         return u != v ? u < v : a < b; // one order, whatever the library does
                     });
    return axis;
}

Neighbours NeighbourTree::of(std::uint32_t point) const {
    struct Visit {
        Range range;
        double atLeast; // squared distance to the half space the range is in
    };
    // Each level leaves one range open, and there are fewer than 32.
    std::array<Visit, 64> open;
    std::size_t depth = 0;
    const glm::dvec3& p = points_[point];
    Neighbours found;
    const auto look = [&](std::uint32_t place) {
        const double squared = squaredDistance(points_[order_[place]], p);
        if (order_[place] != point && isNearer(found, squared)) {
            insert(found, squared, order_[place]);
        }
    };
    open[depth++] = {{0, std::uint32_t(order_.size())}, 0.0};
    while (depth > 0) {
        const Visit visit = open[--depth];
        const auto [first, end] = visit.range;
        if (!isNearer(found, visit.atLeast)) {
            continue;
        }
        if (end - first <= kLeaf) {
            for (std::uint32_t i = first; i < end; ++i) {
                look(i);
            }
            continue;
        }
        const std::uint32_t middle = middleOf(first, end);
        look(middle);
        const int axis = axis_[middle];
        const double beyond = p[axis] - points_[order_[middle]][axis];
        const Range low{first, middle}, high{middle + 1, end};
        open[depth++] = {beyond < 0.0 ? high : low, std::max(visit.atLeast, beyond * beyond)};
        open[depth++] = {beyond < 0.0 ? low : high, visit.atLeast};
    }
    return found;
}

} // namespace gnomon
