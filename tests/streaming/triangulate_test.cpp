#include "streaming/features/triangulate.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

namespace gnomon {
namespace {

double areaOf(const PlanPolygon& polygon, const Corners& corners) {
    std::vector<glm::dvec2> points;
    for (const PlanRing& ring : polygon.rings)
        points.insert(points.end(), ring.begin(), ring.end());
    double area = 0.0;
    for (const auto& [a, b, c] : corners) {
        const double one = signedArea({points[a], points[b], points[c]});
        EXPECT_GT(one, 0.0);
        area += one;
    }
    return area;
}

PlanRing star(std::size_t corners, double inner, double outer) {
    PlanRing ring;
    for (std::size_t i = 0; i < corners; ++i) {
        const double angle = 2.0 * std::numbers::pi * double(i) / double(corners);
        const double r = i % 2 ? inner : outer;
        ring.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    return ring;
}

TEST(CuttingIntoTriangles, CoversAPolygonOnce) {
    for (const std::size_t corners : {4u, 10u, 60u, 200u}) {
        const PlanPolygon polygon{{star(corners, 3.0, 10.0)}};
        const Corners cut = cornersOf(polygon);
        EXPECT_EQ(cut.size(), corners - 2);
        EXPECT_NEAR(areaOf(polygon, cut), signedArea(polygon.rings[0]), 1e-9);
    }
}

TEST(CuttingIntoTriangles, LeavesHolesOpen) {
    PlanRing hole = star(12, 1.0, 2.0);
    std::reverse(hole.begin(), hole.end());
    const PlanPolygon polygon{{star(40, 8.0, 10.0), hole}};
    const Corners cut = cornersOf(polygon);
    EXPECT_EQ(cut.size(), 40 + 12); // n + 2 h - 2
    EXPECT_NEAR(areaOf(polygon, cut), signedArea(polygon.rings[0]) + signedArea(hole), 1e-9);
}

TEST(CuttingIntoTriangles, KeepsVerticesOnStraightEdges) {
    // Walls stand on every vertex: a roof that skips one leaves a gap.
    const PlanPolygon polygon{{{{0, 0}, {5, 0}, {10, 0}, {10, 5}, {10, 10}, {0, 10}, {0, 5}}}};
    const Corners cut = cornersOf(polygon);
    EXPECT_EQ(cut.size(), 5u);
    std::vector<bool> used(7, false);
    for (const auto& t : cut)
        for (const std::uint32_t v : t)
            used[v] = true;
    EXPECT_EQ(std::count(used.begin(), used.end(), true), 7);
    EXPECT_NEAR(areaOf(polygon, cut), 100.0, 1e-9);
}

TEST(CuttingIntoTriangles, HoldsForRandomRectilinearOutlines) {
    std::mt19937 random(7);
    for (int round = 0; round < 200; ++round) {
        // Steps up and down: sound by construction, full of straight and repeated heights.
        PlanRing ring{{0, 0}};
        const int steps = 2 + int(random() % 20);
        ring.emplace_back(double(steps), 0.0);
        for (int x = steps; x > 0; --x) {
            const double y = 1.0 + double(random() % 4);
            ring.emplace_back(double(x), y);
            ring.emplace_back(double(x - 1), y);
        }
        PlanRing clean;
        for (const glm::dvec2& p : ring)
            if (clean.empty() || clean.back() != p)
                clean.push_back(p);
        const PlanPolygon polygon{{clean}};
        ASSERT_TRUE(isSound(polygon.rings));
        const Corners cut = cornersOf(polygon);
        EXPECT_EQ(cut.size(), clean.size() - 2);
        EXPECT_NEAR(areaOf(polygon, cut), signedArea(clean), 1e-9);
    }
}

TEST(Soundness, IsDeniedToWhatCrossesItself) {
    EXPECT_TRUE(isSound(std::vector<PlanRing>{star(10, 3.0, 10.0)}));
    EXPECT_FALSE(isSound(std::vector<PlanRing>{{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}));
    // A hole that is outside.
    EXPECT_FALSE(
        isSound(std::vector<PlanRing>{{{0, 0}, {1, 0}, {1, 1}}, {{5, 5}, {6, 5}, {6, 6}}}));
    EXPECT_FALSE(isSound(std::vector<PlanRing>{{{0, 0}, {1, 0}}}));
    EXPECT_FALSE(isSound(std::vector<PlanRing>{}));
}

TEST(Soundness, TellsATangleSoonerThanItCouldBeMended) {
    std::mt19937 random(1);
    PlanRing tangle;
    for (int i = 0; i < 20000; ++i)
        tangle.emplace_back(double(random() % 100000), double(random() % 100000));
    const auto start = std::chrono::steady_clock::now();
    EXPECT_TRUE(crossesTooOften(std::vector<PlanRing>{tangle}));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
    EXPECT_FALSE(crossesTooOften(std::vector<PlanRing>{{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}));
    EXPECT_FALSE(crossesTooOften(std::vector<PlanRing>{star(20000, 9.0, 10.0)}));
}

} // namespace
} // namespace gnomon
