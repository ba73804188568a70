#include "viewer/camera_path.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <random>

using namespace gnomon;
using Json = nlohmann::json;

namespace {

Json key(double t, double lon, double lat, double height, double heading = 0, double pitch = 0) {
    return {{"t", t},           {"lon", lon},         {"lat", lat},
            {"height", height}, {"heading", heading}, {"pitch", pitch}};
}

Result<CameraPath> pathOf(const Json& keys, const char* interpolation = "smooth") {
    return CameraPath::parse(Json{{"keyframes", keys}, {"interpolation", interpolation}}.dump(),
                             "p.json", 45.0);
}

std::string refusal(const std::string& json) {
    const auto path = CameraPath::parse(json, "p.json", 45.0);
    EXPECT_FALSE(bool(path)) << json;
    return path ? "" : path.error().message();
}

double angleBetween(const Camera& a, const Camera& b) {
    const auto angle = [](Vector<Ecef> u, Vector<Ecef> v) {
        return std::atan2(length(cross(u, v)), dot(u, v));
    };
    return std::max({angle(a.right, b.right), angle(a.up, b.up), angle(a.forward, b.forward)});
}

const Json kTour = {key(0, 6.9, 50.9, 300, 350, -30), key(1, 6.91, 50.91, 280, 10, -20),
                    key(4, 6.92, 50.9, 350, 80, -60), key(4.5, 6.9205, 50.9001, 340, 85, -58)};

} // namespace

TEST(CameraPath, PassesExactlyThroughItsKeyframes) {
    for (const char* interpolation : {"smooth", "linear"}) {
        const auto path = pathOf(kTour, interpolation);
        ASSERT_TRUE(bool(path)) << path.error().message();
        for (const Json& k : kTour) {
            Camera expected;
            place(expected, {k["lon"], k["lat"], k["height"]}, {k["heading"], k["pitch"], 0});
            const Camera camera = path->sample(k["t"]).camera;
            EXPECT_LE(length(camera.position - expected.position), 1e-8);
            EXPECT_LE(angleBetween(camera, expected), 1e-14);
        }
    }
}

TEST(CameraPath, StaysAtItsEndsOutside) {
    const auto path = pathOf(kTour);
    ASSERT_TRUE(bool(path));
    EXPECT_EQ(path->startSeconds(), 0);
    EXPECT_EQ(path->endSeconds(), 4.5);
    EXPECT_EQ(path->sample(-5).camera.position.xyz, path->sample(0).camera.position.xyz);
    EXPECT_EQ(path->sample(99).camera.position.xyz, path->sample(4.5).camera.position.xyz);
}

// One-sided differences on both sides of a keyframe agree for a C1 curve, up to the step times the
// curvature; a corner of linear interpolation is there to see that the measure would notice.
TEST(CameraPath, SmoothHasNoCornersThoughKeyframesAreUneven) {
    constexpr double kStep = 1e-5;
    for (const bool smooth : {true, false}) {
        const auto path = pathOf(kTour, smooth ? "smooth" : "linear");
        ASSERT_TRUE(bool(path));
        for (const double t : {1.0, 4.0}) {
            const Camera before = path->sample(t - kStep).camera, at = path->sample(t).camera,
                         after = path->sample(t + kStep).camera;
            const double jump =
                length((after.position - at.position) - (at.position - before.position)) / kStep;
            const double turn = glm::length((after.forward.xyz - at.forward.xyz) -
                                            (at.forward.xyz - before.forward.xyz)) /
                                kStep;
            if (smooth) {
                EXPECT_LE(jump, 0.1); // m/s, of some 1000
                EXPECT_LE(turn, 1e-3);
            } else {
                EXPECT_GE(jump, 100);
                EXPECT_GE(turn, 0.05);
            }
        }
    }
}

TEST(CameraPath, LinearGoesStraightAtConstantSpeed) {
    const auto path = pathOf(kTour, "linear");
    ASSERT_TRUE(bool(path));
    const auto a = path->sample(1).camera, b = path->sample(4).camera;
    const auto middle = path->sample(2.5).camera;
    EXPECT_LE(glm::length(middle.position.xyz - 0.5 * (a.position.xyz + b.position.xyz)), 1e-8);
    EXPECT_NEAR(angleBetween(a, middle), angleBetween(middle, b), 1e-12);
}

