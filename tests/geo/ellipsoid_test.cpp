#include "geo/ellipsoid.h"

#include "random_places.h"

#include <gtest/gtest.h>

#include <limits>

using namespace gnomon;
using gnomon::testing::Random;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct RoundTripErrors {
    double degrees = 0.0, metres = 0.0;
};

RoundTripErrors worstRoundTrip(int count, double maxHeight, unsigned long seed) {
    Random random(seed);
    RoundTripErrors worst;
    for (int i = 0; i < count; ++i) {
        const Geodetic place{random.in(-180, 180), random.in(-90, 90), random.in(-1e4, maxHeight)};
        const Geodetic back = geodeticOf(ecefOf(place));
        worst.degrees = std::max(
            {worst.degrees, std::abs(back.latitudeDegrees - place.latitudeDegrees),
             std::abs(std::remainder(back.longitudeDegrees - place.longitudeDegrees, 360.0))});
        worst.metres = std::max(worst.metres, std::abs(back.heightMetres - place.heightMetres));
    }
    return worst;
}

} // namespace

TEST(Ellipsoid, KnowsWhereGreenwichAndThePolesAre) {
    EXPECT_LE(glm::length(ecefOf({0, 0, 0}).xyz - glm::dvec3(kEquatorialRadiusMetres, 0, 0)), 1e-9);
    EXPECT_LE(glm::length(ecefOf({90, 0, 10}).xyz - glm::dvec3(0, kEquatorialRadiusMetres + 10, 0)),
              1e-9);
    EXPECT_LE(glm::length(ecefOf({0, -90, 5}).xyz - glm::dvec3(0, 0, -kPolarRadiusMetres - 5)),
              2e-9);
}

TEST(Ellipsoid, RoundTripsTwoMillionPlacesWithinTenNanometres) {
    const RoundTripErrors worst = worstRoundTrip(2'000'000, 1e6, 10);
    EXPECT_LE(worst.degrees, 1e-13);
    EXPECT_LE(worst.metres, 1e-8);
}

TEST(Ellipsoid, RoundTripsFarAboveTheEarthWithinTwentyNanometres) {
    const RoundTripErrors worst = worstRoundTrip(200'000, 2e7, 11);
    EXPECT_LE(worst.degrees, 1e-13);
    EXPECT_LE(worst.metres, 2e-8);
}

TEST(Ellipsoid, KeepsPositionsAtThePolesWhereLongitudeMeansNothing) {
    for (const double pole : {-90.0, 90.0})
        for (const double longitude : {-180.0, -77.0, 0.0, 33.3, 180.0}) {
            const Point<Ecef> p = ecefOf({longitude, pole, 123.0});
            EXPECT_LE(length(ecefOf(geodeticOf(p)) - p), 1e-8);
            EXPECT_DOUBLE_EQ(geodeticOf(p).latitudeDegrees, pole);
        }
}

TEST(Ellipsoid, TakesBothSidesOfTheAntimeridianForTheSame) {
    for (const double y : {0.0, -0.0}) {
        const Geodetic g = geodeticOf({{-kEquatorialRadiusMetres, y, 0.0}});
        EXPECT_EQ(std::remainder(g.longitudeDegrees - 180.0, 360.0), 0.0);
    }
    EXPECT_LE(length(ecefOf({180, 12, 34}) - ecefOf({-180, 12, 34})), 1e-9);
    EXPECT_LE(length(ecefOf({190, 12, 34}) - ecefOf({-170, 12, 34})), 1e-9);
}

TEST(Ellipsoid, RejectsWhatIsNotANumberBeforeAnyMaths) {
    for (const double bad : {kNan, kInfinity, -kInfinity}) {
        EXPECT_FALSE(ecefFromGeodetic({bad, 0, 0}));
        EXPECT_FALSE(ecefFromGeodetic({0, bad, 0}));
        EXPECT_FALSE(ecefFromGeodetic({0, 0, bad}));
        EXPECT_FALSE(geodeticFromEcef({{bad, 0, 0}}));
        EXPECT_FALSE(geodeticFromEcef({{0, bad, 0}}));
        EXPECT_FALSE(geodeticFromEcef({{0, 0, bad}}));
    }
    EXPECT_FALSE(ecefFromGeodetic({0, 90.0000001, 0}));
    EXPECT_FALSE(ecefFromGeodetic({0, -91, 0}));
    EXPECT_NE(ecefFromGeodetic({0, 91, 0}).error().message().find("latitude"), std::string::npos);
}

TEST(Ellipsoid, SurvivesNumbersNearTheEndOfTheRange) {
    for (const double huge : {1e150, 1e300, std::numeric_limits<double>::max()}) {
        const Result<Geodetic> g = geodeticFromEcef({{huge, -huge, huge}});
        EXPECT_TRUE(!g || std::isfinite(g->heightMetres));
        const Result<Point<Ecef>> p = ecefFromGeodetic({10, 20, huge});
        EXPECT_TRUE(!p || std::isfinite(p->xyz.x));
    }
}

TEST(Ellipsoid, PutsTheEarthsCentreUnderTheNorthPole) {
    const Result<Geodetic> centre = geodeticFromEcef({});
    ASSERT_TRUE(centre);
    EXPECT_EQ(centre->latitudeDegrees, 90.0);
    EXPECT_NEAR(centre->heightMetres, -6356752.3, 0.05);
}

TEST(Ellipsoid, HasOrthonormalEastNorthUpEverywhere) {
    Random random(12);
    for (int i = 0; i < 20000; ++i) {
        const Geodetic place{random.in(-180, 180), i % 10 == 0 ? 90.0 : random.in(-90, 90), 50.0};
        const Transform<Ecef, Enu> t = ecefFromEnu(place);
        const glm::dmat3 product = glm::transpose(t.axes()) * t.axes();
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                ASSERT_NEAR(product[c][r], c == r ? 1.0 : 0.0, 1e-15);
        ASSERT_NEAR(glm::determinant(t.axes()), 1.0, 1e-15);
        // Up leads along the normal: the height grows by what was climbed.
        const Geodetic above = geodeticOf(t(Point<Enu>{{0, 0, 1000.0}}));
        ASSERT_NEAR(above.heightMetres, 1050.0, 1e-8);
        ASSERT_NEAR(above.latitudeDegrees, place.latitudeDegrees, 1e-13);
        ASSERT_LE(glm::length(ellipsoidNormal(t.origin()).xyz - t.axes()[2]), 1e-14);
    }
}

TEST(Ellipsoid, TurnsEastAtAPoleWithTheLongitudeGiven) {
    EXPECT_EQ(ecefFromEnu({0, 90, 0}).axes()[0], glm::dvec3(0, 1, 0));
    EXPECT_EQ(ecefFromEnu({90, 90, 0}).axes()[0], glm::dvec3(-1, 0, 0));
    EXPECT_EQ(ecefFromEnu({90, -90, 0}).axes()[1], glm::dvec3(0, 1, 0));
}
