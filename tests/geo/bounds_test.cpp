#include "geo/bounds.h"

#include "random_places.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

using namespace gnomon;
using gnomon::testing::edgy;
using gnomon::testing::pointIn;
using gnomon::testing::Random;
using gnomon::testing::widthDegrees;

namespace {

// Rounding of Earth-sized numbers, in the volumes and in the points they are tested with.
constexpr double kRounding = 1e-8;

// Small and large ones, at the poles, across the antimeridian, around the globe.
Region randomRegion(Random& random, int kind) {
    const double low = random.in(-500, 500), high = low + random.magnitude(0.1, 1e4);
    const double lon = random.in(-180, 180);
    const double size = random.magnitude(1e-5, 1.0);
    switch (kind % 7) {
    case 0: {
        const double lat = random.in(-89, 88);
        return makeRegion(lon, lat, lon + size, lat + random.in(0.1, 1) * size, low, high);
    }
    case 1: { // large
        const double south = random.in(-90, 60);
        const double east = std::remainder(lon + random.in(1, 350), 360);
        return makeRegion(lon, south, east, random.in(south, 90), low, high);
    }
    case 2: // cap
        return makeRegion(-180, 90 - random.magnitude(1e-4, 60), 180, 90, low, high);
    case 3: // wedge at the south pole
        return makeRegion(lon, -90, lon + random.in(0.1, 200), -90 + random.magnitude(1e-3, 80),
                          low, high);
    case 4: { // across the antimeridian
        const double lat = random.in(-89, 88);
        return makeRegion(180 - size, lat, -180 + size, lat + size, low, high);
    }
    case 5: // the globe, or a zone of it
        return makeRegion(-180, -random.in(0, 90), 180, random.in(0, 90), low, high);
    default: { // thin shapes
        const double lat = random.in(-89, 89);
        return random.in(0, 1) < 0.5 ? makeRegion(lon, lat, lon, lat + 1, low, high)
                                     : makeRegion(lon, lat, lon + 30, lat, low, low);
    }
    }
}

OrientedBox randomBox(Random& random, double size, bool slanted) {
    OrientedBox box;
    box.centre = ecefOf({random.in(-180, 180), random.in(-90, 90), random.in(-100, 1e4)});
    const glm::dvec3 a = random.direction();
    const glm::dvec3 b = glm::normalize(glm::cross(a, random.direction()));
    const glm::dvec3 c = glm::cross(a, b);
    const auto length = [&] { return size * random.magnitude(0.01, 1.0); };
    box.halfAxes = slanted
                       ? glm::dmat3(length() * random.direction(), length() * random.direction(),
                                    length() * random.direction())
                       : glm::dmat3(length() * a, length() * b, length() * c);
    return box;
}

Point<Ecef> pointInBox(const OrientedBox& box, Random& random) {
    const double u = edgy(random), v = edgy(random), w = edgy(random);
    return box.centre + Vector<Ecef>{box.halfAxes * (2.0 * glm::dvec3(u, v, w) - 1.0)};
}

Point<Ecef> pointInSphere(const Sphere& sphere, Random& random) {
    return sphere.centre + Vector<Ecef>{sphere.radiusMetres * edgy(random) * random.direction()};
}

// Where an eye might be, from the ground to far out, and sometimes under it.
Point<Ecef> randomEye(Random& random, Point<Ecef> near) {
    if (random.in(0, 1) < 0.6)
        return near + Vector<Ecef>{random.magnitude(0.01, 1e7) * random.direction()};
    return ecefOf({random.in(-180, 180), random.in(-90, 90),
                   random.in(0, 1) < 0.1 ? -random.magnitude(1, 6.3e6) : random.magnitude(1, 2e7)});
}

Region shownBy(const BoundingVolume& volume) {
    const std::optional<Region> extent = geographicExtent(volume);
    EXPECT_TRUE(extent);
    return extent ? *extent : Region{};
}

bool containsPlace(const Region& r, const Geodetic& g) {
    double east = std::fmod(g.longitudeDegrees - r.westDegrees, 360.0);
    if (east < 0)
        east += 360.0;
    const bool longitudeFits = east <= widthDegrees(r) || std::abs(g.latitudeDegrees) == 90.0;
    return longitudeFits && g.latitudeDegrees >= r.southDegrees &&
           g.latitudeDegrees <= r.northDegrees && g.heightMetres >= r.minHeightMetres &&
           g.heightMetres <= r.maxHeightMetres;
}

} // namespace

