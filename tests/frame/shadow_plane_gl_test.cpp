// Plain surfaces stay plain: no acne where nothing shades, no light where all is shaded, no seam
// between cascades.
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

constexpr double kElevations[] = {1, 2, 3, 5, 10, 20, 30, 45, 60, 75, 85, 90};

struct Acne {
    std::size_t pixels = 0, wrong = 0;
    double worst = 1.0;
    void operator+=(const Acne& o) {
        pixels += o.pixels, wrong += o.wrong, worst = std::min(worst, o.worst);
    }
};

// On a body, above the two texels in which it may not be told from the ground it stands on.
bool offTheGround(const Shot& shot, std::size_t i) {
    return shot.position[i].z > std::max(0.01, 2.0 * shot.texel(i));
}

// Over the pixels that `lit` takes and that face the sun: those whose visibility is not 1.
template <class Lit>
Acne acneOf(const Shot& shot, const Lit& lit) {
    Acne out;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i)
        if (!shot.sky(i) && shot.facing(i) > 2.0 * kTanSun + 1e-4 && lit(shot, i)) {
            ++out.pixels;
            out.wrong += shot.visibility[i] != 1.0f;
            out.worst = std::min(out.worst, double(shot.visibility[i]));
        }
    return out;
}

} // namespace

TEST(Planes, ShowNoAcneOnOpenGround) {
    Shapes shapes;
    shapes.box({-0.5, -0.5, 0}, {0.5, 0.5, 1});
    SmallScene scene(shapes);
    Acne all;
    for (const double elevation : kElevations)
        for (const double azimuth : {10.0, 200.0})
            for (const Look& look :
                 {Look{{0, -150, 60}, {0, 100, 0}}, Look{{3, -30, 1.7}, {0, 40, 0}}}) {
                const Shot shot = scene.draw(look, azimuth, elevation);
                // The little box's shadow is no longer than 60 m.
                const Acne acne = acneOf(shot, [](const Shot& s, std::size_t i) {
                    return glm::length(glm::dvec2(s.position[i])) > 70.0;
                });
                EXPECT_EQ(acne.wrong, 0u) << elevation << " " << azimuth << " worst " << acne.worst;
                all += acne;
            }
    EXPECT_GT(all.pixels, 200000u);
    std::printf("[ measured ] %zu of %zu pixels\n", all.wrong, all.pixels);
}

// Bodies that never shade their own lit faces, each alone on the ground.
TEST(Planes, ShowNoAcneOnConvexBodies) {
    Shapes house, sheet, dome;
    house.house({-8, -12}, {8, 12}, 6, 12);
    sheet.quad({-8, -8, 2}, {8, -8, 2}, {8, 8, 9}, {-8, 8, 9});
    dome.dome({0, 0}, 10);
    for (const auto& [name, shapes] :
         {std::pair("house", house), std::pair("sheet", sheet), std::pair("dome", dome)}) {
        SmallScene scene(shapes);
        Acne all;
        for (const double elevation : {1.0, 3.0, 10.0, 30.0, 60.0, 85.0, 90.0})
            for (const double azimuth : {90.0, 180.0, 265.0})
                for (const Look& look :
                     {Look{{18, -20, 18}, {0, 0, 4}}, Look{{-60, -5, 3}, {0, 0, 5}, 25}}) {
                    const Shot shot = scene.draw(look, azimuth, elevation);
                    const Acne acne = acneOf(shot, offTheGround);
                    EXPECT_EQ(acne.wrong, 0u)
                        << name << " " << elevation << " " << azimuth << " worst " << acne.worst;
                    all += acne;
                }
        EXPECT_GT(all.pixels, 100000u);
        std::printf("[ measured ] %s: %zu of %zu pixels, worst %.3f\n", name, all.wrong, all.pixels,
                    all.worst);
    }
}

TEST(Planes, ShowNoAcneWithAnyFilter) {
    Shapes shapes;
    shapes.dome({0, 0}, 10);
    SmallScene scene(shapes);
    for (const char* filter : {"none", "bilinear", "pcf:3", "pcf:9", "pcss:5,9"}) {
        ShadowSettings settings;
        ASSERT_FALSE(parseShadowFilter(filter, settings));
        scene.setShadows(settings);
        for (const double elevation : {2.0, 30.0, 75.0}) {
            const Shot shot = scene.draw({{18, -35, 25}, {0, 0, 4}}, 190, elevation);
            // The widest box reaches four and a half texels down the wall to the ground.
            const Acne acne = acneOf(shot, [](const Shot& s, std::size_t i) {
                return s.position[i].z > 6.0 * s.texel(i);
            });
            EXPECT_EQ(acne.wrong, 0u) << filter << " " << elevation << " worst " << acne.worst;
        }
    }
}

TEST(Planes, AreDarkThroughoutBelowARoofOverAll) {
    Shapes shapes;
    shapes.box({-3000, -3000, 40}, {3000, 3000, 41});
    SmallScene scene(shapes);
    for (const double elevation : {30.0, 60.0, 90.0}) {
        const Shot shot = scene.draw({{0, -100, 8}, {0, 0, 0}}, 160, elevation);
        std::size_t ground = 0, lit = 0;
        float most = 0.0f;
        std::vector<bool> cascades(6, false);
        for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
            if (shot.sky(i) || shot.position[i].z > 1.0 || glm::length(shot.position[i]) > 2000.0 ||
                shot.cascade[i] == 255.0f)
                continue;
            ++ground;
            cascades[std::size_t(shot.cascade[i])] = true;
            lit += shot.visibility[i] != 0.0f;
            most = std::max(most, shot.visibility[i]);
        }
        EXPECT_EQ(lit, 0u) << elevation << " most " << most;
        EXPECT_GT(ground, 20000u);
        EXPECT_GE(std::count(cascades.begin(), cascades.end(), true),
                  3); // seams are in the picture
    }
}

TEST(Planes, FadeToFullSunByDistanceAtTheEndOfTheRange) {
    Shapes shapes;
    shapes.box({-3000, -3000, 40}, {3000, 3000, 41});
    ShadowSettings settings;
    settings.rangeMetres = 200.0;
    settings.fadeMetres = 50.0;
    SmallScene scene(shapes, {kCologne, true, settings});
    const Shot shot = scene.draw({{0, -100, 8}, {0, 0, 0}}, 160, 60);
    const glm::dvec3 eye(0, -100, 8);
    double worst = 0.0;
    std::size_t fading = 0, past = 0;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
        if (shot.sky(i) || shot.position[i].z > 1.0)
            continue;
        const double distance = glm::length(shot.position[i] - eye);
        const double expected = 1.0 - std::clamp((200.0 - distance) / 50.0, 0.0, 1.0);
        fading += expected > 0.0 && expected < 1.0;
        past += expected == 1.0;
        worst = std::max(worst, std::abs(expected - double(shot.visibility[i])));
        if (expected == 1.0) {
            EXPECT_EQ(shot.visibility[i], 1.0f);
        }
    }
    EXPECT_LE(worst, 1e-4);
    EXPECT_GT(fading, 500u);
    EXPECT_GT(past, 500u);
}
