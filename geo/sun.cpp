#include "geo/sun.h"

#include <erfa.h>
#include <erfam.h>

#include <algorithm>
#include <cmath>

namespace gnomon {
namespace {

// Julian dates in two parts, whole days first, as ERFA wants them.
struct JulianDate {
    double day = 0.0, fraction = 0.0;
};

struct Moment {
    JulianDate utc; // stands for UT1 too: they differ by less than 0.9 s (13.5″ of rotation)
    JulianDate tt;
};

// Before 1960 there was no UTC, and after the table's end nobody knows: ERFA then gives what it has
// last, which for the sun (1″ in 24 s) is good for a century around.
double taiMinusUtcSeconds(JulianDate utc) {
    int year = 0, month = 0, day = 0;
    double fraction = 0.0, seconds = 0.0;
    if (eraJd2cal(utc.day, utc.fraction, &year, &month, &day, &fraction) != 0)
        return 0.0;
    return eraDat(year, month, day, fraction, &seconds) < 0 ? 0.0 : seconds;
}

Moment momentOf(UtcTime time) {
    assert(std::isfinite(time.seconds));
    constexpr double kUnixEpoch = 2440587.5;
    const double days = std::floor(time.seconds / ERFA_DAYSEC);
    Moment m;
    m.utc = {kUnixEpoch + days, time.seconds / ERFA_DAYSEC - days};
    const double ttMinusUtc = taiMinusUtcSeconds(m.utc) + ERFA_TTMTAI;
    m.tt = {m.utc.day, m.utc.fraction + ttMinusUtc / ERFA_DAYSEC};
    return m;
}

struct Apparent {
    glm::dvec3 direction; // unit, true equator and equinox of date
    double distanceAu = 1.0;
    double bpn[3][3]; // bias, precession and nutation, which led there
};

// Geocentric. From the Earth's place now to the sun's when the light left, turned by the Earth's
// velocity (aberration) and into the axes of date.
Apparent apparentSun(const Moment& m) {
    double heliocentric[2][3], barycentric[2][3];
    // A status of 1 only says that the year is outside 1900–2100, where its terms are fitted.
    eraEpv00(m.tt.day, m.tt.fraction, heliocentric, barycentric);

    double sun[2][3]; // barycentric
    eraPvmpv(barycentric, heliocentric, sun);
    double distance = eraPm(heliocentric[0]);
    double towards[3];
    constexpr double kDaysPerAu = ERFA_AULT / ERFA_DAYSEC;
    for (int i = 0; i < 3; ++i)
        towards[i] = sun[0][i] - sun[1][i] * distance * kDaysPerAu - barycentric[0][i];
    double natural[3], velocity[3], proper[3];
    eraPn(towards, &distance, natural);
    eraSxp(kDaysPerAu, barycentric[1], velocity); // in units of the speed of light
    const double lorentz = std::sqrt(1.0 - eraPdp(velocity, velocity));
    eraAb(natural, velocity, distance, lorentz, proper);

    Apparent a;
    a.distanceAu = distance;
    eraPnm06a(m.tt.day, m.tt.fraction, a.bpn);
    double ofDate[3];
    eraRxp(a.bpn, proper, ofDate);
    a.direction = glm::dvec3(ofDate[0], ofDate[1], ofDate[2]);
    return a;
}

// Sæmundsson, Sky and Telescope 72 (1986): from the true elevation, in degrees, for 1010 hPa and
// 10 °C; brought to 1013.25 hPa. Below -1.9° the formula turns back, and light that low never
// comes: from its highest value there it fades out smoothly, so that what is seen stays monotone.
double refractionDegrees(double elevation) {
    constexpr double kPressure = 1013.25 / 1010.0;
    constexpr double kA = 10.3, kB = 5.11;
    static const double kTurn = std::sqrt(kA) - kB; // where d/dh (h + a / (h + b)) = 0
    constexpr double kFadeDegrees = 3.0;
    const double h = std::max(elevation, kTurn);
    const double angle = (h + kA / (h + kB)) * kRadiansPerDegree;
    const double formula = kPressure * 1.02 / 60.0 / std::tan(angle);
    const double below = std::min(elevation - kTurn, 0.0) / kFadeDegrees;
    return std::max(formula, 0.0) * std::exp(-below * below);
}

SunPosition positionFor(const glm::dvec3& enu, const Transform<Ecef, Enu>& ecefFromLocal) {
    SunPosition sun;
    sun.azimuthDegrees = std::atan2(enu.x, enu.y) / kRadiansPerDegree;
    if (sun.azimuthDegrees < 0.0)
        sun.azimuthDegrees += 360.0;
    sun.elevationDegrees = std::atan2(enu.z, std::hypot(enu.x, enu.y)) / kRadiansPerDegree;
    sun.towards = normalize(ecefFromLocal(Vector<Enu>{enu}));
    return sun;
}

} // namespace

SunEquatorial sunEquatorial(UtcTime time) {
    const Apparent a = apparentSun(momentOf(time));
    SunEquatorial sun;
    sun.rightAscensionDegrees =
        eraAnp(std::atan2(a.direction.y, a.direction.x)) / kRadiansPerDegree;
    sun.declinationDegrees =
        std::atan2(a.direction.z, std::hypot(a.direction.x, a.direction.y)) / kRadiansPerDegree;
    sun.distanceAu = a.distanceAu;
    return sun;
}

SunPosition sunAt(UtcTime time, const Geodetic& place, Refraction refraction) {
    const Moment m = momentOf(time);
    Apparent a = apparentSun(m);
    const double siderealAngle =
        eraGst06(m.utc.day, m.utc.fraction, m.tt.day, m.tt.fraction, a.bpn);
    // Polar motion (0.3″) is left out.
    const double c = std::cos(siderealAngle), s = std::sin(siderealAngle);
    const glm::dvec3 ecef(c * a.direction.x + s * a.direction.y,
                          c * a.direction.y - s * a.direction.x, a.direction.z);

    const Transform<Ecef, Enu> ecefFromLocal = ecefFromEnu(place);
    // From the place, not from the Earth's centre: up to 8.8″.
    const glm::dvec3 fromPlace = a.distanceAu * ERFA_DAU * ecef - ecefFromLocal.origin().xyz;
    const glm::dvec3 enu = glm::transpose(ecefFromLocal.axes()) * glm::normalize(fromPlace);
    SunPosition sun = positionFor(enu, ecefFromLocal);
    if (refraction == Refraction::On)
        sun = sunFromAngles(
            sun.azimuthDegrees,
            std::min(90.0, sun.elevationDegrees + refractionDegrees(sun.elevationDegrees)), place);
    return sun;
}

SunPosition sunFromAngles(double azimuthDegrees, double elevationDegrees, const Geodetic& place) {
    const double azimuth = azimuthDegrees * kRadiansPerDegree;
    const double elevation = elevationDegrees * kRadiansPerDegree;
    const glm::dvec3 enu(std::cos(elevation) * std::sin(azimuth),
                         std::cos(elevation) * std::cos(azimuth), std::sin(elevation));
    SunPosition sun = positionFor(enu, ecefFromEnu(place));
    // As they were given, also straight up, where the vector has forgotten the azimuth.
    sun.azimuthDegrees = azimuthDegrees - 360.0 * std::floor(azimuthDegrees / 360.0);
    sun.elevationDegrees = elevationDegrees;
    return sun;
}

} // namespace gnomon
