// From a file's own coordinates to longitude, latitude and height above the ellipsoid.
#include "streaming/features/features_read.h"
#include "streaming/terrain/gdal_quiet.h"

#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Placement {
    CrsToEcef crs;
    double metresPerHeight = 1.0; // of heights the CRS itself does not bring to the ellipsoid
};

std::string wktOf(const OGRSpatialReference& reference) {
    char* text = nullptr;
    const std::array<const char*, 2> options = {"FORMAT=WKT2_2019", nullptr};
    const bool done = reference.exportToWkt(&text, options.data()) == OGRERR_NONE && text;
    const std::string wkt = done ? text : "";
    CPLFree(text);
    return wkt;
}

// Of a compound system whose geoid is not installed: its horizontal part, with heights above EGM96.
std::optional<Placement> withoutOwnGeoid(const std::string& crs) {
    const GdalQuiet quiet;
    OGRSpatialReference reference;
    if (reference.SetFromUserInput(crs.c_str()) != OGRERR_NONE || !reference.IsCompound())
        return {};
    const double unit = reference.GetTargetLinearUnits("VERT_CS");
    if (reference.StripVertical() != OGRERR_NONE)
        return {};
    Result<CrsToEcef> flat = CrsToEcef::create(wktOf(reference), Heights::Egm96);
    if (!flat || !(unit > 0.0))
        return {};
    return Placement{std::move(*flat), unit};
}

// Most of its vertices could be longitude and latitude; a few may be wrong.
bool areDegrees(const RawFeatures& raw) {
    std::size_t could = 0, all = 0;
    for (const Feature& feature : raw.features)
        for (const FeaturePart& part : feature.parts)
            for (const FeatureRing& ring : part)
                for (const glm::dvec3& p : ring) {
                    ++all;
                    could += std::abs(p.x) <= 360.0 && std::abs(p.y) <= 90.0;
                }
    return 2 * could >= all;
}

// Which system the layer is in; the one given counts where the file names none.
Result<std::string> crsOf(const RawFeatures& raw, const std::string& path,
                          const FeatureOptions& options, FeatureFile& file) {
    if (!raw.crs.empty() && !(raw.crsIsFormats && options.crs && !areDegrees(raw)))
        return raw.crs;
    if (!options.crs)
        return Error{path, "does not name its coordinate reference system; give it with --crs "
                           "EPSG:n"};
    if (!raw.crs.empty())
        file.notes.push_back("its coordinates are no degrees, as its format would have them: they "
                             "are taken to be in " +
                             *options.crs);
    return *options.crs;
}

Result<Placement> placementOf(const std::string& crs, const std::string& name,
                              const std::string& path, const FeatureOptions& options,
                              FeatureFile& file) {
    Result<CrsToEcef> direct = CrsToEcef::create(crs, options.heights);
    if (direct)
        return Placement{std::move(*direct), 1.0};
    if (std::optional<Placement> flat = withoutOwnGeoid(crs)) {
        file.notes.push_back(name + " " + direct.error().reason +
                             "; its heights are taken as above EGM96, which may be off by some "
                             "decimetres");
        return std::move(*flat);
    }
    if (options.crs && crs == *options.crs)
        return Error{"--crs", direct.error().message(), ErrorKind::Usage};
    return Error{path, direct.error().message()};
}

template <class Use>
void eachVertex(std::vector<Feature>& features, const Use& use) {
    for (Feature& feature : features)
        for (FeaturePart& part : feature.parts)
            for (FeatureRing& ring : part)
                for (glm::dvec3& vertex : ring)
                    use(feature, vertex);
}

// Exporters that must write a height write 0: such a layer is flat.
void flattenIfAllZero(RawFeatures& raw, FeatureFile& file) {
    bool any = false, all = true;
    eachVertex(raw.features, [&](const Feature&, const glm::dvec3& p) {
        any |= !std::isnan(p.z);
        all &= std::isnan(p.z) || p.z == 0.0;
    });
    if (!any || !all)
        return;
    eachVertex(raw.features, [](const Feature&, glm::dvec3& p) { p.z = kNaN; });
    file.notes.push_back("its heights are all 0: it is taken to be flat");
}

