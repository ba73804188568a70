#include "viewer/overlay_marks.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;

namespace {

constexpr Geodetic kPlace{6.96, 50.94, 50.0};

// Looks at the ground at kPlace from `distance` away.
Camera lookingAt(const Orientation& orientation, double distance = 500.0) {
    Camera camera;
    place(camera, kPlace, orientation);
    camera.position = camera.position - distance * camera.forward;
    camera.widthPixels = 1600;
    camera.heightPixels = 900;
    return camera;
}

// Where a pixel (from the centre, to the right and up) meets the level ground at kPlace.
glm::dvec3 groundAt(const Camera& camera, double right, double up) {
    const double perPixel = 2.0 * camera.tanHalfHeight() / camera.heightPixels;
    const glm::dvec3 ray =
        camera.forward.xyz + right * perPixel * camera.right.xyz + up * perPixel * camera.up.xyz;
    const Point<Ecef> ground = ecefOf(kPlace);
    const glm::dvec3 normal = ellipsoidNormal(ground).xyz;
    const double t = glm::dot(normal, ground.xyz - camera.position.xyz) / glm::dot(normal, ray);
    return camera.position.xyz + t * ray;
}

// Where a point stands in the picture, right and up from the centre.
glm::dvec2 pixelOf(const Camera& camera, glm::dvec3 point) {
    const glm::dvec3 to = point - camera.position.xyz;
    const double depth = glm::dot(to, camera.forward.xyz);
    const double pixels = camera.heightPixels / (2.0 * camera.tanHalfHeight());
    return glm::dvec2(glm::dot(to, camera.right.xyz), glm::dot(to, camera.up.xyz)) *
           (pixels / depth);
}

} // namespace

TEST(GroundScale, IsTheFieldOfViewsWidthSeenFromAbove) {
    Camera camera = lookingAt({0, -90, 0}, 1000.0);
    camera.verticalFovRadians = 2.0 * std::atan(0.45); // 900 m over 900 pixels
    const auto scale = groundScale(camera, ecefOf(kPlace));
    ASSERT_TRUE(scale);
    EXPECT_NEAR(scale->metresPerPixel, 1.0, 1e-9);
    EXPECT_FALSE(scale->oblique);
}

TEST(GroundScale, IsTheDistanceBetweenTheGroundsPointsUnderNeighbouringPixels) {
    for (const Orientation& orientation :
         {Orientation{0, -90, 0}, {30, -60, 0}, {200, -40, 0}, {30, -60, 10}, {75, -70, -35}}) {
        const Camera camera = lookingAt(orientation);
        const auto scale = groundScale(camera, ecefOf(kPlace));
        ASSERT_TRUE(scale) << orientation.pitchDegrees;
        const double between =
            glm::length(groundAt(camera, 0.5, 0.0) - groundAt(camera, -0.5, 0.0));
        EXPECT_NEAR(scale->metresPerPixel / between, 1.0, 1e-5) << orientation.pitchDegrees;
        EXPECT_EQ(scale->oblique, orientation.pitchDegrees > -85.0);
    }
}

TEST(GroundScale, IsNotToldOnceTheHorizonIsInThePicture) {
    Camera camera; // 45 degrees tall: half of it above the axis
    camera.verticalFovRadians = 45.0 * kRadiansPerDegree;
    for (const auto& [pitch, roll, told] : {std::tuple{-90.0, 0.0, true},
                                            {-23.0, 0.0, true},
                                            {-22.0, 0.0, false},
                                            {0.0, 0.0, false},
                                            {10.0, 0.0, false},
                                            {-30.0, 0.0, true},
                                            {-30.0, 40.0, false}}) {
        Camera looking = lookingAt({120, pitch, roll});
        looking.verticalFovRadians = camera.verticalFovRadians;
        EXPECT_EQ(bool(groundScale(looking, ecefOf(kPlace))), told) << pitch << ' ' << roll;
    }
}

