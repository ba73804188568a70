// What a frame is besides its shadows' shape: night, shadows switched off, facts that hold.
#include "tests/frame/passes.h"

#include <gtest/gtest.h>

#include <numeric>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Shapes boxAndHouse() {
    Shapes shapes;
    shapes.box({-5, -5, 0}, {5, 5, 10});
    shapes.house({14, -6}, {24, 8}, 5, 9);
    return shapes;
}

const Look kLook{{-35, -45, 25}, {0, 0, 0}};

double brightness(const Picture& p) {
    return std::accumulate(p.rgb.begin(), p.rgb.end(), 0.0) / double(p.rgb.size());
}

} // namespace

TEST(Frame, WithShadowsOffIsLitWhereverItFacesTheSun) {
    ShadowSettings off;
    off.method = ShadowMethod::Off;
    SmallScene scene(boxAndHouse(), {kCologne, true, off});
    const Shot shot = scene.draw(kLook, 140, 35);
    EXPECT_TRUE(shot.facts.cascades.empty());
    EXPECT_TRUE(shot.facts.depthMs.empty());
    std::size_t lit = 0, dark = 0;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
        if (shot.sky(i))
            continue;
        if (shot.facing(i) > 2.0 * kTanSun + 1e-4) {
            ++lit;
            EXPECT_EQ(shot.visibility[i], 1.0f);
        } else if (shot.facing(i) < -1e-4) {
            ++dark;
            EXPECT_EQ(shot.visibility[i], 0.0f);
        }
    }
    EXPECT_GT(lit, 30000u);
    EXPECT_GT(dark, 1000u);
}

TEST(Frame, AtNightHasNoShadowPassAndADarkButFinitePicture) {
    SmallScene scene(boxAndHouse());
    const Shot day = scene.draw(kLook, 140, 35);
    double last = brightness(day.picture);
    for (const double elevation : {-3.0, -10.0, -40.0, -90.0}) {
        const Shot night = scene.draw(kLook, 140, elevation);
        EXPECT_TRUE(night.facts.cascades.empty()) << elevation;
        EXPECT_TRUE(night.facts.depthMs.empty());
        for (std::size_t i = 0; i < night.visibility.size(); ++i)
            if (!night.sky(i) && night.normal[i].z > 0.99) {
                ASSERT_EQ(night.visibility[i], 0.0f) << elevation;
            }
        EXPECT_LE(brightness(night.picture), last + 1.0) << elevation;
        EXPECT_GT(brightness(night.picture), 0.0);
        last = brightness(night.picture);
    }
    EXPECT_LT(last, 0.5 * brightness(day.picture));
}

TEST(Frame, GoesThroughSunsetWithoutAJump) {
    SmallScene scene(boxAndHouse());
    double last = brightness(scene.draw(kLook, 140, 1.5).picture), largest = 0.0;
    for (double elevation = 1.45; elevation > -1.5; elevation -= 0.05) {
        const double now = brightness(scene.draw(kLook, 140, elevation).picture);
        largest = std::max(largest, std::abs(now - last));
        last = now;
    }
    std::printf("[ measured ] largest step of mean brightness over 0.05 degrees: %.2f of 255\n",
                largest);
    EXPECT_LE(largest, 3.0);
}

TEST(Frame, TellsWhatItDrew) {
    SmallScene scene(boxAndHouse());
    const Shot shot = scene.draw(kLook, 140, 35);
    EXPECT_TRUE(shot.facts.complete);
    EXPECT_TRUE(shot.facts.missing.empty());
    EXPECT_EQ(shot.facts.tilesSelected, 1u);
    EXPECT_EQ(shot.facts.cascades.size(), 4u);
    EXPECT_EQ(shot.facts.depthMs.size(), 4u);
    EXPECT_GT(shot.facts.cascades[0].casters, 0u);
    EXPECT_GT(shot.facts.triangles, 20u);
    EXPECT_GT(shot.facts.gpuBytes, 0u);
    for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
        ASSERT_TRUE(shot.visibility[i] == -1.0f ||
                    (shot.visibility[i] >= 0.0f && shot.visibility[i] <= 1.0f));
        ASSERT_EQ(shot.sky(i), std::isinf(shot.depth[i]));
        ASSERT_TRUE(shot.cascade[i] < 4.0f || shot.cascade[i] == 255.0f);
        if (!shot.sky(i)) {
            ASSERT_NEAR(glm::length(shot.normal[i]), 1.0, 1e-3);
        }
    }
}

TEST(Frame, SurvivesCamerasWhereNoneShouldBe) {
    SmallScene scene(boxAndHouse());
    std::vector<FrameRequest> requests;
    const auto with = [&](const Look& look, double fov, int w, int h) {
        FrameRequest request = scene.request(look, 140, 35);
        request.camera.verticalFovRadians = fov * kRadiansPerDegree;
        request.camera.widthPixels = w;
        request.camera.heightPixels = h;
        requests.push_back(request);
    };
    for (const double fov : {0.0, 1e-4, 179.9999, 180.0})
        with(kLook, fov, 64, 36);
    with(kLook, 45, 1, 1);
    with({{0, 0, 5}, {1, 0, 5}}, 45, 64, 36);     // inside the box
    with({{0, 0, -200}, {10, 0, 0}}, 45, 64, 36); // underground
    with({{0, 0, 50}, {0, 0, 100}}, 45, 64, 36);  // nothing but sky
    with({{0, 0, 2e7}, {0, 0, 0}}, 45, 64, 36);   // far out
    requests.push_back(scene.request(kLook, 140, 35));
    requests.back().camera.position = {}; // the Earth's centre
    for (const FrameRequest& request : requests) {
        const auto facts = scene.renderer().draw(request);
        ASSERT_TRUE(facts);
        for (const CascadeFacts& c : facts->cascades) {
            EXPECT_TRUE(std::isfinite(c.nearMetres) && std::isfinite(c.farMetres) &&
                        std::isfinite(c.texelMetres));
            EXPECT_LT(c.nearMetres, c.farMetres);
        }
        for (const float v : scene.renderer().aov(Aov::Sun).values)
            ASSERT_TRUE(v == -1.0f || (v >= 0.0f && v <= 1.0f));
    }
}

TEST(Frame, WithARangeNearerThanAllThereIsToSeeHasNoShadows) {
    ShadowSettings settings;
    settings.rangeMetres = 1.5;
    SmallScene scene(boxAndHouse(), {kCologne, true, settings});
    const Shot shot = scene.draw(kLook, 140, 35);
    for (std::size_t i = 0; i < shot.visibility.size(); ++i)
        if (!shot.sky(i) && shot.facing(i) > 2.0 * kTanSun + 1e-4) {
            ASSERT_EQ(shot.visibility[i], 1.0f);
        }
}
