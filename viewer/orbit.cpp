#include "viewer/orbit.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

constexpr double kClosestMetres = 0.5, kFarthestMetres = 5.0e7;

// Right, up and forward for a heading and a pitch, in the anchor's frame.
struct Axes {
    glm::dvec3 right, up, forward;
};
Axes axesFor(double headingDegrees, double pitchDegrees) {
    const double h = headingDegrees * kRadiansPerDegree, p = pitchDegrees * kRadiansPerDegree;
    const glm::dvec3 right(std::cos(h), -std::sin(h), 0.0);
    const glm::dvec3 forward(std::sin(h) * std::cos(p), std::cos(h) * std::cos(p), std::sin(p));
    return {right, glm::cross(right, forward), forward};
}

} // namespace

Orbit::Orbit(const Scene& scene, const Camera& camera) : scene_(scene), lens_(camera) {
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.ecefFromAnchor);
    const glm::dvec3 eye = anchorFromEcef(camera.position).xyz;
    const glm::dvec3 forward = anchorFromEcef(camera.forward).xyz;
    headingDegrees_ = std::atan2(forward.x, forward.y) / kRadiansPerDegree;
    pitchDegrees_ = std::asin(std::clamp(forward.z, -1.0, 1.0)) / kRadiansPerDegree;
    const double toGround = forward.z < -1e-3 ? -eye.z / forward.z : -1.0;
    distanceMetres_ = toGround > 0.0 ? toGround : std::max(scene.radiusMetres, 1.0);
    distanceMetres_ = std::clamp(distanceMetres_, kClosestMetres, kFarthestMetres);
    target_ = eye + distanceMetres_ * forward;
}

void Orbit::turn(double headingDegrees, double pitchDegrees) {
    headingDegrees_ = std::remainder(headingDegrees_ + headingDegrees, 360.0);
    pitchDegrees_ = std::clamp(pitchDegrees_ + pitchDegrees, -89.9, 89.9);
}

void Orbit::zoom(double factor) {
    distanceMetres_ = std::clamp(distanceMetres_ * factor, kClosestMetres, kFarthestMetres);
}

void Orbit::pan(double rightPixels, double upPixels) {
    const double metresPerPixel =
        2.0 * distanceMetres_ * lens_.tanHalfHeight() / std::max(lens_.heightPixels, 1);
    const Axes axes = axesFor(headingDegrees_, 0.0); // along the ground
    target_ -= metresPerPixel * (rightPixels * axes.right + upPixels * axes.forward);
}

void Orbit::resize(int widthPixels, int heightPixels) {
    lens_.widthPixels = std::max(widthPixels, 1);
    lens_.heightPixels = std::max(heightPixels, 1);
}

Camera Orbit::camera() const {
    Camera camera = lens_;
    const Axes axes = axesFor(headingDegrees_, pitchDegrees_);
    camera.position = scene_.ecefFromAnchor(Point<Enu>{target_ - distanceMetres_ * axes.forward});
    camera.right = scene_.ecefFromAnchor(Vector<Enu>{axes.right});
    camera.up = scene_.ecefFromAnchor(Vector<Enu>{axes.up});
    camera.forward = scene_.ecefFromAnchor(Vector<Enu>{axes.forward});
    return camera;
}

} // namespace gnomon
