// Planes found in pictures made by rays.
#include "shadows/light_basis.h"
#include "shadows/plane_maps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace gnomon;

namespace {

// Half spaces' faces and boxes, in metres about the camera; what a ray meets first.
struct Scene {
    struct Rect { // a + s u + t v, s and t in [0, 1]
        glm::dvec3 a, u, v;
    };
    std::vector<Rect> rects;
    double earthRadius = 0.0; // about (0, 0, -radius - eyeHeight) when not 0
    double eyeHeight = 0.0;

    struct Hit {
        double distance = std::numeric_limits<double>::infinity();
        glm::dvec3 normal{0.0};
    };
    Hit meet(const glm::dvec3& ray) const {
        Hit best;
        for (const Rect& r : rects) {
            const glm::dvec3 n = glm::normalize(glm::cross(r.u, r.v));
            const double along = glm::dot(n, ray);
            if (std::abs(along) < 1e-12)
                continue;
            const double t = glm::dot(n, r.a) / along;
            const glm::dvec3 p = t * ray - r.a;
            const double s = glm::dot(p, r.u) / glm::dot(r.u, r.u),
                         q = glm::dot(p, r.v) / glm::dot(r.v, r.v);
            if (t > 0.0 && t < best.distance && s >= 0 && s <= 1 && q >= 0 && q <= 1)
                best = {t, along > 0.0 ? -n : n};
        }
        if (earthRadius > 0.0) {
            const glm::dvec3 c(0, 0, -earthRadius - eyeHeight);
            const double b = glm::dot(ray, c), d = glm::dot(ray, ray);
            // |c|² - r², without losing the eye's height in it.
            const double k = eyeHeight * (2.0 * earthRadius + eyeHeight);
            const double root = b * b - d * k;
            if (root > 0.0) {
                const double t = k / (b + std::sqrt(root));
                if (t > 0.0 && t < best.distance)
                    best = {t, glm::normalize(t * ray - c)};
            }
        }
        return best;
    }
};

struct Taken {
    Camera camera;
    std::vector<float> depth;
    std::vector<std::uint16_t> normals;
    SeenSurfaces seen() const { return {camera, glm::dmat3(1.0), depth, normals}; }
};

void put(std::vector<std::uint16_t>& out, const glm::dvec3& n) {
    const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    glm::dvec2 e(n.x / sum, n.y / sum);
    if (n.z < 0.0)
        e = {std::copysign(1.0 - std::abs(n.y / sum), n.x),
             std::copysign(1.0 - std::abs(n.x / sum), n.y)};
    const auto word = [](double v) {
        return std::uint16_t(std::lround((v * 0.5 + 0.5) * 65535.0));
    };
    out.insert(out.end(), {word(e.x), word(e.y), word(e.x), word(e.y)});
}

Taken take(const Scene& scene, const glm::dvec3& forward, int width = 640, int height = 360) {
    Taken t;
    t.camera.forward = {glm::normalize(forward)};
    t.camera.right = {glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)))};
    t.camera.up = cross(t.camera.right, t.camera.forward);
    t.camera.widthPixels = width;
    t.camera.heightPixels = height;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = (2.0 * x + 1.0) / width - 1.0, v = 1.0 - (2.0 * y + 1.0) / height;
            const glm::dvec3 ray = t.camera.forward.xyz +
                                   u * t.camera.tanHalfWidth() * t.camera.right.xyz +
                                   v * t.camera.tanHalfHeight() * t.camera.up.xyz;
            const Scene::Hit hit = scene.meet(ray);
            t.depth.push_back(float(hit.distance));
            put(t.normals, std::isfinite(hit.distance) ? hit.normal : glm::dvec3(0, 0, 1));
        }
    return t;
}

const glm::dvec3 kSun = glm::normalize(glm::dvec3(-0.5, -0.6, 0.7));

Scene::Rect level(double x0, double y0, double x1, double y1, double z) {
    return {{x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0}};
}

