// Where the sun stands for a time and a place, by the IAU models in ERFA (apparent place, nutation,
// aberration); ARCHITECTURE.md says why not libnova.
#pragma once

#include "geo/ellipsoid.h"
#include "geo/time.h"

namespace gnomon {

inline constexpr double kSunDiameterDegrees = 0.533;

// The sun's apparent geocentric place, true equator and equinox of date.
struct SunEquatorial {
    double rightAscensionDegrees = 0.0; // [0, 360)
    double declinationDegrees = 0.0;
    double distanceAu = 1.0;
};
SunEquatorial sunEquatorial(UtcTime time);

struct SunPosition {
    double azimuthDegrees = 0.0;   // clockwise from north, [0, 360)
    double elevationDegrees = 0.0; // above the geodetic horizon
    Vector<Ecef> towards;          // unit, from the place to the sun
};

enum class Refraction { Off, On }; // On: standard atmosphere at sea level (1013.25 hPa, 10 °C)

SunPosition sunAt(UtcTime time, const Geodetic& place, Refraction refraction = Refraction::On);
// The direction for an azimuth and elevation given by hand.
SunPosition sunFromAngles(double azimuthDegrees, double elevationDegrees, const Geodetic& place);

} // namespace gnomon
