#include "streaming/terrain/drape_polygons.h"

#include "geo/ellipsoid.h"
#include "streaming/features/features.h"
#include "streaming/terrain/drape_coverage.h"
#include "streaming/terrain/drape_grid.h"

#include <geos_c.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>

namespace gnomon {

namespace {

// Rings of one polygon on the unit sphere, outer ones and holes in opposite senses.
struct Shape {
    std::array<double, 4> extent{}; // west, south, east, north, east may pass 180
    std::vector<std::vector<glm::dvec3>> rings;
};

glm::dvec3 onSphere(glm::dvec2 lonLat) {
    const double lon = lonLat.x * kRadiansPerDegree, lat = lonLat.y * kRadiansPerDegree;
    return {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
}

// GEOS kept quiet, and what it makes kept from leaking.
class Geos {
  public:
    Geos() : handle_(GEOS_init_r()) {
        GEOSContext_setNoticeMessageHandler_r(
            handle_, [](const char*, void*) {}, nullptr);
        GEOSContext_setErrorMessageHandler_r(
            handle_, [](const char*, void*) {}, nullptr);
    }
    ~Geos() { GEOS_finish_r(handle_); }
    Geos(const Geos&) = delete;
    Geos& operator=(const Geos&) = delete;
    operator GEOSContextHandle_t() const { return handle_; }

  private:
    GEOSContextHandle_t handle_;
};

struct GeometryDeleter {
    GEOSContextHandle_t handle;
    void operator()(GEOSGeometry* g) const { GEOSGeom_destroy_r(handle, g); }
};
using Geometry = std::unique_ptr<GEOSGeometry, GeometryDeleter>;
using Ring = std::vector<glm::dvec2>;

Geometry ringOf(const Geos& geos, const Ring& ring) {
    const unsigned count = unsigned(ring.size());
    GEOSCoordSequence* points = GEOSCoordSeq_create_r(geos, count + 1, 2);
    if (points == nullptr)
        return {nullptr, {geos}};
    for (unsigned i = 0; i <= count; ++i)
        GEOSCoordSeq_setXY_r(geos, points, i, ring[i % count].x, ring[i % count].y);
    return {GEOSGeom_createLinearRing_r(geos, points), {geos}}; // takes the points
}

Geometry polygonOf(const Geos& geos, const std::vector<Ring>& rings) {
    Geometry outer = ringOf(geos, rings[0]);
    std::vector<GEOSGeometry*> holes;
    for (std::size_t i = 1; i < rings.size() && outer; ++i)
        if (Geometry hole = ringOf(geos, rings[i]))
            holes.push_back(hole.release());
    if (!outer)
        return {nullptr, {geos}};
    return {GEOSGeom_createPolygon_r(geos, outer.release(), holes.data(), unsigned(holes.size())),
            {geos}};
}

Ring pointsOf(const Geos& geos, const GEOSGeometry* ring) {
    Ring out;
    const GEOSCoordSequence* points = GEOSGeom_getCoordSeq_r(geos, ring);
    unsigned count = 0;
    if (points == nullptr || !GEOSCoordSeq_getSize_r(geos, points, &count))
        return out;
    for (unsigned i = 0; i + 1 < count; ++i) { // the last repeats the first
        glm::dvec2 p;
        GEOSCoordSeq_getXY_r(geos, points, i, &p.x, &p.y);
        out.push_back(p);
    }
    return out;
}

// All polygons in it, however deep.
void collect(const Geos& geos, const GEOSGeometry* g, std::vector<std::vector<Ring>>& out) {
    if (GEOSGeomTypeId_r(geos, g) == GEOS_POLYGON) {
        const GEOSGeometry* outer = GEOSGetExteriorRing_r(geos, g);
        std::vector<Ring> rings;
        if (outer != nullptr)
            rings.push_back(pointsOf(geos, outer));
        const int holes = outer != nullptr ? GEOSGetNumInteriorRings_r(geos, g) : 0;
        for (int i = 0; i < holes; ++i)
            rings.push_back(pointsOf(geos, GEOSGetInteriorRingN_r(geos, g, i)));
        if (!rings.empty() && rings[0].size() >= 3)
            out.push_back(std::move(rings));
        return;
    }
    const int type = GEOSGeomTypeId_r(geos, g);
    if (type != GEOS_MULTIPOLYGON && type != GEOS_GEOMETRYCOLLECTION)
        return;
    for (int i = 0; i < GEOSGetNumGeometries_r(geos, g); ++i)
        collect(geos, GEOSGetGeometryN_r(geos, g, i), out);
}

double signedArea(const Ring& ring) {
    double area = 0.0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
        area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    return area;
}

// Longitudes that run on past ±180, so that a polygon over the antimeridian is one piece.
std::vector<Ring> unwrapped(const FeaturePart& part) {
    std::vector<Ring> out;
    for (const FeatureRing& ring : part) {
        Ring flat;
        double last = part[0].empty() ? 0.0 : part[0][0].x;
        for (const glm::dvec3& p : ring) {
            last += std::remainder(p.x - last, 360.0);
            flat.push_back({last, p.y});
        }
        if (flat.size() >= 3)
            out.push_back(std::move(flat));
        else if (out.empty())
            return {};
    }
    return out;
}

// Long edges are straight between longitudes and latitudes, as GeoJSON has it, not on the sphere.
// A piece of this length bends by 4 cm from its chord at 45 degrees.
constexpr double kPieceDegrees = 1.0 / 64.0;
// No piece shorter than the edge's share of these, however long the edge.
constexpr double kMostPieces = 4096.0;

Shape shapeOf(const std::vector<Ring>& rings) {
    Shape shape;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    shape.extent = {kFar, kFar, -kFar, -kFar};
    for (std::size_t r = 0; r < rings.size(); ++r) {
        Ring ring = rings[r];
        if ((signedArea(ring) > 0.0) != (r == 0))
            std::reverse(ring.begin(), ring.end());
        std::vector<glm::dvec3> out;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const glm::dvec2 a = ring[i], b = ring[(i + 1) % ring.size()];
            const double pieces =
                std::clamp(std::ceil(glm::length(b - a) / kPieceDegrees), 1.0, kMostPieces);
            for (double k = 0.0; k < pieces; ++k)
                out.push_back(onSphere(glm::mix(a, b, k / pieces)));
            shape.extent = {std::min(shape.extent[0], a.x), std::min(shape.extent[1], a.y),
                            std::max(shape.extent[2], a.x), std::max(shape.extent[3], a.y)};
        }
        shape.rings.push_back(std::move(out));
    }
    return shape;
}

bool overlap(const std::array<double, 4>& a, const std::array<double, 4>& b) {
    if (a[1] > b[3] || b[1] > a[3])
        return false;
    const double apart = std::remainder(0.5 * (a[0] + a[2]) - 0.5 * (b[0] + b[2]), 360.0);
    return std::abs(apart) <= 0.5 * (a[2] - a[0] + b[2] - b[0]);
}

class Polygons : public Drape {
  public:
    explicit Polygons(const std::array<std::uint8_t, 3>& color)
        : color_{double(color[0]), double(color[1]), double(color[2])} {}

