// Geodetic coordinates, ECEF and local east-north-up on WGS 84. A thin, typed face of GeographicLib
// (Karney, "Geodesics on an ellipsoid of revolution", 2011), good to some nanometres.
#pragma once

#include "geo/frames.h"
#include "geo/result.h"

#include <numbers>

namespace gnomon {

inline constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
inline constexpr double kEquatorialRadiusMetres = 6378137.0;
inline constexpr double kPolarRadiusMetres = 6356752.314245179;

// Heights are above the ellipsoid. Longitude is in [-180, 180].
struct Geodetic {
    double longitudeDegrees = 0.0;
    double latitudeDegrees = 0.0;
    double heightMetres = 0.0;
};

// Fails for NaN, infinity and |latitude| > 90.
Result<Point<Ecef>> ecefFromGeodetic(const Geodetic& place);
// Fails for NaN and infinity. The Earth's centre is latitude 90, height -6356752.3 m.
Result<Geodetic> geodeticFromEcef(Point<Ecef> p);

// The same for places already known to be finite (asserts otherwise).
Point<Ecef> ecefOf(const Geodetic& place);
Geodetic geodeticOf(Point<Ecef> p);

// East, north, up at `origin`; at a pole the longitude given decides which way east is.
Transform<Ecef, Enu> ecefFromEnu(const Geodetic& origin);
// Unit normal of the ellipsoid below `p`.
Vector<Ecef> ellipsoidNormal(Point<Ecef> p);

} // namespace gnomon
