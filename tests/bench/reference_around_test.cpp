// What the rays say about the surroundings of a point, where every distance is known.
#include "bench/reference.h"
#include "tests/bench/ray_world.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::bench;
using namespace gnomon::test;

namespace {

const glm::dvec3 kUp(0, 0, 1);
const double kSin = std::sqrt(0.5); // of the sun's 45°
// A radius that just reaches what is at a distance, and one that just does not.
constexpr double kJust = 1.1, kNotQuite = 0.9;

// A wall along y, 10 m high and 1 m thick, on a floor; the sun in the west, so that its shadow is
// on the floor from x = 0 to 10.
struct WallOnFloor : ::testing::Test {
    RayWorld world = wallOnFloor();
    bench::Light sun = SunDisc{directionAt(270, 45), 0.533};

    RayScene scene = traced();

    static RayWorld wallOnFloor() {
        RayWorld made;
        made.grid({-100, -100, 0}, {200, 0, 0}, {0, 200, 0}, 10);
        made.box({-1, -60, 0}, {0, 60, 10});
        return made;
    }
    RayScene traced() const { return world.rays({3, 4, 5}); }
    glm::dvec3 at(double x, double y, double z = 0.0) const {
        return glm::dvec3(x, y, z) - glm::dvec3(3, 4, 5);
    }
    bool changes(const glm::dvec3& p, double radius, bool soft = false) const {
        return scene.changesWithin(p, kUp, sun, soft, radius);
    }
    bool shadow(const glm::dvec3& p, double radius, bool soft = false) const {
        return scene.shadowWithin(p, kUp, sun, soft, radius);
    }
    bool contact(const glm::dvec3& p, double radius) const {
        return scene.contactWithin(p, kUp, sun, radius);
    }
};

} // namespace

TEST_F(WallOnFloor, TheShadowsEdgeIsFoundFromBothSidesAtItsDistanceInTheLightsPlane) {
    for (const double x : {10.3, 12.0, 9.7, 8.0}) {
        const double distance = std::abs(x - 10.0) * kSin;
        EXPECT_TRUE(changes(at(x, 0.4), kJust * distance)) << x;
        EXPECT_FALSE(changes(at(x, 0.4), kNotQuite * distance)) << x;
    }
    // The end of the wall, across the sun's way: no foreshortening there.
    EXPECT_TRUE(changes(at(5, 59), kJust * 1.0));
    EXPECT_FALSE(changes(at(5, 59), kNotQuite * 1.0));
}

TEST_F(WallOnFloor, ASoftEdgeBeginsWhereItsPenumbraDoes) {
    const double half = 10.0 / kSin * std::tan(0.2665 * kRadiansPerDegree);
    for (const double x : {12.0, 8.0}) {
        const double distance = std::abs(x - 10.0) * kSin - half;
        EXPECT_TRUE(changes(at(x, 0.4), kJust * distance, true)) << x;
        EXPECT_FALSE(changes(at(x, 0.4), kNotQuite * distance, true)) << x;
    }
    // In the middle of it, all light is between lit and dark as far as half of it goes.
    EXPECT_FALSE(changes(at(10, 0.4), kNotQuite * half, true));
    EXPECT_TRUE(changes(at(10, 0.4), kJust * half, true));
}

TEST_F(WallOnFloor, ShadowIsAsNearAsItsEdgeOrHere) {
    EXPECT_TRUE(shadow(at(12, 1), kJust * 2.0 * kSin));
    EXPECT_FALSE(shadow(at(12, 1), kNotQuite * 2.0 * kSin));
    EXPECT_TRUE(shadow(at(5, 1), 0.01));
    const double half = 10.0 / kSin * std::tan(0.2665 * kRadiansPerDegree);
    EXPECT_TRUE(shadow(at(10.0 + 1.5 * half, 1), kJust * (1.5 * half * kSin), true));
    EXPECT_TRUE(shadow(at(10.0 + 0.5 * half, 1), 1e-3, true)) << "in the penumbra";
    EXPECT_FALSE(shadow(at(10.0 + 0.5 * half, 1), 1e-3, false));
}

TEST_F(WallOnFloor, ContactIsAsNearAsTheWall) {
    for (const double x : {0.5, 3.0, -1.5, -4.0}) { // in its shadow, and on its sunny side
        const double distance = (x > 0 ? x : -1.0 - x) * kSin;
        EXPECT_TRUE(contact(at(x, 2), kJust * distance)) << x;
        EXPECT_FALSE(contact(at(x, 2), kNotQuite * distance)) << x;
    }
    EXPECT_TRUE(contact(at(-0.5, 62), kJust * 2.0)); // its end
    EXPECT_FALSE(contact(at(-0.5, 62), kNotQuite * 2.0));
    EXPECT_FALSE(contact(at(10, 2), 1.0)) << "a shadow's edge is no contact";
}

