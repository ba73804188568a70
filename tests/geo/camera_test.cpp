#include "geo/camera.h"

#include "random_places.h"

#include <gtest/gtest.h>

#include <limits>

using namespace gnomon;
using gnomon::testing::Random;

namespace {

Camera cameraAt(const Geodetic& position, const Orientation& orientation) {
    Camera camera;
    place(camera, position, orientation);
    return camera;
}

glm::dvec3 inEnu(const Geodetic& position, Vector<Ecef> v) {
    return glm::transpose(ecefFromEnu(position).axes()) * v.xyz;
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
    EXPECT_LE(glm::length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " for " << b.x << " " << b.y << " " << b.z;
}

const Geodetic kCologne{6.958, 50.941, 100.0};

// Depth as a float buffer holds it: 1 at the near plane, 0 at infinity.
float reversedDepth(const glm::mat4& clipFromEye, float distance) {
    const glm::vec4 clip = clipFromEye * glm::vec4(0.0f, 0.0f, -distance, 1.0f);
    return clip.z / clip.w;
}

// The distance between what two neighbouring values of a 24-bit depth buffer stand for.
double conventionalStep(double distance, double nearMetres, double farMetres) {
    const double a = farMetres / (farMetres - nearMetres);
    const double b = a * nearMetres; // depth = a - b / distance
    return distance * distance / b * 0x1p-24;
}

} // namespace

TEST(Camera, LooksWhereHeadingAndPitchSay) {
    const double s = std::sqrt(0.5);
    expectNear(inEnu(kCologne, cameraAt(kCologne, {0, 0, 0}).forward), {0, 1, 0}, 1e-15);
    expectNear(inEnu(kCologne, cameraAt(kCologne, {90, 0, 0}).forward), {1, 0, 0}, 1e-15);
    expectNear(inEnu(kCologne, cameraAt(kCologne, {90, 0, 0}).right), {0, -1, 0}, 1e-15);
    expectNear(inEnu(kCologne, cameraAt(kCologne, {180, 45, 0}).forward), {0, -s, s}, 1e-15);
    expectNear(inEnu(kCologne, cameraAt(kCologne, {180, 45, 0}).up), {0, s, s}, 1e-15);
}

TEST(Camera, RollsClockwiseAsSeenFromBehind) {
    // Its top tips to the right.
    const Camera camera = cameraAt(kCologne, {0, 0, 90});
    expectNear(inEnu(kCologne, camera.up), {1, 0, 0}, 1e-15);
    expectNear(inEnu(kCologne, camera.right), {0, 0, -1}, 1e-15);
}

TEST(Camera, LooksStraightDownWithItsTopTowardsTheHeading) {
    const Camera camera = cameraAt(kCologne, {30, -90, 0});
    expectNear(inEnu(kCologne, camera.forward), {0, 0, -1}, 1e-15);
    expectNear(inEnu(kCologne, camera.up), {0.5, std::sqrt(0.75), 0}, 1e-15);
    const Orientation back = orientationOf(camera);
    EXPECT_NEAR(back.pitchDegrees, -90.0, 1e-6);
    EXPECT_NEAR(back.headingDegrees, 30.0, 1e-9);
    EXPECT_NEAR(back.rollDegrees, 0.0, 1e-9);
}

TEST(Camera, StandsAtAPoleWithTheLongitudeGiven) {
    const Camera camera = cameraAt({90, 90, 2}, {0, 0, 0});
    expectNear(camera.position.xyz, {0, 0, kPolarRadiusMetres + 2}, 2e-9);
    expectNear(camera.right.xyz, {-1, 0, 0}, 1e-15);
    expectNear(camera.forward.xyz, {0, -1, 0}, 1e-15);
    const Orientation again = orientationOf(camera);
    EXPECT_NEAR(again.pitchDegrees, 0.0, 1e-9);
    EXPECT_NEAR(again.rollDegrees, 0.0, 1e-9);
}

TEST(Camera, GivesBackTheOrientationItWasPlacedWith) {
    Random random(20);
    for (int i = 0; i < 20000; ++i) {
        const Geodetic position{random.in(-180, 180), random.in(-89.9, 89.9), random.in(-100, 1e6)};
        const Orientation wanted{random.in(0, 360), random.in(-89.9, 89.9), random.in(-180, 180)};
        const Orientation got = orientationOf(cameraAt(position, wanted));
        ASSERT_NEAR(std::remainder(got.headingDegrees - wanted.headingDegrees, 360), 0.0, 1e-9);
        ASSERT_NEAR(got.pitchDegrees, wanted.pitchDegrees, 1e-9);
        ASSERT_NEAR(std::remainder(got.rollDegrees - wanted.rollDegrees, 360), 0.0, 1e-9);
    }
}

TEST(Camera, PlacedByItsOwnOrientationIsTheSameAlsoNearTheVertical) {
    for (const double offVertical : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0})
        for (const double sign : {-1.0, 1.0}) {
            const Camera camera = cameraAt(kCologne, {123, sign * (90 - offVertical), 45});
            const Camera again = cameraAt(kCologne, orientationOf(camera));
            // An arcsine loses half the digits at the vertical; atan2 does not.
            expectNear(again.forward.xyz, camera.forward.xyz, 1e-9);
            expectNear(again.up.xyz, camera.up.xyz, 1e-9);
        }
}

