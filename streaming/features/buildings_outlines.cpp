// Outlines as they must be to be put up: none crosses itself, none is there twice.
#include "geo/plan_frame.h"
#include "streaming/features/buildings_model.h"
#include "streaming/features/features_read.h"
#include "streaming/features/triangulate.h"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool samePlace(const glm::dvec3& a, const glm::dvec3& b) {
    return a.x == b.x && a.y == b.y;
}

// Without repeated vertices; rings with fewer than three are none.
FeaturePart withoutRepeats(const FeaturePart& part) {
    FeaturePart out;
    for (const FeatureRing& ring : part) {
        FeatureRing kept;
        for (const glm::dvec3& p : ring)
            if (kept.empty() || !samePlace(kept.back(), p))
                kept.push_back(p);
        while (kept.size() > 1 && samePlace(kept.front(), kept.back()))
            kept.pop_back();
        if (kept.size() >= 3)
            out.push_back(std::move(kept));
        else if (out.empty())
            return {};
    }
    return out;
}

// The z of new vertices, where outlines crossed, is that of the nearest old one.
double nearestHeight(const std::vector<PlanRing>& rings, const FeaturePart& part,
                     const glm::dvec2& at) {
    double best = std::numeric_limits<double>::infinity(), z = kNaN;
    for (std::size_t r = 0; r < rings.size(); ++r)
        for (std::size_t i = 0; i < rings[r].size(); ++i)
            if (const double d = glm::length(rings[r][i] - at); d < best) {
                best = d;
                z = part[r][i].z;
            }
    return z;
}

enum class Outline { Sound, Mended, NoArea, TooLong, TooTangled };

// Cutting an outline into triangles takes time by their square.
constexpr std::size_t kMostVertices = 100'000;

struct Mended {
    std::vector<FeaturePart> parts;
    Outline was = Outline::NoArea;
    double areaSquareMetres = 0.0; // of the outer ring, roughly
};

Mended mended(const FeaturePart& raw) {
    FeaturePart part = withoutRepeats(raw);
    if (part.empty())
        return {};
    std::size_t vertices = 0;
    for (const FeatureRing& ring : part)
        vertices += ring.size();
    if (vertices > kMostVertices)
        return {{}, Outline::TooLong};
    const PlanFrame frame{glm::dvec2(part[0][0])};
    std::vector<PlanRing> rings;
    for (const FeatureRing& ring : part) {
        PlanRing& plan = rings.emplace_back();
        for (const glm::dvec3& p : ring)
            plan.push_back(frame.plan(p));
    }
    const double covered = std::abs(signedArea(rings[0]));
    if (isSound(rings))
        return {{std::move(part)}, Outline::Sound, covered};
    if (crossesTooOften(rings))
        return {{}, Outline::TooTangled, covered};
    Mended out{{}, Outline::Mended, covered};
    for (const PlanPolygon& area : validAreas(rings)) {
        FeaturePart& made = out.parts.emplace_back();
        for (const PlanRing& ring : area.rings) {
            FeatureRing& corners = made.emplace_back();
            for (const glm::dvec2& p : ring)
                corners.emplace_back(frame.lonLat(p), nearestHeight(rings, part, p));
        }
    }
    if (out.parts.empty())
        out.was = Outline::NoArea;
    return out;
}

void findExtent(BuildingBody& body) {
    const double start = body.parts[0][0][0].x;
    body.west = body.south = std::numeric_limits<double>::infinity();
    body.east = body.north = -body.west;
    for (const FeaturePart& part : body.parts)
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring) {
                const double x = start + std::remainder(p.x - start, 360.0);
                body.west = std::min(body.west, x);
                body.east = std::max(body.east, x);
                body.south = std::min(body.south, p.y);
                body.north = std::max(body.north, p.y);
            }
}

