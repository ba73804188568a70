// Fit: what each cascade must cover, and that nothing a user does with the camera breaks it.
#include "tests/shadows/cascade_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// Smallest radius about a centre on the axis, by ternary search of the convex maximum distance.
double bruteForceRadius(double n, double f, double k) {
    const auto radiusAt = [&](double c) {
        return std::max(std::hypot(c - n, n * k), std::hypot(c - f, f * k));
    };
    double low = n - f, high = f * (2.0 + k * k);
    for (int i = 0; i < 300; ++i) {
        const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
        (radiusAt(a) < radiusAt(b) ? high : low) = radiusAt(a) < radiusAt(b) ? b : a;
    }
    return radiusAt(0.5 * (low + high));
}

Camera randomCamera(gnomon::testing::Random& random, const Place& place) {
    Camera camera = cameraAt(
        place, {random.in(-2000, 2000), random.in(-2000, 2000), random.magnitude(0.5, 3000)},
        random.in(0, 360), random.in(-89.9, 30), random.in(5, 100));
    camera.widthPixels = int(random.in(200, 2000));
    camera.heightPixels = int(random.in(200, 2000));
    return camera;
}

Place randomPlace(gnomon::testing::Random& random) {
    return Place({random.in(-180, 180), random.in(-90, 90), random.in(-50, 5000)});
}

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void expectSound(const CascadeSet& set) {
    for (const Cascade& c : set.cascades) {
        for (const double value : {c.nearMetres, c.farMetres, c.blendStartMetres, c.texelMetres,
                                   c.farPlaneMetres, c.depthRangeMetres})
            ASSERT_TRUE(std::isfinite(value));
        ASSERT_GE(c.texelMetres, kMinTexelMetres);
        ASSERT_GT(c.depthRangeMetres, 0.0);
        ASSERT_LT(c.nearMetres, c.farMetres);
        const CascadePages pages = pagesOf(c, set.mapSize);
        ASSERT_GE(pages.count, 1);
        ASSERT_LE(pages.count, 4);
        const View view = casterView(set, c);
        ASSERT_TRUE(finite(view.eye.xyz));
        for (const Plane& plane : view.planes) {
            ASSERT_TRUE(finite(plane.point.xyz));
            ASSERT_NEAR(length(plane.normal), 1.0, 1e-12);
        }
        for (int p = 0; p < pages.count; ++p) {
            const glm::dvec3 offset =
                pageFromLight(c, pages.pages[std::size_t(p)], glm::dvec3(0.0));
            ASSERT_TRUE(finite(offset));
        }
    }
}

} // namespace

TEST(SliceSphere, ContainsAllCornersAndIsTheSmallestThatDoes) {
    gnomon::testing::Random random(11);
    for (int i = 0; i < 20000; ++i) {
        const double far = random.magnitude(1.0, 2e7), near = far * random.magnitude(1e-6, 0.999);
        const double w = random.magnitude(1e-3, 20.0), h = random.magnitude(1e-3, 20.0);
        const SliceSphere sphere = minimalSliceSphere(near, far, w, h);
        for (const double d : {near, far})
            for (const double u : {-1.0, 1.0})
                for (const double v : {-1.0, 1.0})
                    ASSERT_LE(
                        glm::length(glm::dvec3(u * w * d, v * h * d, d - sphere.centreDepthMetres)),
                        sphere.radiusMetres * (1.0 + 1e-12));
        const double smallest = bruteForceRadius(near, far, std::hypot(w, h));
        ASSERT_NEAR(sphere.radiusMetres / smallest, 1.0, 1e-9) << near << " " << far << " " << w;
    }
}

TEST(Ladder, GivesTheNearestRungAndKeepsWhatStandsOnOne) {
    gnomon::testing::Random random(12);
    for (int i = 0; i < 20000; ++i) {
        const double value = random.magnitude(1e-3, 1e9);
        for (const int steps : {1, 2, 8}) {
            const double up = ladderUp(value, steps), down = ladderDown(value, steps);
            ASSERT_GE(up, value * (1 - 1e-9));
            ASSERT_LE(up, value * std::exp2(1.0 / steps) * (1 + 1e-9));
            ASSERT_LE(down, value * (1 + 1e-9));
            ASSERT_GE(down, value * std::exp2(-1.0 / steps) * (1 - 1e-9));
            ASSERT_EQ(ladderUp(up, steps), up);
            ASSERT_EQ(ladderDown(up, steps), up);
        }
    }
}