TEST(CameraPath, AxesStayOrthonormal) {
    const auto path = pathOf(kTour);
    ASSERT_TRUE(bool(path));
    for (double t = 0; t <= 4.5; t += 0.01) {
        const Camera c = path->sample(t).camera;
        EXPECT_NEAR(length(c.right), 1, 1e-14);
        EXPECT_NEAR(dot(c.right, c.up), 0, 1e-14);
        EXPECT_NEAR(dot(cross(c.right, c.up), c.forward), -1, 1e-14);
    }
}

TEST(CameraPath, CrossesPoleAndAntimeridianWithoutADetour) {
    const struct {
        Json keys;
        double longest; // metres a second that the flight needs at most
    } cases[] = {
        {{key(0, 179.999, 10, 100, 90), key(1, -179.999, 10, 100, 90)}, 220},
        {{key(0, 30, 89.999, 100, 0), key(1, -150, 89.999, 100, 180)}, 224},
        {{key(0, 30, -89.999, 100, 180), key(1, -150, -89.999, 100, 0)}, 224},
    };
    for (const auto& each : cases) {
        const auto path = pathOf(each.keys);
        ASSERT_TRUE(bool(path));
        for (double t = 0; t < 1; t += 0.125) {
            const Camera a = path->sample(t).camera, b = path->sample(t + 0.125).camera;
            EXPECT_LE(length(b.position - a.position), each.longest * 0.125);
            EXPECT_LE(angleBetween(a, b), 1e-4); // looking straight ahead all the way
        }
    }
}

// The same flight in the anchor's frame, at two places: keyframes are written down as longitude,
// latitude and heading there, and come back the same.
TEST(CameraPath, IsTheSameFlightAnywhereOnEarth) {
    const Geodetic places[] = {
        {6.96, 50.94, 100}, {0, 90, 100}, {180, 0, 100}, {-70, -89.9999, 100}, {86.9, 27.98, 8848}};
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> across(-2000, 2000), turn(-180, 180);
    struct Pose {
        glm::dvec3 position;
        double heading, pitch, roll;
    };
    std::vector<Pose> poses;
    for (int i = 0; i < 6; ++i)
        poses.push_back({{across(random), across(random), 300 + 0.1 * across(random)},
                         turn(random),
                         turn(random) / 3,
                         turn(random) / 10});
    std::vector<std::vector<Camera>> flights;
    for (const Geodetic& where : places) {
        const Transform<Ecef, Enu> ecefFromAnchor = ecefFromEnu(where);
        Json keys = Json::array();
        for (std::size_t i = 0; i < poses.size(); ++i) {
            // The pose's axes in the anchor's frame: a camera at longitude 0, latitude 90 has
            // north to -x, so build them by hand.
            const double h = poses[i].heading * kRadiansPerDegree;
            const double p = poses[i].pitch * kRadiansPerDegree;
            const double r = poses[i].roll * kRadiansPerDegree;
            const glm::dvec3 forward(std::sin(h) * std::cos(p), std::cos(h) * std::cos(p),
                                     std::sin(p));
            const glm::dvec3 flat(std::cos(h), -std::sin(h), 0), top = glm::cross(flat, forward);
            Camera camera;
            camera.position = ecefFromAnchor(Point<Enu>{poses[i].position});
            camera.forward = ecefFromAnchor(Vector<Enu>{forward});
            camera.right = ecefFromAnchor(Vector<Enu>{std::cos(r) * flat - std::sin(r) * top});
            camera.up = ecefFromAnchor(Vector<Enu>{std::sin(r) * flat + std::cos(r) * top});
            const Geodetic g = geodeticOf(camera.position);
            const Orientation o = orientationOf(camera);
            Json k = key(double(i) * (1 + 0.3 * double(i)), g.longitudeDegrees, g.latitudeDegrees,
                         g.heightMetres, o.headingDegrees, o.pitchDegrees);
            k["roll"] = o.rollDegrees;
            keys.push_back(k);
        }
        const auto path = pathOf(keys);
        ASSERT_TRUE(bool(path)) << path.error().message();
        const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(ecefFromAnchor);
        flights.emplace_back();
        for (double t = 0; t <= path->endSeconds(); t += 0.05) {
            Camera c = path->sample(t).camera;
            c.position.xyz = anchorFromEcef(c.position).xyz;
            c.forward.xyz = anchorFromEcef(c.forward).xyz;
            c.up.xyz = anchorFromEcef(c.up).xyz;
            flights.back().push_back(c);
        }
    }
    for (const auto& flight : flights)
        for (std::size_t i = 0; i < flight.size(); ++i) {
            EXPECT_LE(length(flight[i].position - flights[0][i].position), 1e-6);
            EXPECT_LE(length(flight[i].forward - flights[0][i].forward), 1e-10);
            EXPECT_LE(length(flight[i].up - flights[0][i].up), 1e-10);
        }
}