// All outlines in one plane, to be compared.
class Outlines {
  public:
    explicit Outlines(const std::vector<BuildingBody>& bodies)
        : bodies_(bodies), handle_(GEOS_init_r()), tree_(GEOSSTRtree_create_r(handle_, 10)) {
        geometries_.resize(bodies.size(), nullptr);
        areas_.resize(bodies.size(), 0.0);
        index_.resize(bodies.size());
        std::iota(index_.begin(), index_.end(), std::size_t(0));
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            if (bodies[i].isSurface)
                continue;
            geometries_[i] = geometryOf(bodies[i]);
            if (geometries_[i] == nullptr)
                continue;
            GEOSArea_r(handle_, geometries_[i], &areas_[i]);
            GEOSSTRtree_insert_r(handle_, tree_, geometries_[i], &index_[i]);
        }
    }
    ~Outlines() {
        GEOSSTRtree_destroy_r(handle_, tree_);
        for (GEOSGeometry* g : geometries_)
            GEOSGeom_destroy_r(handle_, g);
        GEOS_finish_r(handle_);
    }
    Outlines(const Outlines&) = delete;
    Outlines& operator=(const Outlines&) = delete;

    // Those with their boxes inside that of `i`.
    std::vector<std::size_t> inside(std::size_t i) const {
        std::vector<std::size_t> found;
        if (geometries_[i] == nullptr)
            return found;
        GEOSSTRtree_query_r(
            handle_, tree_, geometries_[i],
            [](void* item, void* out) {
                static_cast<std::vector<std::size_t>*>(out)->push_back(
                    *static_cast<std::size_t*>(item));
            },
            &found);
        constexpr double kSlack = 1e-7; // degrees: a centimetre
        const BuildingBody& a = bodies_[i];
        std::erase_if(found, [&](std::size_t j) {
            const BuildingBody& b = bodies_[j];
            return j == i || b.west < a.west - kSlack || b.south < a.south - kSlack ||
                   b.east > a.east + kSlack || b.north > a.north + kSlack;
        });
        std::sort(found.begin(), found.end()); // the tree's order is its own
        return found;
    }
    bool isTwin(std::size_t i, std::size_t j) const {
        constexpr double kSame = 1e-9;
        return std::abs(areas_[i] - areas_[j]) <= kSame * areas_[i] &&
               GEOSEquals_r(handle_, geometries_[i], geometries_[j]) == 1;
    }
    // Two or more smaller ones leave nearly nothing of it.
    bool isCovered(std::size_t i, std::vector<std::size_t> by) const {
        constexpr double kWhole = 0.98;
        std::erase_if(by, [&](std::size_t j) { return areas_[j] >= kWhole * areas_[i]; });
        double most = 0.0;
        for (const std::size_t j : by)
            most += areas_[j];
        if (by.size() < 2 || most < kWhole * areas_[i])
            return false;
        std::vector<GEOSGeometry*> copies;
        for (const std::size_t j : by)
            copies.push_back(GEOSGeom_clone_r(handle_, geometries_[j]));
        GEOSGeometry* all = GEOSGeom_createCollection_r(handle_, GEOS_GEOMETRYCOLLECTION,
                                                        copies.data(), unsigned(copies.size()));
        GEOSGeometry* together = all ? GEOSUnaryUnion_r(handle_, all) : nullptr;
        GEOSGeometry* common =
            together ? GEOSIntersection_r(handle_, together, geometries_[i]) : nullptr;
        double area = 0.0;
        if (common)
            GEOSArea_r(handle_, common, &area);
        for (GEOSGeometry* g : {all, together, common})
            GEOSGeom_destroy_r(handle_, g);
        return area >= kWhole * areas_[i];
    }

  private:
    GEOSGeometry* ringOf(const FeatureRing& ring) const {
        const auto size = unsigned(ring.size());
        GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(handle_, size + 1, 2);
        // Degrees, as wide as high; longitudes go on past 180.
        const double start = bodies_.front().west;
        const double across = std::cos(bodies_.front().south * kRadiansPerDegree);
        for (unsigned i = 0; sequence && i <= size; ++i) {
            const glm::dvec3& p = ring[i % size];
            GEOSCoordSeq_setXY_r(handle_, sequence, i, std::remainder(p.x - start, 360.0) * across,
                                 p.y);
        }
        return sequence ? GEOSGeom_createLinearRing_r(handle_, sequence) : nullptr;
    }
    GEOSGeometry* geometryOf(const BuildingBody& body) const {
        std::vector<GEOSGeometry*> polygons;
        for (const FeaturePart& part : body.parts) {
            std::vector<GEOSGeometry*> rings;
            for (const FeatureRing& ring : part)
                if (GEOSGeometry* made = ringOf(ring))
                    rings.push_back(made);
            if (!rings.empty())
                if (GEOSGeometry* polygon = GEOSGeom_createPolygon_r(
                        handle_, rings[0], rings.data() + 1, unsigned(rings.size() - 1)))
                    polygons.push_back(polygon);
        }
        if (polygons.size() == 1)
            return polygons[0];
        return polygons.empty()
                   ? nullptr
                   : GEOSGeom_createCollection_r(handle_, GEOS_MULTIPOLYGON, polygons.data(),
                                                 unsigned(polygons.size()));
    }

    const std::vector<BuildingBody>& bodies_;
    GEOSContextHandle_t handle_;
    GEOSSTRtree* tree_;
    std::vector<GEOSGeometry*> geometries_;
    std::vector<double> areas_;
    std::vector<std::size_t> index_;
};

// "a, b, c and 29 more"
std::string someOf(const std::vector<std::string>& ids) {
    constexpr std::size_t kNamed = 3;
    std::string text;
    for (std::size_t i = 0; i < std::min(ids.size(), kNamed); ++i)
        text += (i == 0 ? "" : ", ") + ids[i];
    return ids.size() > kNamed ? text + " and " + std::to_string(ids.size() - kNamed) + " more"
                               : text;
}

