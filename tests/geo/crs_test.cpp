#include "geo/crs.h"

#include "random_places.h"

#include <GeographicLib/UTMUPS.hpp>
#include <gtest/gtest.h>

#include <limits>

using namespace gnomon;
using gnomon::testing::Random;

namespace {

CrsToEcef crs(const char* name, Heights heights = Heights::Ellipsoidal) {
    Result<CrsToEcef> made = CrsToEcef::create(name, heights);
    if (!made)
        throw std::runtime_error(made.error().message());
    return std::move(made).value();
}

void expectPlace(const char* name, const glm::dvec3& xyz, const Geodetic& expected,
                 double toleranceMetres, Heights heights = Heights::Ellipsoidal) {
    const Result<Point<Ecef>> p = crs(name, heights)(xyz);
    ASSERT_TRUE(p) << p.error().message();
    EXPECT_LE(length(*p - ecefOf(expected)), toleranceMetres) << name;
}

std::string complaint(const char* name) {
    const Result<CrsToEcef> made = CrsToEcef::create(name, Heights::Ellipsoidal);
    EXPECT_FALSE(made) << name;
    return made ? "" : made.error().message();
}

} // namespace

// Expected values below are from cs2cs 9.1 where the command is given.

TEST(Crs, BringsUtmToTheEarth) {
    // echo 356000 5699000 100 | cs2cs -f %.10f EPSG:25832 EPSG:4326
    expectPlace("EPSG:25832", {356000, 5699000, 100}, {6.9288007882, 51.4238904785, 100}, 1e-4);
}

TEST(Crs, AgreesWithAnotherLibrarysUtmToAMicrometre) {
    Random random(50);
    const CrsToEcef utm = crs("EPSG:32632");
    for (int i = 0; i < 1000; ++i) {
        const double x = random.in(250e3, 750e3), y = random.in(1e5, 9e6);
        double latitude = 0, longitude = 0;
        GeographicLib::UTMUPS::Reverse(32, true, x, y, latitude, longitude);
        const Result<Point<Ecef>> p = utm(glm::dvec3(x, y, 50.0));
        ASSERT_TRUE(p);
        ASSERT_LE(length(*p - ecefOf({longitude, latitude, 50.0})), 1e-6);
    }
}

TEST(Crs, BringsWebMercatorToTheEarth) {
    // echo 800000 6600000 | cs2cs -f %.10f EPSG:3857 EPSG:4326
    expectPlace("EPSG:3857", {800000, 6600000, 50}, {7.1865222730, 50.8794643854, 50}, 1e-4);
    // and from its formula: latitude = 2 atan(exp(y / a)) - 90°
    const double latitude =
        2.0 * std::atan(std::exp(4e6 / kEquatorialRadiusMetres)) / kRadiansPerDegree - 90.0;
    expectPlace("EPSG:3857", {-1e6, 4e6, 0},
                {-1e6 / kEquatorialRadiusMetres / kRadiansPerDegree, latitude, 0}, 1e-6);
}

TEST(Crs, BringsTheDutchGridToTheEarth) {
    // echo 85000 446000 | cs2cs -f %.10f EPSG:28992 EPSG:4326, without the (absent) grids
    expectPlace("EPSG:28992", {85000, 446000, 3}, {4.3678877793, 51.9979621078, 3}, 0.01);
    // Its origin, the tower of Amersfoort, by Schreutelkamp and Strang van Hees (2001).
    expectPlace("EPSG:28992", {155000, 463000, 0}, {5.38720621, 52.15517440, 0}, 0.5);
}

TEST(Crs, TakesLongitudeFirstWhateverTheAuthoritysOrder) {
    expectPlace("EPSG:4326", {7, 51, 100}, {7, 51, 100}, 1e-8);
    expectPlace("EPSG:4979", {7, 51, 100}, {7, 51, 100}, 1e-8);
    // The South African grid is defined westings, southings; Soldner Berlin northing, easting.
    const Result<Geodetic> berlin = crs("EPSG:3068").geodetic({40000, 10000, 0});
    ASSERT_TRUE(berlin);
    EXPECT_NEAR(berlin->longitudeDegrees, 13.627, 0.02);
    EXPECT_NEAR(berlin->latitudeDegrees, 52.418, 0.02);
}

