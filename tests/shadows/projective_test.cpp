// The matrices of maps that follow the eye's perspective.
#include "geo/ellipsoid.h"
#include "shadows/light_basis.h"
#include "shadows/projective.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

using namespace gnomon;

namespace {

const Geodetic kPlace{6.96, 50.94, 55.0};

// Looks from `eye` to `target`, in metres east, north and up of a place; the meshes lie along its
// axes.
struct View {
    Camera camera;
    glm::dmat3 meshAxes;
    glm::dvec3 eye;

    View(const glm::dvec3& from, const glm::dvec3& to, const Geodetic& place = kPlace) : eye(from) {
        const Transform<Ecef, Enu> ecefFromPlace = ecefFromEnu(place);
        meshAxes = ecefFromPlace.axes();
        const glm::dvec3 forward = glm::normalize(to - from);
        const glm::dvec3 right = std::abs(forward.z) > 0.999999
                                     ? glm::dvec3(1, 0, 0)
                                     : glm::normalize(glm::dvec3(forward.y, -forward.x, 0.0));
        camera.position = ecefFromPlace(Point<Enu>{from});
        camera.forward = ecefFromPlace(Vector<Enu>{forward});
        camera.right = ecefFromPlace(Vector<Enu>{right});
        camera.up = ecefFromPlace(Vector<Enu>{glm::cross(right, forward)});
        camera.widthPixels = 640;
        camera.heightPixels = 360;
    }
    // Camera-relative, along the meshes' axes.
    glm::dvec3 of(const glm::dvec3& place) const { return place - eye; }
    // Through the plane z = height, its normal on the eye's side.
    ReceiverPlane level(double height) const {
        ReceiverPlane plane;
        plane.normal = {0, 0, eye.z > height ? 1 : -1};
        plane.offsetMetres = std::abs(eye.z - height);
        plane.toleranceMetres = 0.02;
        return plane;
    }
    // GL's pixel coordinates of a camera-relative point, and view depth.
    glm::dvec3 pixel(const glm::dvec3& p) const {
        const CameraRows rows = cameraRows(camera, meshAxes);
        const glm::dvec4 h(p, 1.0);
        const double w = glm::dot(rows.w, h);
        return {(0.5 * glm::dot(rows.x, h) / w + 0.5) * camera.widthPixels,
                (0.5 * glm::dot(rows.y, h) / w + 0.5) * camera.heightPixels, w};
    }
    PixelRect whole() const { return {0, 0, camera.widthPixels, camera.heightPixels}; }
    std::optional<ProjectiveMap> map(const glm::dvec4& light, const ReceiverPlane& plane) const {
        return planeOptimalMap(camera, meshAxes, light, plane, whole());
    }
};

glm::dvec3 sunAt(double azimuthDegrees, double elevationDegrees) {
    const double a = azimuthDegrees * kRadiansPerDegree, e = elevationDegrees * kRadiansPerDegree;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

double at(const glm::dvec4& row, const glm::dvec3& p) {
    return glm::dot(row, glm::dvec4(p, 1.0));
}

// Points of z = 0 in front of the camera.
std::vector<glm::dvec3> floorPoints(const View& view) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> side(-60.0, 60.0);
    std::vector<glm::dvec3> points;
    while (points.size() < 200) {
        const glm::dvec3 p = view.of({side(random), side(random), 0.0});
        if (view.pixel(p).z > 1.0)
            points.push_back(p);
    }
    return points;
}

// Gaussian elimination with pivots: the x of A x = b.
std::vector<double> solve(std::vector<std::vector<double>> a, std::vector<double> b) {
    const std::size_t n = b.size();
    for (std::size_t c = 0; c < n; ++c) {
        std::size_t pivot = c;
        for (std::size_t r = c + 1; r < n; ++r)
            if (std::abs(a[r][c]) > std::abs(a[pivot][c]))
                pivot = r;
        std::swap(a[c], a[pivot]);
        std::swap(b[c], b[pivot]);
        for (std::size_t r = c + 1; r < n; ++r) {
            const double f = a[r][c] / a[c][c];
            for (std::size_t k = c; k < n; ++k)
                a[r][k] -= f * a[c][k];
            b[r] -= f * b[c];
        }
    }
    for (std::size_t c = n; c-- > 0;) {
        for (std::size_t k = c + 1; k < n; ++k)
            b[c] -= a[c][k] * b[k];
        b[c] /= a[c][c];
    }
    return b;
}

// The light's x, y and w rows as Chong and Gortler find them: four points of the plane are seen
// where the eye sees them, up to a factor each of which the first is 1, and the light nowhere.
// Unknowns are the twelve numbers and three factors.
std::array<glm::dvec4, 3> fromFivePoints(const View& view, const glm::dvec4& light,
                                         const std::array<glm::dvec3, 4>& onPlane) {
    std::vector<std::vector<double>> a(15, std::vector<double>(15, 0.0));
    std::vector<double> b(15, 0.0);
    const CameraRows eye = cameraRows(view.camera, view.meshAxes);
    const std::array<glm::dvec4, 3> rows{eye.x, eye.y, eye.w};
    std::size_t equation = 0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t r = 0; r < 3; ++r, ++equation) {
            for (int k = 0; k < 4; ++k)
                a[equation][4 * r + std::size_t(k)] = glm::dvec4(onPlane[i], 1.0)[k];
            if (i == 0)
                b[equation] = at(rows[r], onPlane[i]);
            else
                a[equation][11 + i] = -at(rows[r], onPlane[i]);
        }
    for (std::size_t r = 0; r < 3; ++r, ++equation)
        for (int k = 0; k < 4; ++k)
            a[equation][4 * r + std::size_t(k)] = light[k];
    const std::vector<double> x = solve(a, b);
    std::array<glm::dvec4, 3> out;
    for (std::size_t r = 0; r < 3; ++r)
        out[r] = {x[4 * r], x[4 * r + 1], x[4 * r + 2], x[4 * r + 3]};
    return out;
}