TEST(GroundScale, ChangesByThreeAtMostWithinTheMiddleHalfWhereItIsTold) {
    const Camera camera = lookingAt({0, -22.6, 0});
    ASSERT_TRUE(groundScale(camera, ecefOf(kPlace)));
    const auto across = [&](double up) {
        return glm::length(groundAt(camera, 0.5, up) - groundAt(camera, -0.5, up));
    };
    EXPECT_LE(across(225) / across(-225), 3.0);
    EXPECT_GT(across(225) / across(-225), 2.8);
}

TEST(ScaleBar, HasTheLongestNiceLengthThatFits) {
    for (const auto& [perPixel, most, label, pixels] : {std::tuple{1.0, 160.0, "100 m", 100.0},
                                                        {1.0, 200.0, "200 m", 200.0},
                                                        {1.0, 199.0, "100 m", 100.0},
                                                        {1.0, 999.0, "500 m", 500.0},
                                                        {10.0, 160.0, "1 km", 100.0},
                                                        {0.01, 160.0, "1 m", 100.0},
                                                        {0.004, 160.0, "0.5 m", 125.0},
                                                        {2000.0, 160.0, "200 km", 100.0},
                                                        {50000.0, 160.0, "5000 km", 100.0}}) {
        const auto bar = scaleBar(perPixel, most);
        ASSERT_TRUE(bar);
        EXPECT_EQ(bar->label, label);
        EXPECT_NEAR(bar->pixels, pixels, 1e-9 * pixels) << label;
    }
    for (const double wrong : {0.0, -1.0, double(NAN), double(INFINITY)})
        EXPECT_FALSE(scaleBar(wrong, 160.0)) << wrong;
}

TEST(ScaleBar, IsAsLongInThePictureAsItsLabelSaysOnTheGround) {
    const Camera camera = lookingAt({40, -90, 0}, 700.0);
    const auto bar = scaleBar(groundScale(camera, ecefOf(kPlace))->metresPerPixel, 200.0);
    ASSERT_EQ(bar->label, "100 m");
    // A hundred metres along the picture's rows, about the centre.
    const glm::dvec3 half = 50.0 * camera.right.xyz;
    const glm::dvec3 middle = ecefOf(kPlace).xyz;
    EXPECT_NEAR(pixelOf(camera, middle + half).x - pixelOf(camera, middle - half).x, bar->pixels,
                1e-3);
}

TEST(Compass, TurnsAgainstTheCameraSeenFromAbove) {
    for (const auto& [heading, roll, x, y] : {std::tuple{0.0, 0.0, 0.0, 1.0},
                                              {90.0, 0.0, -1.0, 0.0},
                                              {180.0, 0.0, 0.0, -1.0},
                                              {270.0, 0.0, 1.0, 0.0},
                                              {0.0, 90.0, -1.0, 0.0}}) {
        const CompassAxes axes = compassAxes(lookingAt({heading, -90, roll}));
        EXPECT_NEAR(axes.north.x, x, 1e-4) << heading;
        EXPECT_NEAR(axes.north.y, y, 1e-4) << heading;
        EXPECT_NEAR(axes.east.x, y, 1e-4) << heading;
        EXPECT_NEAR(axes.east.y, -x, 1e-4) << heading;
    }
}

TEST(Compass, PointsWhereNorthIsOnTheGroundAtTheCentre) {
    const glm::dmat3 enu = ecefFromEnu(kPlace).axes();
    for (const Orientation& orientation :
         {Orientation{30, -90, 0}, {75, -60, 0}, {200, -30, 0}, {310, -45, 25}}) {
        const Camera camera = lookingAt(orientation);
        const CompassAxes axes = compassAxes(camera);
        const glm::dvec3 at = ecefOf(kPlace).xyz;
        for (const auto& [said, step] : {std::pair{axes.north, enu[1]}, {axes.east, enu[0]}}) {
            const glm::dvec2 seen = pixelOf(camera, at + 0.1 * step) - pixelOf(camera, at);
            const double off = std::atan2(said.x * seen.y - said.y * seen.x, glm::dot(said, seen));
            EXPECT_NEAR(off / kRadiansPerDegree, 0.0, 0.05) << orientation.headingDegrees;
        }
    }
}

