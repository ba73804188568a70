#include "viewer/daylight.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// Optical depth of a clear sky's air and haze towards the zenith, at 650, 550 and 450 nm: Rayleigh
// 0.05, 0.10, 0.22 (Bucholtz 1995) and 0.06, 0.07, 0.09 of aerosol.
const glm::dvec3 kOpticalDepth(0.11, 0.17, 0.31);

constexpr double kHazeHeightMetres = 2000.0; // scale height; composite.frag's HAZE_HEIGHT
constexpr double kAirHeightMetres = 8000.0;

double smoothstep(double a, double b, double x) {
    const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// Kasten & Young, "Revised optical air mass tables", 1989; held constant below the horizon.
double airMass(double elevationDegrees) {
    const double e = std::max(elevationDegrees, -0.5);
    return 1.0 / (std::sin(e * kRadiansPerDegree) + 0.50572 * std::pow(e + 6.07995, -1.6364));
}

// How bright the sky is: falls by a factor of e every 2.5° below the horizon (civil twilight takes
// it to a tenth), saturates by day.
double skyBrightness(double elevationDegrees) {
    const double floor = 0.012; // a moonlit night, so that one sees at all
    if (elevationDegrees < 0.0)
        return floor + 0.25 * std::exp(elevationDegrees / 2.5);
    return floor + 0.25 + 0.75 * std::pow(std::sin(elevationDegrees * kRadiansPerDegree), 0.6);
}

glm::vec4 rgb(const glm::dvec3& c, double w = 0.0) {
    return glm::vec4(glm::dvec4(c, w));
}

} // namespace

double eyeOpening(double sunElevationDegrees) {
    // With the square root of what the sky loses, up to twice: a low sun is still seen by.
    return std::min(1.0 / std::sqrt(skyBrightness(sunElevationDegrees)), 2.0);
}

double sunShareAboveHorizon(double elevationDegrees, double eyeHeightMetres) {
    const double h = std::max(eyeHeightMetres, 0.0);
    const double dip =
        std::acos(kEquatorialRadiusMetres / (kEquatorialRadiusMetres + h)) / kRadiansPerDegree;
    return smoothstep(-0.5 * kSunDiameterDegrees, 0.5 * kSunDiameterDegrees,
                      elevationDegrees + dip);
}

shader::LookBlock daylight(const SunPosition& sun, const Camera& camera,
                           const glm::dmat3& meshAxes) {
    const glm::dmat3 stored = glm::transpose(meshAxes);
    const double e = sun.elevationDegrees;
    // In steps too small to see: the ellipsoid curves a little differently from place to place, and
    // without them that would show in the last bit of a haze.
    const auto stepped = [](double x, double step) { return std::round(x / step) * step; };
    const double height = stepped(geodeticOf(camera.position).heightMetres, 0.25);
    glm::dvec3 up = glm::transpose(meshAxes) * ellipsoidNormal(camera.position).xyz;
    for (int i = 0; i < 3; ++i)
        up[i] = stepped(up[i], 1e-5);
    const glm::dvec3 through = glm::exp(-kOpticalDepth * airMass(e));
    const double share = sunShareAboveHorizon(e, 0.0);
    const double sky = skyBrightness(e);
    // Near the horizon the sky takes the colour of the light that crossed it.
    const double low = 1.0 - smoothstep(0.0, 20.0, std::abs(e));
    const glm::dvec3 warm = glm::mix(glm::dvec3(1.0), glm::pow(through, glm::dvec3(0.12)), low);

    // Seen from high up the horizon sinks: cos(dip) = R / (R + h).
    const double cosDip =
        kEquatorialRadiusMetres / (kEquatorialRadiusMetres + std::max(height, 0.0));
    const double dip = std::sqrt(1.0 - cosDip * cosDip);
    const double eye = eyeOpening(e);

    shader::LookBlock look{};
    look.sunDirection =
        rgb(stored * sun.towards.xyz, std::cos(0.5 * kSunDiameterDegrees * kRadiansPerDegree));
    look.localUp = rgb(up, height);
    const double aboveGround = std::max(height, 0.0);
    look.sunRadiance = rgb(eye * 3.0 * share * through, std::exp(-aboveGround / kHazeHeightMetres));
    look.skyZenith =
        rgb(eye * sky * glm::dvec3(0.16, 0.30, 0.62), std::exp(-aboveGround / kAirHeightMetres));
    look.skyHorizon = rgb(eye * sky * glm::dvec3(0.62, 0.74, 0.88) * warm, dip);
    look.skyLightUp = rgb(eye * sky * glm::dvec3(0.50, 0.62, 0.80));
    look.groundBounce = rgb(eye * (sky * glm::dvec3(0.26, 0.26, 0.25) + 0.12 * share * through));
    look.sunGlow =
        rgb(eye * 0.6 * sky * through * glm::dvec3(1.0, 0.9, 0.75) * (0.3 + 0.7 * share));
    look.haze = rgb(eye * sky * glm::dvec3(0.55, 0.68, 0.84) * warm,
                    3.912 / 60000.0); // 60 km (Koschmieder)
    // By day an unlit colour is shown as it is, in shadow at the share that the sky has of the
    // light.
    look.unlitShade = glm::vec4(float(0.45 * std::min(sky, 1.0)), float(0.55 * share), 0.0f, 0.0f);
    return look;
}

} // namespace gnomon
