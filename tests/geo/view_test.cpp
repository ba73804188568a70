#include "geo/view.h"

#include <gtest/gtest.h>

#include <limits>

using namespace gnomon;

namespace {

Camera testCamera() {
    Camera camera;
    place(camera, {6.958, 50.941, 500.0}, {40.0, -10.0, 0.0});
    camera.verticalFovRadians = 60.0 * kRadiansPerDegree;
    camera.widthPixels = 1600;
    camera.heightPixels = 900;
    return camera;
}

// right, up and ahead of the camera, in metres
Point<Ecef> seen(const Camera& c, double right, double up, double ahead) {
    return c.position + right * c.right + up * c.up + ahead * c.forward;
}

} // namespace

TEST(View, SidePlanesAreTheEdgesOfThePicture) {
    const Camera camera = testCamera();
    const View view = perspectiveView(camera);
    ASSERT_EQ(view.planes.size(), 4u);
    const double x = camera.tanHalfWidth(), y = camera.tanHalfHeight(), d = 1000.0;
    const auto sees = [&](double right, double up) {
        return classify(Sphere{seen(camera, right, up, d), 0.0}, view.planes) !=
               Containment::Outside;
    };
    EXPECT_TRUE(sees(0, 0));
    for (const double s : {-1.0, 1.0}) {
        EXPECT_TRUE(sees(0.999 * s * x * d, 0));
        EXPECT_FALSE(sees(1.001 * s * x * d, 0));
        EXPECT_TRUE(sees(0, 0.999 * s * y * d));
        EXPECT_FALSE(sees(0, 1.001 * s * y * d));
    }
    for (const Plane& plane : view.planes)
        EXPECT_NEAR(length(plane.normal), 1.0, 1e-15);
}

TEST(View, ScreenSpaceErrorIsTheErrorsHeightInPixels) {
    const Camera camera = testCamera();
    const View view = perspectiveView(camera);
    const Sphere sphere{seen(camera, 0, 0, 1100.0), 100.0};
    // ge · H / (d · 2 tan(fovy / 2))
    const double expected = 8.0 * 900.0 / (1000.0 * 2.0 * std::tan(30.0 * kRadiansPerDegree));
    EXPECT_NEAR(screenSpaceError(view, sphere, 8.0), expected, 1e-9);
    // and that is what the projection makes of it
    const double pixels = 8.0 / 1000.0 / camera.tanHalfHeight() * 450.0;
    EXPECT_NEAR(expected, pixels, 1e-9);
}

TEST(View, ScreenSpaceErrorIsInfiniteInsideUnlessThereIsNoError) {
    const Camera camera = testCamera();
    const View view = perspectiveView(camera);
    const Sphere around{camera.position, 10.0};
    EXPECT_EQ(screenSpaceError(view, around, 0.1), std::numeric_limits<double>::infinity());
    EXPECT_EQ(screenSpaceError(view, around, 0.0), 0.0);
}

TEST(View, ScreenSpaceErrorStaysFiniteAndHugeAsTheDistanceGoesToZero) {
    const Camera camera = testCamera();
    const View view = perspectiveView(camera);
    double last = 0.0;
    for (double d = 1.0; d > 1e-8; d *= 0.1) {
        const Sphere near{seen(camera, 0, 0, d), 0.0};
        const double error = screenSpaceError(view, near, 1e-3);
        ASSERT_TRUE(std::isfinite(error));
        ASSERT_GE(error, last);
        last = error;
    }
    EXPECT_GT(last, 1e5);
}

TEST(View, OrthographicErrorDependsOnThePixelAlone) {
    View view;
    view.pixelMetres = 0.25;
    for (const double distance : {0.0, 10.0, 1e6})
        EXPECT_DOUBLE_EQ(screenSpaceError(view, Sphere{{{distance, 0, 0}}, 1.0}, 3.0), 12.0);
    EXPECT_EQ(screenSpaceError(view, Sphere{}, 0.0), 0.0);
}

TEST(View, WeightMultipliesTheError) {
    View view = perspectiveView(testCamera());
    const Sphere sphere{seen(testCamera(), 0, 0, 1000.0), 1.0};
    const double full = screenSpaceError(view, sphere, 5.0);
    view.weight = 0.25;
    EXPECT_DOUBLE_EQ(screenSpaceError(view, sphere, 5.0), 0.25 * full);
    view.weight = 0.0;
    EXPECT_EQ(screenSpaceError(view, Sphere{view.eye, 1.0}, 5.0), 0.0);
}

TEST(View, AnErrorThatIsNotANumberOrNegativeAsksForNothing) {
    const View view = perspectiveView(testCamera());
    EXPECT_EQ(screenSpaceError(view, Sphere{}, std::numeric_limits<double>::quiet_NaN()), 0.0);
    EXPECT_EQ(screenSpaceError(view, Sphere{}, -4.0), 0.0);
}