TEST(Bounds, ARegionsBoxContainsEveryPointOfIt) {
    Random random(30);
    for (int kind = 0; kind < 210; ++kind) {
        const Region region = randomRegion(random, kind);
        for (int i = 0; i < 500; ++i) {
            const Point<Ecef> p = pointIn(region, random);
            ASSERT_EQ(distanceTo(region.box, p), 0.0) << "kind " << kind % 7;
            ASSERT_LE(distanceTo(region, p), kRounding) << "kind " << kind % 7;
        }
    }
}

TEST(Bounds, ASmallRegionsBoxIsAsSmallAsItsSides) {
    const Region r = makeRegion(7.0, 51.0, 7.01, 51.01, 40.0, 90.0);
    // 0.01° are 702.0 m (at the southern side) by 1112.5 m; the ground bends by 3.4 cm below the
    // tangent at the middle.
    EXPECT_NEAR(2 * glm::length(r.box.halfAxes[0]), 702.0, 0.1);
    EXPECT_NEAR(2 * glm::length(r.box.halfAxes[1]), 1112.5, 0.5);
    EXPECT_NEAR(2 * glm::length(r.box.halfAxes[2]), 50.034, 0.002);
}

TEST(Bounds, ALargeRegionsBoxLiesAlongTheEarthsAxisWhereThatIsSmaller) {
    const Region globe = makeRegion(-180, -90, 180, 90, 0, 0);
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(glm::length(globe.box.halfAxes[i]),
                    i == 1 ? kPolarRadiusMetres : kEquatorialRadiusMetres, 22000.0);
    EXPECT_LE(glm::length(globe.box.centre.xyz), 1.0);
    // A cap's box is flat: it lies across the axis.
    const Region cap = makeRegion(-180, 70, 180, 90, 0, 0);
    double flattest = 1e9;
    for (int i = 0; i < 3; ++i)
        flattest = std::min(flattest, glm::length(cap.box.halfAxes[i]));
    EXPECT_LT(flattest, 200e3);
}

TEST(Bounds, DistanceToARegionNeverExceedsTheTrueOne) {
    Random random(31);
    for (int kind = 0; kind < 140; ++kind) {
        const Region region = randomRegion(random, kind);
        std::vector<Point<Ecef>> points;
        for (int i = 0; i < 700; ++i)
            points.push_back(pointIn(region, random));
        for (int e = 0; e < 60; ++e) {
            const Point<Ecef> eye = randomEye(random, points[e]);
            double nearest = std::numeric_limits<double>::infinity();
            for (const Point<Ecef>& p : points)
                nearest = std::min(nearest, length(p - eye));
            ASSERT_LE(distanceTo(region, eye), nearest * (1 + 1e-14) + kRounding)
                << "kind " << kind % 7;
        }
    }
}

TEST(Bounds, DistanceToARegionIsTheDistanceToItsNearestPoint) {
    Random random(32);
    for (int n = 0; n < 30; ++n) {
        const double lon = random.in(-180, 180), lat = random.in(-80, 75);
        const Region r = makeRegion(lon, lat, lon + 5, lat + 5, 0, 1000);
        for (int e = 0; e < 10; ++e) {
            // Above the ground, to all sides and overhead.
            const Point<Ecef> eye =
                ecefOf({lon + random.in(-10, 15), std::clamp(lat + random.in(-10, 15), -90.0, 90.0),
                        random.magnitude(2e4, 3e6)});
            double nearest = std::numeric_limits<double>::infinity();
            constexpr int kSteps = 100;
            for (int i = 0; i <= kSteps; ++i)
                for (int j = 0; j <= kSteps; ++j)
                    nearest = std::min(
                        nearest,
                        length(pointIn(r, double(i) / kSteps, double(j) / kSteps, 1) - eye));
            ASSERT_GE(distanceTo(r, eye), 0.985 * nearest);
        }
    }
}

