#include "geo/plan_frame.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;

TEST(PlanFrame, IsThereAndBackTheSamePlaceAlsoAtAPoleAndOnTheAntimeridian) {
    for (const glm::dvec2 origin : {glm::dvec2(7, 51), glm::dvec2(179.9999, -16.5),
                                    glm::dvec2(0, 90), glm::dvec2(30, -89.9999)}) {
        const PlanFrame frame(origin);
        for (const glm::dvec2 p : {glm::dvec2(0, 0), glm::dvec2(300, -40), glm::dvec2(-5e3, 2e4),
                                   glm::dvec2(9e4, 9e4)}) {
            const glm::dvec2 lonLat = frame.lonLat(p);
            EXPECT_LE(std::abs(lonLat.x - origin.x), 180.0);
            EXPECT_LT(glm::length(frame.plan(lonLat) - p), 1e-3) << p.x << ' ' << p.y;
        }
    }
}

TEST(PlanFrame, MetresAreMetres) {
    const PlanFrame frame({7, 51});
    EXPECT_NEAR(glm::length(frame.plan({7, 51})), 0.0, 1e-8);
    // A thousandth of a degree: 111.2483 m along the meridian there (its radius of curvature).
    EXPECT_NEAR(frame.plan({7, 51.001}).y, 111.2483, 1e-3);
    EXPECT_NEAR(frame.plan({7, 51.001}).x, 0.0, 1e-6);
    EXPECT_GT(frame.plan({7.001, 51}).x, 70.0);
}