TEST(Crs, ReadsProjStringsAndWkt) {
    // GRS 80 there and WGS 84 here differ by 0.1 mm.
    expectPlace("+proj=utm +zone=32 +datum=WGS84", {356000, 5699000, 100},
                {6.9288007882, 51.4238904785, 100}, 1e-3);
    // As in a shapefile's .prj: no authority, no names PROJ knows.
    expectPlace("GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\",SPHEROID[\"WGS_1984\",6378137.0,"
                "298.257223563]],PRIMEM[\"Greenwich\",0.0],UNIT[\"Degree\",0.0174532925199433]]",
                {106.8, -6.2, 5}, {106.8, -6.2, 5}, 1e-4);
}

TEST(Crs, KeepsGeocentricCoordinates) {
    const Point<Ecef> p = ecefOf({7, 51, 100});
    const Result<Point<Ecef>> same = crs("EPSG:4978")(p.xyz);
    ASSERT_TRUE(same);
    EXPECT_LE(length(*same - p), 1e-6);
}

TEST(Crs, AddsTheGeoidToHeightsAboveIt) {
    // echo 51 7 0 | cs2cs -f %.6f EPSG:4326+5773 EPSG:4979
    expectPlace("EPSG:4326", {7, 51, 0}, {7, 51, 46.870041}, 1e-5, Heights::Egm96);
    expectPlace("EPSG:4326", {367, 51, 0}, {7, 51, 46.870041}, 1e-5, Heights::Egm96);
}

TEST(Crs, LetsACompoundCrsBringItsOwnHeights) {
    // echo 356000 5699000 100 | cs2cs -f %.9f EPSG:25832+5773 EPSG:4979
    for (const Heights ignored : {Heights::Ellipsoidal, Heights::Egm96})
        expectPlace("EPSG:25832+5773", {356000, 5699000, 100},
                    {6.928800788, 51.423890478, 145.756656987}, 1e-3, ignored);
}

TEST(Crs, NamesTheGridItWouldNeedForHeights) {
    // NAP heights are tied to a geoid that is not in Debian's proj-data; passing them on as if they
    // were ellipsoidal would be 43 m wrong.
    const Result<CrsToEcef> dutch = CrsToEcef::create("EPSG:7415", Heights::Ellipsoidal);
    if (dutch) {
        const Result<Geodetic> delft = dutch->geodetic({85000, 446000, 0});
        ASSERT_TRUE(delft);
        EXPECT_NEAR(delft->heightMetres, 43.0, 2.0);
    } else {
        EXPECT_NE(dutch.error().message().find("nlgeo2018"), std::string::npos)
            << dutch.error().message();
    }
}

TEST(Crs, RefusesHeightsOfAnUnknownKindInsteadOfGuessing) {
    const std::string reason = complaint(
        "COMPD_CS[\"site\",PROJCS[\"UTM 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
        "84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
        "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],PARAMETER["
        "\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_easting\","
        "500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]],VERT_CS[\"staff\",VERT_DATUM["
        "\"site datum\",2005],UNIT[\"metre\",1]]]");
    EXPECT_NE(reason.find("heights"), std::string::npos) << reason;
}

TEST(Crs, RefusesWhatIsNoPlaceOnEarth) {
    EXPECT_NE(complaint("").find("not a coordinate reference system"), std::string::npos);
    EXPECT_NE(complaint("EPSG:0").find("not a coordinate reference system"), std::string::npos);
    EXPECT_NE(complaint("Cologne").find("not a coordinate reference system"), std::string::npos);
    EXPECT_NE(complaint("EPSG:5773").find("where on the Earth"), std::string::npos);
    complaint("IAU_2015:49900"); // Mars
    complaint("LOCAL_CS[\"site\",UNIT[\"metre\",1]]");
    complaint("PROJCS[[[[");
    const std::string longText(100000, '[');
    EXPECT_LT(complaint(longText.c_str()).size(), 300u);
    EXPECT_EQ(complaint("EPSG\n:1\n").find('\n'), std::string::npos);
}

