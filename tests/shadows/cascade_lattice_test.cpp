// The lattice: cells that stay where they are, in double and through the GPU's float.
#include "tests/shadows/cascade_support.h"

#include <glm/common.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Camera eye(gnomon::testing::Random& random, const Place& place, double fov = 45.0) {
    return cameraAt(place,
                    {random.in(-5000, 5000), random.in(-5000, 5000), random.magnitude(1, 500)},
                    random.in(0, 360), random.in(-85, 5), fov);
}

// Farthest a number is from an integer.
double offInteger(double x) {
    return std::abs(x - std::round(x));
}

// The shader's float sum of products, in its order and without fused operations.
float dotFloat(const glm::vec3& a, const glm::vec3& b) {
    float sum = a.x * b.x;
    sum += a.y * b.y;
    sum += a.z * b.z;
    return sum;
}

struct Rows {
    glm::vec3 x, y; // light axes over the texel size, as CascadePass uploads them
};
Rows rowsOf(const CascadeSet& set, const Cascade& c) {
    const glm::dmat3 rows = glm::transpose(set.lightFromEcef.axes());
    return {glm::vec3(rows[0] / c.texelMetres), glm::vec3(rows[1] / c.texelMetres)};
}

} // namespace

TEST(Lattice, IndexIsAnIntegerAnywhereOnEarth) {
    gnomon::testing::Random random(21);
    double worst = 0.0;
    for (int i = 0; i < 20000; ++i) {
        const Place place({random.in(-180, 180), random.in(-90, 90), random.in(-100, 9000)});
        const SunPosition sun = sunFromAngles(random.in(0, 360), random.in(0, 90), place.anchor);
        Cascade c;
        c.texelMetres = ladderUp(random.magnitude(kMinTexelMetres, 100.0), 8);
        c.cornerX = std::int64_t(random.in(-2e4, 2e4) / c.texelMetres);
        c.cornerY = std::int64_t(random.in(-2e4, 2e4) / c.texelMetres);
        const Transform<Light, Ecef> light = lightFromEcef(place.ecefFromAnchor, sun.towards);
        // A cell's corner, put on the Earth and found again.
        const glm::dvec3 cell(double(c.cornerX + 700) * c.texelMetres,
                              double(c.cornerY + 1234) * c.texelMetres, random.in(-1000, 20000));
        const Point<Ecef> onEarth = rigidInverse(light)(Point<Light>{cell});
        const glm::dvec3 window = windowFromLight(c, light(onEarth).xyz);
        worst = std::max({worst, std::abs(window.x - 700), std::abs(window.y - 1234)});
        ASSERT_LE(offInteger(window.x), 1e-4);
        ASSERT_LE(offInteger(window.y), 1e-4);
    }
    EXPECT_LE(worst, 1e-4);
    RecordProperty("worstTexels", std::to_string(worst * 1e9) + "e-9");
}

TEST(Lattice, MovesByWholeCellsAndNoMoreThanTheCamera) {
    gnomon::testing::Random random(22);
    int stayed = 0, moved = 0;
    for (int i = 0; i < 200; ++i) {
        const Place place({random.in(-180, 180), random.in(-90, 90), random.in(-100, 5000)});
        const Camera first = eye(random, place);
        const double azimuth = random.in(0, 360), elevation = random.in(2, 90);
        const CascadeSet a = fit(place, first, azimuth, elevation, 4, 1000).set;
        for (int k = 0; k < 10; ++k) {
            Camera second = first;
            const double step = a.cascades[0].texelMetres * random.in(0.0, 1.0);
            second.position = first.position + step * Vector<Ecef>{random.direction()};
            const CascadeSet b = fit(place, second, azimuth, elevation, 4, 1000).set;
            for (std::size_t n = 0; n < a.cascades.size(); ++n) {
                ASSERT_EQ(a.cascades[n].texelMetres, b.cascades[n].texelMetres);
                const std::int64_t dx = b.cascades[n].cornerX - a.cascades[n].cornerX;
                const std::int64_t dy = b.cascades[n].cornerY - a.cascades[n].cornerY;
                ASSERT_LE(std::max(std::abs(dx), std::abs(dy)), 1);
                ++(dx == 0 && dy == 0 ? stayed : moved);
            }
        }
    }
    EXPECT_GT(stayed, 100);
    EXPECT_GT(moved, 100);
}

TEST(Lattice, TexelsStayWhenTheCameraTurns) {
    const Place place({6.96, 50.94, 55});
    const CascadeSet a = fit(place, cameraAt(place, {10, 20, 30}, 0, -20), 100, 35, 4, 1000).set;
    for (double heading = 0.0; heading < 360.0; heading += 0.37) {
        const CascadeSet b =
            fit(place, cameraAt(place, {10, 20, 30}, heading, -20), 100, 35, 4, 1000).set;
        for (std::size_t n = 0; n < a.cascades.size(); ++n)
            ASSERT_EQ(a.cascades[n].texelMetres, b.cascades[n].texelMetres);
    }
}