TEST(Bounds, DistanceStraightUpFromARegionIsTheHeightAboveIt) {
    const Region r = makeRegion(179, -1, -179, 1, -20, 300);
    EXPECT_NEAR(distanceTo(r, ecefOf({180, 0.3, 1300})), 1000.0, 1e-6);
    EXPECT_NEAR(distanceTo(r, ecefOf({-179.5, -0.3, -120})), 100.0, 1e-6);
    EXPECT_NEAR(distanceTo(r, ecefOf({-179.5, -0.3, -50020})), 50000.0, 1e-3);
    EXPECT_EQ(distanceTo(r, ecefOf({-179.5, 0.9, 100})), 0.0);
    EXPECT_GT(distanceTo(r, ecefOf({0, 0, 100})), 1e7);
    // Half way to the pole, and at the Earth's centre, where only a bound is promised.
    const Region north = makeRegion(10, 40, 20, 50, -20, 300);
    EXPECT_NEAR(distanceTo(north, ecefOf({15, 45, -10020})), 10000.0, 1e-3);
    EXPECT_NEAR(distanceTo(north, {}), kPolarRadiusMetres, 45000.0);
}

TEST(Bounds, DistanceToABoxIsExactForStraightAxes) {
    OrientedBox box;
    box.centre = {{1e6, 2e6, 3e6}};
    box.halfAxes = glm::dmat3(glm::dvec3(0, 3, 0), glm::dvec3(-2, 0, 0), glm::dvec3(0, 0, 1));
    EXPECT_NEAR(distanceTo(box, box.centre + Vector<Ecef>{{12, 0, 0}}), 10.0, 1e-9);
    EXPECT_NEAR(distanceTo(box, box.centre + Vector<Ecef>{{5, 7, 13}}), 13.0, 1e-9);
    EXPECT_EQ(distanceTo(box, box.centre + Vector<Ecef>{{1.9, 2.9, 0.9}}), 0.0);
    box.halfAxes = glm::dmat3(0.0);
    EXPECT_NEAR(distanceTo(box, box.centre + Vector<Ecef>{{3, 4, 0}}), 5.0, 1e-9);
}

TEST(Bounds, DistanceToABoxNeverExceedsTheTrueOneAndIsSeldomFarBelow) {
    Random random(33);
    double lowest = 1.0;
    for (int n = 0; n < 200; ++n) {
        const bool slanted = n % 2 == 1;
        const double size = random.magnitude(1, 1e5);
        const OrientedBox box = randomBox(random, size, slanted);
        std::vector<Point<Ecef>> points;
        for (int i = 0; i < 3000; ++i)
            points.push_back(pointInBox(box, random));
        for (int e = 0; e < 20; ++e) {
            const Point<Ecef> eye =
                box.centre + Vector<Ecef>{size * random.magnitude(0.1, 100) * random.direction()};
            double nearest = std::numeric_limits<double>::infinity();
            for (const Point<Ecef>& p : points)
                nearest = std::min(nearest, length(p - eye));
            const double distance = distanceTo(box, eye);
            ASSERT_LE(distance, nearest + kRounding);
            if (nearest > 2 * size)
                lowest = std::min(lowest, distance / nearest);
        }
    }
    EXPECT_GE(lowest, 0.95);
}

TEST(Bounds, NothingThatIsSeenIsCalledOutside) {
    Random random(34);
    for (int n = 0; n < 600; ++n) {
        BoundingVolume volume = randomBox(random, 1000, n % 2 == 1);
        if (n % 3 == 1)
            volume = Sphere{ecefOf({random.in(-180, 180), random.in(-90, 90), 0}), 500.0};
        if (n % 3 == 2)
            volume = randomRegion(random, n / 3);
        const auto sample = [&] {
            if (const auto* s = std::get_if<Sphere>(&volume))
                return pointInSphere(*s, random);
            if (const auto* r = std::get_if<Region>(&volume))
                return pointIn(*r, random);
            return pointInBox(std::get<OrientedBox>(volume), random);
        };
        // Through a point of it, or close by.
        const Plane plane{{random.direction()},
                          sample() + Vector<Ecef>{random.in(-300, 300) * random.direction()}};
        const Containment answer = classify(volume, plane);
        const Interval along = extentAlong(volume, plane.point, plane.normal);
        for (int i = 0; i < 100; ++i) {
            const double d = plane.signedDistance(sample());
            if (answer == Containment::Outside) {
                ASSERT_LT(d, kRounding);
            }
            if (answer == Containment::Inside) {
                ASSERT_GE(d, -kRounding);
            }
            ASSERT_GE(d, along.min - kRounding);
            ASSERT_LE(d, along.max + kRounding);
        }
    }
}