TEST_F(WallOnFloor, WhatLiesBehindTheWallIsNotAroundAPoint) {
    // Dark at its foot, and sun on the other side, a metre and less in the light's plane.
    EXPECT_FALSE(changes(at(0.05, 0), 1.5));
    EXPECT_FALSE(changes(at(0.05, 0), 1.5, true));
    // In the sun at its other foot: the wall's face is lit, the floor under the wall is nobody's.
    EXPECT_FALSE(changes(at(-1.05, 0), 1.5));
    EXPECT_FALSE(changes(at(-1.05, 0), 1.5, true));
    EXPECT_FALSE(shadow(at(-1.05, 0), 1.5));
}

TEST_F(WallOnFloor, OverARoofsEdgeIsNoSurface) {
    // The wall's top: shaded floor is far below on one side, lit floor on the other.
    for (const double x : {-0.05, -0.5, -0.95}) {
        EXPECT_FALSE(changes(at(x, 0, 10), 0.7)) << x;
        EXPECT_FALSE(changes(at(x, 0, 10), 0.7, true)) << x;
        EXPECT_FALSE(shadow(at(x, 0, 10), 0.7)) << x;
        EXPECT_FALSE(contact(at(x, 0, 10), 0.7)) << x;
    }
}

TEST_F(WallOnFloor, AShadedPartOfAWallIsAroundTheFloorInFrontOfIt) {
    // A roof over the sunny face, from 3 m up: what is in its shadow of face and floor.
    world.quad({-3, -5, 3}, {-1, -5, 3}, {-1, 5, 3}, {-3, 5, 3});
    const RayScene roofed = traced();
    // Its shadow: on the face from 3 m down to 1 m. The floor is lit and 1 m from it along z.
    EXPECT_EQ(roofed.visibility(at(-1.2, 0), kUp, sun, 1, 0), 1.0);
    EXPECT_EQ(roofed.visibility(at(-1, 0, 1.1), {-1, 0, 0}, sun, 1, 0), 0.0);
    const double distance = 1.2 * kSin; // 0.2 of floor, 1 of wall, both seen at 45°
    EXPECT_TRUE(roofed.changesWithin(at(-1.2, 0), kUp, sun, false, kJust * distance));
    EXPECT_FALSE(roofed.changesWithin(at(-1.2, 0), kUp, sun, false, kNotQuite * distance));
}

TEST_F(WallOnFloor, LampsHaveEdgesToo) {
    sun = LampPoint{at(-10, 0, 20)}; // over the wall's edge: dark to x = 10
    for (const double x : {10.5, 9.5}) {
        const glm::dvec3 p = at(x, 0);
        EXPECT_EQ(scene.visibility(p, kUp, sun, 1, 0), x > 10 ? 1.0 : 0.0);
        const double distance = 0.5 * 20.0 / std::hypot(10.0 + x, 20.0);
        EXPECT_TRUE(changes(p, kJust * distance)) << x;
        EXPECT_FALSE(changes(p, kNotQuite * distance)) << x;
    }
}

TEST_F(WallOnFloor, ATurnedAwayFaceIsDarkAllOver) {
    const glm::dvec3 east(1, 0, 0);
    EXPECT_FALSE(scene.changesWithin(at(0, 0, 5), east, sun, false, 3.0));
    EXPECT_TRUE(scene.shadowWithin(at(0, 0, 5), east, sun, false, 0.1));
}

TEST(Around, AnUnevenPlainInTheSunHasNoEdges) {
    RayWorld world;
    std::vector<glm::dvec3> points;
    std::vector<std::uint32_t> indices;
    constexpr std::uint32_t kSide = 60;
    for (std::uint32_t j = 0; j < kSide; ++j)
        for (std::uint32_t i = 0; i < kSide; ++i) {
            const double x = i - 30.0, y = j - 30.0;
            points.emplace_back(x, y, std::sin(0.4 * x) * std::cos(0.3 * y));
            const std::uint32_t k = j * kSide + i;
            if (i + 1 < kSide && j + 1 < kSide)
                indices.insert(indices.end(),
                               {k, k + 1, k + kSide + 1, k, k + kSide + 1, k + kSide});
        }
    world.add(points, indices);
    const RayScene scene = world.rays();
    const bench::Light sun = SunDisc{directionAt(250, 40)}; // steeper than any slope: 22°
    int asked = 0;
    for (double x = -20.3; x < 20; x += 1.7)
        for (double y = -20.1; y < 20; y += 1.9) {
            const RayHit hit = scene.first({x, y, 50}, -kUp);
            EXPECT_FALSE(scene.changesWithin(hit.position, hit.normal, sun, true, 0.8));
            EXPECT_FALSE(scene.shadowWithin(hit.position, hit.normal, sun, true, 0.8));
            ++asked;
        }
    EXPECT_GT(asked, 400);
}
