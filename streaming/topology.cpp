#include "streaming/topology.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gnomon {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

// A triangle's side, seen from its lower vertex: the higher one, and corner * 2 + (1 if the
// triangle runs along it from high to low).
struct Side {
    std::uint32_t high = 0;
    std::uint32_t code = 0;

    std::uint32_t triangle() const { return code / 6; }
    std::uint32_t corner() const { return code / 2; }
    bool downward() const { return code & 1u; }
};

class Forest {
  public:
    explicit Forest(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t find(std::uint32_t i) {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        parent_[std::max(a, b)] = std::min(a, b); // the root is the first: order is the file's
    }

  private:
    std::vector<std::uint32_t> parent_;
};

// What a triangle's winding encloses, as seen from `from`, times six; and its area times two.
struct Amount {
    double volume6 = 0.0, area2 = 0.0;
    bool open = false;
    bool met = false;
    glm::dvec3 from{0.0};
};

class Analysis {
  public:
    Analysis(std::span<const std::array<std::uint32_t, 3>> triangles,
             std::span<const std::uint8_t> group, std::span<const glm::dvec3> positions)
        : triangles_(triangles), group_(group), positions_(positions), component_(triangles.size()),
          patch_(triangles.size(), kNone), flip_(triangles.size(), 0) {}

    Topology run(double thickness) {
        collectSides();
        link();
        windConsistently();
        balance();
        measure();
        return judge(thickness);
    }

  private:
    // Sides by their lower vertex (a counting sort), then by the higher one.
    void collectSides() {
        const std::size_t vertices = positions_.size();
        start_.assign(2 * vertices + 1, 0);
        forEachSide([&](std::size_t low, Side) { ++start_[low + 1]; });
        std::partial_sum(start_.begin(), start_.end(), start_.begin());
        sides_.resize(triangles_.size() * 3);
        std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
        forEachSide([&](std::size_t low, Side side) { sides_[next[low]++] = side; });
        for (std::size_t v = 0; v + 1 < start_.size(); ++v) {
            std::sort(sides_.begin() + start_[v], sides_.begin() + start_[v + 1],
                      [](const Side& a, const Side& b) {
                          return a.high != b.high ? a.high < b.high : a.code < b.code;
                      });
        }
    }