TEST(Cascades, CoverDepthsFromTheEyeToTheEndInOrder) {
    const Place place({6.96, 50.94, 55});
    const Camera camera = cameraAt(place, {0, 0, 50}, 30, -20);
    for (int count = 1; count <= kMaxCascades; ++count) {
        ShadowSettings settings;
        settings.cascades = count;
        const CascadeSet set = fit(place, camera, 120, 40, 5, 2000, settings).set;
        ASSERT_EQ(set.cascades.size(), std::size_t(count));
        EXPECT_EQ(set.cascades.front().nearMetres, 0.0);
        EXPECT_EQ(set.cascades.back().farMetres, 2000.0);
        for (std::size_t i = 0; i < set.cascades.size(); ++i) {
            const Cascade& c = set.cascades[i];
            if (i > 0) {
                EXPECT_EQ(c.nearMetres, set.cascades[i - 1].farMetres);
                EXPECT_GE(c.texelMetres, set.cascades[i - 1].texelMetres);
            }
            EXPECT_GT(c.blendStartMetres, c.nearMetres);
            EXPECT_LT(c.blendStartMetres, c.farMetres);
        }
    }
    ShadowSettings single;
    single.method = ShadowMethod::Single;
    EXPECT_EQ(fit(place, camera, 120, 40, 5, 2000, single).set.cascades.size(), 1u);
}

TEST(Cascades, HoldTheirSliceAndTheBlendBeforeItWithRoomForTheFilter) {
    gnomon::testing::Random random(13);
    for (int i = 0; i < 300; ++i) {
        const Place place = randomPlace(random);
        const Camera camera = randomCamera(random, place);
        const double near = random.magnitude(1, 100), far = near * random.magnitude(1.05, 1000);
        const CascadeSet set =
            fit(place, camera, random.in(0, 360), random.in(0.5, 90), near, far).set;
        for (std::size_t k = 0; k < set.cascades.size(); ++k) {
            const Cascade& c = set.cascades[k];
            const double from = k == 0 ? near : set.cascades[k - 1].blendStartMetres;
            for (int s = 0; s < 60; ++s) {
                const double u = s < 8 ? (s & 1 ? 1 : -1) : random.in(-1, 1);
                const double v = s < 8 ? (s & 2 ? 1 : -1) : random.in(-1, 1);
                const double d =
                    s < 8 ? (s & 4 ? from : c.farMetres) : random.in(from, c.farMetres);
                const glm::dvec3 p =
                    windowFromLight(c, set.lightFromEcef(inFrustum(camera, d, u, v)).xyz);
                // A cell is lost to the snap.
                ASSERT_GE(std::min(p.x, p.y), kBorderTexels - 1 - 1e-3) << "cascade " << k;
                ASSERT_LE(std::max(p.x, p.y), set.mapSize.x - kBorderTexels + 1 + 1e-3);
                ASSERT_GE(p.z, 0.0);
                ASSERT_LE(p.z, c.depthRangeMetres);
            }
        }
    }
}

TEST(Cascades, SpendNoMoreTexelsThanTheLadderAndTheBorderCost) {
    gnomon::testing::Random random(14);
    for (int i = 0; i < 300; ++i) {
        const Place place = randomPlace(random);
        const Camera camera = randomCamera(random, place);
        const CascadeSet set = fit(place, camera, 100, 40, 10, 1000).set;
        const Cascade& last = set.cascades.back();
        const SliceSphere sphere =
            minimalSliceSphere(set.cascades[2].blendStartMetres, last.farMetres,
                               camera.tanHalfWidth(), camera.tanHalfHeight());
        const double needed = 2.0 * sphere.radiusMetres / (set.mapSize.x - 2 * kBorderTexels);
        EXPECT_LE(last.texelMetres, needed * std::exp2(1.0 / 8.0) * (1 + 1e-9));
        EXPECT_GE(last.texelMetres, needed * (1 - 1e-9));
    }
}

TEST(Cascades, SeeEveryCasterThatCanShadeAPointOfTheirSlice) {
    gnomon::testing::Random random(15);
    for (int i = 0; i < 300; ++i) {
        const Place place = randomPlace(random);
        const Camera camera = randomCamera(random, place);
        const double azimuth = random.in(0, 360), elevation = random.in(0.2, 90);
        const double top = 3500.0;
        const Fitted fitted = fit(place, camera, azimuth, elevation, 5, 3000, {}, top);
        const Vector<Ecef> sun = sunFromAngles(azimuth, elevation, place.anchor).towards;
        const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(place.ecefFromAnchor);
        for (const Cascade& c : fitted.set.cascades) {
            const View view = casterView(fitted.set, c);
            const CascadePages pages = pagesOf(c, fitted.set.mapSize);
            for (int s = 0; s < 30; ++s) {
                const double d = random.in(std::max(5.0, c.nearMetres), c.farMetres);
                const Point<Ecef> receiver =
                    inFrustum(camera, d, random.in(-1, 1), random.in(-1, 1));
                const Point<Ecef> blocker = receiver + random.magnitude(1e-3, 1e5) * sun;
                // Touched by a corner only.
                OrientedBox box;
                const double half = random.magnitude(0.01, 500);
                box.halfAxes = glm::dmat3(half);
                box.centre = blocker + half * (1 - 1e-9) *
                                           Vector<Ecef>{{random.in(0, 1) < 0.5 ? -1.0 : 1.0,
                                                         random.in(0, 1) < 0.5 ? -1.0 : 1.0,
                                                         random.in(0, 1) < 0.5 ? -1.0 : 1.0}};
                ASSERT_NE(classify(BoundingVolume(box), view.planes), Containment::Outside);
                const LightBox light = lightBox(fitted.set.lightFromEcef, box);
                bool touched = false;
                for (int p = 0; p < pages.count; ++p)
                    touched = touched || touches(c, pages.pages[std::size_t(p)], light);
                ASSERT_TRUE(touched);
                // Below the highest caster its depth is kept as it is, not clamped.
                if (anchorFromEcef(blocker).xyz.z <= top) {
                    ASSERT_LE(windowFromLight(c, fitted.set.lightFromEcef(blocker).xyz).z,
                              c.depthRangeMetres);
                }
            }
        }
    }
}

