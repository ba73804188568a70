#include "geo/sun.h"

#include "random_places.h"

#include <gtest/gtest.h>

using namespace gnomon;
using gnomon::testing::Random;

namespace {

constexpr double kArcsecond = 1.0 / 3600.0;

UtcTime at(const char* text) {
    const Result<UtcTime> t = parseTime(text);
    EXPECT_TRUE(t) << text;
    return t ? *t : UtcTime{};
}

double turnBetween(double a, double b) {
    return std::abs(std::remainder(a - b, 360.0));
}

void expectApparent(const char* time, double rightAscension, double declination) {
    const SunEquatorial sun = sunEquatorial(at(time));
    EXPECT_LE(turnBetween(sun.rightAscensionDegrees, rightAscension), 10 * kArcsecond) << time;
    EXPECT_NEAR(sun.declinationDegrees, declination, 10 * kArcsecond) << time;
}

// Reda and Andreas, "Solar position algorithm for solar radiation applications", NREL/TP-560-34302,
// table A5.1: Golden, Colorado.
const Geodetic kGolden{-105.1786, 39.742476, 1830.14};
const char* const kGoldenTime = "2003-10-17T12:30:30-07:00";

const Geodetic kCologne{6.958, 50.941, 60.0};

} // namespace

TEST(Sun, AgreesWithMeeusExample25b) {
    // 1992 October 13.0 TD, 59.184 s ahead of UTC: 13h 13m 30.749s, -7° 47' 01.74".
    expectApparent("1992-10-12T23:59:00.816Z", 15.0 * (13 + 13 / 60.0 + 30.749 / 3600.0),
                   -(7 + 47 / 60.0 + 1.74 / 3600.0));
}

TEST(Sun, AgreesWithTheNrelReport) {
    expectApparent(kGoldenTime, 202.22741, -9.31434);
    EXPECT_NEAR(sunEquatorial(at(kGoldenTime)).distanceAu, 0.9965422974, 1e-6);
    const SunPosition bare = sunAt(at(kGoldenTime), kGolden, Refraction::Off);
    EXPECT_NEAR(bare.azimuthDegrees, 194.340241, 0.001);
    EXPECT_NEAR(bare.elevationDegrees, 39.872046, 0.001);
    // The report has 820 hPa and 11 °C; at sea level refraction is 0.0039° more.
    const SunPosition seen = sunAt(at(kGoldenTime), kGolden, Refraction::On);
    EXPECT_NEAR(seen.azimuthDegrees, 194.340241, 0.01);
    EXPECT_NEAR(seen.elevationDegrees, 90.0 - 50.111622, 0.01);
}

// The moments the almanacs give, to the minute (half of that is 1.2″ of the sun's way).
TEST(Sun, CrossesTheEquatorAtThePublishedEquinoxes) {
    for (const char* march :
         {"1990-03-20T21:19", "2030-03-20T13:52", "2040-03-20T00:11", "2050-03-20T10:19",
          "2000-03-20T07:35", "2005-03-20T12:33", "2010-03-20T17:32", "2015-03-20T22:45",
          "2018-03-20T16:15", "2019-03-20T21:58", "2020-03-20T03:50", "2021-03-20T09:37",
          "2022-03-20T15:33", "2023-03-20T21:24", "2024-03-20T03:06", "2025-03-20T09:01"})
        expectApparent(march, 0.0, 0.0);
    for (const char* september :
         {"1990-09-23T06:56", "2030-09-22T23:27", "2050-09-22T19:28", "2000-09-22T17:28",
          "2005-09-22T22:23", "2010-09-23T03:09", "2015-09-23T08:21", "2018-09-23T01:54",
          "2019-09-23T07:50", "2020-09-22T13:31", "2021-09-22T19:21", "2022-09-23T01:04",
          "2023-09-23T06:50", "2024-09-22T12:44", "2025-09-22T18:19"})
        expectApparent(september, 180.0, 0.0);
}