// A floor 5 m below the eye, a wall across it, and two roofs before that.
Scene roofs() {
    Scene scene;
    scene.rects.push_back(level(-200, -10, 200, 80, -5));
    scene.rects.push_back({{-200, 80, -5}, {400, 0, 0}, {0, 0, 60}});
    scene.rects.push_back(level(-14, 15, -2, 40, -3));
    scene.rects.push_back(level(3, 15, 16, 45, -2));
    return scene;
}

} // namespace

TEST(SurfaceReader, ReadsWhatWasSeen) {
    // A ceiling, a floor and walls, so that normals point everywhere.
    Scene scene;
    scene.rects.push_back(level(-20, 1, 20, 60, -5));
    scene.rects.push_back(level(-20, 1, 20, 60, 7));
    scene.rects.push_back({{-9, 1, -5}, {3, 59, 0}, {2, 1, 12}});
    scene.rects.push_back({{9, 1, -5}, {3, 59, 0}, {2, -1, 12}});
    const Taken t = take(scene, {0, 1, 0.05}, 160, 90);
    const SurfaceReader read(t.seen());
    int seen = 0, downward = 0;
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 160; ++x) {
            if (read.sky(x, y))
                continue;
            const glm::dvec3 p = read.position(x, y);
            const Scene::Hit hit = scene.meet(p);
            EXPECT_NEAR(hit.distance, 1.0, 1e-6); // p itself is what the ray to it meets
            EXPECT_LT(glm::length(hit.normal - read.normal(x, y)), 1e-4);
            ++seen;
            downward += hit.normal.z < -0.1;
        }
    EXPECT_GT(seen, 10000);
    EXPECT_GT(downward, 1000);
}

TEST(PlaneFinder, FindsTheFloorFirstAndExactly) {
    const Taken t = take(roofs(), {0, 1, -0.25});
    const std::vector<FoundPlane> planes = findPlanes(t.seen(), kSun, 1);
    ASSERT_EQ(planes.size(), 1u);
    EXPECT_NEAR(planes[0].plane.normal.z, 1.0, 1e-7);
    EXPECT_NEAR(planes[0].plane.offsetMetres, 5.0, 1e-3);
    EXPECT_GT(planes[0].share, 0.3);
}

TEST(PlaneFinder, FindsTheWallAndRoofsAfterIt) {
    const Taken t = take(roofs(), {0, 1, -0.25});
    const std::vector<FoundPlane> planes = findPlanes(t.seen(), kSun, 8);
    ASSERT_EQ(planes.size(), 4u);
    std::vector<double> heights;
    int walls = 0;
    for (std::size_t i = 0; i < planes.size(); ++i) {
        if (i > 0) {
            EXPECT_LE(planes[i].share, planes[i - 1].share);
        }
        if (planes[i].plane.normal.z > 0.999)
            heights.push_back(-planes[i].plane.offsetMetres);
        else if (planes[i].plane.normal.y < -0.999) {
            ++walls;
            EXPECT_NEAR(planes[i].plane.offsetMetres, 80.0, 1e-2);
        }
    }
    EXPECT_EQ(walls, 1);
    std::sort(heights.begin(), heights.end());
    ASSERT_EQ(heights.size(), 3u);
    EXPECT_NEAR(heights[0], -5.0, 1e-3);
    EXPECT_NEAR(heights[1], -3.0, 1e-3);
    EXPECT_NEAR(heights[2], -2.0, 1e-3);
}

TEST(PlaneFinder, LeavesOutWhatTheSunDoesNotSee) {
    const Taken t = take(roofs(), {0, 1, -0.25});
    // From behind the wall, low: the wall's front is dark.
    for (const FoundPlane& f : findPlanes(t.seen(), glm::normalize(glm::dvec3(0, 1, 0.5)), 8))
        EXPECT_GT(f.plane.normal.z, 0.999);
    EXPECT_TRUE(findPlanes(t.seen(), glm::normalize(glm::dvec3(0, 1, -0.5)), 8).empty());
}

