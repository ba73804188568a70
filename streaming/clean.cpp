#include "streaming/clean.h"

#include "streaming/topology.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

std::uint64_t mix(std::uint64_t h, std::uint64_t v) {
    h = (h ^ v) * 0x9e3779b97f4a7c15ull;
    return h ^ (h >> 29);
}

// Open addressing: the first index that equals what is asked for, or a new entry. What comes out
// depends on the order of insertion alone.
class IndexTable {
  public:
    explicit IndexTable(std::size_t expected)
        : slots_(std::bit_ceil(std::max<std::size_t>(expected * 2, 16)), kNone) {}

    template <class Equal>
    std::uint32_t findOrAdd(std::uint64_t hash, std::uint32_t index, const Equal& equal) {
        for (std::size_t i = hash & (slots_.size() - 1);; i = (i + 1) & (slots_.size() - 1)) {
            if (slots_[i] == kNone) {
                slots_[i] = index;
                return index;
            }
            if (equal(slots_[i])) {
                return slots_[i];
            }
        }
    }
    template <class Equal>
    std::uint32_t find(std::uint64_t hash, const Equal& equal) const {
        for (std::size_t i = hash & (slots_.size() - 1); slots_[i] != kNone;
             i = (i + 1) & (slots_.size() - 1)) {
            if (equal(slots_[i])) {
                return slots_[i];
            }
        }
        return kNone;
    }

  private:
    std::vector<std::uint32_t> slots_;
};

std::uint64_t hashOf(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    return mix(mix(mix(0, a), b), c);
}

bool isNear(const glm::dvec3& p) {
    return std::abs(p.x) < kFarthestMetres && std::abs(p.y) < kFarthestMetres &&
           std::abs(p.z) < kFarthestMetres; // false for NaN
}

struct Bounds {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};

    void add(const glm::dvec3& p) {
        min = glm::min(min, p);
        max = glm::max(max, p);
    }
    bool empty() const { return !(min.x <= max.x); }
};

Bounds boundsOf(const std::vector<glm::dvec3>& positions) {
    Bounds bounds;
    for (const glm::dvec3& p : positions) {
        if (isNear(p)) {
            bounds.add(p);
        }
    }
    return bounds;
}

// The first vertex at exactly the same place, for each vertex.
std::vector<std::uint32_t> sameplace(const std::vector<glm::dvec3>& positions) {
    IndexTable table(positions.size());
    std::vector<std::uint32_t> first(positions.size());
    for (std::uint32_t v = 0; v < positions.size(); ++v) {
        const glm::dvec3& p = positions[v];
        const std::uint64_t hash =
            hashOf(std::bit_cast<std::uint64_t>(p.x), std::bit_cast<std::uint64_t>(p.y),
                   std::bit_cast<std::uint64_t>(p.z));
        first[v] =
            isNear(p) ? table.findOrAdd(hash, v, [&](std::uint32_t o) { return positions[o] == p; })
                      : v;
    }
    return first;
}

struct Cell {
    std::int64_t x = 0, y = 0, z = 0;
    bool operator==(const Cell&) const = default;
};

// See clean.h. Representatives are more than `tolerance` apart, so a cell of four tolerances holds
// a bounded number of them, however dense the vertices are.
class Welder {
  public:
    Welder(const std::vector<glm::dvec3>& positions, double tolerance, std::size_t expected)
        : positions_(positions), tolerance_(tolerance), cell_(4.0 * tolerance), heads_(expected),
          next_(positions.size(), kNone) {}

    std::uint32_t weld(std::uint32_t v) {
        const glm::dvec3& p = positions_[v];
        const Cell low = cellOf(p - tolerance_), high = cellOf(p + tolerance_);
        std::uint32_t nearest = kNone;
        double best = tolerance_ * tolerance_;
        for (std::int64_t x = low.x; x <= high.x; ++x) {
            for (std::int64_t y = low.y; y <= high.y; ++y) {
                for (std::int64_t z = low.z; z <= high.z; ++z) {
                    for (std::uint32_t r = head({x, y, z}); r != kNone; r = next_[r]) {
                        const glm::dvec3 d = positions_[r] - p;
                        const double squared = glm::dot(d, d);
                        if (squared < best || (squared == best && r < nearest)) {
                            best = squared;
                            nearest = r;
                        }
                    }
                }
            }
        }
        if (nearest != kNone) {
            return nearest;
        }
        const Cell own = cellOf(p);
        const std::uint32_t first =
            heads_.findOrAdd(hash(own), v, [&](std::uint32_t o) { return sameCell(o, own); });
        if (first != v) { // behind the first, which stays the cell's key
            next_[v] = next_[first];
            next_[first] = v;
        }
        return v;
    }