TEST(Sun, StandsFurthestNorthAndSouthAtThePublishedSolstices) {
    for (const char* june :
         {"1990-06-21T15:33", "2030-06-21T07:31", "2050-06-21T03:33", "2000-06-21T01:48",
          "2005-06-21T06:46", "2010-06-21T11:28", "2015-06-21T16:38", "2018-06-21T10:07",
          "2019-06-21T15:54", "2020-06-20T21:44", "2021-06-21T03:32", "2022-06-21T09:14",
          "2023-06-21T14:58", "2024-06-20T20:51", "2025-06-21T02:42"}) {
        const SunEquatorial sun = sunEquatorial(at(june));
        EXPECT_LE(turnBetween(sun.rightAscensionDegrees, 90.0), 10 * kArcsecond) << june;
        // The obliquity, 23° 26' 21.4" in 2000 less 0.468" a year, with 9.2" of nutation.
        EXPECT_NEAR(sun.declinationDegrees, 23.4365, 0.006) << june;
    }
    for (const char* december :
         {"1990-12-22T03:07", "2030-12-21T20:09", "2050-12-21T16:38", "2000-12-21T13:37",
          "2005-12-21T18:35", "2010-12-21T23:38", "2015-12-22T04:48", "2018-12-21T22:23",
          "2019-12-22T04:19", "2020-12-21T10:02", "2021-12-21T15:59", "2022-12-21T21:48",
          "2023-12-22T03:27", "2024-12-21T09:20", "2025-12-21T15:03"})
        EXPECT_LE(turnBetween(sunEquatorial(at(december)).rightAscensionDegrees, 270.0),
                  10 * kArcsecond)
            << december;
}

TEST(Sun, IsNearestInJanuaryAndFarthestInJuly) {
    // Perihelion and aphelion of 2020: 0.9832436 and 1.0166943 AU.
    EXPECT_NEAR(sunEquatorial(at("2020-01-05T07:48")).distanceAu, 0.9832436, 2e-6);
    EXPECT_NEAR(sunEquatorial(at("2020-07-04T11:35")).distanceAu, 1.0166943, 2e-6);
}

TEST(Sun, StandsInTheZenithWhereItsCoordinatesSay) {
    // Geocentric and topocentric places coincide there, but for the ellipsoid's slanted normal.
    const UtcTime time = at("2023-05-05T12:00Z");
    const SunEquatorial sun = sunEquatorial(time);
    const SunPosition greenwich = sunAt(time, {0.0, 0.0, 0.0}, Refraction::Off);
    // Longitude of the subsolar point, from the direction seen at (0, 0).
    const double longitude =
        std::atan2(greenwich.towards.xyz.y, greenwich.towards.xyz.x) / kRadiansPerDegree;
    const SunPosition below =
        sunAt(time, {longitude, sun.declinationDegrees, 0.0}, Refraction::Off);
    EXPECT_GT(below.elevationDegrees, 89.99);
    // The equation of time on May 5 is 3.3 minutes: the sun is past Greenwich.
    EXPECT_NEAR(longitude, -3.3 / 4.0, 0.05);
}

TEST(Sun, PointsTheSameWayInAnglesAndInEcef) {
    Random random(40);
    for (int i = 0; i < 2000; ++i) {
        const UtcTime time{random.in(631152000.0, 2524608000.0)}; // 1990 to 2050
        const Geodetic place{random.in(-180, 180), i % 20 == 0 ? 90.0 : random.in(-90, 90), 100};
        for (const Refraction refraction : {Refraction::Off, Refraction::On}) {
            const SunPosition sun = sunAt(time, place, refraction);
            ASSERT_NEAR(length(sun.towards), 1.0, 1e-14);
            ASSERT_GE(sun.azimuthDegrees, 0.0);
            ASSERT_LT(sun.azimuthDegrees, 360.0);
            const SunPosition again =
                sunFromAngles(sun.azimuthDegrees, sun.elevationDegrees, place);
            ASSERT_LE(length(again.towards - sun.towards), 1e-13);
        }
    }
}

TEST(Sun, SeenFromTheGroundIsLowerByItsParallaxAtMost) {
    // Towards the Earth's centre's view: 8.8″ at the horizon.
    const UtcTime time = at("2021-06-21T05:00Z");
    const SunPosition low = sunAt(time, kCologne, Refraction::Off);
    const SunPosition fromSpace = sunAt(
        time, {kCologne.longitudeDegrees, kCologne.latitudeDegrees, -6.36e6}, Refraction::Off);
    const double parallax = fromSpace.elevationDegrees - low.elevationDegrees;
    EXPECT_GT(parallax, 7.5 * kArcsecond);
    EXPECT_LT(parallax, 8.8 * kArcsecond);
}

