#include "geo/camera.h"

#include <GeographicLib/Math.hpp>

#include <cmath>

namespace gnomon {
namespace {

struct SinCos {
    explicit SinCos(double degrees) { GeographicLib::Math::sincosd(degrees, sin, cos); }
    double sin = 0.0, cos = 1.0;
};

} // namespace

double Camera::tanHalfHeight() const {
    constexpr double kSmallest = 1e-6;
    const double fov = std::isfinite(verticalFovRadians)
                           ? std::clamp(verticalFovRadians, kSmallest, std::numbers::pi - kSmallest)
                           : 45.0 * kRadiansPerDegree;
    return std::tan(0.5 * fov);
}

void place(Camera& camera, const Geodetic& position, const Orientation& orientation) {
    const SinCos heading(orientation.headingDegrees);
    const SinCos pitch(orientation.pitchDegrees);
    const SinCos roll(orientation.rollDegrees);
    const Transform<Ecef, Enu> ecefFromLocal = ecefFromEnu(position);

    // Right and ahead lie in the horizontal plane, so the axes exist at any pitch.
    const glm::dvec3 right(heading.cos, -heading.sin, 0.0);
    const glm::dvec3 ahead(heading.sin, heading.cos, 0.0);
    const glm::dvec3 zenith(0.0, 0.0, 1.0);
    const glm::dvec3 forward = pitch.cos * ahead + pitch.sin * zenith;
    const glm::dvec3 up = -pitch.sin * ahead + pitch.cos * zenith;

    camera.position = ecefFromLocal.origin();
    camera.forward = ecefFromLocal(Vector<Enu>{forward});
    camera.right = ecefFromLocal(Vector<Enu>{roll.cos * right - roll.sin * up});
    camera.up = ecefFromLocal(Vector<Enu>{roll.cos * up + roll.sin * right});
}

Orientation orientationOf(const Camera& camera) {
    const glm::dmat3 enuFromEcef = glm::transpose(ecefFromEnu(geodeticOf(camera.position)).axes());
    const glm::dvec3 forward = enuFromEcef * camera.forward.xyz;
    const glm::dvec3 right = enuFromEcef * camera.right.xyz;

    const double level = std::hypot(forward.x, forward.y);
    // Looking straight up or down, heading and roll turn about the same axis: all goes to heading.
    // 1e-10 rad is where the rounding of the axes (1e-16) begins to show in a heading.
    const bool vertical = level < 1e-10;
    const double heading =
        vertical ? std::atan2(-right.y, right.x) : std::atan2(forward.x, forward.y);
    Orientation o;
    o.pitchDegrees = std::atan2(forward.z, level) / kRadiansPerDegree;
    o.headingDegrees = heading / kRadiansPerDegree;
    if (!vertical) {
        // Measured from the level axes of just that heading, so that its rounding cancels.
        const glm::dvec3 levelRight(std::cos(heading), -std::sin(heading), 0.0);
        const glm::dvec3 levelUp = glm::cross(levelRight, forward);
        o.rollDegrees =
            std::atan2(-glm::dot(right, levelUp), glm::dot(right, levelRight)) / kRadiansPerDegree;
    }
    if (o.headingDegrees < 0.0)
        o.headingDegrees += 360.0;
    return o;
}

glm::dmat3 eyeFromEcefRotation(const Camera& camera) {
    return glm::transpose(glm::dmat3(camera.right.xyz, camera.up.xyz, -camera.forward.xyz));
}

glm::dmat4 reversedInfiniteProjection(const Camera& camera, double nearMetres) {
    glm::dmat4 clipFromEye(0.0);
    clipFromEye[0][0] = 1.0 / camera.tanHalfWidth();
    clipFromEye[1][1] = 1.0 / camera.tanHalfHeight();
    clipFromEye[2][3] = -1.0;
    clipFromEye[3][2] = nearMetres;
    return clipFromEye;
}

} // namespace gnomon