TEST(Crs, RefusesCoordinatesThatHaveNoPlace) {
    const CrsToEcef utm = crs("EPSG:25832");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(utm(glm::dvec3(nan, 0, 0)));
    EXPECT_FALSE(utm(glm::dvec3(0, 0, std::numeric_limits<double>::infinity())));
    EXPECT_FALSE(utm(glm::dvec3(1e30, 1e30, 0)));
    EXPECT_FALSE(crs("EPSG:4326")(glm::dvec3(0, 91, 0)));
    // and goes on after an error
    EXPECT_TRUE(utm(glm::dvec3(356000, 5699000, 0)));
}

TEST(Crs, GivesATangentFrameThatFollowsGridNorthAndGridScale) {
    // EPSG:3857 stretches by 1 / cos(latitude) (to 0.3 %), and its north is north.
    const glm::dvec3 origin(800000, 6600000, 50);
    const CrsToEcef mercator = crs("EPSG:3857");
    const Result<Transform<Ecef, Tile>> frame = mercator.ecefFromCrsNear(origin);
    ASSERT_TRUE(frame);
    const Geodetic place = *mercator.geodetic(origin);
    const glm::dmat3 enu = ecefFromEnu(place).axes();
    const double scale = std::cos(place.latitudeDegrees * kRadiansPerDegree);
    EXPECT_NEAR(glm::length(frame->axes()[0]), scale, 0.003 * scale);
    EXPECT_NEAR(glm::dot(glm::normalize(frame->axes()[0]), enu[0]), 1.0, 1e-9);
    EXPECT_NEAR(glm::dot(glm::normalize(frame->axes()[1]), enu[1]), 1.0, 1e-9);
    EXPECT_LE(glm::length(frame->axes()[2] - enu[2]), 1e-9);
    EXPECT_LE(length((*frame)(Point<Tile>{origin}) - ecefOf(place)), 1e-7);
}

TEST(Crs, FitsTheCurvedEarthToSecondOrderAroundTheFramesOrigin) {
    const glm::dvec3 origin(356000, 5699000, 100);
    const CrsToEcef utm = crs("EPSG:25832");
    const Transform<Ecef, Tile> frame = utm.ecefFromCrsNear(origin).value();
    for (const double d : {10.0, 100.0, 1000.0}) {
        const glm::dvec3 p = origin + glm::dvec3(d, -d, 5.0);
        const double off = length(frame(Point<Tile>{p}) - *utm(p));
        // The sagitta of the Earth's curve, d² / R for this diagonal, and little else.
        EXPECT_LE(off, 1.2 * d * d / 6.37e6 + 1e-4);
    }
    // Handedness and convergence: grid north is some 1.6° west of north, two degrees west of 9° E.
    const glm::dmat3 enu = ecefFromEnu(*utm.geodetic(origin)).axes();
    const double turn =
        std::atan2(glm::dot(frame.axes()[1], enu[0]), glm::dot(frame.axes()[1], enu[1])) /
        kRadiansPerDegree;
    EXPECT_NEAR(turn, -(6.9288 - 9.0) * std::sin(51.4239 * kRadiansPerDegree) * -1.0, 0.01);
    EXPECT_GT(glm::determinant(frame.axes()), 0.0);
}

TEST(Crs, KnowsTheGeoidEverywhere) {
    // EGM96's own test values: 17.16 m at (0, 0), 13.61 m and -29.53 m at the poles.
    EXPECT_NEAR(*egm96GeoidHeight(0, 0), 17.16, 0.01);
    for (const double longitude : {-180.0, 0.0, 77.0, 180.0, 359.9}) {
        EXPECT_NEAR(*egm96GeoidHeight(longitude, 90), 13.61, 0.01);
        EXPECT_NEAR(*egm96GeoidHeight(longitude, -90), -29.53, 0.01);
    }
    EXPECT_NEAR(*egm96GeoidHeight(180, 10), *egm96GeoidHeight(-180, 10), 1e-9);
    EXPECT_NEAR(*egm96GeoidHeight(179.9999, 10), *egm96GeoidHeight(-179.9999, 10), 1e-3);
    EXPECT_FALSE(egm96GeoidHeight(std::numeric_limits<double>::quiet_NaN(), 0));
    EXPECT_FALSE(egm96GeoidHeight(0, 90.1));
}
