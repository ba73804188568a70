// The same scene under the same sun is the same picture wherever on Earth it stands, and from a
// camera a rounding error away.
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A yard of its own instead of the ground, whose curvature is another at a pole.
Shapes yard() {
    Shapes shapes;
    shapes.box({-120, -120, -1}, {120, 120, 0});
    shapes.box({-5, -5, 0}, {5, 5, 10});
    shapes.house({14, -6}, {24, 8}, 5, 9);
    shapes.dome({-20, 10}, 6);
    shapes.box({-12, 24, 5}, {12, 30, 5.5});
    for (int i = 0; i < 10; ++i)
        shapes.box({-10 + 2.0 * i, 18, 0}, {-9.8 + 2.0 * i, 18.2, 4});
    return shapes;
}

// No horizon in view: the Earth's curvature differs from place to place.
const Look kLooks[] = {{{-45, -55, 40}, {0, 0, 0}}, {{8, -30, 18}, {2, 4, 2}}};

// Pixels with a channel more than 2 of 255 apart.
std::size_t apart(const Picture& a, const Picture& b) {
    std::size_t out = 0;
    for (std::size_t i = 0; i + 2 < a.rgb.size(); i += 3) {
        int most = 0;
        for (std::size_t c = 0; c < 3; ++c)
            most = std::max(most, std::abs(int(a.rgb[i + c]) - int(b.rgb[i + c])));
        out += most > 2;
    }
    return out;
}

std::size_t allowed(const Picture& p) {
    return p.rgb.size() / 3 / 10000;
} // 0.01 %

} // namespace

TEST(Rigidity, TheSameSceneIsTheSamePictureAnywhereOnEarth) {
    const SmallScene::Options first{{0, 0, 20}, false, {}};
    SmallScene reference(yard(), first);
    std::vector<Shot> expected;
    for (const Look& look : kLooks)
        for (const double elevation : {8.0, 40.0, 90.0})
            expected.push_back(reference.draw(look, 215, elevation));
    for (const Geodetic& place : {Geodetic{0, 90, 20}, Geodetic{180, 0, 20}, Geodetic{-180, 0, 20},
                                  Geodetic{6.96, 50.94, 20}, Geodetic{-70, -90, 20}}) {
        SmallScene scene(yard(), {place, false, {}});
        std::size_t i = 0;
        for (const Look& look : kLooks)
            for (const double elevation : {8.0, 40.0, 90.0}) {
                const Shot shot = scene.draw(look, 215, elevation);
                const std::size_t pixels = apart(shot.picture, expected[i].picture);
                EXPECT_LE(pixels, allowed(shot.picture))
                    << place.longitudeDegrees << "," << place.latitudeDegrees << " " << elevation;
                std::printf("[ measured ] %g,%g sun %g: %zu pixels apart\n", place.longitudeDegrees,
                            place.latitudeDegrees, elevation, pixels);
                ASSERT_EQ(shot.facts.cascades.size(), expected[i].facts.cascades.size());
                for (std::size_t c = 0; c < shot.facts.cascades.size(); ++c) {
                    EXPECT_NEAR(shot.facts.cascades[c].texelMetres /
                                    expected[i].facts.cascades[c].texelMetres,
                                1.0, 1e-9);
                    EXPECT_NEAR(shot.facts.cascades[c].farMetres /
                                    expected[i].facts.cascades[c].farMetres,
                                1.0, 1e-9);
                }
                ++i;
            }
    }
}

TEST(Rigidity, ACameraARoundingErrorAwaySeesTheSamePicture) {
    SmallScene scene(yard(), {kCologne, true, {}});
    for (const Look& look : kLooks)
        for (const double elevation : {8.0, 40.0}) {
            FrameRequest request = scene.request(look, 215, elevation);
            const Shot first = scene.draw(request);
            for (int axis = 0; axis < 3; ++axis)
                for (const double towards : {-1e9, 1e9}) {
                    FrameRequest moved = request;
                    double& x = moved.camera.position.xyz[axis];
                    x = std::nextafter(x, towards);
                    EXPECT_LE(apart(scene.draw(moved).picture, first.picture),
                              allowed(first.picture))
                        << axis << " " << towards << " " << elevation;
                }
        }
}