TEST(Camera, HasOrthonormalAxesEverywhere) {
    Random random(21);
    for (int i = 0; i < 10000; ++i) {
        const Camera camera = cameraAt({random.in(-180, 180), random.in(-90, 90), 0},
                                       {random.in(0, 360), random.in(-90, 90), random.in(0, 360)});
        const glm::dmat3 r = eyeFromEcefRotation(camera);
        const glm::dmat3 product = r * glm::transpose(r);
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k)
                ASSERT_NEAR(product[c][k], c == k ? 1.0 : 0.0, 2e-15);
        ASSERT_NEAR(glm::determinant(r), 1.0, 2e-15);
        expectNear(r * camera.forward.xyz, {0, 0, -1}, 2e-15);
    }
}

TEST(Camera, ProjectsTheEdgesOfThePictureToOne) {
    Camera camera;
    camera.verticalFovRadians = 60.0 * kRadiansPerDegree;
    const glm::dmat4 m = reversedInfiniteProjection(camera, 0.5);
    const double d = 10.0;
    const glm::dvec4 corner =
        m * glm::dvec4(d * camera.tanHalfWidth(), d * camera.tanHalfHeight(), -d, 1.0);
    EXPECT_NEAR(corner.x / corner.w, 1.0, 1e-15);
    EXPECT_NEAR(corner.y / corner.w, 1.0, 1e-15);
    EXPECT_NEAR(corner.z / corner.w, 0.5 / d, 1e-15);
    EXPECT_NEAR(camera.tanHalfHeight(), std::tan(30.0 * kRadiansPerDegree), 1e-15);
    const glm::dvec4 atNear = m * glm::dvec4(0, 0, -0.5, 1);
    EXPECT_EQ(atNear.z / atNear.w, 1.0);
    const glm::dvec4 farAway = m * glm::dvec4(0, 0, -1, 0);
    EXPECT_EQ(farAway.z / farAway.w, 0.0);
}

TEST(Camera, ReversedDepthInFloatTellsDistancesApartToOnePartInEightMillion) {
    const double nearMetres = 0.1;
    const glm::mat4 clipFromEye(reversedInfiniteProjection(Camera{}, nearMetres));
    const double nearInFloat = double(clipFromEye[3][2]);
    double worst = 0.0;
    for (double d = 1.0; d <= 2e7; d *= 1.00013) {
        const float distance = static_cast<float>(d);
        const float depth = reversedDepth(clipFromEye, distance);
        const double here = nearInFloat / double(depth);
        const double next = nearInFloat / double(std::nextafter(depth, 0.0f));
        worst = std::max({worst, (next - here) / d, std::abs(here - double(distance)) / d});
    }
    RecordProperty("worst_relative_step", std::to_string(worst * 1e7) + "e-7");
    EXPECT_LE(worst, 1.2e-7);
    EXPECT_GE(worst, 0.5e-7);
}

TEST(Camera, AConventionalDepthBufferWouldBeOffAMetreBeforeTwoKilometres) {
    EXPECT_LT(conventionalStep(1000.0, 0.1, 2e7), 1.0);
    EXPECT_GT(conventionalStep(2000.0, 0.1, 2e7), 1.0);
}

TEST(Camera, StaysFiniteForPointlessFieldsOfViewAndWindows) {
    Camera camera;
    for (const double fov :
         {0.0, -1.0, std::numbers::pi, 7.0, 1e-300, std::numeric_limits<double>::quiet_NaN(),
          std::numeric_limits<double>::infinity()})
        for (const int size : {0, -5, 1, 100000}) {
            camera.verticalFovRadians = fov;
            camera.widthPixels = size;
            for (const int height : {0, 1, 720}) {
                camera.heightPixels = height;
                const glm::dmat4 m = reversedInfiniteProjection(camera, 0.1);
                for (int c = 0; c < 4; ++c)
                    for (int r = 0; r < 4; ++r)
                        ASSERT_TRUE(std::isfinite(m[c][r]));
                ASSERT_GT(camera.tanHalfWidth(), 0.0);
            }
        }
}
