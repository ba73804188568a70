// Shadows stand still: what one camera sees, asked again under another camera's maps, and the maps'
// own bytes.
#include "tests/frame/passes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Shapes town() {
    Shapes shapes;
    shapes.box({-5, -5, 0}, {5, 5, 10});
    shapes.house({14, -6}, {24, 8}, 5, 9);
    shapes.dome({-20, 10}, 6);
    shapes.box({-30, -18, 0}, {30, -17.7, 3});
    for (int i = 0; i < 12; ++i) // bars
        shapes.box({-10 + 2.0 * i, 18, 0}, {-9.8 + 2.0 * i, 18.2, 4});
    shapes.box({-12, 24, 5}, {12, 30, 5.5});
    shapes.quad({30, 10, 0}, {36, 16, 0}, {36, 16, 7}, {30, 10, 7});
    shapes.box({60, 40, 0}, {75, 60, 30});
    return shapes;
}

ShadowSettings smallMaps(int cascades = 3, int size = 1024) {
    ShadowSettings s;
    s.cascades = cascades;
    s.mapSize = size;
    return s;
}

// Turns and shifts that a hand on the mouse makes, each less than a texel of the nearest cascade.
Camera nudged(const Camera& from, std::mt19937& random, double texel) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    Camera camera = from;
    camera.position =
        from.position + 0.5 * texel * Vector<Ecef>{{unit(random), unit(random), unit(random)}};
    const double turn = 2e-4 * unit(random), tilt = 2e-4 * unit(random);
    camera.forward = normalize(from.forward + turn * from.right + tilt * from.up);
    camera.right = normalize(from.right - dot(from.right, camera.forward) * camera.forward);
    camera.up = cross(camera.right, camera.forward);
    return camera;
}

// Which cascade decides, and whether it alone does: not where two are mixed or shadows fade.
struct Zones {
    Zones(const Shot& shot, const Camera& camera, const CascadeSet& set) : set_(set) {
        const Vector<Ecef> shift = shot.camera.position - camera.position;
        const Camera& c = shot.camera;
        for (int y = 0; y < c.heightPixels; ++y)
            for (int x = 0; x < c.widthPixels; ++x) {
                const std::size_t i = along_.size();
                const double u = (2.0 * x + 1.0) / c.widthPixels - 1.0;
                const double v = 1.0 - (2.0 * y + 1.0) / c.heightPixels;
                const double d = std::isfinite(shot.depth[i]) ? double(shot.depth[i]) : 0.0;
                const Vector<Ecef> p = shift + d * (c.forward + u * c.tanHalfWidth() * c.right +
                                                    v * c.tanHalfHeight() * c.up);
                along_.push_back(dot(camera.forward, p));
                distance_.push_back(length(p));
            }
    }
    bool alone(std::size_t i, std::size_t cascade) const {
        const bool last = cascade + 1 == set_.cascades.size();
        return (last || along_[i] < set_.cascades[cascade].blendStartMetres * (1 - 1e-5)) &&
               distance_[i] < set_.rangeMetres - set_.fadeMetres;
    }

  private:
    const CascadeSet& set_;
    std::vector<double> along_, distance_;
};

double nearestTexel(const CascadeSet& set) {
    return set.cascades.front().texelMetres;
}

} // namespace

TEST(Stability, SurfacesSeenOnceKeepTheirShadowWhileTheCameraMovesAndTurns) {
    std::mt19937 random(5);
    std::size_t asked = 0, flips = 0, otherCascade = 0, mixed = 0, shadowed = 0;
    double worst = 0.0;
    const ShadowSettings settings = smallMaps();
    SmallScene scene(town(), {kCologne, true, settings});
    for (const auto& [azimuth, elevation, look] :
         {std::tuple(140.0, 35.0, Look{{-45, -55, 25}, {0, 0, 0}, 45, 240, 135}),
          std::tuple(250.0, 12.0, Look{{10, -35, 1.8}, {4, 0, 3}, 60, 240, 135})}) {
        const FrameRequest request = scene.request(look, azimuth, elevation);
        const Shot shot = scene.draw(request);
        Passes passes(scene.scene(), kCologne.heightMetres);
        passes.load(request.camera);
        passes.see(request.camera);
        const Passes::Answer first = passes.ask(request.camera, request.sun, settings);
        ASSERT_EQ(first.visibility.size(), shot.visibility.size());
        const CascadeSet firstSet = passes.cascades();
        const Zones firstZones(shot, request.camera, firstSet);
        Camera camera = request.camera;
        for (int frame = 0; frame < 100; ++frame) {
            camera = nudged(camera, random, nearestTexel(firstSet));
            const Passes::Answer now = passes.ask(camera, request.sun, settings);
            const Zones zones(shot, camera, passes.cascades());
            for (std::size_t i = 0; i < now.visibility.size(); ++i) {
                if (shot.sky(i) || now.cascade[i] == 255)
                    continue;
                if (now.cascade[i] != first.cascade[i]) {
                    ++otherCascade;
                    continue;
                }
                if (!zones.alone(i, now.cascade[i]) || !firstZones.alone(i, now.cascade[i])) {
                    ++mixed;
                    continue;
                }
                ++asked;
                shadowed += now.visibility[i] < 0.5f;
                const double change = std::abs(now.visibility[i] - first.visibility[i]);
                flips += change > 1.0 / 255.0;
                worst = std::max(worst, change);
            }
        }
    }
    std::printf("[ measured ] flips %zu of %zu asked (%zu in another cascade, %zu mixed), largest "
                "change %.5f\n",
                flips, asked, otherCascade, mixed, worst);
    EXPECT_GT(asked, 2000000u);
    EXPECT_GT(shadowed, 100000u);
    EXPECT_EQ(flips, 0u);
}

