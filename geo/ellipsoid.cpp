#include "geo/ellipsoid.h"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Math.hpp>

#include <cmath>
#include <exception>

namespace gnomon {
namespace {

bool isFinite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

Point<Ecef> forward(const Geodetic& place) {
    Point<Ecef> p;
    GeographicLib::Geocentric::WGS84().Forward(place.latitudeDegrees, place.longitudeDegrees,
                                               place.heightMetres, p.xyz.x, p.xyz.y, p.xyz.z);
    return p;
}

Geodetic reverse(Point<Ecef> p) {
    Geodetic place;
    GeographicLib::Geocentric::WGS84().Reverse(p.xyz.x, p.xyz.y, p.xyz.z, place.latitudeDegrees,
                                               place.longitudeDegrees, place.heightMetres);
    return place;
}

} // namespace

Result<Point<Ecef>> ecefFromGeodetic(const Geodetic& place) {
    if (!std::isfinite(place.longitudeDegrees) || !std::isfinite(place.latitudeDegrees) ||
        !std::isfinite(place.heightMetres))
        return Error{"position", "longitude, latitude and height must be finite numbers"};
    if (std::abs(place.latitudeDegrees) > 90.0)
        return Error{"position", "latitude must lie between -90 and 90 degrees"};
    try {
        const Point<Ecef> p = forward(place);
        if (!isFinite(p.xyz))
            return Error{"position", "height is too large"};
        return p;
    } catch (const std::exception& e) {
        return Error{"position", e.what()};
    }
}

Result<Geodetic> geodeticFromEcef(Point<Ecef> p) {
    if (!isFinite(p.xyz))
        return Error{"position", "ECEF coordinates must be finite numbers"};
    try {
        const Geodetic place = reverse(p);
        if (!std::isfinite(place.heightMetres))
            return Error{"position", "ECEF coordinates are too large"};
        return place;
    } catch (const std::exception& e) {
        return Error{"position", e.what()};
    }
}

Point<Ecef> ecefOf(const Geodetic& place) {
    const Result<Point<Ecef>> p = ecefFromGeodetic(place);
    assert(p);
    return p ? *p : Point<Ecef>{};
}

Geodetic geodeticOf(Point<Ecef> p) {
    const Result<Geodetic> place = geodeticFromEcef(p);
    assert(place);
    return place ? *place : Geodetic{};
}

Transform<Ecef, Enu> ecefFromEnu(const Geodetic& origin) {
    double sinLon = 0, cosLon = 0, sinLat = 0, cosLat = 0;
    // In degrees, because cos 90° is then zero and an ENU frame at a pole is exact.
    GeographicLib::Math::sincosd(origin.longitudeDegrees, sinLon, cosLon);
    GeographicLib::Math::sincosd(origin.latitudeDegrees, sinLat, cosLat);
    Transform<Ecef, Enu> t;
    t.matrix[0] = glm::dvec4(-sinLon, cosLon, 0.0, 0.0);
    t.matrix[1] = glm::dvec4(-sinLat * cosLon, -sinLat * sinLon, cosLat, 0.0);
    t.matrix[2] = glm::dvec4(cosLat * cosLon, cosLat * sinLon, sinLat, 0.0);
    t.matrix[3] = glm::dvec4(ecefOf(origin).xyz, 1.0);
    return t;
}

Vector<Ecef> ellipsoidNormal(Point<Ecef> p) {
    Geodetic foot = geodeticOf(p);
    foot.heightMetres = 0.0;
    return {ecefFromEnu(foot).axes()[2]};
}

} // namespace gnomon
