#include "streaming/terrain/ground_heights.h"
#include "tests/viewer/files.h"
#include "viewer/capture_plan.h"
#include "viewer/frame_report.h"
#include "viewer/shot.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace gnomon;

namespace {

Scene cologne() {
    Scene scene;
    scene.anchor = {6.96, 50.94, 50};
    scene.ecefFromAnchor = ecefFromEnu(scene.anchor);
    scene.radiusMetres = 500;
    return scene;
}

Shot firstShot(const PictureOptions& options, const Scene& scene, double seconds = 0) {
    const auto shots = Shots::create(options);
    EXPECT_TRUE(bool(shots));
    return shots->at(seconds, scene);
}

} // namespace

TEST(Shot, TheSunIsTheKeyframesThenTheCommandLinesThenTheScenes) {
    const test::Folder folder;
    Scene scene = cologne();
    PictureOptions options;
    EXPECT_NEAR(firstShot(options, scene).sun.azimuthDegrees, kDefaultSun.azimuthDegrees, 1e-9);
    EXPECT_TRUE(Shots::create(options)->usesDefaultSun(scene));
    scene.time = *parseTime("2021-06-21T12:00Z");
    EXPECT_EQ(formatUtc(*firstShot(options, scene).time), "2021-06-21T12:00:00Z");
    EXPECT_FALSE(Shots::create(options)->usesDefaultSun(scene));
    options.sun = *parseTime("2021-06-21T15:00Z");
    EXPECT_EQ(formatUtc(*firstShot(options, scene).time), "2021-06-21T15:00:00Z");
    options.camera = CameraFile{folder.write("p.json", R"({"keyframes":[
            {"t":10,"lon":6.96,"lat":50.94,"height":300,"heading":0,"pitch":0,"time":"2021-06-21T06:00Z"},
            {"t":12,"lon":6.96,"lat":50.94,"height":300,"heading":0,"pitch":0,"time":"2021-06-21T08:00Z"}]})")};
    EXPECT_EQ(formatUtc(*firstShot(options, scene).time), "2021-06-21T06:00:00Z");
    EXPECT_EQ(formatUtc(*firstShot(options, scene, 1.0).time), "2021-06-21T07:00:00Z");
    EXPECT_EQ(Shots::create(options)->lengthSeconds(), 2.0);
    options.sun = SunAngles{100, 20};
    options.camera = {};
    EXPECT_EQ(firstShot(options, scene).time->seconds, scene.time->seconds); // of the flood
    EXPECT_NEAR(firstShot(options, scene).sun.elevationDegrees, 20, 1e-9);
    options.sun = *parseTime("2021-06-21T15:00Z");
    options.fixedSun = SunAngles{100, 30};
    EXPECT_EQ(formatUtc(*firstShot(options, scene).time), "2021-06-21T15:00:00Z");
    EXPECT_NEAR(firstShot(options, scene).sun.elevationDegrees, 30, 1e-9);
}

TEST(Shot, ATourAboveTheGroundStandsOnTheScenesTerrainElseOnItsBase) {
    const test::Folder folder;
    PictureOptions options;
    options.camera = CameraFile{folder.write(
        "t.kml", R"(<kml xmlns:gx="http://www.google.com/kml/ext/2.2"><gx:Tour><gx:Playlist>
        <gx:FlyTo><Camera><longitude>6.96</longitude><latitude>50.94</latitude>
        <altitude>10</altitude><altitudeMode>relativeToGround</altitudeMode></Camera></gx:FlyTo>
        </gx:Playlist></gx:Tour></kml>)")};
    const auto height = [&](const Scene& scene) {
        return geodeticOf(firstShot(options, scene).camera.position).heightMetres;
    };
    Scene scene = cologne();
    EXPECT_NEAR(height(scene), 60, 1e-6);
    scene.groundHeights = flatGround(100);
    EXPECT_NEAR(height(scene), 110, 1e-6);
}

TEST(Shot, ATourIsAsLongAsItsStepsUnlessFramesOrDurationSayOtherwise) {
    const test::Folder folder;
    CaptureOptions options;
    const std::string view = "<Camera><longitude>6.96</longitude><latitude>50.94</latitude>"
                             "<altitudeMode>absolute</altitudeMode></Camera>";
    options.picture.camera = CameraFile{folder.write(
        "t.kml", R"(<kml xmlns:gx="http://www.google.com/kml/ext/2.2"><gx:Tour><gx:Playlist>
        <gx:FlyTo>)" +
                     view + R"(</gx:FlyTo><gx:Wait><gx:duration>0.5</gx:duration></gx:Wait>
        <gx:FlyTo><gx:duration>1.5</gx:duration>)" +
                     view + R"(</gx:FlyTo>
        </gx:Playlist></gx:Tour></kml>)")};
    options.framesPerSecond = 10;
    const double seconds = Shots::create(options.picture)->lengthSeconds();
    EXPECT_EQ(seconds, 2.0);
    const auto frames = [&] {
        return planFrames(options, *OutputName::parse("f{frame}.png"), seconds)->size();
    };
    EXPECT_EQ(frames(), 20u);
    options.durationSeconds = 1.0;
    EXPECT_EQ(frames(), 10u);
    options.frames = FrameRange{0, 9, 3};
    EXPECT_EQ(frames(), 4u);
}

