#include "streaming/features/barriers_plan.h"

#include <geos_c.h>

#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace gnomon {

namespace {

// GEOS with a context of its own, so that any thread may come. What fails is a null geometry.
class Geos {
  public:
    Geos() : handle_(GEOS_init_r()) {}
    ~Geos() { GEOS_finish_r(handle_); }
    Geos(const Geos&) = delete;
    Geos& operator=(const Geos&) = delete;
    GEOSContextHandle_t get() const { return handle_; }

    struct Free {
        GEOSContextHandle_t handle;
        void operator()(GEOSGeometry* g) const { GEOSGeom_destroy_r(handle, g); }
    };
    using Geometry = std::unique_ptr<GEOSGeometry, Free>;
    Geometry own(GEOSGeometry* g) const { return Geometry(g, Free{handle_}); }

    GEOSCoordSequence* sequence(std::span<const glm::dvec2> points, bool closed) const {
        const std::size_t count = points.size() + (closed ? 1 : 0);
        GEOSCoordSequence* out = GEOSCoordSeq_create_r(handle_, unsigned(count), 2);
        for (std::size_t i = 0; out && i < count; ++i) {
            const glm::dvec2& p = points[i % points.size()];
            GEOSCoordSeq_setXY_r(handle_, out, unsigned(i), p.x, p.y);
        }
        return out;
    }

    Geometry polygon(std::span<const PlanRing> rings) const {
        std::vector<GEOSGeometry*> made;
        for (const PlanRing& ring : rings)
            if (ring.size() >= 3)
                if (GEOSCoordSequence* s = sequence(ring, true))
                    if (GEOSGeometry* g = GEOSGeom_createLinearRing_r(handle_, s))
                        made.push_back(g);
        if (made.empty())
            return own(nullptr);
        return own(
            GEOSGeom_createPolygon_r(handle_, made[0], made.data() + 1, unsigned(made.size() - 1)));
    }

    PlanRing ring(const GEOSGeometry* g) const {
        PlanRing out;
        const GEOSCoordSequence* s = GEOSGeom_getCoordSeq_r(handle_, g);
        unsigned size = 0;
        if (!s || !GEOSCoordSeq_getSize_r(handle_, s, &size))
            return out;
        for (unsigned i = 0; i + 1 < size; ++i) { // GEOS repeats the first point
            glm::dvec2 p(0.0);
            GEOSCoordSeq_getXY_r(handle_, s, i, &p.x, &p.y);
            out.push_back(p);
        }
        return out;
    }

    // On the grid, and valid there. Null stays null.
    Geometry onGrid(const Geometry& g) const {
        return own(g ? GEOSGeom_setPrecision_r(handle_, g.get(), kPlanGridMetres, 0) : nullptr);
    }

    // The polygons in it; lines and points that a repair left over have no area.
    std::vector<PlanPolygon> polygons(const GEOSGeometry* g) const {
        std::vector<PlanPolygon> out;
        const int parts = g ? GEOSGetNumGeometries_r(handle_, g) : 0;
        for (int i = 0; i < parts; ++i) {
            const GEOSGeometry* part = GEOSGetGeometryN_r(handle_, g, i);
            if (GEOSGeomTypeId_r(handle_, part) != GEOS_POLYGON || GEOSisEmpty_r(handle_, part))
                continue;
            PlanPolygon polygon;
            polygon.rings.push_back(ring(GEOSGetExteriorRing_r(handle_, part)));
            const int holes = GEOSGetNumInteriorRings_r(handle_, part);
            for (int k = 0; k < holes; ++k)
                polygon.rings.push_back(ring(GEOSGetInteriorRingN_r(handle_, part, k)));
            out.push_back(std::move(polygon));
        }
        return out;
    }

  private:
    GEOSContextHandle_t handle_;
};

double area2(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

} // namespace

std::vector<PlanPolygon> stripAlong(std::span<const glm::dvec2> line, double widthMetres) {
    const Geos geos;
    GEOSCoordSequence* points = geos.sequence(line, false);
    const auto path = geos.own(points ? GEOSGeom_createLineString_r(geos.get(), points) : nullptr);
    if (!path)
        return {};
    constexpr int kQuadrantSegments = 8; // of round joins, which mitred ones have none of
    const auto strip =
        geos.own(GEOSBufferWithStyle_r(geos.get(), path.get(), widthMetres / 2.0, kQuadrantSegments,
                                       GEOSBUF_CAP_FLAT, GEOSBUF_JOIN_MITRE, kMitreLimit));
    return geos.polygons(geos.onGrid(strip).get());
}

std::vector<PlanPolygon> validAreas(std::span<const PlanRing> rings) {
    const Geos geos;
    const auto polygon = geos.polygon(rings);
    if (!polygon)
        return {};
    if (GEOSisValid_r(geos.get(), polygon.get()) == 1)
        return geos.polygons(geos.onGrid(polygon).get());
    const auto repaired = geos.own(GEOSMakeValid_r(geos.get(), polygon.get()));
    return geos.polygons(geos.onGrid(repaired).get());
}

std::optional<PlanMesh> triangulated(const PlanPolygon& polygon) {
    const Geos geos;
    const auto whole = geos.polygon(polygon.rings);
    if (!whole)
        return std::nullopt;
    const auto cut = geos.own(GEOSConstrainedDelaunayTriangulation_r(geos.get(), whole.get()));
    PlanMesh mesh;
    std::map<std::pair<double, double>, std::uint32_t> known; // GEOS keeps points to the last bit
    for (const PlanPolygon& triangle : geos.polygons(cut.get())) {
        const PlanRing& ring = triangle.rings.front();
        if (ring.size() != 3)
            return std::nullopt;
        std::array<std::uint32_t, 3> t;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [at, fresh] =
                known.emplace(std::pair(ring[i].x, ring[i].y), std::uint32_t(mesh.points.size()));
            if (fresh)
                mesh.points.push_back(ring[i]);
            t[i] = at->second;
        }
        if (area2(ring[0], ring[1], ring[2]) < 0.0)
            std::swap(t[1], t[2]);
        mesh.triangles.push_back(t);
    }
    if (mesh.triangles.empty())
        return std::nullopt;
    return mesh;
}

} // namespace gnomon