  private:
    Cell cellOf(const glm::dvec3& p) const {
        const glm::dvec3 c = glm::floor(p / cell_);
        // |p| < kFarthestMetres, but the tolerance of a tiny model may be tiny too.
        const auto whole = [](double v) { return std::int64_t(std::clamp(v, -9e18, 9e18)); };
        return {whole(c.x), whole(c.y), whole(c.z)};
    }
    static std::uint64_t hash(const Cell& c) {
        return hashOf(std::uint64_t(c.x), std::uint64_t(c.y), std::uint64_t(c.z));
    }
    bool sameCell(std::uint32_t vertex, const Cell& cell) const {
        return cellOf(positions_[vertex]) == cell;
    }
    std::uint32_t head(const Cell& cell) const {
        return heads_.find(hash(cell), [&](std::uint32_t o) { return sameCell(o, cell); });
    }

    const std::vector<glm::dvec3>& positions_;
    double tolerance_, cell_;
    IndexTable heads_; // the first representative of each cell
    std::vector<std::uint32_t> next_;
};

glm::dvec3 crossOf(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return glm::cross(b - a, c - a);
}

// Sorts the corners; true when that took an odd number of swaps, that is, turned the triangle
// round.
bool sortCorners(std::array<std::uint32_t, 3>& t) {
    bool odd = false;
    const auto order = [&](int i, int j) {
        if (t[std::size_t(i)] > t[std::size_t(j)]) {
            std::swap(t[std::size_t(i)], t[std::size_t(j)]);
            odd = !odd;
        }
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    return odd;
}

// A triangle on its way to being kept.
struct Candidate {
    std::uint32_t soup = 0;               // index of the soup's triangle
    std::array<std::uint32_t, 3> corners; // vertices by place, then welded
    bool odd = false;
    std::uint8_t twofaced = 0; // there, too, the other way round
    bool flat = false;         // no area, but its edges close a gap
    bool thin = false;         // has an area, but two of its corners weld
};

class Cleaner {
  public:
    Cleaner(const Soup& soup, const Transform<Ecef, Tile>& ecefFromTile)
        : soup_(soup), transform_(ecefFromTile) {}

    CleanSoup run() {
        place();
        first_ = sameplace(out_.local);
        pick();
        weld();
        const Topology topology = connect();
        emit(topology);
        return std::move(out_);
    }

  private:
    void place() {
        const Bounds bounds = boundsOf(soup_.positions);
        const glm::dvec3 centre =
            bounds.empty() ? glm::dvec3(0.0) : (bounds.min + bounds.max) / 2.0;
        out_.origin = transform_(Point<Tile>{centre});
        const glm::dmat3 axes = transform_.axes();
        mirrored_ = glm::determinant(axes) < 0.0;
        out_.local.reserve(soup_.positions.size());
        for (const glm::dvec3& p : soup_.positions) {
            out_.local.push_back(axes * (p - centre) + 0.0); // + 0: no negative zeros
        }
        if (!isNear(out_.origin.xyz)) { // the transform itself is beyond use
            std::fill(out_.local.begin(), out_.local.end(),
                      glm::dvec3(std::numeric_limits<double>::quiet_NaN()));
        }
    }

    // Drops what has no finite place or is there already.
    void pick() {
        const auto& local = out_.local;
        IndexTable table(soup_.triangles.size());
        candidates_.reserve(soup_.triangles.size());
        for (std::uint32_t i = 0; i < soup_.triangles.size(); ++i) {
            const auto& v = soup_.triangles[i].vertex;
            if (!isNear(local[v[0]]) || !isNear(local[v[1]]) || !isNear(local[v[2]])) {
                ++out_.invalid;
                continue;
            }
            Candidate c{i, {first_[v[0]], first_[v[1]], first_[v[2]]}, false, 0, false, false};
            if (c.corners[0] == c.corners[1] || c.corners[1] == c.corners[2] ||
                c.corners[2] == c.corners[0]) {
                ++out_.degenerate;
                continue;
            }
            const double area = glm::length(crossOf(local[v[0]], local[v[1]], local[v[2]]));
            c.flat = !(area > 0.0);
            c.odd = sortCorners(c.corners);
            const std::uint32_t index = std::uint32_t(candidates_.size());
            const std::uint32_t found = table.findOrAdd(
                hashOf(c.corners[0], c.corners[1], c.corners[2]), index,
                [&](std::uint32_t o) { return candidates_[o].corners == c.corners; });
            if (found == index) {
                candidates_.push_back(c);
                continue;
            }
            out_.degenerate += c.flat;
            out_.duplicates += !c.flat;
            candidates_[found].twofaced |= std::uint8_t(candidates_[found].odd != c.odd);
        }
    }

    void weld() {
        Bounds bounds;
        for (const Candidate& c : candidates_) {
            for (const std::uint32_t v : c.corners) {
                bounds.add(out_.local[v]);
            }
        }
        if (bounds.empty()) {
            return;
        }
        constexpr double kSmallestPart = 1e-4, kLeast = 1e-12; // the least keeps cells finite
        const double size = glm::length(bounds.max - bounds.min);
        tolerance_ = std::clamp(kSmallestPart * size, kLeast, kWeldMetres);
        Welder welder(out_.local, tolerance_, out_.local.size());
        std::vector<std::uint32_t> welded(out_.local.size(), kNone);
        for (Candidate& c : candidates_) {
            for (std::size_t k = 0; k < 3; ++k) {
                // As stored, not as sorted: winding matters from here on.
                const std::uint32_t v = first_[soup_.triangles[c.soup].vertex[k]];
                if (welded[v] == kNone) {
                    welded[v] = welder.weld(v);
                }
                c.corners[k] = welded[v];
            }
            c.thin = c.corners[0] == c.corners[1] || c.corners[1] == c.corners[2] ||
                     c.corners[2] == c.corners[0];
        }
    }

    // Two-faced triangles (a wall that two houses share, a sheet drawn from both sides) are looked
    // at apart: without them the houses may be solid, and with them they would not. A thin one is
    // drawn, for there would be a crack without it, but is no more than an edge here.
    Topology connect() const {
        std::vector<std::array<std::uint32_t, 3>> triangles;
        std::vector<std::uint8_t> group;
        triangles.reserve(candidates_.size());
        group.reserve(candidates_.size());
        for (const Candidate& c : candidates_) {
            if (!c.thin) {
                triangles.push_back(c.corners);
                group.push_back(c.twofaced);
            }
        }
        return analyse(triangles, group, out_.local, tolerance_);
    }

    void emit(const Topology& topology) {
        out_.components = topology.components;
        out_.closedComponents = topology.closedComponents;
        out_.triangles.reserve(candidates_.size());
        out_.closed.reserve(candidates_.size());
        std::size_t next = 0; // in the topology, which has no thin ones
        for (const Candidate& c : candidates_) {
            const std::size_t i = c.thin ? 0 : next++;
            const bool closed = !c.thin && topology.closed[i], flip = !c.thin && topology.flip[i];
            if (c.flat) {
                ++out_.degenerate;
                continue;
            }
            Soup::Triangle t = soup_.triangles[c.soup];
            const auto& p = soup_.positions;
            const double sign = flip ? -0.5 : 0.5;
            out_.areaVector += sign * crossOf(p[t.vertex[0]], p[t.vertex[1]], p[t.vertex[2]]);
            // A mirroring transform turns every triangle; what is closed was judged after it.
            if (closed ? flip : mirrored_) {
                std::swap(t.vertex[1], t.vertex[2]);
            }
            out_.triangles.push_back(t);
            out_.closed.push_back(closed);
            out_.closedTriangles += closed;
        }
    }

    const Soup& soup_;
    const Transform<Ecef, Tile>& transform_;
    CleanSoup out_;
    bool mirrored_ = false;
    double tolerance_ = kWeldMetres;
    std::vector<std::uint32_t> first_;
    std::vector<Candidate> candidates_;
};

} // namespace

CleanSoup clean(const Soup& soup, const Transform<Ecef, Tile>& ecefFromTile) {
    return Cleaner(soup, ecefFromTile).run();
}

ContentFacts factsOf(const CleanSoup& cleaned) {
    ContentFacts facts;
    facts.triangles = cleaned.triangles.size();
    facts.duplicates = cleaned.duplicates;
    facts.degenerate = cleaned.degenerate;
    facts.invalid = cleaned.invalid;
    facts.closedTriangles = cleaned.closedTriangles;
    facts.components = cleaned.components;
    facts.closedComponents = cleaned.closedComponents;
    facts.areaVector = cleaned.areaVector;
    return facts;
}

} // namespace gnomon