void expectSameUpToScale(const ProjectiveMap& map, const std::array<glm::dvec4, 3>& rows) {
    // The scale is what the largest number says.
    const std::array<glm::dvec4, 3> ours{map.x, map.y, map.w};
    double largest = 0.0, scale = 1.0;
    for (std::size_t r = 0; r < 3; ++r)
        for (int k = 0; k < 4; ++k)
            if (std::abs(ours[r][k]) > largest) {
                largest = std::abs(ours[r][k]);
                scale = rows[r][k] / ours[r][k];
            }
    for (std::size_t r = 0; r < 3; ++r)
        for (int k = 0; k < 4; ++k)
            EXPECT_NEAR(rows[r][k] / scale, ours[r][k], 1e-9 * largest) << r << " " << k;
}

const std::array<glm::dvec3, 4> kFloorQuad{
    glm::dvec3{-3, 2, 0}, {4, 3, 0}, {-7, 25, 0}, {9, 30, 0}};

std::array<glm::dvec3, 4> seenQuad(const View& view) {
    std::array<glm::dvec3, 4> out;
    for (std::size_t i = 0; i < 4; ++i)
        out[i] = view.of(kFloorQuad[i]);
    return out;
}

} // namespace

TEST(PlaneOptimalMap, PutsAPointOfThePlaneOnItsOwnPixel) {
    for (const glm::dvec3& eye :
         {glm::dvec3(0, -20, 5), {0, -20, 1.7}, {3, 2, 120}, {-9, 4, 2000}}) {
        const View view(eye, {1, 15, 0});
        for (const double elevation : {4.0, 30.0, 85.0})
            for (const double azimuth : {0.0, 70.0, 180.0, 290.0}) {
                const auto map =
                    view.map(glm::dvec4(sunAt(azimuth, elevation), 0), view.level(0.0));
                ASSERT_TRUE(map);
                for (const glm::dvec3& p : floorPoints(view)) {
                    const glm::dvec3 pixel = view.pixel(p), texel = texelOf(*map, p);
                    // Relative to how far off screen it may be.
                    EXPECT_NEAR(texel.x, pixel.x, 1e-9 * (1.0 + std::abs(pixel.x)));
                    EXPECT_NEAR(texel.y, pixel.y, 1e-9 * (1.0 + std::abs(pixel.y)));
                    EXPECT_NEAR(texel.z, pixel.z, 1e-9 * pixel.z);
                }
            }
    }
}