TEST(Stability, MapsKeepTheirBytesWhereTheWindowStaysAndWhereItOverlaps) {
    std::mt19937 random(6);
    const ShadowSettings settings = smallMaps(2, 512);
    SmallScene scene(town(), {kCologne, true, settings});
    const FrameRequest request = scene.request({{-45, -55, 25}, {0, 0, 0}}, 140, 35);
    Passes passes(scene.scene(), kCologne.heightMetres);
    passes.load(request.camera);
    passes.fit(request.camera, request.sun, settings);
    passes.drawMaps(settings);
    std::vector<Cascade> before = passes.cascades().cascades;
    std::vector<std::vector<float>> maps{passes.maps().read(0), passes.maps().read(1)};
    std::size_t same = 0, moved = 0, differing = 0, compared = 0, drawn = 0;
    Camera camera = request.camera;
    const int n = settings.mapSize;
    for (int frame = 0; frame < 60; ++frame) {
        camera = nudged(camera, random, (frame % 3 + 0.3) * before[0].texelMetres);
        passes.fit(camera, request.sun, settings);
        passes.drawMaps(settings);
        for (std::size_t c = 0; c < 2; ++c) {
            const Cascade &a = before[c], b = passes.cascades().cascades[c];
            const std::vector<float> now = passes.maps().read(int(c));
            // Another far plane or range is another map.
            if (a.texelMetres == b.texelMetres && a.farPlaneMetres == b.farPlaneMetres &&
                a.depthRangeMetres == b.depthRangeMetres) {
                (a.cornerX == b.cornerX && a.cornerY == b.cornerY ? same : moved) += 1;
                const auto modulo = [n](std::int64_t x) { return std::size_t(((x % n) + n) % n); };
                for (std::int64_t y = std::max(a.cornerY, b.cornerY);
                     y < std::min(a.cornerY, b.cornerY) + n; ++y)
                    for (std::int64_t x = std::max(a.cornerX, b.cornerX);
                         x < std::min(a.cornerX, b.cornerX) + n; ++x) {
                        const std::size_t at = modulo(y) * std::size_t(n) + modulo(x);
                        ++compared;
                        drawn += now[at] != 0.0f;
                        differing += std::memcmp(&now[at], &maps[c][at], sizeof(float)) != 0;
                    }
            }
            before[c] = b;
            maps[c] = now;
        }
    }
    std::printf("[ measured ] %zu of %zu texels differ; windows: %zu the same, %zu moved\n",
                differing, compared, same, moved);
    EXPECT_EQ(differing, 0u);
    EXPECT_GT(same, 10u);
    EXPECT_GT(moved, 10u);
    EXPECT_GT(drawn, compared / 10);
}

TEST(Stability, TheSameFrameTwiceIsTheSameBytes) {
    SmallScene scene(town());
    const Look look{{-45, -55, 25}, {0, 0, 0}};
    const Shot first = scene.draw(look, 140, 35);
    scene.draw({{10, -35, 1.8}, {4, 0, 3}}, 250, 12); // something else between
    const Shot second = scene.draw(look, 140, 35);
    EXPECT_EQ(first.picture.rgb, second.picture.rgb);
    EXPECT_EQ(first.visibility, second.visibility);
    EXPECT_EQ(first.depth, second.depth);
    SmallScene again(town());
    EXPECT_EQ(again.draw(look, 140, 35).picture.rgb, first.picture.rgb);
}