TEST(Cascades, KeepTheDepthOfEveryCasterWhenTheSunStandsOnTheHorizon) {
    const Place place({6.96, 50.94, 55});
    const Camera camera = cameraAt(place, {0, 0, 20}, 30, -5);
    // Elevations at the anchor; below 0 an eye high up may still see the sun.
    for (const double elevation : {-0.3, 0.0, 1e-9, 0.01}) {
        Fitted fitted = fit(place, camera, 210, elevation, 5, 1000);
        fitted.bound.lightMaxMetres = 8000.0;
        for (Cascade& c : fitted.set.cascades) {
            setDepthRange(c, fitted.set.mapSize, fitted.bound);
            EXPECT_GE(c.farPlaneMetres + c.depthRangeMetres, 8000.0) << elevation;
            EXPECT_LE(c.depthRangeMetres, 1.5 * (8000.0 - c.farPlaneMetres)) << elevation;
        }
    }
}

TEST(Cascades, AreTheSameInTheAnchorsFrameEverywhereOnEarth) {
    gnomon::testing::Random random(16);
    const std::vector<Place> places = placesToCompare();
    for (int i = 0; i < 200; ++i) {
        const glm::dvec3 eye(random.in(-500, 500), random.in(-500, 500), random.in(1, 300));
        const double heading = random.in(0, 360), pitch = random.in(-80, 10);
        const double azimuth = random.in(0, 360), elevation = random.in(1, 90);
        const CascadeSet first =
            fit(places[0], cameraAt(places[0], eye, heading, pitch), azimuth, elevation, 4, 2000)
                .set;
        for (const Place& place : places) {
            const Fitted fitted =
                fit(place, cameraAt(place, eye, heading, pitch), azimuth, elevation, 4, 2000);
            for (std::size_t k = 0; k < first.cascades.size(); ++k) {
                const Cascade &a = first.cascades[k], &b = fitted.set.cascades[k];
                EXPECT_EQ(a.nearMetres, b.nearMetres);
                EXPECT_EQ(a.farMetres, b.farMetres);
                ASSERT_NEAR(a.texelMetres / b.texelMetres, 1.0, 1e-9);
                ASSERT_NEAR(a.farPlaneMetres, b.farPlaneMetres, 1e-9 * a.depthRangeMetres);
                ASSERT_NEAR(a.depthRangeMetres / b.depthRangeMetres, 1.0, 1e-9);
                // A fixed seed: none of these stands within 1e-6 of a cell's edge.
                ASSERT_EQ(a.cornerX, b.cornerX) << i;
                ASSERT_EQ(a.cornerY, b.cornerY) << i;
            }
        }
    }
}

TEST(Cascades, AreSoundForDegenerateCameras) {
    const Place place({6.96, 50.94, 55});
    for (const double fov :
         {-1.0, 0.0, 1e-12, 1e-3, 179.9, 180.0, 1e9, double(NAN), double(INFINITY)})
        for (const auto& [w, h] : {std::pair(0, 0), std::pair(1, 1), std::pair(0, 900),
                                   std::pair(4000, 1), std::pair(1, 4000), std::pair(-5, -5)})
            for (const double height : {30.0, -500.0, -6356752.3, 2e7})
                for (const auto& [near, far] :
                     {std::pair(1.0, 1.01), std::pair(1.0, 2e7), std::pair(1e6, 2e6)}) {
                    Camera camera = cameraAt(place, {0, 0, height}, 10, -90);
                    camera.verticalFovRadians = fov * kRadiansPerDegree;
                    camera.widthPixels = w;
                    camera.heightPixels = h;
                    expectSound(fit(place, camera, 120, 30, near, far).set);
                    expectSound(fit(place, camera, 120, 90, near, far).set);
                    expectSound(fit(place, camera, 120, 0, near, far).set);
                    if (HasFatalFailure())
                        FAIL() << fov << " " << w << "x" << h << " " << height;
                }
    Camera centre = cameraAt(place, {0, 0, 0}, 10, -20);
    centre.position = {};
    expectSound(fit(place, centre, 120, 30, 1, 1000).set);
}

TEST(Cascades, AreSoundWhenTheSunIsBehindBeforeOrAboveTheEye) {
    const Place place({6.96, 50.94, 55});
    for (const double pitch : {-90.0, -45.0, 0.0, 45.0, 90.0}) {
        const Camera camera = cameraAt(place, {0, 0, 50}, 40, pitch);
        for (const double elevation : {0.0, 45.0, 90.0})
            for (const double azimuth : {40.0, 220.0}) {
                const CascadeSet set = fit(place, camera, azimuth, elevation, 2, 1000).set;
                expectSound(set);
            }
    }
}
