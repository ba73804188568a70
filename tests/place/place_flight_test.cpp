// The flight: clear of ground and walls, and the same wherever the place is put.
#include "viewer/place/flight.h"

#include "geo/camera.h"
#include "geo/time.h"
#include "viewer/place/shape.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon::builtin {
namespace {

bool insideBuilding(const Building& b, glm::dvec3 p, double margin) {
    const glm::dvec2 d = glm::dvec2(p.x, p.y) - b.centre;
    const double c = std::cos(b.headingRadians), s = std::sin(b.headingRadians);
    const glm::dvec2 q = glm::abs(glm::dvec2(c * d.x + s * d.y, -s * d.x + c * d.y)) - b.half;
    return std::max(q.x, q.y) < margin && p.z < b.topMetres() + 1 + margin;
}

void expectClear(const Plan& plan) {
    const auto keys = flight(plan);
    ASSERT_GT(keys.size(), 10u);
    const int first = plan.firstCell(), last = first + plan.cells() - 1;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i)
        for (double t = 0; t < 1; t += 0.05) {
            const glm::dvec3 p = glm::mix(keys[i].position, keys[i + 1].position, t);
            const int ix = int(std::floor(p.x / kCellMetres)),
                      iy = int(std::floor(p.y / kCellMetres));
            EXPECT_GT(p.z, plan.ground({p.x, p.y}) + 1.5);
            if (ix < first || iy < first || ix > last || iy > last)
                continue;
            const Cell cell = plan.cell(ix, iy);
            for (const Building& b : cell.buildings)
                EXPECT_FALSE(insideBuilding(b, p, 1.5)) << "at " << p.x << ' ' << p.y << ' ' << p.z;
            for (const Tree& tree : cell.trees)
                EXPECT_FALSE(glm::distance(tree.at, glm::dvec2(p.x, p.y)) <
                                 0.42 * tree.heightMetres &&
                             p.z < plan.ground(tree.at) + tree.heightMetres);
            if (std::abs(p.y - plan.bridgeY()) < plan.deckHalfLength()) {
                EXPECT_GT(p.z, plan.deckMetres() + 7);
            }
        }
}

TEST(Flight, KeepsClearOfGroundWallsTreesAndBridge) {
    for (const std::uint64_t seed : {1, 2, 3})
        for (const std::size_t n : {0, 60, 400, 5000})
            expectClear(Plan(seed, n));
}

TEST(Flight, GoesFromFarAboveDownIntoTheStreetLookingAtTheTower) {
    const Plan plan(1, 400);
    const auto keys = flight(plan);
    EXPECT_EQ(keys.front().seconds, 0.0);
    EXPECT_EQ(keys.back().seconds, 5.0);
    EXPECT_GT(keys.front().position.z, 300);
    EXPECT_GT(glm::distance(keys.front().position, glm::dvec3(Plan::centre(), 0)), 700);
    const glm::dvec3 end = keys.back().position;
    EXPECT_NEAR(end.z - plan.ground({end.x, end.y}), 2.6, 0.3);
    EXPECT_NEAR(end.x, Plan::axisX(), 1e-9);
    EXPECT_NEAR(keys.back().target.x, Plan::centre().x, 1e-9);
    // Houses on both sides of the last stretch.
    bool west = false, east = false;
    for (const Building& b : plan.cell(0, -1).buildings) {
        west |= b.centre.x < end.x && end.x - b.centre.x < 25;
        east |= b.centre.x > end.x && b.centre.x - end.x < 25;
    }
    EXPECT_TRUE(west && east);
}

TEST(Flight, IsTheSameAnywhereOnEarth) {
    const auto keys = flight(Plan(1, 60));
    for (const Geodetic at : {Geodetic{6.96, 50.94, 100},
                              {0, 0, 0},
                              {0, 90, 0},
                              {180, 0, 50},
                              {-180, -16.5, 0},
                              {77, -90, 2800},
                              {86.9, 28, 8848}}) {
        const auto json = flightJson(keys, at);
        const auto ecefFromPlace = ecefFromEnu(at);
        double before = json["keyframes"][0]["heading"];
        ASSERT_EQ(json["keyframes"].size(), keys.size());
        for (std::size_t i = 0; i < keys.size(); ++i) {
            const auto& k = json["keyframes"][i];
            Camera camera;
            place(camera, {k["lon"], k["lat"], k["height"]}, {k["heading"], k["pitch"], k["roll"]});
            const auto wanted = ecefFromPlace(Point<Enu>{keys[i].position});
            EXPECT_LT(length(camera.position - wanted), 1e-6);
            const auto forward =
                ecefFromPlace(Vector<Enu>{glm::normalize(keys[i].target - keys[i].position)});
            EXPECT_LT(length(camera.forward - forward), 1e-9);
            // Level in the place's frame.
            EXPECT_NEAR(dot(camera.right, ecefFromPlace(Vector<Enu>{{0, 0, 1}})), 0, 1e-9);
            EXPECT_LT(std::abs(double(k["heading"]) - before), 180.0);
            before = k["heading"];
        }
    }
}

TEST(Flight, StartsInTheAfternoonByTheSun) {
    EXPECT_EQ(afternoon({0, 50, 0}), "2025-06-21T16:00:00Z");
    EXPECT_EQ(afternoon({-180, 50, 0}), "2025-06-22T04:00:00Z");
    EXPECT_EQ(afternoon({180, -50, 0}), "2025-12-21T04:00:00Z");
    for (double lon = -180; lon <= 180; lon += 7.5)
        EXPECT_TRUE(parseTime(afternoon({lon, 10, 0}))) << lon;
}

} // namespace
} // namespace gnomon::builtin
