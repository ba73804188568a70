#include "geo/region.h"

#include <GeographicLib/Math.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace gnomon {
namespace {

constexpr double kEccentricitySquared = 1.0 - (kPolarRadiusMetres / kEquatorialRadiusMetres) *
                                                  (kPolarRadiusMetres / kEquatorialRadiusMetres);

// Some units in the last place of an Earth radius (9e-10 m), the rounding of the sums below.
constexpr double kRoundingMetres = 1e-8;

// Cosine and sine; exact at multiples of 90°.
glm::dvec2 direction(double degrees) {
    glm::dvec2 d;
    GeographicLib::Math::sincosd(degrees, d.y, d.x);
    return d;
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

double normalRadius(double sinLatitude) {
    return kEquatorialRadiusMetres /
           std::sqrt(1.0 - kEccentricitySquared * sinLatitude * sinLatitude);
}

// (r, z) in the meridian plane for a latitude given by cosine and sine.
glm::dvec2 meridianPoint(const glm::dvec2& latitude, double height) {
    const double n = normalRadius(latitude.y);
    return {(n + height) * latitude.x, (n * (1.0 - kEccentricitySquared) + height) * latitude.y};
}

bool containsLongitude(const Region& region, const glm::dvec2& xy) {
    const bool eastOfWest = cross(region.west, xy) >= 0.0;
    const bool westOfEast = cross(xy, region.east) >= 0.0;
    return region.overHalfTurn ? eastOfWest || westOfEast : eastOfWest && westOfEast;
}

// Height above the ellipsoid, from below and from above, by the foot that one step of Bowring's
// method finds; near the Earth's surface both agree to a nanometre. The ellipsoid is convex, so it
// lies below the tangent at any foot, and a ball of its smallest radius of curvature (b² / a) that
// touches it there lies within it.
Interval heightBounds(const glm::dvec2& p) {
    constexpr double kSecondEccentricitySquared =
        kEccentricitySquared / (1.0 - kEccentricitySquared);
    constexpr double kBall = kPolarRadiusMetres * kPolarRadiusMetres / kEquatorialRadiusMetres;
    glm::dvec2 reduced(p.x * kPolarRadiusMetres, p.y * kEquatorialRadiusMetres);
    const double length = glm::length(reduced);
    reduced = length > 0.0 ? reduced / length : glm::dvec2(1.0, 0.0);
    glm::dvec2 latitude(
        p.x - kEccentricitySquared * kEquatorialRadiusMetres * reduced.x * reduced.x * reduced.x,
        p.y + kSecondEccentricitySquared * kPolarRadiusMetres * reduced.y * reduced.y * reduced.y);
    const double latitudeLength = glm::length(latitude);
    latitude = latitudeLength > 0.0 ? latitude / latitudeLength : glm::dvec2(1.0, 0.0);
    const glm::dvec2 fromFoot = p - meridianPoint(latitude, 0.0);
    return {glm::dot(fromFoot, latitude), glm::length(fromFoot + kBall * latitude) - kBall};
}

// Beyond a side of constant latitude the region lies in the quadrant behind the side and below its
// top (the top curves away from it). `outward` is the
// side's normal.
double squaredBeyondSide(const glm::dvec2& fromFoot, const glm::dvec2& latitude,
                         const glm::dvec2& outward, double maxHeight) {
    const double beyond = glm::dot(fromFoot, outward);
    if (beyond <= 0.0)
        return 0.0;
    const double above = std::max(glm::dot(fromFoot, latitude) - maxHeight, 0.0);
    return beyond * beyond + above * above;
}

// The square of the distance in the meridian plane; p.x may be negative (beyond the axis).
double squaredDistanceToSection(const Region& r, const glm::dvec2& p) {
    const double beyond = std::max(
        squaredBeyondSide(p - r.northFoot, r.north, {-r.north.y, r.north.x}, r.maxHeightMetres),
        squaredBeyondSide(p - r.southFoot, r.south, {r.south.y, -r.south.x}, r.maxHeightMetres));
    // A height is a distance, so what it exceeds the range by never exceeds the distance.
    const Interval height = heightBounds(p);
    const double vertical =
        std::max({height.min - r.maxHeightMetres, r.minHeightMetres - height.max, 0.0});
    return std::max(beyond, vertical * vertical);
}

struct Frame {
    glm::dmat3 axes;
    explicit Frame(double longitudeDegrees, double latitudeDegrees) {
        const glm::dvec2 lon = direction(longitudeDegrees);
        const glm::dvec2 lat = direction(latitudeDegrees);
        axes = glm::dmat3(glm::dvec3(-lon.y, lon.x, 0.0),
                          glm::dvec3(-lat.y * lon.x, -lat.y * lon.y, lat.x),
                          glm::dvec3(lat.x * lon.x, lat.x * lon.y, lat.y));
    }
};

OrientedBox boxInFrame(const Region& region, const Frame& frame) {
    OrientedBox box;
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 axis = frame.axes[i];
        const Interval range = regionExtent(region, axis);
        box.centre.xyz += 0.5 * (range.min + range.max) * axis;
        box.halfAxes[i] = (0.5 * (range.max - range.min) + kRoundingMetres) * axis;
    }
    return box;
}

double volumeOf(const OrientedBox& box) {
    return glm::length(box.halfAxes[0]) * glm::length(box.halfAxes[1]) *
           glm::length(box.halfAxes[2]);
}

} // namespace