TEST(Compass, IsNeverSeenFlatterThanFromTwentyFiveDegrees) {
    const double flattest = std::sin(25.0 * kRadiansPerDegree);
    for (const double pitch : {-20.0, 0.0, 30.0, 80.0}) {
        const CompassAxes north = compassAxes(lookingAt({0, pitch, 0}));
        EXPECT_NEAR(north.north.y, flattest, 1e-3) << pitch;
        EXPECT_NEAR(north.north.x, 0.0, 1e-3);
        EXPECT_NEAR(north.east.x, 1.0, 1e-6);
        const CompassAxes east = compassAxes(lookingAt({90, pitch, 0}));
        EXPECT_NEAR(east.north.x, -1.0, 1e-3) << pitch;
        EXPECT_NEAR(east.east.y, flattest, 1e-3);
    }
    const CompassAxes steeper = compassAxes(lookingAt({0, -26, 0}));
    EXPECT_NEAR(steeper.north.y, std::sin(26.0 * kRadiansPerDegree), 1e-4);
    const CompassAxes up = compassAxes(lookingAt({0, 90, 0}));
    EXPECT_TRUE(std::isfinite(up.north.x) && std::isfinite(up.north.y));
}

TEST(Ticks, AreMultiplesOfOneTwoOrFive) {
    const auto labels = [](double least, double most, int count) {
        const Ticks ticks = ticksBetween(least, most, count);
        std::string text;
        for (const double value : ticks.values)
            text += (text.empty() ? "" : " ") + ticks.label(value);
        return text;
    };
    EXPECT_EQ(labels(0, 4, 6), "0 1 2 3 4");
    EXPECT_EQ(labels(0, 4, 4), "0 2 4");
    EXPECT_EQ(labels(0, 1.5, 5), "0.0 0.5 1.0 1.5");
    EXPECT_EQ(labels(0, 0.3, 5), "0.0 0.1 0.2 0.3");
    EXPECT_EQ(labels(0, 8, 7), "0 2 4 6 8");
    EXPECT_EQ(labels(38.3, 121.7, 5), "40 60 80 100 120");
    EXPECT_EQ(labels(-1.2, 1.1, 6), "\u22121.0 \u22120.5 0.0 0.5 1.0");
    EXPECT_EQ(labels(0, 0.002, 3), "0.000 0.001 0.002");
    EXPECT_EQ(labels(0, 250000, 6), "0 50000 100000 150000 200000 250000");
}

TEST(Ticks, LieInTheRangeAndAreNoMoreThanAskedFor) {
    for (double least = -37.7; least < 40.0; least += 7.31)
        for (double range = 0.0013; range < 1e6; range *= 1.37)
            for (const int most : {2, 3, 5, 7}) {
                const Ticks ticks = ticksBetween(least, least + range, most);
                ASSERT_LE(int(ticks.values.size()), most);
                for (const double value : ticks.values) {
                    ASSERT_GE(value, least - 1e-6 * range);
                    ASSERT_LE(value, least + 1.000001 * range);
                    ASSERT_NEAR(value / ticks.step, std::round(value / ticks.step), 1e-6);
                }
                ASSERT_GE(ticks.values.size(), most >= 5 ? 2u : 0u) << least << ' ' << range;
            }
}

TEST(Ticks, OfNoRangeAreNone) {
    EXPECT_TRUE(ticksBetween(1, 1, 5).values.empty());
    EXPECT_TRUE(ticksBetween(2, 1, 5).values.empty());
    EXPECT_TRUE(ticksBetween(0, NAN, 5).values.empty());
    EXPECT_TRUE(ticksBetween(-INFINITY, INFINITY, 5).values.empty());
    EXPECT_TRUE(ticksBetween(1e300, 1e300 * (1 + 1e-15), 5).values.empty());
}

TEST(SunText, IsToATenthAndTurnsOverAtNorth) {
    EXPECT_EQ(sunText(261.34, 28.06), "Sun: azimuth 261.3\u00B0, elevation 28.1\u00B0");
    EXPECT_EQ(sunText(359.96, -5.25), "Sun: azimuth 0.0\u00B0, elevation \u22125.2\u00B0");
    EXPECT_EQ(sunText(-90.0, -0.04), "Sun: azimuth 270.0\u00B0, elevation 0.0\u00B0");
}