void place(glm::dvec3& p, const Placement& placement, double raise) {
    const bool flat = std::isnan(p.z);
    const Result<Geodetic> there =
        placement.crs.geodetic({p.x, p.y, flat ? 0.0 : p.z * placement.metresPerHeight});
    p = there ? glm::dvec3(there->longitudeDegrees, there->latitudeDegrees,
                           flat ? kNaN : there->heightMetres + raise)
              : glm::dvec3(kNaN);
}

bool hasPlace(const Feature& feature) {
    for (const FeaturePart& part : feature.parts)
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring)
                if (std::isnan(p.x))
                    return false;
    return true;
}

// Twice the area vector of a ring, in square metres, east, north, up.
glm::dvec3 areaVector(const FeatureRing& ring) {
    const double north = 6371e3 * kRadiansPerDegree; // metres a degree, roughly
    const double east = north * std::cos(ring.front().y * kRadiansPerDegree);
    const auto at = [&](std::size_t i) {
        const glm::dvec3& p = ring[i % ring.size()];
        return glm::dvec3(std::remainder(p.x - ring.front().x, 360.0) * east,
                          (p.y - ring.front().y) * north, p.z - ring.front().z);
    };
    glm::dvec3 sum(0.0);
    for (std::size_t i = 1; i + 1 < ring.size(); ++i)
        sum += glm::cross(at(i), at(i + 1));
    return sum;
}

// A polygon that stands upright is a wall, and what it belongs to a body of surfaces in space.
// Steeper than any roof that is drawn as a footprint: 84 degrees.
bool isUpright(const FeatureRing& ring) {
    constexpr double kUpright = 0.1;
    if (ring.size() < 3 || std::isnan(ring.front().z))
        return false;
    const glm::dvec3 area = areaVector(ring);
    return std::abs(area.z) < kUpright * glm::length(area);
}

void recognizeSurfaces(std::vector<Feature>& features) {
    for (Feature& feature : features)
        if (feature.shape == FeatureShape::Polygon &&
            std::any_of(feature.parts.begin(), feature.parts.end(),
                        [](const FeaturePart& part) { return isUpright(part.front()); }))
            feature.shape = FeatureShape::Surface;
}

} // namespace

Failure placeFeatures(RawFeatures raw, const std::string& path, const FeatureOptions& options,
                      FeatureFile& file) {
    if (raw.features.empty())
        return {};
    const Result<std::string> crs = crsOf(raw, path, options, file);
    if (!crs)
        return crs.error();
    const std::string name = *crs == raw.crs && !raw.crsName.empty() ? raw.crsName : *crs;
    const Result<Placement> placement = placementOf(*crs, name, path, options, file);
    if (!placement)
        return placement.error();
    if (file.crs.empty())
        file.crs = name;
    flattenIfAllZero(raw, file);
    eachVertex(raw.features,
               [&](const Feature&, glm::dvec3& p) { place(p, *placement, options.raiseMetres); });

    ManyLines lost("features have coordinates that " + name + " has no place for");
    std::vector<Feature> placed;
    placed.reserve(raw.features.size());
    for (Feature& feature : raw.features) {
        if (hasPlace(feature))
            placed.push_back(std::move(feature));
        else if (lost.add())
            file.leftOut.push_back(
                {path + ", " + feature.id, "has coordinates that " + name + " has no place for"});
    }
    if (placed.empty()) {
        file.leftOut.clear();
        return Error{path, "none of its " + std::to_string(raw.features.size()) +
                               " features lies where " + name +
                               " has a place: its coordinates may be in another system"};
    }
    if (const auto rest = lost.rest())
        file.leftOut.push_back({path, *rest});
    recognizeSurfaces(placed);
    file.features.insert(file.features.end(), std::make_move_iterator(placed.begin()),
                         std::make_move_iterator(placed.end()));
    return {};
}

} // namespace gnomon