    void add(Shape shape) {
        if (shapes_.empty()) {
            extent_ = shape.extent;
        } else {
            const double middle = 0.5 * (extent_[0] + extent_[2]);
            const double shift =
                middle + std::remainder(shape.extent[0] - middle, 360.0) - shape.extent[0];
            extent_ = {std::min(extent_[0], shape.extent[0] + shift),
                       std::min(extent_[1], shape.extent[1]),
                       std::max(extent_[2], shape.extent[2] + shift),
                       std::max(extent_[3], shape.extent[3])};
        }
        shapes_.push_back(std::move(shape));
    }
    bool isEmpty() const { return shapes_.empty(); }

    std::array<double, 4> extent() const override {
        if (extent_[2] - extent_[0] >= 360.0)
            return {-180.0, extent_[1], 180.0, extent_[3]};
        return {std::remainder(extent_[0], 360.0), extent_[1], std::remainder(extent_[2], 360.0),
                extent_[3]};
    }
    double texelMetres() const override { return std::numeric_limits<double>::infinity(); }
    Failure paint(std::span<const glm::dvec2> lonLat, int width,
                  std::span<std::uint8_t> rgba) const override;

  private:
    double color_[3];
    std::array<double, 4> extent_{}; // east may pass 180
    std::vector<Shape> shapes_;
};

// Around all of them, east perhaps beyond 180, a little more than their own texels reach.
std::array<double, 4> extentOf(std::span<const glm::dvec2> lonLat) {
    const glm::dvec2 first = lonLat[lonLat.size() / 2];
    glm::dvec2 low = first, high = first;
    for (const glm::dvec2& p : lonLat) {
        const glm::dvec2 q(first.x + std::remainder(p.x - first.x, 360.0), p.y);
        low = glm::min(low, q);
        high = glm::max(high, q);
    }
    const glm::dvec2 slack = 0.02 * (high - low) + 1e-9;
    // Towards a pole all longitudes are near.
    if (std::max(std::abs(low.y), std::abs(high.y)) > 89.9)
        return {-180.0, low.y - slack.y, 180.0, high.y + slack.y};
    return {low.x - slack.x, low.y - slack.y, high.x + slack.x, high.y + slack.y};
}

Failure Polygons::paint(std::span<const glm::dvec2> lonLat, int width,
                        std::span<std::uint8_t> rgba) const {
    assert(width > 0 && rgba.size() == 4 * lonLat.size());
    const int height = int(lonLat.size() / std::size_t(width));
    if (width < 2 || height < 2)
        return {}; // no texel has a size
    const std::array<double, 4> around = extentOf(lonLat);
    std::optional<TexelPlane> plane;
    std::optional<Coverage> coverage;
    for (const Shape& shape : shapes_) {
        if (!overlap(shape.extent, around))
            continue;
        if (!plane) {
            plane.emplace(lonLat, width);
            coverage.emplace(width, height);
        }
        for (const std::vector<glm::dvec3>& ring : shape.rings)
            coverage->add(plane->texels(ring));
    }
    if (!coverage)
        return {};
    const std::vector<float> shares = coverage->shares();
    for (std::size_t k = 0; k < shares.size(); ++k)
        if (shares[k] > 0.0f)
            paintOver(&rgba[4 * k], color_, shares[k]);
    return {};
}

// What is wrong with many is said of the first few.
class Remarks {
  public:
    explicit Remarks(std::vector<std::string>& notes) : notes_(notes) {}
    void add(const std::string& note) {
        constexpr int kSaid = 5;
        if (++count_ <= kSaid)
            notes_.push_back(note);
        else
            ++more_;
    }
    ~Remarks() {
        if (more_ > 0)
            notes_.push_back("and " + std::to_string(more_) + " more like these");
    }

