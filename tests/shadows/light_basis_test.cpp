#include "shadows/light_basis.h"

#include "geo/ellipsoid.h"
#include "geo/sun.h"
#include "tests/geo/random_places.h"

#include <gtest/gtest.h>

#include <glm/common.hpp>

#include <cmath>
#include <vector>

using namespace gnomon;

namespace {

glm::dvec3 fromAngles(double azimuthDegrees, double elevationDegrees) {
    const double a = azimuthDegrees * kRadiansPerDegree, e = elevationDegrees * kRadiansPerDegree;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

// The largest entry of MᵀM - 1.
double orthonormalError(const glm::dmat3& m) {
    const glm::dmat3 square = glm::transpose(m) * m;
    double worst = 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            worst = std::max(worst, std::abs(square[i][j] - (i == j ? 1.0 : 0.0)));
    return worst;
}

double difference(const glm::dmat3& a, const glm::dmat3& b) {
    double worst = 0.0;
    for (int i = 0; i < 3; ++i)
        worst = std::max(worst, glm::length(a[i] - b[i]));
    return worst;
}

std::vector<glm::dvec3> singularDirections() {
    std::vector<glm::dvec3> out;
    for (const double x : {-1.0, -1e-8, -1e-16, 0.0, 1e-300, 1e-12, 1.0})
        for (const double y : {-1.0, -1e-12, 0.0, 1e-300, 1e-9, 1.0})
            for (const double z : {0.0, 1e-300, 1e-16, 1e-9, 1.0})
                if (x != 0.0 || y != 0.0 || z != 0.0)
                    out.push_back(glm::normalize(glm::dvec3(x, y, z) /
                                                 std::max({std::abs(x), std::abs(y), z})));
    return out;
}

} // namespace

TEST(LightBasis, IsRightHandedAndOrthonormalForEverySunThatShines) {
    gnomon::testing::Random random(1);
    std::vector<glm::dvec3> suns = singularDirections();
    // Down to where a sun may stand for an eye 20,000 km up.
    for (int i = 0; i < 200000; ++i) {
        const glm::dvec3 d = random.direction();
        if (d.z > -0.97)
            suns.push_back(d);
    }
    for (const glm::dvec3& sun : suns) {
        const glm::dmat3 axes = lightAxes(sun);
        ASSERT_LE(orthonormalError(axes), 1e-15) << sun.x << " " << sun.y << " " << sun.z;
        ASSERT_NEAR(glm::determinant(axes), 1.0, 1e-15);
        ASSERT_LE(glm::length(axes[2] - sun), 1e-15);
    }
}

TEST(LightBasis, StaysFiniteAndOrthonormalAroundTheNadir) {
    gnomon::testing::Random random(2);
    for (int i = 0; i < 20000; ++i) {
        const double angle = random.magnitude(1e-18, 0.3), turn = random.in(0.0, 6.3);
        const glm::dvec3 sun(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                             -std::cos(angle));
        // Where 1 + z has lost nearly all its digits.
        ASSERT_LE(orthonormalError(lightAxes(sun)), 1e-15) << angle;
    }
    EXPECT_LE(orthonormalError(lightAxes({0, 0, -1})), 1e-15);
}

TEST(LightBasis, TurnsNoFasterThanTheSunThroughZenithAndHorizon) {
    // Rotation of the axes for a sun that moves by `step`: the basis turns at most 1 / (1 + z)
    // times as fast about the sun, plus the sun's own motion.
    for (const double step : {1e-3, 1e-6, 1e-9})
        for (double azimuth = 0.0; azimuth < 360.0; azimuth += 7.5) {
            const auto across = [&](double elevation) {
                const double degrees = step / kRadiansPerDegree;
                for (int i = -3; i < 3; ++i) {
                    const glm::dmat3 a = lightAxes(fromAngles(azimuth, elevation + i * degrees));
                    const glm::dmat3 b =
                        lightAxes(fromAngles(azimuth, elevation + (i + 1) * degrees));
                    ASSERT_LE(difference(a, b), 2.5 * step + 1e-15)
                        << azimuth << " " << elevation << " " << step;
                }
            };
            across(90.0);
            across(0.0);
            across(45.0);
        }
    // Round the horizon and round the zenith.
    for (const double elevation : {-3.0, 0.0, 89.9999}) {
        const double step = 1e-3;
        for (int i = 0; i < 6300; ++i) {
            const double a = i * step / kRadiansPerDegree, b = (i + 1) * step / kRadiansPerDegree;
            ASSERT_LE(difference(lightAxes(fromAngles(a, elevation)),
                                 lightAxes(fromAngles(b, elevation))),
                      2.5 * step);
        }
    }
}

TEST(LightBasis, HasItsOriginAtTheAnchorAndItsZTowardsTheSunEverywhere) {
    gnomon::testing::Random random(3);
    for (int i = 0; i < 2000; ++i) {
        const Geodetic place{random.in(-180, 180), random.in(-90, 90), random.in(-100, 9000)};
        const Transform<Ecef, Enu> ecefFromAnchor = ecefFromEnu(place);
        const SunPosition sun = sunFromAngles(random.in(0, 360), random.in(0, 90), place);
        const Transform<Light, Ecef> light = lightFromEcef(ecefFromAnchor, sun.towards);
        // A product of 6e6 m and a rotation.
        ASSERT_LE(glm::length(light(ecefFromAnchor.origin()).xyz), 4e-9);
        ASSERT_LE(glm::length(light(sun.towards).xyz - glm::dvec3(0, 0, 1)), 1e-15);
        ASSERT_LE(orthonormalError(light.axes()), 2e-15);
    }
}

TEST(LightBasis, IsTheSameInTheAnchorsFrameEverywhereOnEarth) {
    for (const double elevation : {0.0, 1e-9, 3.0, 47.0, 89.99999, 90.0})
        for (const double azimuth : {0.0, 33.0, 180.0, 271.0}) {
            const glm::dmat3 expected = lightAxes(fromAngles(azimuth, elevation));
            for (const Geodetic place : {Geodetic{0, 0, 0}, Geodetic{0, 90, 0}, Geodetic{180, 0, 0},
                                         Geodetic{-180, 0, 0}, Geodetic{6.96, 50.94, 55},
                                         Geodetic{86.925, 27.988, 8848}, Geodetic{0, -90, 2800}}) {
                const Transform<Ecef, Enu> ecefFromAnchor = ecefFromEnu(place);
                const Transform<Light, Ecef> light =
                    lightFromEcef(ecefFromAnchor, sunFromAngles(azimuth, elevation, place).towards);
                const glm::dmat3 enuAxes =
                    glm::transpose(ecefFromAnchor.axes()) * glm::transpose(light.axes());
                EXPECT_LE(difference(enuAxes, expected), 2e-15)
                    << place.longitudeDegrees << " " << place.latitudeDegrees;
            }
        }
}
