// What barriers cover seen from above, and its triangles.
#include "streaming/features/barriers_plan.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace gnomon;

namespace {

double areaOf(const PlanRing& ring) {
    double area = 0.0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
        area += (a.x * b.y - a.y * b.x) / 2.0;
    }
    return std::abs(area);
}
double areaOf(const PlanPolygon& polygon) {
    double area = areaOf(polygon.rings[0]);
    for (std::size_t i = 1; i < polygon.rings.size(); ++i)
        area -= areaOf(polygon.rings[i]);
    return area;
}

void expectOnGrid(const PlanPolygon& polygon) {
    for (const PlanRing& ring : polygon.rings)
        for (std::size_t i = 0; i < ring.size(); ++i)
            EXPECT_GE(glm::distance(ring[i], ring[(i + 1) % ring.size()]), 0.99 * kPlanGridMetres);
}

// Each edge once each way at most, all triangles wound alike, together as large as the polygon.
void expectWhole(const PlanPolygon& polygon) {
    expectOnGrid(polygon);
    const auto mesh = triangulated(polygon);
    ASSERT_TRUE(mesh);
    std::size_t points = 0;
    for (const PlanRing& ring : polygon.rings)
        points += ring.size();
    EXPECT_EQ(mesh->points.size(), points);
    double area = 0.0;
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const auto& t : mesh->triangles) {
        const glm::dvec2 a = mesh->points[t[0]], b = mesh->points[t[1]], c = mesh->points[t[2]];
        const double twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        EXPECT_GT(twice, 0.0);
        area += twice / 2.0;
        for (std::size_t i = 0; i < 3; ++i)
            EXPECT_TRUE(edges.insert({t[i], t[(i + 1) % 3]}).second);
    }
    EXPECT_NEAR(area, areaOf(polygon), 1e-6 * area);
    std::size_t outline = 0;
    for (const auto& [a, b] : edges)
        outline += !edges.contains({b, a});
    EXPECT_EQ(outline, points);
}

} // namespace

TEST(BarriersPlan, AStraightWallIsARectangleAndABendIsMitred) {
    const std::vector<glm::dvec2> straight{{0, 0}, {100, 0}}, bend{{0, 0}, {10, 0}, {10, 10}};
    const auto wall = stripAlong(straight, 0.5);
    ASSERT_EQ(wall.size(), 1u);
    EXPECT_EQ(wall[0].rings[0].size(), 4u);
    EXPECT_NEAR(areaOf(wall[0]), 50.0, 1e-9);
    const auto corner = stripAlong(bend, 1.0);
    ASSERT_EQ(corner.size(), 1u);
    EXPECT_EQ(corner[0].rings[0].size(), 6u);
    EXPECT_NEAR(areaOf(corner[0]), 20.0, 1e-9);
    EXPECT_TRUE(std::ranges::any_of(corner[0].rings[0], [](const glm::dvec2& p) {
        return glm::distance(p, glm::dvec2(10.5, -0.5)) < kPlanGridMetres;
    }));
    expectWhole(corner[0]);
}

TEST(BarriersPlan, LinesThatCrossCloseOrTurnBackAreOnePolygon) {
    const std::vector<std::vector<glm::dvec2>> lines{
        {{0, 0}, {10, 10}, {10, 0}, {0, 10}},         // crosses itself
        {{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}}, // closed
        {{0, 0}, {10, 0}, {5, 0}},                    // turns back on itself
        {{0, 0}, {10, 0}, {0, 0.3}},                  // a hairpin
        {{0, 0}, {10, 0}, {20, 0.0001}, {30, 0}},     // all but straight
        {{0, 0}, {0, 0}, {10, 0}, {10, 0}}};          // points twice
    for (const auto& line : lines) {
        const auto strip = stripAlong(line, 1.0);
        ASSERT_EQ(strip.size(), 1u);
        expectWhole(strip[0]);
    }
    // A closed one has no gap and no missing corner.
    const auto ring = stripAlong(lines[1], 1.0);
    EXPECT_EQ(ring[0].rings.size(), 2u);
    EXPECT_NEAR(areaOf(ring[0]), 11.0 * 11.0 - 9.0 * 9.0, 1e-9);
}

TEST(BarriersPlan, AreasThatCrossThemselvesAreRepaired) {
    const std::vector<PlanRing> bow{{{0, 0}, {10, 10}, {10, 0}, {0, 10}}};
    const auto halves = validAreas(bow);
    ASSERT_EQ(halves.size(), 2u);
    EXPECT_NEAR(areaOf(halves[0]) + areaOf(halves[1]), 50.0, 1e-9);
    const std::vector<PlanRing> holed{{{0, 0}, {10, 0}, {10, 10}, {0, 10}},
                                      {{2, 2}, {2, 5}, {5, 5}, {5, 2}}};
    const auto one = validAreas(holed);
    ASSERT_EQ(one.size(), 1u);
    EXPECT_NEAR(areaOf(one[0]), 91.0, 1e-9);
    expectWhole(one[0]);
}

TEST(BarriersPlan, WhatHasNoAreaIsNothing) {
    EXPECT_TRUE(stripAlong(std::vector<glm::dvec2>{{1, 1}, {1, 1}}, 1.0).empty());
    EXPECT_TRUE(stripAlong(std::vector<glm::dvec2>{}, 1.0).empty());
    EXPECT_TRUE(validAreas(std::vector<PlanRing>{{{0, 0}, {10, 0}, {5, 0}}}).empty());
    EXPECT_TRUE(validAreas(std::vector<PlanRing>{}).empty());
    EXPECT_FALSE(triangulated({}));
    EXPECT_TRUE(stripAlong(std::vector<glm::dvec2>{{0, 0}, {NAN, 1}}, 1.0).empty());
}