TEST(PlaneOptimalMap, PutsAllOfALightRayOnOneTexelWithOneWAndDepthInMetres) {
    const View view({0, -20, 5}, {1, 15, 0});
    for (const double elevation : {4.0, 30.0, 85.0}) {
        const glm::dvec3 sun = sunAt(205, elevation);
        const auto map = view.map(glm::dvec4(sun, 0), view.level(0.0));
        ASSERT_TRUE(map);
        for (const glm::dvec3& p : floorPoints(view))
            for (const double along : {-3.0, 0.5, 40.0, 3000.0}) {
                const glm::dvec3 on = texelOf(*map, p), off = texelOf(*map, p + along * sun);
                EXPECT_NEAR(off.x, on.x, 1e-8 * (1.0 + std::abs(on.x)));
                EXPECT_NEAR(off.y, on.y, 1e-8 * (1.0 + std::abs(on.y)));
                EXPECT_NEAR(off.z, on.z, 1e-8 * on.z);
                EXPECT_NEAR(at(map->depth, p + along * sun), along, 1e-9 * std::abs(along));
            }
    }
}

TEST(PlaneOptimalMap, HasWAboveZeroWhereTheShadowFallsInFrontOfTheEye) {
    const View view({0, -20, 5}, {1, 15, 0});
    for (const double azimuth : {0.0, 90.0, 180.0}) {
        const glm::dvec3 sun = sunAt(azimuth, 20);
        const auto map = view.map(glm::dvec4(sun, 0), view.level(0.0));
        ASSERT_TRUE(map);
        const glm::dvec3 inFront = view.of({0, 10, 0}), behind = view.of({0, -60, 0});
        EXPECT_GT(texelOf(*map, inFront).z, 0.0);
        EXPECT_LT(texelOf(*map, behind).z, 0.0);
        // Casters in front of the eye or behind it: only where their shadow falls counts.
        for (const double along : {1.0, 50.0, 500.0}) {
            EXPECT_GT(texelOf(*map, inFront + along * sun).z, 0.0) << azimuth << " " << along;
            EXPECT_LT(texelOf(*map, behind + along * sun).z, 0.0) << azimuth << " " << along;
        }
    }
}

TEST(PlaneOptimalMap, IsWhatFivePointsSayOfTheSun) {
    for (const glm::dvec3& eye : {glm::dvec3(0, -20, 5), {12, -40, 60}}) {
        const View view(eye, {1, 15, 0});
        for (const double elevation : {5.0, 30.0, 80.0}) {
            const glm::dvec4 light(sunAt(140, elevation), 0);
            const auto map = view.map(light, view.level(0.0));
            ASSERT_TRUE(map);
            expectSameUpToScale(*map, fromFivePoints(view, light, seenQuad(view)));
        }
    }
}

TEST(PlaneOptimalMap, IsWhatFivePointsSayOfALamp) {
    const View view({0, -20, 5}, {1, 15, 0});
    for (const glm::dvec3& lamp : {glm::dvec3(0, 10, 8), {-15, 3, 2}, {4, -70, 30}}) {
        const glm::dvec4 light(view.of(lamp), 1);
        const auto map = view.map(light, view.level(0.0));
        ASSERT_TRUE(map);
        expectSameUpToScale(*map, fromFivePoints(view, light, seenQuad(view)));
    }
}

TEST(PlaneOptimalMap, OfALampPutsAPointOfThePlaneOnItsOwnPixelAndNearerOnesInFront) {
    const View view({0, -20, 5}, {1, 15, 0});
    const glm::dvec3 lamp = view.of({2, 12, 9});
    const auto map = view.map(glm::dvec4(lamp, 1), view.level(0.0));
    ASSERT_TRUE(map);
    for (const glm::dvec3& p : floorPoints(view)) {
        const glm::dvec3 pixel = view.pixel(p), texel = texelOf(*map, p);
        EXPECT_NEAR(texel.x, pixel.x, 1e-9 * (1.0 + std::abs(pixel.x)));
        EXPECT_NEAR(texel.y, pixel.y, 1e-9 * (1.0 + std::abs(pixel.y)));
        double last = 0.0;
        for (const double s : {0.2, 0.5, 0.9}) { // of the way to the lamp
            const glm::dvec3 q = p + s * (lamp - p), seen = texelOf(*map, q);
            EXPECT_NEAR(seen.x, texel.x, 1e-8 * (1.0 + std::abs(texel.x)));
            EXPECT_NEAR(seen.y, texel.y, 1e-8 * (1.0 + std::abs(texel.y)));
            EXPECT_GT(seen.z, 0.0);
            EXPECT_GT(at(map->depth, q) / seen.z, last);
            last = at(map->depth, q) / seen.z;
        }
        // What hangs above the lamp is behind it.
        EXPECT_LT(texelOf(*map, p + 1.5 * (lamp - p)).z, 0.0);
    }
}

