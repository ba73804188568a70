#include "streaming/features/triangulate.h"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace gnomon {

namespace {

double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// One a thread: making one costs as much as a small polygon.
GEOSContextHandle_t context() {
    struct Context {
        GEOSContextHandle_t handle = GEOS_init_r();
        ~Context() { GEOS_finish_r(handle); }
    };
    thread_local const Context one;
    return one.handle;
}

GEOSGeometry* geosRing(GEOSContextHandle_t geos, const PlanRing& ring) {
    const auto size = unsigned(ring.size());
    GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(geos, size + 1, 2);
    for (unsigned i = 0; sequence && i <= size; ++i)
        GEOSCoordSeq_setXY_r(geos, sequence, i, ring[i % size].x, ring[i % size].y);
    return sequence ? GEOSGeom_createLinearRing_r(geos, sequence) : nullptr;
}

bool isInside(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0;
}

// Cuts off ears one by one (Meisters, "Polygons have ears", 1975). Gives up where what is left has
// none that is surely one.
Corners clipped(const PlanRing& ring) {
    std::vector<std::uint32_t> left(ring.size());
    std::iota(left.begin(), left.end(), 0u);
    Corners corners;
    const double size = std::sqrt(std::abs(signedArea(ring)));
    const double least = 1e-9 * size * size; // an ear, not a straight stretch
    const auto isEar = [&](std::size_t i) {
        const std::size_t n = left.size();
        const std::uint32_t a = left[(i + n - 1) % n], b = left[i], c = left[(i + 1) % n];
        if (!(cross(ring[a], ring[b], ring[c]) > least))
            return false;
        for (const std::uint32_t v : left)
            if (v != a && v != b && v != c && isInside(ring[v], ring[a], ring[b], ring[c]))
                return false;
        return true;
    };
    while (left.size() > 3) {
        std::size_t ear = 0;
        while (ear < left.size() && !isEar(ear))
            ++ear;
        if (ear == left.size())
            return {};
        const std::size_t n = left.size();
        corners.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
        left.erase(left.begin() + std::ptrdiff_t(ear));
    }
    if (!(cross(ring[left[0]], ring[left[1]], ring[left[2]]) > least))
        return {};
    corners.push_back({left[0], left[1], left[2]});
    return corners;
}

// They cover the ring: as large together, and none of them turned round.
bool isWhole(const Corners& corners, const PlanRing& ring) {
    constexpr double kSame = 1e-9;
    double sum = 0.0;
    for (const auto& t : corners)
        sum += cross(ring[t[0]], ring[t[1]], ring[t[2]]) / 2.0;
    const double area = signedArea(ring);
    return std::abs(sum - area) <= kSame * area;
}

Corners cutByGeos(const PlanPolygon& polygon) {
    const std::optional<PlanMesh> mesh = triangulated(polygon);
    if (!mesh)
        return {};
    std::map<std::pair<double, double>, std::uint32_t> known;
    std::uint32_t count = 0;
    for (const PlanRing& ring : polygon.rings)
        for (const glm::dvec2& p : ring)
            known.emplace(std::pair(p.x, p.y), count++);
    std::vector<std::uint32_t> index;
    for (const glm::dvec2& p : mesh->points) {
        const auto at = known.find(std::pair(p.x, p.y));
        if (at == known.end())
            return {};
        index.push_back(at->second);
    }
    Corners corners;
    for (const auto& t : mesh->triangles)
        corners.push_back({index[t[0]], index[t[1]], index[t[2]]});
    return corners;
}

} // namespace

double signedArea(const PlanRing& ring) {
    double twice = 0.0;
    for (std::size_t i = 1; i + 1 < ring.size(); ++i)
        twice += cross(ring[0], ring[i], ring[i + 1]);
    return twice / 2.0;
}

bool isSound(std::span<const PlanRing> rings) {
    const GEOSContextHandle_t geos = context();
    std::vector<GEOSGeometry*> made;
    for (const PlanRing& ring : rings) {
        GEOSGeometry* one = ring.size() >= 3 ? geosRing(geos, ring) : nullptr;
        if (one == nullptr)
            break;
        made.push_back(one);
    }
    if (made.empty() || made.size() < rings.size()) {
        for (GEOSGeometry* one : made)
            GEOSGeom_destroy_r(geos, one);
        return false;
    }
    GEOSGeometry* polygon =
        GEOSGeom_createPolygon_r(geos, made[0], made.data() + 1, unsigned(made.size() - 1));
    const bool sound = polygon != nullptr && GEOSisValid_r(geos, polygon) == 1;
    GEOSGeom_destroy_r(geos, polygon);
    return sound;
}

bool crossesTooOften(std::span<const PlanRing> rings) {
    // Enough for any outline drawn or digitised, and for what is looked at to find them.
    constexpr std::size_t kMostCrossings = 2000, kMostLooks = 100'000'000;
    struct Edge {
        glm::dvec2 a, b;
    };
    std::vector<Edge> edges; // from west to east
    for (const PlanRing& ring : rings)
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const glm::dvec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
            edges.push_back(a.x <= b.x ? Edge{a, b} : Edge{b, a});
        }
    std::sort(edges.begin(), edges.end(),
              [](const Edge& e, const Edge& f) { return e.a.x < f.a.x; });
    std::size_t crossings = 0, looks = 0;
    for (std::size_t i = 0; i < edges.size(); ++i)
        for (std::size_t j = i + 1; j < edges.size() && edges[j].a.x <= edges[i].b.x; ++j) {
            const Edge &e = edges[i], &f = edges[j];
            crossings += cross(e.a, e.b, f.a) * cross(e.a, e.b, f.b) < 0.0 &&
                         cross(f.a, f.b, e.a) * cross(f.a, f.b, e.b) < 0.0;
            if (crossings > kMostCrossings || ++looks > kMostLooks)
                return true;
        }
    return false;
}

Corners cornersOf(const PlanPolygon& polygon) {
    const PlanRing& outer = polygon.rings.front();
    constexpr std::size_t kFew = 64; // clipping takes time by the square or worse
    if (polygon.rings.size() == 1 && outer.size() <= kFew) {
        Corners corners = clipped(outer);
        if (!corners.empty() && isWhole(corners, outer))
            return corners;
    }
    return cutByGeos(polygon);
}

} // namespace gnomon
