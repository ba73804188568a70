// What the filters that stand beside PCSS promise: jittered taps that stay where they are, and the
// penumbra of a near light, which for the sun is wrong by a factor that is known.
#include "tests/frame/passes.h"
#include "tests/frame/profile.h"
#include "tests/frame/technique.h"

#include <gtest/gtest.h>

#include <map>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Shapes plateAndPosts() {
    Shapes shapes;
    shapes.box({-12, -8, 5}, {12, 8, 5.5});
    for (int i = 0; i < 12; ++i)
        shapes.box({-20 + 3.5 * i, 14, 0}, {-19.6 + 3.5 * i, 14.4, 6});
    shapes.house({20, -16}, {30, -2}, 5, 9);
    return shapes;
}

} // namespace

TEST(Jitter, OfALatticeCellStaysWhileTheCameraMoves) {
    const Look look{{-35, -45, 25}, {0, 0, 0}, 45, 320, 180};
    for (const char* text : {"single+receiver-plane+jitter4", "single+normal+jitter4"}) {
        const ShadowSettings settings = technique(text);
        SmallScene scene(plateAndPosts(), {kCologne, true, settings});
        const FrameRequest request = scene.request(look, 140, 35);
        Passes passes(scene.scene(), kCologne.heightMetres);
        passes.load(request.camera);
        passes.see(request.camera);
        const Passes::Answer first = passes.ask(request.camera, request.sun, settings);
        const Cascade before = passes.cascades().cascades[0];
        std::size_t partly = 0, changed = 0, windows = 0;
        Camera camera = request.camera;
        for (int frame = 1; frame <= 12; ++frame) {
            camera.position = request.camera.position +
                              (0.37 * frame * before.texelMetres) * request.camera.right +
                              (0.21 * frame * before.texelMetres) * request.camera.forward;
            const Passes::Answer now = passes.ask(camera, request.sun, settings);
            const Cascade after = passes.cascades().cascades[0];
            if (after.texelMetres != before.texelMetres)
                continue;
            windows += after.cornerX != before.cornerX || after.cornerY != before.cornerY;
            for (std::size_t i = 0; i < now.visibility.size(); ++i)
                if (first.visibility[i] > 0.01f && first.visibility[i] < 0.99f) {
                    ++partly;
                    changed += std::abs(now.visibility[i] - first.visibility[i]) > 1.0f / 255.0f;
                }
        }
        std::printf("[ measured ] %s: %zu of %zu partly lit pixels change over %zu windows\n", text,
                    changed, partly, windows);
        EXPECT_GT(partly, 5000u);
        EXPECT_GT(windows, 4u);
        // Where a receiver stands on the very border of two cells, rounding chooses.
        EXPECT_LE(double(changed), 2e-3 * double(partly)) << text;
    }
}

TEST(Jitter, TakesSixteenTapsThatTogetherAreTheBox) {
    SmallScene scene(plateAndPosts());
    const Look look{{-35, -45, 25}, {0, 0, 0}, 45, 640, 360};
    scene.setShadows(technique("single+normal+pcf:4"));
    const Shot box = scene.draw(look, 140, 35);
    scene.setShadows(technique("single+normal+jitter4"));
    const Shot jitter = scene.draw(look, 140, 35);
    double boxSum = 0.0, jitterSum = 0.0, apart = 0.0;
    std::size_t partly = 0, between = 0;
    std::map<int, std::size_t> levels;
    for (std::size_t i = 0; i < box.visibility.size(); ++i) {
        const double b = box.visibility[i], j = jitter.visibility[i];
        if (box.sky(i) || box.facing(i) < 0.1 || b <= 0.02 || b >= 0.98)
            continue;
        ++partly;
        boxSum += b, jitterSum += j, apart += std::abs(b - j);
        ++levels[int(std::lround(16.0 * j))];
        between += std::abs(16.0 * j - std::round(16.0 * j)) > 1e-3;
    }
    ASSERT_GT(partly, 2000u);
    std::printf("[ measured ] mean %.4f of the box, %.4f jittered; %.4f apart; %zu levels\n",
                boxSum / double(partly), jitterSum / double(partly), apart / double(partly),
                levels.size());
    EXPECT_NEAR(jitterSum / double(partly), boxSum / double(partly), 0.01);
    EXPECT_EQ(between, 0u); // sixteenths
    EXPECT_EQ(levels.size(), 17u);
    EXPECT_GT(apart / double(partly), 0.01); // and it is no box
    EXPECT_LT(apart / double(partly), 0.12);
}

// The penumbra of a light at the map's near plane is range / blocker's distance from there as wide,
// where the light has the sun's extent as seen across the range.
TEST(PcssRatio, IsTooWideForTheSunByRangeOverBlockerDistance) {
    Shapes shapes;
    const double height = 150.0, e = 60.0 * kRadiansPerDegree;
    shapes.box({0, -400, height}, {200, 1500, height + 0.2});
    const double gap = height / std::sin(e), half = gap * kTanSun, shadowX = -height / std::tan(e);
    const Look look{{shadowX - 3, -30, 25}, {shadowX, 90, 0}, 40, 640, 360};
    for (const char* bias : {"receiver-plane", "slope"}) {
        std::map<std::string, std::map<std::size_t, Profile>> profiles;
        std::vector<double> factors;
        Shot shot;
        for (const char* filter : {"pcss:32,64", "pcss-ratio:32,64"}) {
            const ShadowSettings settings =
                technique(std::string("csm+") + bias + "+" + filter, 2048);
            SmallScene scene(shapes, {kCologne, true, settings});
            const FrameRequest request = scene.request(look, 90, 60);
            shot = scene.draw(request);
            Passes passes(scene.scene(), kCologne.heightMetres);
            passes.load(request.camera);
            factors.clear();
            const CascadeSet& set = passes.fit(request.camera, request.sun, settings);
            for (const Cascade& c : set.cascades) {
                // The plate's western edge, where its shadow's edge comes from.
                const Transform<Ecef, Enu> at = ecefFromEnu(kCologne);
                const double z = set.lightFromEcef(at(Point<Enu>{{0, 60, height}})).xyz.z;
                factors.push_back(c.depthRangeMetres /
                                  (c.depthRangeMetres - (z - c.farPlaneMetres)));
            }
            for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
                const auto c = std::size_t(shot.cascade[i]);
                if (shot.sky(i) || shot.position[i].z > 1.0 || c >= factors.size() ||
                    shot.position[i].y > 1000.0 ||
                    shot.texel(i) != shot.facts.cascades[c].texelMetres)
                    continue;
                profiles[filter]
                    .try_emplace(c, 9.0 * half)
                    .first->second.add((shadowX - shot.position[i].x) * std::sin(e),
                                       shot.visibility[i]);
            }
        }
        std::size_t cases = 0;
        for (const auto& [c, right] : profiles["pcss:32,64"]) {
            const Profile& ratio = profiles["pcss-ratio:32,64"].at(c);
            if (2.0 * half < 4.0 * shot.facts.cascades[c].texelMetres || right.samples() < 400)
                continue;
            const double wider = ratio.width() / right.width();
            std::printf("[ measured ] %s cascade %zu: %.3f m and %.3f m, %.2f times; expected "
                        "%.2f\n",
                        bias, c, right.width(), ratio.width(), wider, factors[c]);
            ++cases;
            EXPECT_GT(factors[c], 1.2);
            EXPECT_NEAR(wider / factors[c], 1.0, 0.12) << bias << " " << c;
        }
        EXPECT_GE(cases, 2u);
    }
}