  private:
    std::vector<std::string>& notes_;
    int count_ = 0, more_ = 0;
};

void addPolygon(const Geos& geos, const std::string& name, const std::vector<Ring>& rings,
                Polygons& to, Remarks& remarks) {
    Geometry geometry = polygonOf(geos, rings);
    if (!geometry) {
        remarks.add(name + " is no polygon and is left out");
        return;
    }
    if (GEOSisValid_r(geos, geometry.get()) == 1) {
        to.add(shapeOf(rings));
        return;
    }
    char* reason = GEOSisValidReason_r(geos, geometry.get());
    std::string why = reason != nullptr ? reason : "not valid";
    GEOSFree_r(geos, reason);
    if (const std::size_t at = why.find('['); at != std::string::npos)
        why = why.substr(0, at) + " at " + why.substr(at + 1, why.find(']') - at - 1);
    geometry.reset(GEOSMakeValid_r(geos, geometry.get()));
    std::vector<std::vector<Ring>> pieces;
    if (geometry)
        collect(geos, geometry.get(), pieces);
    remarks.add(name + (pieces.empty() ? " has no area and is left out" : " was made valid") +
                " (" + why + ")");
    for (const std::vector<Ring>& piece : pieces)
        to.add(shapeOf(piece));
}

} // namespace

Result<std::shared_ptr<const Drape>> openDrapePolygons(const std::string& path,
                                                       const DrapeOptions& options,
                                                       std::vector<std::string>& notes) {
    FeatureOptions source;
    source.crs = options.crs;
    Result<FeatureFile> file = readFeatures(path, source);
    if (!file)
        return file.error();
    auto polygons = std::make_shared<Polygons>(options.color);
    std::vector<std::string> said = file->notes;
    std::size_t others = 0;
    {
        Remarks remarks(said);
        for (const Error& left : file->leftOut)
            remarks.add(left.message());
        const Geos geos;
        for (const Feature& feature : file->features) {
            if (feature.shape == FeatureShape::Point || feature.shape == FeatureShape::Line) {
                ++others;
                continue;
            }
            for (const FeaturePart& part : feature.parts)
                if (const std::vector<Ring> rings = unwrapped(part); !rings.empty())
                    addPolygon(geos, "polygon " + feature.id, rings, *polygons, remarks);
        }
    }
    if (others > 0)
        said.push_back(std::to_string(others) + " points or lines are not painted");
    if (polygons->isEmpty())
        return Error{path, "holds no polygon that could be painted" +
                               (said.empty() ? "" : ": " + said.front())};
    notes.insert(notes.end(), said.begin(), said.end());
    return std::shared_ptr<const Drape>(std::move(polygons));
}

} // namespace gnomon
