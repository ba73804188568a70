#include "viewer/fit_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon {

namespace {

constexpr Orientation kFromSouthEast{315.0, -35.0, 0.0};
constexpr double kMargin = 1.05; // some air around it

} // namespace

Camera fitCamera(const Scene& scene, int widthPixels, int heightPixels, double verticalFovRadians) {
    Camera camera;
    camera.widthPixels = widthPixels;
    camera.heightPixels = heightPixels;
    camera.verticalFovRadians = verticalFovRadians;
    place(camera, scene.anchor, kFromSouthEast);
    // A point p (from the anchor) is in the picture when |right·p| ≤ (d + forward·p)·tan of the
    // half angle, likewise upwards: each gives a least distance d, the farthest wins. The scene is
    // a cylinder on the anchor's level.
    const double radius = std::max(scene.radiusMetres, 1.0);
    const double top = std::max(scene.heightMetres, 0.0);
    double distance = 0.0;
    constexpr int kAround = 64;
    for (int i = 0; i < 2 * kAround; ++i) {
        const double angle = 2.0 * std::numbers::pi * (i / 2) / kAround;
        const Vector<Ecef> p = scene.ecefFromAnchor(Vector<Enu>{
            {radius * std::cos(angle), radius * std::sin(angle), i % 2 == 0 ? 0.0 : top}});
        const double along = dot(camera.forward, p);
        distance =
            std::max({distance, std::abs(dot(camera.right, p)) / camera.tanHalfWidth() - along,
                      std::abs(dot(camera.up, p)) / camera.tanHalfHeight() - along});
    }
    // Turning with the anchor's own axes, not with those below the camera: so kept as they are.
    camera.position = camera.position - kMargin * distance * camera.forward;
    return camera;
}

} // namespace gnomon