TEST(Bounds, OnePlaneSufficesToBeOutside) {
    const Sphere sphere{{{100, 0, 0}}, 10};
    const auto facing = [](double x, double sign) { return Plane{{{sign, 0, 0}}, {{x, 0, 0}}}; };
    const std::vector<Plane> around{facing(50, 1), facing(150, -1)};
    const std::vector<Plane> cut{facing(50, 1), facing(105, -1)};
    const std::vector<Plane> off{facing(105, -1), facing(111, 1)};
    EXPECT_EQ(classify(sphere, around), Containment::Inside);
    EXPECT_EQ(classify(sphere, cut), Containment::Crosses);
    EXPECT_EQ(classify(sphere, off), Containment::Outside);
    EXPECT_EQ(classify(sphere, std::span<const Plane>{}), Containment::Inside);
}

TEST(Bounds, ExtentAlongARegionIsThatOfItsFarthestPoints) {
    Random random(35);
    for (int kind = 0; kind < 70; ++kind) {
        const Region region = randomRegion(random, kind);
        const glm::dvec3 direction = random.direction();
        const Point<Ecef> from = pointIn(region, random);
        Interval sampled{0, 0};
        constexpr int kSteps = 80;
        for (int i = 0; i <= kSteps; ++i)
            for (int j = 0; j <= kSteps; ++j)
                for (const double w : {0.0, 1.0}) {
                    const double d = glm::dot(
                        direction,
                        (pointIn(region, double(i) / kSteps, double(j) / kSteps, w) - from).xyz);
                    sampled.min = std::min(sampled.min, d);
                    sampled.max = std::max(sampled.max, d);
                }
        const Interval exact = extentAlong(region, from, {direction});
        ASSERT_GE(sampled.min, exact.min - kRounding);
        ASSERT_LE(sampled.max, exact.max + kRounding);
        // 80 steps miss the top of a full circle by 1 - cos(360° / 80 / 2), 0.08 %
        const double slack = 1e-3 * (exact.max - exact.min) + 1e-6;
        ASSERT_NEAR(sampled.min, exact.min, slack) << "kind " << kind % 7;
        ASSERT_NEAR(sampled.max, exact.max, slack) << "kind " << kind % 7;
    }
}

TEST(Bounds, ABoundingSphereHoldsTheCorners) {
    Random random(36);
    for (int n = 0; n < 200; ++n) {
        const OrientedBox box = randomBox(random, 100, true);
        const Sphere sphere = boundingSphere(box);
        double farthest = 0.0;
        for (const Point<Ecef>& corner : corners(box))
            farthest = std::max(farthest, length(corner - sphere.centre));
        ASSERT_NEAR(farthest, sphere.radiusMetres, kRounding);
    }
}

TEST(Bounds, MovesVolumesButLeavesRegions) {
    Random random(37);
    Transform<Ecef, Tile> t = {ecefFromEnu({7, 51, 0}).matrix};
    t.matrix[0] *= 2.0;
    t.matrix[1] *= 3.0;
    const Sphere sphere = std::get<Sphere>(transformed(Sphere{{{1, 2, 3}}, 5.0}, t));
    EXPECT_NEAR(sphere.radiusMetres, 15.0, 1e-9);
    EXPECT_LE(length(sphere.centre - t(Point<Tile>{{1, 2, 3}})), 1e-9);
    OrientedBox box;
    box.centre = {{1, 2, 3}};
    box.halfAxes = glm::dmat3(4.0);
    const OrientedBox moved = std::get<OrientedBox>(transformed(box, t));
    EXPECT_NEAR(glm::length(moved.halfAxes[1]), 12.0, 1e-9);
    const Region region = makeRegion(1, 2, 3, 4, 5, 6);
    const Region same = std::get<Region>(transformed(region, t));
    EXPECT_EQ(same.westDegrees, 1.0);
    EXPECT_EQ(same.box.centre.xyz, region.box.centre.xyz);
    // A shear stretches more than any of its columns.
    t.matrix = glm::dmat4(1.0);
    t.matrix[1] = glm::dvec4(1.0, 1.0, 0.0, 0.0);
    const Sphere sheared = std::get<Sphere>(transformed(Sphere{{}, 1.0}, t));
    for (int i = 0; i < 1000; ++i)
        ASSERT_LE(length(t(Vector<Tile>{random.direction()})), sheared.radiusMetres + 1e-12);
}