TEST(Sun, RefractionLiftsTheSunByTheTabulatedAmounts) {
    // Bennett's formula from the seen elevation, in minutes of arc: an independent one.
    Random random(41);
    int low = 0;
    for (int i = 0; i < 4000; ++i) {
        const UtcTime time{random.in(1.6e9, 1.7e9)};
        const SunPosition bare = sunAt(time, kCologne, Refraction::Off);
        if (bare.elevationDegrees < 0.0)
            continue;
        const SunPosition seen = sunAt(time, kCologne, Refraction::On);
        const double h = seen.elevationDegrees;
        const double bennett =
            1013.25 / 1010.0 / 60.0 / std::tan((h + 7.31 / (h + 4.4)) * kRadiansPerDegree);
        EXPECT_NEAR(h - bare.elevationDegrees, bennett, h > 5.0 ? 0.002 : 0.01) << h;
        EXPECT_EQ(seen.azimuthDegrees, bare.azimuthDegrees);
        low += h < 5.0;
    }
    EXPECT_GT(low, 50);
}

TEST(Sun, SetsWithoutAJumpAndWithoutTurningBack) {
    // From the afternoon to the deepest night: bare and seen elevation both only fall.
    const double noon = at("2021-03-20T12:00Z").seconds;
    double lastBare = sunAt({noon}, kCologne, Refraction::Off).elevationDegrees;
    double lastSeen = sunAt({noon}, kCologne, Refraction::On).elevationDegrees;
    double largestLift = 0.0;
    for (int second = 10; second < 11 * 3600; second += 10) {
        const UtcTime time{noon + second};
        const double bare = sunAt(time, kCologne, Refraction::Off).elevationDegrees;
        const double seen = sunAt(time, kCologne, Refraction::On).elevationDegrees;
        ASSERT_LT(bare, lastBare);
        ASSERT_LT(seen, lastSeen) << bare;
        ASSERT_GE(seen, bare);
        ASSERT_LT(lastSeen - seen, 0.06); // 10 s of way are 0.026° here
        largestLift = std::max(largestLift, seen - bare);
        lastBare = bare;
        lastSeen = seen;
    }
    EXPECT_NEAR(largestLift, 0.75, 0.15);
    EXPECT_LT(lastBare, -35.0);
    EXPECT_NEAR(lastSeen, lastBare, 1e-6);
}

TEST(Sun, TakesAnglesByHandAsTheyAreGiven) {
    const SunPosition east = sunFromAngles(90.0, 0.0, {0, 0, 0});
    EXPECT_LE(glm::length(east.towards.xyz - glm::dvec3(0, 1, 0)), 1e-15);
    const SunPosition zenith = sunFromAngles(123.0, 90.0, {0, 0, 0});
    EXPECT_LE(glm::length(zenith.towards.xyz - glm::dvec3(1, 0, 0)), 1e-15);
    EXPECT_EQ(zenith.azimuthDegrees, 123.0);
    EXPECT_EQ(sunFromAngles(-90.0, 10.0, kCologne).azimuthDegrees, 270.0);
    const SunPosition north = sunFromAngles(0.0, 45.0, kCologne);
    const glm::dmat3 enu = ecefFromEnu(kCologne).axes();
    EXPECT_NEAR(glm::dot(north.towards.xyz, enu[1]), std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(glm::dot(north.towards.xyz, enu[2]), std::sqrt(0.5), 1e-15);
}

TEST(Sun, IsFiniteInAnyYearThatCanBeWritten) {
    for (const char* text : {"0001-01-01T00:00", "1583-01-01T12:00", "1900-01-01T00:00",
                             "1959-12-31T23:59", "2100-06-01T00:00", "9999-12-31T23:59"}) {
        const SunPosition sun = sunAt(at(text), kCologne);
        EXPECT_TRUE(std::isfinite(sun.azimuthDegrees) && std::isfinite(sun.elevationDegrees));
        EXPECT_NEAR(length(sun.towards), 1.0, 1e-14);
    }
    // Still the sun: the solstice of 1900, June 21 21:40, 23.452° north.
    EXPECT_NEAR(sunEquatorial(at("1900-06-21T21:40")).declinationDegrees, 23.452, 0.005);
}
