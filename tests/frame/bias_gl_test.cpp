// What each bias promises: no surface shades itself up to some angle between it and the sun, and
// shadows fall where geometry says but for a few texels.
#include "shadows/bias.h"
#include "tests/frame/small_scene.h"
#include "tests/frame/technique.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A sheet that rises by 20° to the north, nothing around it.
Shapes inclinedSheet() {
    Shapes shapes;
    const double rise = 40.0 * std::tan(20.0 * kRadiansPerDegree);
    shapes.quad({-20, -20, 0}, {20, -20, 0}, {20, 20, rise}, {-20, 20, rise});
    return shapes;
}

constexpr Look kAboveTheSheet{{3, -25, 28}, {0, 2, 7}, 60, 240, 135};

// The share of the sheet's pixels that are not fully lit; nothing stands before it.
double acne(SmallScene& scene, const char* text, double azimuth, double angleToSun) {
    scene.setShadows(technique(text));
    // The sheet's normal points 20° off the zenith to the south: a sun in the south at this
    // elevation, or turned about that normal.
    const double tilt = 20.0 * kRadiansPerDegree, angle = angleToSun * kRadiansPerDegree,
                 turn = azimuth * kRadiansPerDegree;
    const glm::dvec3 normal(0, -std::sin(tilt), std::cos(tilt)), east(1, 0, 0),
        up = glm::cross(normal, east);
    const glm::dvec3 sun =
        std::cos(angle) * normal + std::sin(angle) * (std::cos(turn) * east + std::sin(turn) * up);
    const Shot shot = scene.draw(kAboveTheSheet, std::atan2(sun.x, sun.y) / kRadiansPerDegree,
                                 std::asin(sun.z) / kRadiansPerDegree);
    std::size_t pixels = 0, wrong = 0;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i)
        if (!shot.sky(i)) {
            EXPECT_NEAR(shot.facing(i), std::cos(angle), 1e-3);
            ++pixels;
            wrong += shot.visibility[i] != 1.0f;
        }
    EXPECT_GT(pixels, 8000u);
    return double(wrong) / double(pixels);
}

constexpr const char* kFilters[] = {"none", "bilinear", "pcf:5", "jitter4", "pcss:5,9"};

} // namespace

TEST(Bias, IsByTheTexelAndTheFilter) {
    ShadowSettings s = technique("csm+constant+none");
    const double root2 = std::sqrt(2.0);
    EXPECT_DOUBLE_EQ(constantBiasMetres(s, 0.1), root2 * 0.05);
    s = technique("csm+constant+pcf:5");
    EXPECT_DOUBLE_EQ(constantBiasMetres(s, 0.1), root2 * 0.3);
    EXPECT_EQ(constantBiasMetres(technique("csm+constant:0.7+pcf:5"), 0.1), 0.7);
    EXPECT_EQ(constantBiasMetres(technique("csm+slope+pcf:5"), 0.1), 0.0);
    EXPECT_DOUBLE_EQ(layerOffsetMetres(technique("csm+dual-peel+bilinear"), 0.1),
                     root2 * 0.1 * kSteepestSlope);
    EXPECT_EQ(layerOffsetMetres(technique("csm+dual-atomic:3+bilinear"), 0.1), 3.0);
    EXPECT_TRUE(std::isinf(layerOffsetMetres(technique("csm+midpoint+bilinear"), 0.1)));
}

// Constant to 45°, the others as far as 84°.
TEST(Bias, KeepsAPlaneLitUpToTheAngleItPromises) {
    SmallScene scene(inclinedSheet(), {kCologne, false, {}});
    struct Row {
        const char* bias;
        double most;
    };
    for (const char* filter : kFilters)
        for (const Row& row :
             {Row{"constant", 44.5}, Row{"slope", 83.5}, Row{"normal", 83.5},
              Row{"receiver-plane", 88}, Row{"dual-peel", 83.5}, Row{"midpoint", 83.5}})
            for (const double azimuth : {33.0, 270.0})
                for (const double angle : {0.6 * row.most, row.most}) {
                    const std::string text = std::string("single+") + row.bias + "+" + filter;
                    EXPECT_EQ(acne(scene, text.c_str(), azimuth, angle), 0.0)
                        << text << " " << azimuth << " " << angle;
                }
}

TEST(Bias, IsNeededAndFailsBeyondItsPromise) {
    SmallScene scene(inclinedSheet(), {kCologne, false, {}});
    for (const char* filter : kFilters) {
        const auto with = [&](const char* bias, double angle) {
            const std::string text = std::string("single+") + bias + "+" + filter;
            const double share = acne(scene, text.c_str(), 33.0, angle);
            std::printf("[ measured ] %s at %.0f: %.3f of the pixels\n", text.c_str(), angle,
                        share);
            return share;
        };
        for (const double angle : {20.0, 60.0}) {
            EXPECT_GT(with("constant:0", angle), 0.3) << filter;
            EXPECT_GT(with("dual-peel:0", angle), 0.3) << filter;
            EXPECT_GT(with("dual-atomic:0", angle), 0.3) << filter;
        }
        EXPECT_GT(with("constant", 70.0), 0.1) << filter;
        EXPECT_GT(with("dual-peel", 87.0), 0.1) << filter;
    }
}

// On a box, a house, a dome, a wall and a sheet: shadows against rays, but for the texels that the
// bias moves them.
TEST(Bias, LeavesShadowsWhereGeometrySays) {
    Shapes shapes;
    shapes.box({-5, -5, 0}, {5, 5, 10});
    shapes.house({20, -6}, {30, 8}, 5, 9);
    shapes.dome({-20, 10}, 6);
    shapes.box({-30, -25, 0}, {30, -24.5, 4});
    shapes.quad({8, 14, 0}, {18, 14, 0}, {18, 14, 6}, {8, 14, 6});
    SmallScene scene(shapes);
    for (const char* text : {"csm+slope+bilinear", "csm+normal+pcss", "csm+dual-peel+pcf:3",
                             "csm+midpoint+pcf:3", "csm+dual-atomic+pcss", "csm+slope+jitter4"}) {
        ShadowSettings settings = technique(text);
        settings.mapSize = 2048;
        scene.setShadows(settings);
        Compared all;
        for (const auto& [azimuth, elevation] : {std::pair(30.0, 30.0), std::pair(285.0, 60.0)})
            for (const Look& look : {Look{{-55, -60, 40}, {0, 0, 0}}, Look{{0, 1, 140}, {0, 0, 0}}})
                all += compare(scene.draw(look, azimuth, elevation), scene.rays(azimuth, elevation),
                               {10.0, 6.0, settings.filter == ShadowFilter::Pcss});
        std::printf("[ measured ] %s: false lit %zu of %zu, false shadow %zu of %zu, edge %zu\n",
                    text, all.falseLit, all.dark, all.falseShadow, all.lit, all.edge);
        EXPECT_GT(all.dark, 2000u);
        EXPECT_LE(double(all.falseLit), 1e-3 * double(all.dark)) << text;
        EXPECT_LE(double(all.falseShadow), 1e-3 * double(all.lit)) << text;
    }
}
