#include "geo/bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {
namespace {

// Radius of curvature of the meridian where the equator is nearest: the smallest among latitudes up
// to `change` from `latitude`.
double leastMeridianRadius(double latitudeDegrees, double changeDegrees) {
    constexpr double kRatio = kPolarRadiusMetres / kEquatorialRadiusMetres;
    constexpr double kEccentricitySquared = 1.0 - kRatio * kRatio;
    const double nearest = std::max(std::abs(latitudeDegrees) - changeDegrees, 0.0);
    const double s = std::sin(nearest * kRadiansPerDegree);
    return kPolarRadiusMetres * kRatio / std::pow(1.0 - kEccentricitySquared * s * s, 1.5);
}

// Rounding of geodetic coordinates, with room.
constexpr double kMarginDegrees = 1e-12;
constexpr double kMarginMetres = 1e-6;

// What lies wholly outside is not meant to be on the Earth: no ground is that deep, no city in
// orbit.
constexpr double kDeepestMetres = -20e3, kHighestMetres = 2000e3;

double wrapped(double degrees) {
    return std::remainder(degrees, 360.0);
}

// What is known of a volume around `centre`, before it becomes a region.
struct Spread {
    Geodetic centre;
    double radius = 0.0; // every point is within this of the centre
    double northward = 0.0, downward = 0.0, highest = 0.0;
    bool aroundAxis = false;               // a pole's axis goes through it, or may
    double westward = 0.0, eastward = 0.0; // degrees from the centre, unless aroundAxis
};

// A step ds to the north turns the latitude by ds / (M + h). North itself turns on the way from the
// centre to a point, by no more than the change of latitude and longitude together.
double latitudeChangeDegrees(const Spread& s, double lowest) {
    double change = 180.0;
    // The first round knows nothing of the latitude, the second what the first found.
    for (int round = 0; round < 2; ++round) {
        const double least = leastMeridianRadius(s.centre.latitudeDegrees, change) + lowest;
        if (least <= 0.0)
            return 180.0;
        const double byRadius = s.radius / least;
        const double turn = byRadius + std::max(s.westward, s.eastward) * kRadiansPerDegree;
        const double byNorthward = (s.northward + s.radius * turn) / least;
        change = (s.aroundAxis ? byRadius : std::min(byRadius, byNorthward)) / kRadiansPerDegree;
    }
    return change;
}

std::optional<Region> regionOf(const Spread& s) {
    const double lowest = s.centre.heightMetres - s.downward - kMarginMetres;
    const double highest = s.highest + kMarginMetres;
    if (!std::isfinite(lowest) || !std::isfinite(highest) || highest < kDeepestMetres ||
        lowest > kHighestMetres)
        return std::nullopt;
    const double dLat = latitudeChangeDegrees(s, lowest) + kMarginDegrees;
    double west = -180.0, east = 180.0;
    if (!s.aroundAxis && s.westward + s.eastward + 2.0 * kMarginDegrees < 360.0) {
        west = wrapped(s.centre.longitudeDegrees - s.westward - kMarginDegrees);
        east = wrapped(s.centre.longitudeDegrees + s.eastward + kMarginDegrees);
    }
    return makeRegion(west, s.centre.latitudeDegrees - dLat, east, s.centre.latitudeDegrees + dLat,
                      lowest, highest);
}

std::optional<Spread> spreadOf(const Sphere& sphere) {
    const Result<Geodetic> centre = geodeticFromEcef(sphere.centre);
    if (!centre)
        return std::nullopt;
    Spread s;
    s.centre = *centre;
    s.radius = s.northward = s.downward = sphere.radiusMetres;
    s.highest = s.centre.heightMetres + s.radius;
    const double fromAxis = std::hypot(sphere.centre.xyz.x, sphere.centre.xyz.y);
    s.aroundAxis = s.radius >= fromAxis;
    if (!s.aroundAxis)
        s.westward = s.eastward = std::asin(s.radius / fromAxis) / kRadiansPerDegree;
    return s;
}

std::optional<Spread> spreadOf(const OrientedBox& box) {
    const Result<Geodetic> centre = geodeticFromEcef(box.centre);
    if (!centre)
        return std::nullopt;
    Spread s;
    s.centre = *centre;
    s.radius = boundingSphere(box).radiusMetres;
    const glm::dmat3 enu = ecefFromEnu(s.centre).axes();
    const auto half = [&](const glm::dvec3& d) {
        return std::abs(glm::dot(d, box.halfAxes[0])) + std::abs(glm::dot(d, box.halfAxes[1])) +
               std::abs(glm::dot(d, box.halfAxes[2]));
    };
    s.northward = half(enu[1]);
    // Height is convex: lowest above the tangent plane below the centre, highest at a corner.
    s.downward = half(enu[2]);
    s.highest = -std::numeric_limits<double>::infinity();
    for (const Point<Ecef>& corner : corners(box)) {
        const Result<Geodetic> place = geodeticFromEcef(corner);
        if (!place)
            return std::nullopt;
        s.highest = std::max(s.highest, place->heightMetres);
        // Seen along the axis the box is the hull of its corners, and its angles theirs.
        const double turn = wrapped(place->longitudeDegrees - s.centre.longitudeDegrees);
        s.westward = std::max(s.westward, -turn);
        s.eastward = std::max(s.eastward, turn);
    }
    // Less than half a turn, or else the hull holds the axis.
    s.aroundAxis = s.westward + s.eastward + 2.0 * kMarginDegrees >= 180.0;
    return s;
}

} // namespace

std::optional<Region> geographicExtent(const BoundingVolume& volume) {
    if (const auto* region = std::get_if<Region>(&volume)) {
        if (region->maxHeightMetres < kDeepestMetres || region->minHeightMetres > kHighestMetres)
            return std::nullopt;
        return *region;
    }
    const auto* sphere = std::get_if<Sphere>(&volume);
    const std::optional<Spread> spread =
        sphere ? spreadOf(*sphere) : spreadOf(std::get<OrientedBox>(volume));
    return spread ? regionOf(*spread) : std::nullopt;
}

} // namespace gnomon
