#include "viewer/orbit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon {
namespace {

Scene sceneAt(const Geodetic& anchor) {
    Scene scene;
    scene.anchor = anchor;
    scene.ecefFromAnchor = ecefFromEnu(anchor);
    scene.radiusMetres = 500.0;
    return scene;
}

Camera lookingDown(const Scene& scene) {
    Camera camera;
    Geodetic above = scene.anchor;
    above.heightMetres += 300.0;
    place(camera, above, {30.0, -40.0, 0.0});
    return camera;
}

double distance(Point<Ecef> a, Point<Ecef> b) {
    return length(a - b);
}

// Where the view axis meets the anchor's level.
glm::dvec3 target(const Scene& scene, const Camera& camera) {
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.ecefFromAnchor);
    const glm::dvec3 eye = anchorFromEcef(camera.position).xyz;
    const glm::dvec3 forward = anchorFromEcef(camera.forward).xyz;
    return eye - forward * (eye.z / forward.z);
}

TEST(Orbit, StartsWhereTheCameraStandsAndLooks) {
    const Scene scene = sceneAt({6.96, 50.94, 100.0});
    const Camera camera = lookingDown(scene);
    const Camera held = Orbit(scene, camera).camera();
    EXPECT_LT(distance(held.position, camera.position), 1e-6);
    EXPECT_GT(dot(held.forward, camera.forward), 1.0 - 1e-12);
}

TEST(Orbit, TurnsAboutItsTargetAtTheSameDistance) {
    const Scene scene = sceneAt({180.0, -33.0, 10.0});
    const Camera camera = lookingDown(scene);
    Orbit orbit(scene, camera);
    const glm::dvec3 before = target(scene, orbit.camera());
    orbit.turn(75.0, -20.0);
    const Camera turned = orbit.camera();
    EXPECT_LT(glm::length(target(scene, turned) - before), 1e-5);
    EXPECT_GT(distance(turned.position, camera.position), 100.0);
}

TEST(Orbit, NeverTipsOverTheTop) {
    const Scene scene = sceneAt({0.0, 90.0, 0.0});
    Orbit orbit(scene, lookingDown(scene));
    orbit.turn(0.0, -500.0);
    const Camera camera = orbit.camera();
    const Vector<Ecef> up = scene.ecefFromAnchor(Vector<Enu>{{0, 0, 1}});
    EXPECT_LT(dot(camera.forward, up), -0.999);
    EXPECT_GT(dot(camera.up, up), 0.0);
}

TEST(Orbit, ZoomsTowardsItsTargetButNotThroughIt) {
    const Scene scene = sceneAt({6.96, 50.94, 100.0});
    Orbit orbit(scene, lookingDown(scene));
    const glm::dvec3 before = target(scene, orbit.camera());
    orbit.zoom(0.5);
    EXPECT_LT(glm::length(target(scene, orbit.camera()) - before), 1e-6);
    for (int i = 0; i < 200; ++i)
        orbit.zoom(0.5);
    EXPECT_GT(rigidInverse(scene.ecefFromAnchor)(orbit.camera().position).xyz.z, 0.0);
}

TEST(Orbit, PansWithTheGroundBelowThePointer) {
    const Scene scene = sceneAt({6.96, 50.94, 100.0});
    Camera camera = lookingDown(scene);
    place(camera, {6.96, 50.94, 400.0}, {0.0, -89.9, 0.0});
    Orbit orbit(scene, camera);
    const glm::dvec3 before = target(scene, orbit.camera());
    orbit.pan(100.0, 0.0); // the ground moves right, so the target moves west
    const glm::dvec3 moved = target(scene, orbit.camera()) - before;
    const double metresAPixel = 2.0 * 300.0 * camera.tanHalfHeight() / camera.heightPixels;
    EXPECT_NEAR(moved.x, -100.0 * metresAPixel, 0.01 * 100.0 * metresAPixel);
    EXPECT_NEAR(moved.y, 0.0, 1.0);
}

TEST(Orbit, KeepsAWindowOfNoSizeFinite) {
    const Scene scene = sceneAt({6.96, 50.94, 100.0});
    Orbit orbit(scene, lookingDown(scene));
    orbit.resize(0, 0);
    orbit.pan(5.0, 5.0);
    EXPECT_TRUE(std::isfinite(orbit.camera().position.xyz.x));
}

} // namespace
} // namespace gnomon
