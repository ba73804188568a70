// The plan: how many, where, and that nothing leaves its cell.
#include "viewer/place/plan.h"
#include "viewer/place/tiles.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon::builtin {
namespace {

template <class Visit>
void forEachCell(const Plan& plan, const Visit& visit) {
    for (int iy = plan.firstCell(); iy < plan.firstCell() + plan.cells(); ++iy)
        for (int ix = plan.firstCell(); ix < plan.firstCell() + plan.cells(); ++ix)
            visit(ix, iy);
}

std::size_t countBuildings(const Plan& plan) {
    std::size_t n = 0;
    forEachCell(plan, [&](int ix, int iy) { n += plan.cell(ix, iy).buildings.size(); });
    return n;
}

TEST(Plan, HasExactlyTheBuildingsAskedFor) {
    for (const std::size_t n : {0, 1, 2, 60, 400, 1500})
        EXPECT_EQ(countBuildings(Plan(1, n)), n);
    EXPECT_EQ(countBuildings(Plan(77, 400)), 400u);
}

TEST(Plan, PutsEverythingInsideItsCell) {
    const Plan plan(3, 700);
    forEachCell(plan, [&](int ix, int iy) {
        const Cell cell = plan.cell(ix, iy);
        for (const Building& b : cell.buildings)
            for (const glm::dvec2 p : b.footprint(b.overhangMetres))
                EXPECT_TRUE(cell.rect.contains(p)) << ix << ' ' << iy;
        for (const Tree& t :
             cell.trees) // the widest crown is 0.34 of the height, 10 % rougher and wider
            EXPECT_TRUE(cell.rect.inset(0.412 * t.heightMetres).contains(t.at)) << ix << ' ' << iy;
        for (const Shed& s : cell.sheds)
            EXPECT_TRUE(cell.rect.inset(std::hypot(s.size.x, s.size.y) / 2 + 0.3).contains(s.at));
    });
}

// Separating axes of two convex footprints (an L by its whole rectangle).
bool apart(const Building& a, const Building& b) {
    const auto corners = [](Building x) {
        x.notch = {0, 0};
        return x.footprint();
    };
    const auto p = corners(a), q = corners(b);
    for (const Building* frame : {&a, &b})
        for (const double turn : {0.0, 1.5707963267948966}) {
            const double h = frame->headingRadians + turn;
            const glm::dvec2 axis{std::cos(h), std::sin(h)};
            double pMin = 1e9, pMax = -1e9, qMin = 1e9, qMax = -1e9;
            for (const auto& v : p)
                pMin = std::min(pMin, glm::dot(v, axis)), pMax = std::max(pMax, glm::dot(v, axis));
            for (const auto& v : q)
                qMin = std::min(qMin, glm::dot(v, axis)), qMax = std::max(qMax, glm::dot(v, axis));
            if (pMax + 0.1 < qMin || qMax + 0.1 < pMin)
                return true;
        }
    return false;
}

TEST(Plan, KeepsBuildingsApartFromEachOtherTheRiverAndTheAvenue) {
    const Plan plan(5, 900);
    std::size_t ells = 0;
    forEachCell(plan, [&](int ix, int iy) {
        const Cell cell = plan.cell(ix, iy);
        for (std::size_t i = 0; i < cell.buildings.size(); ++i) {
            const Building& a = cell.buildings[i];
            ells += a.notch.x > 0;
            EXPECT_GT(a.half.x, 1.5);
            EXPECT_GT(a.half.y, 1.5);
            for (std::size_t k = 0; k < i; ++k)
                EXPECT_TRUE(apart(a, cell.buildings[k]))
                    << ix << ' ' << iy << ": " << i << ' ' << k;
            for (const glm::dvec2 p : a.footprint()) {
                EXPECT_GT(plan.riverDistance(p), plan.riverHalfWidth() + 5);
                EXPECT_GT(std::abs(plan.avenueDistance(p)), 10);
            }
        }
    });
    EXPECT_GT(ells, 10u);
}

TEST(Plan, StandsBuildingsInTheGroundNotAboveIt) {
    const Plan plan(1, 400);
    forEachCell(plan, [&](int ix, int iy) {
        for (const Building& b : plan.cell(ix, iy).buildings)
            for (const glm::dvec2 p : b.footprint()) {
                EXPECT_LT(b.baseMetres, plan.ground(p) - 1);
                EXPECT_GT(b.eavesMetres, plan.ground(p) + 2);
            }
    });
}

TEST(Plan, IsTallerInTheMiddle) {
    const Plan plan(1, 20000);
    double inner = 0, outer = 0, highest = 0;
    std::size_t innerCount = 0, outerCount = 0;
    for (int i = plan.firstCell(); i < plan.firstCell() + plan.cells(); ++i)
        for (const Building& b : plan.cell(i, 1).buildings) {
            const double height = b.topMetres() - b.baseMetres - 1.5;
            const double r = glm::distance(b.centre, Plan::centre()) / plan.radiusMetres();
            highest = std::max(highest, height);
            if (r < 0.3)
                inner += height, ++innerCount;
            if (r > 0.8)
                outer += height, ++outerCount;
        }
    ASSERT_GT(innerCount, 20u);
    ASSERT_GT(outerCount, 20u);
    EXPECT_GT(inner / double(innerCount), 13);
    EXPECT_LT(outer / double(outerCount), 11);
    EXPECT_LT(highest, 70);
}

TEST(Plan, HasLevelRiverAndLevelBridgeheads) {
    const Plan plan(1, 400);
    for (double x = -500; x < 500; x += 7)
        for (double y = -500; y < 500; y += 7)
            if (plan.riverDistance({x, y}) < plan.riverHalfWidth()) {
                EXPECT_EQ(plan.terrain({x, y}), 0.0);
            }
    for (const double end : {-1.0, 1.0}) {
        const glm::dvec2 p{Plan::axisX(), plan.bridgeY() + end * plan.deckHalfLength()};
        EXPECT_NEAR(plan.ground(p), plan.deckMetres(), 0.05);
    }
}

TEST(Plan, DependsOnTheSeed) {
    const Plan a(1, 400), b(2, 400);
    EXPECT_NE(a.terrain({300, 300}), b.terrain({300, 300}));
    const Cell ca = a.cell(1, 1), cb = b.cell(1, 1);
    ASSERT_FALSE(ca.buildings.empty());
    ASSERT_FALSE(cb.buildings.empty());
    EXPECT_NE(ca.buildings[0].half, cb.buildings[0].half);
}

TEST(Plan, DividesEveryTileIntoAllFourOrNone) {
    const Plan plan(1, 20000);
    EXPECT_EQ(plan.levels(), 6);
    EXPECT_TRUE(subdivided(plan, {0, 0, 0}));
    EXPECT_FALSE(subdivided(plan, {6, 0, 0}));
    EXPECT_FALSE(subdivided(plan, {4, 0, 0})); // country in the corner
    EXPECT_TRUE(subdivided(plan, {5, 16, 16}));
}

TEST(Plan, HalvesTheErrorAtEveryLevel) {
    const Plan plan(1, 400);
    for (int level = 0; level < plan.levels(); ++level)
        EXPECT_EQ(geometricErrorMetres(plan, level), 2 * geometricErrorMetres(plan, level + 1));
    EXPECT_EQ(geometricErrorMetres(plan, plan.levels() - 1), 4.0);
}

} // namespace
} // namespace gnomon::builtin