TEST(PlaneOptimalMap, OfALampAtTheEyeIsTheCamera) {
    const View view({0, -20, 5}, {1, 15, 0});
    const CameraRows eye = cameraRows(view.camera, view.meshAxes);
    const auto map = view.map(glm::dvec4(0, 0, 0, 1), view.level(0.0));
    ASSERT_TRUE(map);
    EXPECT_EQ(map->x, eye.x);
    EXPECT_EQ(map->y, eye.y);
    EXPECT_EQ(map->w, eye.w);
}

TEST(PlaneOptimalMap, IsNoneWhenThePlaneIsSeenOrLitEdgeOn) {
    const glm::dvec4 sun(sunAt(140, 30), 0);
    const View above({0, -20, 5}, {1, 15, 0});
    EXPECT_TRUE(above.map(sun, above.level(0.0)));
    EXPECT_FALSE(above.map(glm::dvec4(sunAt(140, 1.0), 0), above.level(0.0)));
    EXPECT_FALSE(above.map(glm::dvec4(sunAt(140, 0.0), 0), above.level(0.0)));
    EXPECT_FALSE(above.map(glm::dvec4(sunAt(140, -30.0), 0), above.level(0.0)));
    const View in({0, -20, 0}, {1, 15, 0});
    ReceiverPlane through = above.level(0.0);
    through.offsetMetres = 0.0;
    EXPECT_FALSE(in.map(sun, through));
    // From below the sun shines on the other side.
    const View below({0, -20, -5}, {1, 15, 0});
    EXPECT_FALSE(below.map(sun, below.level(0.0)));
    EXPECT_FALSE(planeOptimalMap(above.camera, above.meshAxes, sun, above.level(0.0), {}));
}

TEST(PlaneOptimalMap, OfPartOfThePictureHasTheSameTexels) {
    const View view({0, -20, 5}, {1, 15, 0});
    const glm::dvec4 sun(sunAt(140, 30), 0);
    const auto whole = view.map(sun, view.level(0.0));
    // Also one that reaches beyond the picture.
    for (const PixelRect& rect : {PixelRect{100, 37, 211, 90}, PixelRect{-13, -5, 700, 300}}) {
        const auto part = planeOptimalMap(view.camera, view.meshAxes, sun, view.level(0.0), rect);
        ASSERT_TRUE(part);
        EXPECT_EQ(part->width, rect.width);
        for (const glm::dvec3& p : floorPoints(view)) {
            const glm::dvec3 a = texelOf(*whole, p), b = texelOf(*part, p);
            EXPECT_NEAR(b.x + rect.x, a.x, 1e-9 * (1.0 + std::abs(a.x)));
            EXPECT_NEAR(b.y + rect.y, a.y, 1e-9 * (1.0 + std::abs(a.y)));
        }
    }
}

TEST(PlaneOptimalMap, CountedFromAnotherPlaceIsTheSame) {
    const View view({0, -20, 5}, {1, 15, 0});
    auto map = view.map(glm::dvec4(sunAt(140, 30), 0), view.level(0.0));
    setDepthRange(*map, 0.5, -0.3, 40.0);
    const glm::dvec3 shift(3, -8, 2.5);
    const ProjectiveMap moved = seenFrom(*map, shift);
    for (const glm::dvec3& p : floorPoints(view)) {
        const glm::dvec3 a = texelOf(*map, p), b = texelOf(moved, p - shift);
        EXPECT_NEAR(a.x, b.x, 1e-8 * (1.0 + std::abs(a.x)));
        EXPECT_NEAR(a.y, b.y, 1e-8 * (1.0 + std::abs(a.y)));
        EXPECT_NEAR(at(map->depth, p), at(moved.depth, p - shift), 1e-10);
        EXPECT_NEAR(map->plane.distance(p), moved.plane.distance(p - shift), 1e-10);
        EXPECT_NEAR(at(map->depth, p), 0.3, 1e-9); // the lowest lies that far below
    }
}