TEST(CameraPath, FieldOfViewAndTimeNeverOvershoot) {
    Json keys = {key(0, 0, 0, 10), key(1, 0, 0, 10), key(2, 0, 0, 10), key(3, 0, 0, 10)};
    keys[0]["fov"] = 20;
    keys[1]["fov"] = 20;
    keys[2]["fov"] = 90;
    keys[3]["fov"] = 90;
    keys[1]["time"] = "2021-07-14T12:00Z"; // not every keyframe needs one
    keys[3]["time"] = "2021-07-14T18:00Z";
    const auto path = pathOf(keys);
    ASSERT_TRUE(bool(path)) << path.error().message();
    double before = 0, clock = 0;
    for (double t = 0; t <= 3; t += 0.01) {
        const auto sample = path->sample(t);
        const double fov = sample.camera.verticalFovRadians / kRadiansPerDegree;
        EXPECT_GE(fov, std::max(before, 20.0) - 1e-9);
        EXPECT_LE(fov, 90 + 1e-9);
        before = fov;
        ASSERT_TRUE(sample.time);
        EXPECT_GE(sample.time->seconds, clock);
        clock = sample.time->seconds;
    }
    EXPECT_EQ(formatUtc(*path->sample(0).time), "2021-07-14T12:00:00Z");
    EXPECT_EQ(formatUtc(*path->sample(2).time), "2021-07-14T15:00:00Z");
    EXPECT_EQ(formatUtc(*path->sample(3).time), "2021-07-14T18:00:00Z");
}

TEST(CameraPath, OneKeyframeStandsStill) {
    const auto path = CameraPath::parse(
        R"({"keyframes":[{"t":3,"lon":1,"lat":2,"height":3,"heading":4,"pitch":5}]})", "p.json",
        30.0);
    ASSERT_TRUE(bool(path)) << path.error().message();
    EXPECT_EQ(path->sample(0).camera.position.xyz, path->sample(9).camera.position.xyz);
    EXPECT_NEAR(path->sample(0).camera.verticalFovRadians, 30 * kRadiansPerDegree, 1e-15);
    EXPECT_FALSE(path->sample(0).time);
}

TEST(CameraPath, RefusesWhatIsWrongAndSaysWhere) {
    const auto expect = [](const std::string& json, const std::string& words) {
        const std::string message = refusal(json);
        EXPECT_TRUE(message.starts_with("p.json: ")) << message;
        EXPECT_NE(message.find(words), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos);
    };
    const std::string good = R"("lon":1,"lat":2,"height":3,"heading":4,"pitch":5)";
    expect("", "not valid JSON");
    expect("{", "not valid JSON");
    expect("[1]", "must be an object");
    expect("{}", "\"keyframes\"");
    expect(R"({"keyframes":[]})", "at least one");
    expect(R"({"keyframes":{}})", "at least one");
    expect(R"({"keyframes":[7]})", "keyframe 0");
    expect(R"({"keyframes":[{"t":0,)" + good + R"(},{"t":0,)" + good + "}]}", "keyframe 1");
    expect(R"({"keyframes":[{"t":1,)" + good + R"(},{"t":0,)" + good + "}]}", "later");
    expect(R"({"keyframes":[{"t":NaN,)" + good + "}]}", "not valid JSON");
    expect(R"({"keyframes":[{"t":1e999,)" + good + "}]}", "not valid JSON");
    expect(R"({"keyframes":[{"t":null,)" + good + "}]}", "\"t\" must be a number");
    expect(R"({"keyframes":[{)" + good + "}]}", "\"t\" is missing");
    expect(R"({"keyframes":[{"t":0,"lon":1,"lat":91,"height":3,"heading":4,"pitch":5}]})",
           "\"lat\"");
    expect(R"({"keyframes":[{"t":0,"lon":1,"lat":2,"height":1e30,"heading":4,"pitch":5}]})",
           "\"height\"");
    expect(R"({"keyframes":[{"t":0,"fov":180,)" + good + "}]}", "\"fov\"");
    expect(R"({"keyframes":[{"t":0,"time":"noon",)" + good + "}]}", "\"time\"");
    expect(R"({"keyframes":[{"t":0,"rol":1,)" + good + "}]}", "\"rol\"");
    expect(R"({"interpolation":"cubic","keyframes":[{"t":0,)" + good + "}]}", "interpolation");
    expect("<kml></kml>", "KML");
    expect(std::string(100000, '['), "not valid JSON");
}