TEST(Shot, TheCommandLinesCameraWinsOverTheScenes) {
    Scene scene = cologne();
    scene.camera = SceneCamera{{6.9, 50.9, 200}, {10, -20, 0}, 30.0};
    PictureOptions options;
    Shot shot = firstShot(options, scene);
    EXPECT_NEAR(geodeticOf(shot.camera.position).heightMetres, 200, 1e-6);
    EXPECT_NEAR(shot.camera.verticalFovRadians, 30 * kRadiansPerDegree, 1e-12);
    options.camera = FixedCamera{{6.95, 50.95, 400}, {0, -90, 0}};
    options.fovDegrees = 60;
    options.widthPixels = 33;
    shot = firstShot(options, scene);
    EXPECT_NEAR(geodeticOf(shot.camera.position).heightMetres, 400, 1e-6);
    EXPECT_NEAR(shot.camera.verticalFovRadians, 60 * kRadiansPerDegree, 1e-12);
    EXPECT_EQ(shot.camera.widthPixels, 33);
}

TEST(Shot, TheCommandLinesGroundWinsOverTheScenes) {
    Scene scene = cologne();
    scene.ground = GroundChoice{false, 12.0};
    PictureOptions options;
    EXPECT_EQ(frameOptionsFor(options, scene).groundHeightMetres, 12.0);
    options.groundGiven = true;
    EXPECT_TRUE(frameOptionsFor(options, scene).groundAuto);
}

TEST(FrameReport, HasTheContractsKeys) {
    FrameReport report;
    report.renderer = "test";
    report.settingsHash = settingsHash(PictureOptions{});
    ReportedFrame frame;
    place(frame.camera, {6.96, 50.94, 300}, {30, -20, 0});
    frame.time = *parseTime("2021-06-21T12:00Z");
    frame.facts.cascades.resize(2);
    frame.facts.depthMs = {1, 2};
    frame.facts.missing = {"a.b3dm"};
    frame.facts.gpuBytes = 3'000'000;
    report.frames.push_back(frame);
    report.skipped.push_back({"a\xff.b3dm", "gone"}); // a name that is no UTF-8
    const auto json = nlohmann::json::parse(report.json());
    for (const char* key : {"version", "renderer", "settings_hash", "frames", "skipped",
                            "time_to_full_detail_ms", "peak_rss_mb", "peak_gpu_mb"})
        EXPECT_TRUE(json.contains(key)) << key;
    const auto& f = json["frames"][0];
    for (const char* key : {"index", "time_utc", "camera", "sun", "tiles", "sse", "bytes",
                            "triangles", "draws", "cpu_ms", "gpu_ms", "cascades"})
        EXPECT_TRUE(f.contains(key)) << key;
    EXPECT_EQ(f["time_utc"], "2021-06-21T12:00:00Z");
    EXPECT_NEAR(f["camera"]["heading"].get<double>(), 30, 1e-9);
    EXPECT_EQ(f["tiles"]["missing"], nlohmann::json({"a.b3dm"}));
    EXPECT_EQ(f["gpu_ms"]["depth"].size(), 2u);
    EXPECT_FALSE(f["gpu_ms"].contains("resolve"));
    EXPECT_EQ(f["cascades"].size(), 2u);
    EXPECT_EQ(json["peak_gpu_mb"], 3.0);
    EXPECT_GT(json["peak_rss_mb"].get<double>(), 1.0);
    EXPECT_TRUE(json["time_to_full_detail_ms"].is_null());
    report.frames.front().facts.resolveMs = 0.5;
    EXPECT_EQ(nlohmann::json::parse(report.json())["frames"][0]["gpu_ms"]["resolve"], 0.5);
}

TEST(FrameReport, TheHashChangesWithWhatChangesThePicture) {
    PictureOptions a, b;
    EXPECT_EQ(settingsHash(a), settingsHash(b));
    b.frame.shadows.mapSize = 4096;
    EXPECT_NE(settingsHash(a), settingsHash(b));
    b = a;
    b.sun = SunAngles{1, 2};
    EXPECT_NE(settingsHash(a), settingsHash(b));
    b = a;
    b.scene.inputs = {"x"};
    EXPECT_NE(settingsHash(a), settingsHash(b));
    b = a;
    b.timeoutSeconds = 5; // no pixel depends on it
    EXPECT_EQ(settingsHash(a), settingsHash(b));
}