TEST(PlaneOptimalMap, AnswersForItsPlaneOnly) {
    const View view({0, -20, 5}, {1, 15, 0});
    auto map = view.map(glm::dvec4(sunAt(140, 30), 0), view.level(0.0));
    setDepthRange(*map, 1.0, -0.1, 40.0);
    const glm::dvec3 up(0, 0, 1);
    EXPECT_TRUE(answersFor(*map, view.of({0, 10, 0}), up));
    EXPECT_TRUE(answersFor(*map, view.of({0, 10, 0.019}), up));
    EXPECT_FALSE(answersFor(*map, view.of({0, 10, 0.021}), up));
    EXPECT_FALSE(answersFor(*map, view.of({0, 10, -0.021}), up));
    EXPECT_FALSE(answersFor(*map, view.of({0, 10, 0.0}), glm::dvec3(1, 0, 0)));
    EXPECT_FALSE(answersFor(*map, view.of({0, -60, 0}), up)); // behind the eye
    EXPECT_FALSE(answersFor(*map, view.of({90, 10, 0}), up)); // beside the picture
    map->plane.tolerancePerW = 0.001;
    EXPECT_TRUE(answersFor(*map, view.of({0, 10, 0.04}), up)); // w is about 30 m
}

TEST(PlaneOptimalMap, TexelsAreThePixelsSeenFromTheSun) {
    const View view({0, -20, 5}, {1, 15, 0});
    for (const double elevation : {10.0, 40.0, 80.0}) {
        const glm::dvec3 sun = sunAt(140, elevation);
        const auto map = view.map(glm::dvec4(sun, 0), view.level(0.0));
        const std::vector<glm::dvec3> points = floorPoints(view);
        for (std::size_t k = 0; k < points.size(); k += 10) {
            // A small step on the floor, over how many pixels it is: the largest in any direction,
            // measured across the sun's rays.
            const glm::dvec3 p = points[k];
            double widest = 0.0;
            for (int i = 0; i < 3600; ++i) {
                const double a = i * 0.05 * kRadiansPerDegree;
                const glm::dvec3 step = 1e-4 * glm::dvec3(std::cos(a), std::sin(a), 0.0);
                const glm::dvec3 moved = view.pixel(p + step) - view.pixel(p - step);
                const glm::dvec3 across = 2.0 * (step - glm::dot(step, sun) * sun);
                widest = std::max(widest, glm::length(across) / std::hypot(moved.x, moved.y));
            }
            const double told = texelMetres(*map, sun, p);
            EXPECT_NEAR(told, widest, 0.02 * widest);
        }
    }
}

TEST(PlaneOptimalMap, IsAsExactAnywhereOnTheEarth) {
    for (const Geodetic& place :
         {Geodetic{0, 0, 0}, {180, 0, 0}, {30, 90, 0}, {6.96, 50.94, 8848}}) {
        const View view({0, -20, 5}, {1, 15, 0}, place);
        const auto map = view.map(glm::dvec4(sunAt(205, 6), 0), view.level(0.0));
        ASSERT_TRUE(map);
        // A camera whose place has lost its last digits still has the same rows: all is relative.
        const View here({0, -20, 5}, {1, 15, 0});
        const auto same = here.map(glm::dvec4(sunAt(205, 6), 0), here.level(0.0));
        for (const glm::dvec3& p : floorPoints(here)) {
            const glm::dvec3 a = texelOf(*map, p), b = texelOf(*same, p);
            EXPECT_NEAR(a.x, b.x, 1e-9 * (1.0 + std::abs(b.x)));
            EXPECT_NEAR(a.y, b.y, 1e-9 * (1.0 + std::abs(b.y)));
        }
    }
}

// ------------------------------------------------------------------------------------------------
namespace {

PerspectiveInput perspective(const View& view, const glm::dvec3& sun, double topMetres) {
    PerspectiveInput in;
    in.camera = view.camera;
    in.meshAxes = view.meshAxes;
    in.towardsSun = sun;
    in.nearMetres = 2.0;
    in.farMetres = 300.0;
    // Metres along the ray to z = top.
    in.reach = glm::dvec4(0, 0, -1.0 / sun.z, (topMetres - view.eye.z) / sun.z);
    in.mapSize = 1024;
    return in;
}

// Points of the view between near and far.
std::vector<glm::dvec3> viewPoints(const PerspectiveInput& in) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> side(-1.0, 1.0), far(0.0, 1.0);
    const glm::dmat3 stored = glm::transpose(in.meshAxes);
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 300; ++i) {
        const double depth = in.nearMetres * std::pow(in.farMetres / in.nearMetres, far(random));
        points.push_back(depth *
                         (stored * (in.camera.forward.xyz +
                                    side(random) * in.camera.tanHalfWidth() * in.camera.right.xyz +
                                    side(random) * in.camera.tanHalfHeight() * in.camera.up.xyz)));
    }
    return points;
}

} // namespace

