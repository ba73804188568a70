#include "bench/contours.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

using namespace gnomon::bench;

namespace {

constexpr int kSize = 96;

std::vector<float> picture(const std::function<double(double x, double y)>& value) {
    std::vector<float> values;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            values.push_back(float(value(x, y)));
    return values;
}
std::vector<std::uint8_t> allLinked() {
    return std::vector<std::uint8_t>(kSize * kSize, kLinkRight | kLinkBelow);
}
// Dark on one side of a line, a pixel's ramp between.
auto halfPlane(double angle, double offset) {
    return [=](double x, double y) {
        const double d = std::cos(angle) * (x - 40) + std::sin(angle) * (y - 40) - offset;
        return std::min(std::max(0.5 + 0.5 * d, 0.0), 1.0);
    };
}

} // namespace

TEST(Contours, ParallelLinesAreAsFarApartAsTheyAreAtAnyAngle) {
    const auto links = allLinked();
    for (const double angle : {0.0, 0.3, 0.785, 1.2, 1.5707963, 2.6})
        for (const double offset : {0.25, 1.0, 5.5}) {
            const auto distance =
                contourDistance({kSize, kSize, links}, picture(halfPlane(angle, offset)),
                                picture(halfPlane(angle, 0.0)));
            ASSERT_TRUE(distance);
            // Where one line leaves the picture the other's end is the nearest.
            EXPECT_NEAR(*distance, offset, 0.02 * offset + 0.01) << angle;
        }
}

TEST(Contours, CirclesDifferByTheirRadii) {
    const auto circle = [](double radius) {
        return picture([=](double x, double y) {
            return std::min(std::max(0.5 + radius - std::hypot(x - 48.0, y - 47.0), 0.0), 1.0);
        });
    };
    const auto links = allLinked();
    EXPECT_NEAR(contourDistance({kSize, kSize, links}, circle(20.0), circle(23.0)).value(), 3.0,
                0.05);
    EXPECT_EQ(contourDistance({kSize, kSize, links}, circle(20.0), circle(20.0)).value(), 0.0);
}

TEST(Contours, NoneInEitherIsNoneAndNoneInOneIsTheMost) {
    const auto links = allLinked();
    const auto flat = picture([](double, double) { return 1.0; });
    EXPECT_FALSE(contourDistance({kSize, kSize, links}, flat, flat));
    EXPECT_EQ(contourDistance({kSize, kSize, links}, flat, picture(halfPlane(0, 0))),
              kMostEdgePixels);
}

TEST(Contours, NothingRunsBetweenSurfacesThatAreNotOne) {
    auto links = allLinked();
    for (int y = 0; y < kSize; ++y) // a seam where the line is
        for (int x = 38; x < 42; ++x)
            links[std::size_t(y * kSize + x)] = kLinkBelow;
    EXPECT_FALSE(contourDistance({kSize, kSize, links}, picture(halfPlane(0, 0)),
                                 picture(halfPlane(0, 0.4))));
}