TEST(Bounds, ABoxAroundPointsTouchesThemOnEverySide) {
    Random random(38);
    const glm::dmat3 axes = ecefFromEnu({7, 51, 0}).axes();
    std::vector<Point<Ecef>> points;
    for (int i = 0; i < 50; ++i)
        points.push_back(
            ecefOf({7 + random.in(0, 0.01), 51 + random.in(0, 0.01), random.in(0, 99)}));
    const OrientedBox box = boxAround(points, axes);
    for (int axis = 0; axis < 3; ++axis) {
        double least = 1.0, most = -1.0;
        for (const Point<Ecef>& p : points) {
            const double squared = glm::dot(box.halfAxes[axis], box.halfAxes[axis]);
            const double along = glm::dot((p - box.centre).xyz, box.halfAxes[axis]) / squared;
            least = std::min(least, along);
            most = std::max(most, along);
        }
        EXPECT_NEAR(least, -1.0, 1e-9);
        EXPECT_NEAR(most, 1.0, 1e-9);
    }
}

TEST(Bounds, AGeographicExtentHoldsEveryPointOfItsVolume) {
    Random random(39);
    for (int n = 0; n < 300; ++n) {
        const double size = random.magnitude(1, n % 5 == 0 ? 7e6 : 1e5);
        OrientedBox box = randomBox(random, size, n % 3 == 0);
        const double lon = n % 4 == 1 ? 180.0 : random.in(-180, 180);
        const double lat = n % 4 == 2 ? random.in(89.9, 90) : random.in(-90, 90);
        box.centre = ecefOf({lon, lat, random.in(0, 1000)});
        const Sphere sphere{box.centre, size};
        const Region ofBox = shownBy(box), ofSphere = shownBy(sphere);
        for (int i = 0; i < 300; ++i) {
            ASSERT_TRUE(containsPlace(ofBox, geodeticOf(pointInBox(box, random)))) << n;
            // Deeper than a region goes, nothing is asked of it.
            const Geodetic inSphere = geodeticOf(pointInSphere(sphere, random));
            ASSERT_TRUE(inSphere.heightMetres < -6.3e6 || containsPlace(ofSphere, inSphere)) << n;
        }
    }
}

TEST(Bounds, AGeographicExtentIsTightForATile) {
    const Region r = makeRegion(179.999, 51, -179.99, 51.01, 40, 90);
    const Region extent = shownBy(r.box);
    EXPECT_NEAR(extent.westDegrees, 179.999, 2e-5);
    EXPECT_NEAR(extent.eastDegrees, -179.99, 2e-5);
    EXPECT_NEAR(extent.southDegrees, 51, 2e-5);
    EXPECT_NEAR(extent.northDegrees, 51.01, 2e-5);
    EXPECT_NEAR(extent.minHeightMetres, 40, 0.2);
    EXPECT_NEAR(extent.maxHeightMetres, 90, 0.2);
}

TEST(Bounds, AVolumeInAFrameOfItsOwnHasNoGeographicExtent) {
    EXPECT_FALSE(geographicExtent(Sphere{{{10, 20, 30}}, 500}));
    EXPECT_FALSE(geographicExtent(Sphere{{{356000, 5699000, 100}}, 500})); // UTM for ECEF
    EXPECT_FALSE(geographicExtent(Sphere{{{1e9, 0, 0}}, 500}));
    EXPECT_FALSE(geographicExtent(Sphere{{{std::nan(""), 0, 0}}, 500}));
    OrientedBox box;
    box.halfAxes = glm::dmat3(100.0);
    EXPECT_FALSE(geographicExtent(box));
    EXPECT_TRUE(geographicExtent(Sphere{{}, 7e6})); // the Earth
}

TEST(Bounds, SurviveVolumesOfNoSizeAndOfAbsurdSize) {
    OrientedBox box;
    for (const double size : {0.0, 1e-300, 1e150, 1e300}) {
        box.halfAxes = glm::dmat3(size);
        const double distance = distanceTo(box, {{7e6, 0, 0}});
        EXPECT_TRUE(distance >= 0.0 && distance <= 7e6);
        geographicExtent(box);
        classify(box, Plane{{{1, 0, 0}}, {{0, 0, 0}}});
    }
    const Region odd = makeRegion(10, 95, 20, -95, 1e9, -1e9);
    EXPECT_EQ(odd.southDegrees, -90.0);
    EXPECT_EQ(odd.northDegrees, 90.0);
    EXPECT_TRUE(std::isfinite(odd.box.centre.xyz.x));
}