void dropCovered(std::vector<BuildingBody>& bodies, FeatureFile& file) {
    std::vector<std::uint8_t> drop(bodies.size(), 0);
    std::vector<std::string> twins, wholes;
    {
        const Outlines outlines(bodies);
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            const std::vector<std::size_t> inside = outlines.inside(i);
            const bool twin = std::any_of(inside.begin(), inside.end(), [&](std::size_t j) {
                return j < i && !drop[j] && outlines.isTwin(i, j);
            });
            drop[i] = twin || outlines.isCovered(i, inside);
            if (drop[i])
                (twin ? twins : wholes).push_back(bodies[i].id);
        }
    }
    if (!twins.empty())
        file.notes.push_back(someOf(twins) + ": the same outline is there twice; one is shown");
    if (!wholes.empty())
        file.notes.push_back(someOf(wholes) +
                             ": smaller outlines cover it wholly; they are shown instead");
    std::size_t i = 0;
    std::erase_if(bodies, [&](const BuildingBody&) { return drop[i++] != 0; });
}

class Collector {
  public:
    Collector(FeatureFile& file, const std::string& name) : file_(file), name_(name) {}

    std::vector<BuildingBody> run() {
        for (Feature& feature : file_.features)
            take(feature);
        if (const auto rest = crossing_.rest())
            file_.notes.push_back(*rest);
        if (!vast_.empty())
            file_.notes.push_back(someOf(vast_) +
                                  ": larger than any building (1 km²); perhaps a district");
        if (const auto rest = lost_.rest())
            file_.leftOut.push_back({name_, *rest});
        if (others_ > 0)
            file_.notes.push_back(std::to_string(others_) +
                                  " points and lines are no outlines: left out");
        return std::move(bodies_);
    }

  private:
    void take(Feature& feature) {
        if (feature.shape != FeatureShape::Polygon && feature.shape != FeatureShape::Surface) {
            ++others_;
            return;
        }
        BuildingBody body;
        body.id = std::move(feature.id);
        body.isSurface = feature.shape == FeatureShape::Surface;
        if (body.isSurface)
            takeFaces(feature, body);
        else
            takeOutlines(feature, body);
        if (body.parts.empty())
            return;
        body.attributes = std::move(feature.attributes);
        findExtent(body);
        bodies_.push_back(std::move(body));
    }

    void takeFaces(Feature& feature, BuildingBody& body) {
        for (FeaturePart& part : feature.parts) {
            bool placed = true;
            for (const FeatureRing& ring : part)
                for (const glm::dvec3& p : ring)
                    placed &= std::isfinite(p.z);
            if (placed && !part.empty())
                body.parts.push_back(std::move(part));
        }
        if (body.parts.empty())
            leaveOut(body.id, "its surfaces have no heights");
    }

    void takeOutlines(const Feature& feature, BuildingBody& body) {
        constexpr double kVastSquareMetres = 1e6;
        double area = 0.0;
        bool wasMended = false;
        for (const FeaturePart& part : feature.parts) {
            Mended made = mended(part);
            wasMended |= made.was == Outline::Mended;
            if (made.was == Outline::TooLong)
                leaveOut(body.id, "its outline has more than " + std::to_string(kMostVertices) +
                                      " vertices");
            else if (made.was == Outline::TooTangled)
                leaveOut(body.id, "its outline crosses itself too often to be mended");
            else if (made.was == Outline::NoArea && feature.parts.size() == 1)
                leaveOut(body.id, "its outline has no area");
            for (FeaturePart& one : made.parts)
                body.parts.push_back(std::move(one));
            area += made.areaSquareMetres;
        }
        if (area > kVastSquareMetres)
            vast_.push_back(body.id);
        if (wasMended && crossing_.add())
            file_.notes.push_back(body.id + ": its outline crosses itself; mended");
    }

    void leaveOut(const std::string& id, const std::string& reason) {
        if (lost_.add())
            file_.leftOut.push_back({name_ + ", " + id, reason});
    }

    FeatureFile& file_;
    const std::string& name_;
    std::vector<BuildingBody> bodies_;
    ManyLines crossing_{"outlines that cross themselves; mended"},
        lost_{"buildings with such outlines"};
    std::vector<std::string> vast_;
    std::size_t others_ = 0;
};

} // namespace

std::vector<BuildingBody> bodiesOf(FeatureFile& file, const std::string& name) {
    std::vector<BuildingBody> bodies = Collector(file, name).run();
    file.features.clear();
    file.features.shrink_to_fit();
    if (!bodies.empty())
        dropCovered(bodies, file);
    return bodies;
}

} // namespace gnomon