    template <class F>
    void forEachSide(const F& f) const {
        const std::size_t vertices = positions_.size();
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
                const std::uint32_t code = std::uint32_t(t * 6 + k * 2 + (a > b));
                f(std::min(a, b) + group_[t] * vertices, Side{std::max(a, b), code});
            }
        }
    }

    // Calls f with the sides of one edge at a time.
    template <class F>
    void forEachEdge(const F& f) {
        for (std::size_t v = 0; v + 1 < start_.size(); ++v) {
            for (std::size_t i = start_[v]; i < start_[v + 1];) {
                std::size_t end = i + 1;
                while (end < start_[v + 1] && sides_[end].high == sides_[i].high) {
                    ++end;
                }
                f(std::span<const Side>(&sides_[i], end - i));
                i = end;
            }
        }
    }

    void link() {
        Forest forest(triangles_.size());
        across_.assign(triangles_.size() * 3, kNone);
        forEachEdge([&](std::span<const Side> edge) {
            for (const Side& side : edge.subspan(1)) {
                forest.join(edge[0].triangle(), side.triangle());
            }
            if (edge.size() == 2) {
                across_[edge[0].corner()] = edge[1].code;
                across_[edge[1].corner()] = edge[0].code;
            }
        });
        std::uint32_t count = 0; // a root is the first of its component, so it is numbered first
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            const std::uint32_t root = forest.find(t);
            component_[t] = root == t ? count++ : component_[root];
        }
        components_.resize(count);
    }

    // Flood over edges with two sides; the outcome agrees with most of the stored windings.
    void windConsistently() {
        std::vector<std::uint32_t> queue;
        for (std::uint32_t seed = 0; seed < triangles_.size(); ++seed) {
            if (patch_[seed] != kNone) {
                continue;
            }
            queue.assign(1, seed);
            const std::uint32_t patch = std::uint32_t(patches_.size());
            patches_.emplace_back();
            patch_[seed] = patch;
            std::size_t flipped = 0;
            for (std::size_t head = 0; head < queue.size(); ++head) {
                const std::uint32_t t = queue[head];
                for (std::uint32_t k = 0; k < 3; ++k) {
                    const std::uint32_t code = across_[t * 3 + k];
                    if (code == kNone || patch_[code / 6] != kNone) {
                        continue;
                    }
                    const std::uint32_t other = code / 6;
                    const bool mine = triangles_[t][k] > triangles_[t][(k + 1) % 3];
                    patch_[other] = patch;
                    flip_[other] = std::uint8_t(flip_[t] ^ (mine == bool(code & 1u)));
                    flipped += flip_[other];
                    queue.push_back(other);
                }
            }
            if (2 * flipped > queue.size()) {
                for (const std::uint32_t t : queue) {
                    flip_[t] ^= 1u;
                }
            }
        }
    }

    int direction(const Side& side) const {
        return side.downward() != bool(flip_[side.triangle()]) ? -1 : 1;
    }

    void balance() {
        std::vector<std::pair<std::uint32_t, int>> byPatch;
        forEachEdge([&](std::span<const Side> edge) {
            byPatch.clear();
            int sum = 0;
            for (const Side& side : edge) {
                byPatch.emplace_back(patch_[side.triangle()], direction(side));
                sum += direction(side);
            }
            if (sum != 0) {
                components_[component_[edge[0].triangle()]].open = true;
            }
            std::sort(byPatch.begin(), byPatch.end());
            for (std::size_t i = 0; i < byPatch.size();) {
                const std::uint32_t patch = byPatch[i].first;
                int own = 0;
                for (; i < byPatch.size() && byPatch[i].first == patch; ++i) {
                    own += byPatch[i].second;
                }
                patches_[patch].open = patches_[patch].open || own != 0;
            }
        });
    }

    // The amount a triangle's closedness is judged by: its patch's, else its component's.
    Amount& amountOf(std::uint32_t t) {
        Amount& patch = patches_[patch_[t]];
        return patch.open ? components_[component_[t]] : patch;
    }

    void measure() {
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            Amount& amount = amountOf(t);
            if (!amount.met) { // from nearby, lest the volume drown in rounding
                amount.met = true;
                amount.from = positions_[triangles_[t][0]];
            }
            const glm::dvec3 a = positions_[triangles_[t][0]] - amount.from;
            const glm::dvec3 b = positions_[triangles_[t][1]] - amount.from;
            const glm::dvec3 c = positions_[triangles_[t][2]] - amount.from;
            const double sign = flip_[t] ? -1.0 : 1.0;
            amount.volume6 += sign * glm::dot(a, glm::cross(b, c));
            amount.area2 += glm::length(glm::cross(b - a, c - a));
        }
    }

    Topology judge(double thickness) {
        Topology out;
        out.closed.resize(triangles_.size());
        out.flip.resize(triangles_.size());
        std::vector<std::uint8_t> hasOpen(components_.size(), 0);
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            const Amount& amount = amountOf(t);
            // A slab of area A on each side and thickness h has 2 A of surface and A h of volume.
            const bool solid = std::abs(amount.volume6) / 6.0 > thickness * amount.area2 / 4.0;
            out.closed[t] = !amount.open && solid;
            out.flip[t] = out.closed[t] && (bool(flip_[t]) != (amount.volume6 < 0.0));
            hasOpen[component_[t]] |= std::uint8_t(!out.closed[t]);
        }
        out.components = std::uint32_t(components_.size());
        out.closedComponents =
            std::uint32_t(std::count(hasOpen.begin(), hasOpen.end(), std::uint8_t(0)));
        return out;
    }

    std::span<const std::array<std::uint32_t, 3>> triangles_;
    std::span<const std::uint8_t> group_;
    std::span<const glm::dvec3> positions_;
    std::vector<std::uint32_t> start_; // of each lower vertex's sides, by group
    std::vector<Side> sides_;
    std::vector<std::uint32_t> across_; // a corner's side to the one other side of its edge
    std::vector<std::uint32_t> component_, patch_; // of each triangle
    std::vector<std::uint8_t> flip_;
    std::vector<Amount> patches_, components_;
};

} // namespace

Topology analyse(std::span<const std::array<std::uint32_t, 3>> triangles,
                 std::span<const std::uint8_t> group, std::span<const glm::dvec3> positions,
                 double thickness) {
    return Analysis(triangles, group, positions).run(thickness);
}

} // namespace gnomon