TEST(PlaneFinder, FindsTheSameInTheSamePicture) {
    const Taken t = take(roofs(), {0.2, 1, -0.25});
    const auto a = findPlanes(t.seen(), kSun, 4), b = findPlanes(t.seen(), kSun, 4);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].plane.normal, b[i].plane.normal);
        EXPECT_EQ(a[i].plane.offsetMetres, b[i].plane.offsetMetres);
    }
}

TEST(PlaneFinder, TakesTheRoundEarthForAPlaneAsFarAsItIsOne) {
    for (const double height : {5.0, 60.0, 400.0}) {
        Scene scene;
        scene.earthRadius = 6371000.0;
        scene.eyeHeight = height;
        const Taken t = take(scene, {0, 1, -0.3});
        const std::vector<FoundPlane> planes = findPlanes(t.seen(), kSun, 1);
        ASSERT_EQ(planes.size(), 1u);
        EXPECT_GT(planes[0].plane.normal.z, 0.9999);
        // From the foot of the picture to where the Earth sinks by half a pixel.
        EXPECT_GT(planes[0].share, 0.6) << height;
        EXPECT_NEAR(planes[0].plane.offsetMetres, height, 0.01 * height);
    }
}

TEST(PlaneFinder, TakesPlanesThatAreNearlyEqualForOne) {
    // Slabs of a pavement that are half a millimetre off each other.
    Scene scene;
    for (int i = 0; i < 40; ++i)
        scene.rects.push_back(level(-40, -10 + 2 * i, 40, -8 + 2 * i, -2 + 0.0005 * (i % 3)));
    const Taken t = take(scene, {0, 1, -0.25});
    EXPECT_EQ(findPlanes(t.seen(), kSun, 8).size(), 1u);
    // Every third slab stands out by more than the tolerance at that distance, but by less than
    // twice that.
    Scene rough;
    for (int i = 0; i < 40; ++i)
        rough.rects.push_back(
            level(-40, -10 + 0.5 * i, 40, -9.5 + 0.5 * i, i % 3 == 0 ? -1.994 : -2));
    EXPECT_EQ(findPlanes(take(rough, {0, 1, -0.25}).seen(), kSun, 8).size(), 1u);
    // Two levels that lie farther apart: two planes.
    Scene steps;
    steps.rects.push_back(level(-40, -10, 40, 8, -2));
    steps.rects.push_back(level(-40, 8, 40, 40, -1.85));
    EXPECT_EQ(findPlanes(take(steps, {0, 1, -0.25}).seen(), kSun, 8).size(), 2u);
}

TEST(PlaneFinder, FindsNothingInTheSkyAndNothingSmall) {
    Scene sky;
    EXPECT_TRUE(findPlanes(take(sky, {0, 1, 0.3}).seen(), kSun, 4).empty());
    Scene small;
    small.rects.push_back(level(-0.5, 20, 0.5, 21, -3));
    EXPECT_TRUE(findPlanes(take(small, {0, 1, -0.15}).seen(), kSun, 4).empty());
    EXPECT_TRUE(findPlanes(take(small, {0, 1, -0.15}, 1, 1).seen(), kSun, 4).empty());
}

// ------------------------------------------------------------------------------------------------
namespace {

PlaneMapsInput mapsInput(const Taken& t) {
    PlaneMapsInput in;
    in.seen = t.seen();
    in.camera = t.camera;
    in.towardsSun = kSun;
    in.reach = glm::dvec4(0, 0, -1.0 / kSun.z, 10.0 / kSun.z);
    in.rangeMetres = 1000.0;
    return in;
}

ShadowSettings planeSettings(int planes) {
    ShadowSettings s;
    s.method = ShadowMethod::PlaneOptimal;
    s.filter = ShadowFilter::None;
    s.planes = planes;
    return s;
}

} // namespace