TEST(Lattice, PagesTileTheWindowExactlyAndKeepEachCellAtItsRemainder) {
    constexpr int m = 16, n = 8; // across, up
    for (std::int64_t x = -40; x <= 40; x += 3)
        for (std::int64_t y = -40; y <= 40; ++y) {
            Cascade c;
            c.cornerX = x;
            c.cornerY = y;
            const CascadePages pages = pagesOf(c, {m, n});
            std::vector<int> covered(std::size_t(m * n), 0);
            for (int p = 0; p < pages.count; ++p) {
                const CascadePage& page = pages.pages[std::size_t(p)];
                ASSERT_EQ(page.originX % m, 0);
                ASSERT_EQ(page.originY % n, 0);
                for (int ty = page.y; ty < page.y + page.height; ++ty)
                    for (int tx = page.x; tx < page.x + page.width; ++tx) {
                        ++covered[std::size_t(ty * m + tx)];
                        const std::int64_t cellX = page.originX + tx, cellY = page.originY + ty;
                        ASSERT_TRUE(cellX >= x && cellX < x + m && cellY >= y && cellY < y + n);
                        ASSERT_EQ(((cellX % m) + m) % m, tx);
                        ASSERT_EQ(((cellY % n) + n) % n, ty);
                    }
            }
            for (const int times : covered)
                ASSERT_EQ(times, 1) << x << " " << y;
        }
}

TEST(Lattice, SurvivesTheDepthPassInFloat) {
    gnomon::testing::Random random(23);
    double worst = 0.0, worstNaive = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const Place place({random.in(-180, 180), random.in(-90, 90), random.in(-100, 5000)});
        const Fitted fitted =
            fit(place, eye(random, place), random.in(0, 360), random.in(1, 90), 2, 2000);
        const int size = fitted.set.mapSize.x;
        const double bound = size * std::exp2(-22);
        for (const Cascade& c : fitted.set.cascades) {
            const Rows rows = rowsOf(fitted.set, c);
            const CascadePages pages = pagesOf(c, fitted.set.mapSize);
            // A cell of the window, and a mesh around it that is no larger than the window.
            const double reach = std::min(0.25 * size * c.texelMetres, 128.0);
            for (int p = 0; p < pages.count; ++p) {
                const CascadePage& page = pages.pages[std::size_t(p)];
                const glm::dvec3 light(
                    (double(page.originX) + page.x + random.in(0, page.width)) * c.texelMetres,
                    (double(page.originY) + page.y + random.in(0, page.height)) * c.texelMetres,
                    random.in(-100, 100));
                const Point<Ecef> vertex =
                    rigidInverse(fitted.set.lightFromEcef)(Point<Light>{light});
                const Point<Ecef> origin = vertex + reach * Vector<Ecef>{random.direction()};
                const glm::vec3 position = relativeTo(origin, vertex);
                const glm::vec3 offset(
                    pageFromLight(c, page, fitted.set.lightFromEcef(origin).xyz));
                const glm::dvec3 exact = pageFromLight(c, page, light);
                const double errorX = std::abs(dotFloat(rows.x, position) + offset.x - exact.x);
                const double errorY = std::abs(dotFloat(rows.y, position) + offset.y - exact.y);
                worst = std::max({worst, errorX, errorY});
                ASSERT_LE(std::max(errorX, errorY), bound) << c.texelMetres;
                // What absolute coordinates in float would give instead.
                const float naive = dotFloat(rows.x, glm::vec3(vertex.xyz)) -
                                    dotFloat(rows.x, glm::vec3(place.ecefFromAnchor.origin().xyz)) -
                                    float(page.originX);
                worstNaive = std::max(worstNaive, std::abs(double(naive) - exact.x));
            }
        }
    }
    EXPECT_GT(worstNaive, 0.5); // the test can tell
    RecordProperty("worstTexels", std::to_string(worst));
}

TEST(Lattice, SurvivesTheReceiversLookUpInFloat) {
    gnomon::testing::Random random(24);
    double worst = 0.0;
    for (int i = 0; i < 2000; ++i) {
        const Place place({random.in(-180, 180), random.in(-90, 90), random.in(-100, 5000)});
        const Camera camera = eye(random, place, random.in(30, 70));
        const Fitted fitted = fit(place, camera, random.in(0, 360), random.in(1, 90), 2, 2000);
        const glm::dmat3 axes = glm::transpose(fitted.set.lightFromEcef.axes());
        const glm::vec3 axisX(axes[0]), axisY(axes[1]);
        const int size = fitted.set.mapSize.x;
        for (const Cascade& c : fitted.set.cascades) {
            // sun.frag: camera-relative metres along the light's axes, over the texel, plus the
            // camera's own lattice place.
            const glm::dvec3 eyeLattice =
                windowFromLight(c, fitted.set.lightFromEcef(camera.position).xyz);
            const glm::vec2 offset(float(eyeLattice.x), float(eyeLattice.y));
            for (int s = 0; s < 10; ++s) {
                const double depth = random.in(std::max(2.0, c.nearMetres), c.farMetres);
                const Point<Ecef> seen =
                    inFrustum(camera, depth, random.in(-1, 1), random.in(-1, 1));
                const glm::vec3 position = relativeTo(camera.position, seen);
                const Point<Ecef> surface{camera.position.xyz + glm::dvec3(position)};
                const glm::dvec3 exact = windowFromLight(c, fitted.set.lightFromEcef(surface).xyz);
                const float texel = float(c.texelMetres);
                const double ex = std::abs(dotFloat(axisX, position) / texel + offset.x - exact.x);
                const double ey = std::abs(dotFloat(axisY, position) / texel + offset.y - exact.y);
                worst = std::max({worst, ex, ey});
                ASSERT_LE(std::max(ex, ey), size * std::exp2(-22));
            }
        }
    }
    RecordProperty("worstTexels", std::to_string(worst));
}
