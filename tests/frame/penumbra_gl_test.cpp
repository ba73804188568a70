// Penumbrae are as wide as the sun makes them, in every cascade.
#include "tests/frame/profile.h"
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

#include <map>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A disc of radius 1 is covered to 10 % where its edge stands 0.6871 from the middle: the root of
// 1/2 + (x sqrt(1 - x²) + asin x) / pi = 0.9.
double tenToNinety() {
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 60; ++i) {
        const double x = 0.5 * (low + high);
        const double share = 0.5 + (x * std::sqrt(1 - x * x) + std::asin(x)) / 3.14159265358979;
        (share < 0.9 ? low : high) = x;
    }
    return 2.0 * low;
}

} // namespace

TEST(Penumbra, IsAsWideAsTheGapTimesTheSunInEveryCascade) {
    // A plate high up, its western edge along the view: the same gap from near to far.
    double worst = 0.0, worstApart = 0.0;
    std::size_t cases = 0;
    for (const double height : {60.0, 150.0, 300.0})
        for (const double elevation : {35.0, 60.0, 89.0}) {
            Shapes shapes;
            shapes.box({0, -400, height}, {200, 1500, height + 0.2});
            ShadowSettings settings;
            settings.cascades = 4;
            SmallScene scene(shapes, {kCologne, true, settings});
            const double azimuth = 90.0; // square to the edge
            const double e = elevation * kRadiansPerDegree;
            const double gap = height / std::sin(e), half = gap * kTanSun;
            // The edge's shadow on the ground: the lower one of the plate's western edges decides.
            const double shadowX = -height / std::tan(e);
            const Shot shot = scene.draw({{shadowX - 3, -30, 25}, {shadowX, 90, 0}, 40, 640, 360},
                                         azimuth, elevation);
            std::map<std::size_t, Profile> profiles;
            for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
                if (shot.sky(i) || shot.position[i].z > 1.0 || shot.cascade[i] == 255.0f ||
                    shot.position[i].y > 1000.0)
                    continue;
                const auto c = std::size_t(shot.cascade[i]);
                if (shot.texel(i) != shot.facts.cascades[c].texelMetres) // mixed with the next
                    continue;
                // Positive on the lit side; across the edge the light's plane is sin(e)
                // foreshortened.
                const double across = (shadowX - shot.position[i].x) * std::sin(e);
                profiles.try_emplace(c, 3.0 * half).first->second.add(across, shot.visibility[i]);
            }
            double least = 1e9, most = 0.0;
            for (const auto& [c, profile] : profiles) {
                const double texel = shot.facts.cascades[c].texelMetres;
                if (2.0 * half < 4.0 * texel || profile.samples() < 400)
                    continue;
                ++cases;
                const double expected = tenToNinety() * half;
                const double error = profile.width() / expected - 1.0;
                std::printf("[ measured ] gap %5.1f cascade %zu texel %.3f: width %.3f, true %.3f, "
                            "%+.1f %%\n",
                            gap, c, texel, profile.width(), expected, 100.0 * error);
                EXPECT_LE(std::abs(error), 0.10) << height << " " << elevation << " cascade " << c;
                worst = std::max(worst, std::abs(error));
                least = std::min(least, profile.width());
                most = std::max(most, profile.width());
            }
            if (most > 0.0) {
                EXPECT_LE(most / least, 1.05) << height << " " << elevation;
                worstApart = std::max(worstApart, most / least - 1.0);
            }
        }
    EXPECT_GE(cases, 15u);
    std::printf("[ measured ] worst %.1f %%, apart between cascades %.1f %%\n", 100.0 * worst,
                100.0 * worstApart);
}