TEST(PlaneMaps, AnswerForEveryPixelOfTheirPlanesAtThatPixel) {
    const Taken t = take(roofs(), {0, 1, -0.25});
    const std::vector<ProjectiveMap> maps = planeOptimalMaps(mapsInput(t), planeSettings(4));
    ASSERT_EQ(maps.size(), 4u);
    const SurfaceReader read(t.seen());
    std::size_t answered = 0;
    double worst = 0.0;
    for (int y = 0; y < t.camera.heightPixels; ++y)
        for (int x = 0; x < t.camera.widthPixels; ++x) {
            if (read.sky(x, y))
                continue;
            const glm::dvec3 p = read.position(x, y);
            for (const ProjectiveMap& map : maps)
                if (answersFor(map, p, read.normal(x, y))) {
                    ++answered;
                    const glm::dvec3 texel = texelOf(map, p);
                    // At a pixel's middle, but for what the point is off its plane.
                    worst = std::max({worst, std::abs(texel.x - std::floor(texel.x) - 0.5),
                                      std::abs(texel.y - std::floor(texel.y) - 0.5)});
                    const double depth = glm::dot(map.depth, glm::dvec4(p, 1.0));
                    EXPECT_GT(depth, 0.0);
                    // Up to the highest caster on its ray.
                    const double reach = std::max((10.0 - p.z) / kSun.z, 0.0);
                    EXPECT_LE((depth + reach) / texel.z * map.depthScale, 1.0);
                    break;
                }
        }
    EXPECT_GT(double(answered), 0.9 * double(t.seen().pixels()));
    EXPECT_LT(worst, 0.01);
    std::printf("[ measured ] %.1f %% of the picture, at most %.4f of a pixel off\n",
                100.0 * double(answered) / double(t.seen().pixels()), worst);
}

TEST(PlaneMaps, CoverNoMoreThanTheirPlanesAndTheFiltersMargin) {
    Scene scene;
    scene.rects.push_back(level(-3, 20, 3, 40, -5));
    const Taken t = take(scene, {0, 1, -0.2});
    const auto maps = planeOptimalMaps(mapsInput(t), planeSettings(1));
    ASSERT_EQ(maps.size(), 1u);
    int left = 1000, right = 0, top = 1000, bottom = 0;
    for (int y = 0; y < t.camera.heightPixels; ++y)
        for (int x = 0; x < t.camera.widthPixels; ++x)
            if (!SurfaceReader(t.seen()).sky(x, y)) {
                left = std::min(left, x), right = std::max(right, x);
                top = std::min(top, y), bottom = std::max(bottom, y);
            }
    EXPECT_EQ(maps[0].width, right - left + 1 + 2);
    EXPECT_EQ(maps[0].height, bottom - top + 1 + 2);
}

TEST(PlaneMaps, ForAnotherCameraCoverTheSameSurfaces) {
    const Taken t = take(roofs(), {0, 1, -0.25});
    PlaneMapsInput in = mapsInput(t);
    in.camera.position = {{0.2, -0.1, 0.3}};
    const auto maps = planeOptimalMaps(in, planeSettings(1));
    ASSERT_EQ(maps.size(), 1u);
    EXPECT_NEAR(maps[0].plane.offsetMetres, 5.3, 1e-3);
    const SurfaceReader read(t.seen());
    std::size_t floor = 0, answered = 0;
    for (int y = 0; y < t.camera.heightPixels; ++y)
        for (int x = 0; x < t.camera.widthPixels; ++x) {
            const glm::dvec3 p = read.sky(x, y) ? glm::dvec3(0.0) : read.position(x, y);
            if (std::abs(p.z + 5.0) < 1e-3) {
                ++floor;
                answered += answersFor(maps[0], p - in.camera.position.xyz, read.normal(x, y));
            }
        }
    EXPECT_GT(floor, 10000u);
    // All but a rim that the moved camera no longer has in its picture.
    EXPECT_GT(double(answered), 0.9 * double(floor));
}