double distanceToRegion(const Region& region, Point<Ecef> p) {
    const glm::dvec2 xy(p.xyz);
    if (containsLongitude(region, xy))
        return std::sqrt(squaredDistanceToSection(region, {glm::length(xy), p.xyz.z}));
    // Nearest is a point on the nearer side plane: squares of the distance to that plane and of the
    // distance within it add up exactly.
    const glm::dvec2 side =
        glm::dot(xy, region.west) > glm::dot(xy, region.east) ? region.west : region.east;
    const double aside = cross(side, xy);
    return std::sqrt(aside * aside +
                     squaredDistanceToSection(region, {glm::dot(xy, side), p.xyz.z}));
}

Interval regionExtent(const Region& region, const glm::dvec3& d) {
    const glm::dvec2 dXy(d);
    // d · q = a r + d.z z, where a runs over this range as the longitude does.
    Interval a{glm::dot(dXy, region.west), glm::dot(dXy, region.west)};
    a.min = std::min(a.min, glm::dot(dXy, region.east));
    a.max = std::max(a.max, glm::dot(dXy, region.east));
    if (containsLongitude(region, dXy))
        a.max = glm::length(dXy);
    if (containsLongitude(region, -dXy))
        a.min = -glm::length(dXy);

    Interval range{std::numeric_limits<double>::infinity(),
                   -std::numeric_limits<double>::infinity()};
    for (const double factor : {a.min, a.max}) {
        const glm::dvec2 d2(factor, d.z);
        const auto include = [&](const glm::dvec2& latitude) {
            for (const double height : {region.minHeightMetres, region.maxHeightMetres}) {
                const double value = glm::dot(d2, meridianPoint(latitude, height));
                range.min = std::min(range.min, value);
                range.max = std::max(range.max, value);
            }
        };
        include(region.south);
        include(region.north);
        // Along a curve of equal height the extreme is where the normal is ±d2, whatever the
        // height.
        const double length = glm::length(d2);
        if (length > 0.0) {
            const glm::dvec2 latitude = d2 / (factor < 0.0 ? -length : length);
            if (latitude.y > region.south.y && latitude.y < region.north.y)
                include(latitude);
        }
    }
    return range;
}

OrientedBox boxAroundRegion(const Region& region) {
    double width = region.eastDegrees - region.westDegrees;
    if (width < 0.0)
        width += 360.0;
    const double longitude = region.westDegrees + 0.5 * width;
    const double latitude = 0.5 * (region.southDegrees + region.northDegrees);
    OrientedBox best = boxInFrame(region, Frame(longitude, latitude));
    // For rings and caps a box along the Earth's axis may be smaller.
    constexpr double kLargeDegrees = 30.0;
    if (std::max(width, region.northDegrees - region.southDegrees) > kLargeDegrees) {
        const OrientedBox upright = boxInFrame(region, Frame(longitude, 0.0));
        if (volumeOf(upright) < volumeOf(best))
            best = upright;
    }
    return best;
}

Region makeRegion(double westDegrees, double southDegrees, double eastDegrees, double northDegrees,
                  double minHeightMetres, double maxHeightMetres) {
    assert(std::isfinite(westDegrees) && std::isfinite(eastDegrees) &&
           std::isfinite(southDegrees) && std::isfinite(northDegrees) &&
           std::isfinite(minHeightMetres) && std::isfinite(maxHeightMetres));
    // The evolute of the ellipsoid lies 6335 km and more below it.
    constexpr double kDeepest = -6.3e6;
    Region r;
    r.westDegrees = westDegrees;
    r.eastDegrees = eastDegrees;
    std::tie(r.southDegrees, r.northDegrees) =
        std::minmax({std::clamp(southDegrees, -90.0, 90.0), std::clamp(northDegrees, -90.0, 90.0)});
    std::tie(r.minHeightMetres, r.maxHeightMetres) =
        std::minmax({std::max(minHeightMetres, kDeepest), std::max(maxHeightMetres, kDeepest)});
    const double width = eastDegrees - westDegrees;
    r.overHalfTurn = width > 180.0 || (width < 0.0 && width > -180.0);
    r.west = direction(westDegrees);
    r.east = direction(eastDegrees);
    r.south = direction(r.southDegrees);
    r.north = direction(r.northDegrees);
    r.southFoot = meridianPoint(r.south, 0.0);
    r.northFoot = meridianPoint(r.north, 0.0);
    r.box = boxAroundRegion(r);
    return r;
}

} // namespace gnomon