// The sun behind the eye, ahead, across, above, and just where the view is at right angles to it,
// where its place in post-perspective space passes through infinity.
class PerspectiveMapUnder : public testing::TestWithParam<glm::dvec3> {};

TEST_P(PerspectiveMapUnder, SeesAllTheViewAndKeepsRaysTogether) {
    const View view({0, -20, 15}, {1, 25, 0});
    const glm::dvec3 sun = GetParam();
    const PerspectiveInput in = perspective(view, sun, 30.0);
    const auto map = perspectiveMap(in);
    ASSERT_TRUE(map);
    for (const glm::dvec3& p : viewPoints(in)) {
        const glm::dvec3 texel = texelOf(*map, p);
        EXPECT_TRUE(answersFor(*map, p, {0, 0, 1}));
        EXPECT_GE(texel.z, 2.0 * map->minW * 0.999);
        const double depth = at(map->depth, p);
        EXPECT_GE(depth, 0.0);
        EXPECT_LE(depth / texel.z * map->depthScale, 1.0 + 1e-9);
        for (const double along : {5.0, 60.0, 900.0}) {
            const glm::dvec3 caster = texelOf(*map, p + along * sun);
            EXPECT_NEAR(caster.x, texel.x, 1e-5);
            EXPECT_NEAR(caster.y, texel.y, 1e-5);
            EXPECT_NEAR(caster.z, texel.z, 1e-8 * texel.z);
            EXPECT_NEAR(at(map->depth, p + along * sun) - depth, along, 1e-9 * along);
        }
    }
}

TEST_P(PerspectiveMapUnder, UsesTheWholeMap) {
    const View view({0, -20, 15}, {1, 25, 0});
    const PerspectiveInput in = perspective(view, GetParam(), 30.0);
    const auto map = perspectiveMap(in);
    ASSERT_TRUE(map);
    glm::dvec2 low(1e9), high(-1e9);
    const glm::dmat3 stored = glm::transpose(in.meshAxes);
    for (const double depth : {in.nearMetres, in.farMetres})
        for (const double u : {-1.0, 1.0})
            for (const double v : {-1.0, 1.0}) {
                const glm::dvec3 t = texelOf(
                    *map, depth * (stored * (in.camera.forward.xyz +
                                             u * in.camera.tanHalfWidth() * in.camera.right.xyz +
                                             v * in.camera.tanHalfHeight() * in.camera.up.xyz)));
                low = glm::min(low, glm::dvec2(t));
                high = glm::max(high, glm::dvec2(t));
            }
    for (int k = 0; k < 2; ++k) {
        EXPECT_NEAR(low[k], 2.0, 1e-6);
        EXPECT_NEAR(high[k], 1022.0, 1e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(Suns, PerspectiveMapUnder,
                         testing::Values(sunAt(180, 30), sunAt(1, 20), sunAt(90, 30), sunAt(90, 5),
                                         sunAt(0, 89.9), sunAt(270, 60),
                                         glm::normalize(glm::cross(glm::dvec3(1, 45, -15),
                                                                   glm::dvec3(-1, 0, 0.2)))));

TEST(PerspectiveMap, GivesWhatIsNearMoreTexelsWhenTheSunIsAcross) {
    const View view({0, -20, 15}, {1, 25, 0});
    const glm::dvec3 sun = sunAt(90, 60);
    const auto map = perspectiveMap(perspective(view, sun, 20.0));
    ASSERT_TRUE(map);
    const double near = texelMetres(*map, sun, view.of({0, 0, 0}));
    const double far = texelMetres(*map, sun, view.of({3, 200, 0}));
    EXPECT_LT(3.0 * near, far);
    std::printf("[ measured ] texels of %.3f m at 25 m, %.3f m at 220 m\n", near, far);
}

TEST(PerspectiveMap, LosesThatWhenTheSunIsBehindAndCastersStandHigh) {
    const View view({0, -20, 15}, {1, 25, 0});
    const glm::dvec3 across = sunAt(90, 60), behind = sunAt(180, 15);
    const auto easy = perspectiveMap(perspective(view, across, 20.0));
    const auto hard = perspectiveMap(perspective(view, behind, 80.0));
    ASSERT_TRUE(easy && hard);
    const glm::dvec3 near = view.of({0, 0, 0});
    EXPECT_GT(texelMetres(*hard, behind, near), 2.0 * texelMetres(*easy, across, near));
}
