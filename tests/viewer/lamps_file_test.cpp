// Lamps from GeoJSON: what is read, what is refused and how it is said, and where they end up.
#include "viewer/lamps_file.h"

#include "tests/streaming/glb_builder.h"
#include "tests/viewer/files.h"
#include "viewer/lamps.h"
#include "viewer/scene.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

using namespace gnomon;
using namespace gnomon::test;

namespace {

std::string collection(const std::string& features) {
    return R"({"type":"FeatureCollection","features":[)" + features + "]}";
}
std::string point(const std::string& coordinates, const std::string& properties = "{}") {
    return R"({"type":"Feature","geometry":{"type":"Point","coordinates":)" + coordinates +
           R"(},"properties":)" + properties + "}";
}
std::string messageOf(const std::string& text) {
    const auto file = parseLampsFile(text, "lamps.geojson");
    return file ? "" : file.error().message();
}

} // namespace

TEST(LampsFile, ReadsPointsAndTheirProperties) {
    const auto file = parseLampsFile(
        collection(point("[6.96, 50.94]") + "," +
                   point("[6.97, 50.95, 61.5]",
                         R"({"facing":"all","power":[3,2,1],"range":20,"height":4,"id":7})") +
                   R"(,{"type":"Feature","properties":null,
                      "geometry":{"type":"LineString","coordinates":[[0,0],[1,1]]}})"),
        "lamps.geojson");
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->entries.size(), 2u);
    EXPECT_EQ(file->others, 1u);
    const LampsFile::Entry &a = file->entries[0], &b = file->entries[1];
    EXPECT_TRUE(a.onLevel);
    EXPECT_EQ(a.heightMetres, 6.0);
    EXPECT_FALSE(a.allRound);
    EXPECT_EQ(a.lamp.power, glm::vec3(100.0f));
    EXPECT_FALSE(b.onLevel);
    EXPECT_EQ(b.heightMetres, 4.0);
    EXPECT_TRUE(b.allRound);
    EXPECT_EQ(b.lamp.rangeMetres, 20.0);
    EXPECT_EQ(b.lamp.power, glm::vec3(3, 2, 1));

    const Lamp down = placedLamp(a, 55.0), round = placedLamp(b, 55.0);
    EXPECT_NEAR(geodeticOf(down.position).heightMetres, 61.0, 1e-6);
    EXPECT_NEAR(dot(down.facing, ellipsoidNormal(down.position)), -1.0, 1e-12);
    EXPECT_NEAR(geodeticOf(round.position).heightMetres, 65.5, 1e-6);
    EXPECT_EQ(round.facing.xyz, glm::dvec3(0.0));
}

TEST(LampsFile, SaysInOneLineWhatIsWrong) {
    const std::pair<std::string, const char*> cases[] = {
        {"{", "not valid JSON"},
        {"[]", "\"features\" must be a list"},
        {R"({"features":{}})", "\"features\" must be a list"},
        {collection("7"), "feature 1: \"geometry\" is missing"},
        {collection(point("[6.9]")), "feature 1: \"coordinates\" must be [lon, lat]"},
        {collection(point("\"x\"")), "\"coordinates\" must be a list"},
        {collection(point("[6.9,50.9]") + "," + point("[6.9,95]")),
         "feature 2: \"coordinates\" are not a place"},
        {collection(point("[6.9,50.9,1e300]")), "are not a place"},
        {collection(point("[6.9,50.9]", R"({"range":-1})")), "\"range\" is -1"},
        {collection(point("[6.9,50.9]", R"({"height":"tall"})")), "\"height\" must be a number"},
        {collection(point("[6.9,50.9]", R"({"power":[1,2]})")), "\"power\" must be"},
        {collection(point("[6.9,50.9]", R"({"power":[1,2,-3]})")), "\"power\" must be"},
        {collection(point("[6.9,50.9]", R"({"power":-3})")), "\"power\" is -3"},
        {collection(point("[6.9,50.9]", R"({"facing":"up"})")), "\"facing\" must be"},
    };
    for (const auto& [text, message] : cases) {
        const std::string said = messageOf(text);
        EXPECT_NE(said.find(message), std::string::npos) << text << " said " << said;
        EXPECT_EQ(said.find('\n'), std::string::npos);
        EXPECT_EQ(said.rfind("lamps.geojson", 0), 0u) << said;
    }
}

TEST(LampsFile, ReadsPointsOfAnyCoordinateReferenceSystem) {
    Folder folder;
    const std::string path =
        folder.write("lamps.geojson",
                     R"({"type":"FeatureCollection",
        "crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}},
        "features":[)" +
                         point("[356760.24, 5645168.54]",
                               R"({"Height":"7.5","power":[3,2,1],"range":30,"facing":"all"})") +
                         "," + point("[356770.24, 5645168.54]") + "," +
                         point("[356780.24, 5645168.54]", R"({"facing":"up"})") + "]}");
    const auto file = readLampsFile(path);
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->entries.size(), 2u);
    EXPECT_EQ(file->crs, "EPSG:25832");
    const LampsFile::Entry& lamp = file->entries[0];
    EXPECT_NEAR(lamp.foot.longitudeDegrees, 6.9612, 1e-4);
    EXPECT_NEAR(lamp.foot.latitudeDegrees, 50.94, 1e-3);
    EXPECT_TRUE(lamp.onLevel);
    EXPECT_EQ(lamp.heightMetres, 7.5);
    EXPECT_EQ(lamp.lamp.power, glm::vec3(3, 2, 1));
    EXPECT_EQ(lamp.lamp.rangeMetres, 30.0);
    EXPECT_TRUE(lamp.allRound);
    EXPECT_EQ(file->entries[1].heightMetres, 6.0);
    EXPECT_NEAR(
        length(placedLamp(lamp, 50.0).position - placedLamp(file->entries[1], 51.5).position), 10.0,
        0.01);
    ASSERT_EQ(file->leftOut.size(), 1u); // one that is wrong is said, the rest is shown
    EXPECT_NE(file->leftOut[0].message().find("\"facing\" must be"), std::string::npos);
    // Without a system of its own: the one given.
    FeatureOptions options;
    options.crs = "EPSG:25832";
    options.heights = Heights::Egm96;
    const auto given = readLampsFile(
        folder.write("plain.geojson", collection(point("[356760.24, 5645168.54, 50]"))), options);
    ASSERT_TRUE(given) << given.error().message();
    EXPECT_NEAR(given->entries.at(0).foot.longitudeDegrees, lamp.foot.longitudeDegrees, 1e-9);
    EXPECT_FALSE(given->entries[0].onLevel);
    EXPECT_NEAR(given->entries[0].foot.heightMetres, 96.6, 0.5);
    const auto missing = readLampsFile(folder / "none.gpkg");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().message().find('\n'), std::string::npos);
}

TEST(LampsFile, SaysWhenNotAllCanBeLitAtOnce) {
    std::string features = point("[6.96, 50.94]");
    for (int i = 1; i < kMaxLampHemispheres; ++i)
        features += "," + point("[6.96, 50.94]");
    EXPECT_TRUE(parseLampsFile(collection(features), "lamps.geojson")->notes.empty());
    const auto more =
        parseLampsFile(collection(features + "," + point("[6.96, 50.94]")), "l.geojson");
    ASSERT_EQ(more->notes.size(), 1u);
    EXPECT_NE(more->notes[0].find("33 lamps, of which at most 32 are lit"), std::string::npos);
}

TEST(LampsFile, IsALayerOfASceneAndAnInputOfItsOwn) {
    Folder folder;
    GlbBuilder builder;
    builder.triangles({-5, 0, -5, 5, 0, -5, 5, 0, 5, -5, 0, 5}, {0, 2, 1, 0, 3, 2});
    const std::string model = folder.write("model.glb", builder.text());
    const std::string lamps = folder.write("lamps.geojson", collection(point("[6.96, 50.94]")));
    SceneOptions options;
    options.inputs = {folder.write("a.scene.json", R"({"layers":[
        {"model":"model.glb","place":[6.96,50.94,55]},{"lamps":"lamps.geojson"}]})")};
    for (int i = 0; i < 2; ++i) {
        const auto scene = openScene(options);
        ASSERT_TRUE(scene) << scene.error().message();
        for (const Problem& problem : scene->problems)
            EXPECT_EQ(problem.severity, Problem::Severity::Note) << problem.reason;
        ASSERT_EQ(scene->lamps.size(), 1u);
        EXPECT_NEAR(geodeticOf(scene->lamps[0].position).heightMetres,
                    scene->anchor.heightMetres + 6.0, 1e-6);
        options.inputs = {model, "lamps=" + lamps};
        options.placement = Placement{{6.96, 50.94, 55.0}, 0.0};
    }
    options.inputs = {model, "lamps=" + folder.write("bad.geojson", "{}")};
    const auto scene = openScene(options); // the rest is shown, and the fault named
    ASSERT_TRUE(scene);
    EXPECT_TRUE(scene->lamps.empty());
    ASSERT_FALSE(scene->problems.empty());
    EXPECT_EQ(scene->problems.back().severity, Problem::Severity::Error);
}

TEST(Lamps, ComeUpOverADegreeBelowTheHorizon) {
    EXPECT_EQ(lampShare(10.0), 0.0);
    EXPECT_EQ(lampShare(0.0), 0.0);
    EXPECT_EQ(lampShare(-1.0), 1.0);
    EXPECT_EQ(lampShare(-40.0), 1.0);
    double before = 0.0;
    for (double e = 0.5; e > -1.5; e -= 0.01) {
        EXPECT_GE(lampShare(e), before);
        EXPECT_LT(lampShare(e) - before, 0.02);
        before = lampShare(e);
    }
}

TEST(Lamps, ThatAreLitAreTheNearestInView) {
    const Transform<Ecef, Enu> at = ecefFromEnu({6.96, 50.94, 55.0});
    std::vector<Lamp> lamps;
    for (int i = -100; i < 100; ++i) { // a row to the north
        Lamp& lamp = lamps.emplace_back();
        lamp.position = at(Point<Enu>{{0, 10.0 * i + 5.0, 6}});
        lamp.rangeMetres = 1.5;
        if (i % 2 == 0)
            lamp.facing = at(Vector<Enu>{{0, 0, -1}});
    }
    Camera camera;
    place(camera, {6.96, 50.94, 60.0}, {0.0, 0.0, 0.0});
    const std::vector<std::size_t> live = liveLamps(lamps, camera);
    int hemispheres = 0;
    for (std::size_t i = 0; i < live.size(); ++i) {
        EXPECT_EQ(live[i], 100 + i); // northwards, in order
        hemispheres += lamps[live[i]].facing.xyz == glm::dvec3(0.0) ? 2 : 1;
    }
    EXPECT_GE(hemispheres, kMaxLampHemispheres - 1);
    EXPECT_LE(hemispheres, kMaxLampHemispheres);
    // A brighter one farther away comes before.
    lamps[105].power = glm::vec3(1e6f);
    EXPECT_EQ(liveLamps(lamps, camera).front(), 105u);
}

// The view that its casters are selected by: all within its range, nothing far off.
TEST(Lamps, WantTheTilesThatTheyReach) {
    const Transform<Ecef, Enu> at = ecefFromEnu({6.96, 50.94, 55.0});
    Lamp lamp;
    lamp.position = at(Point<Enu>{{0, 0, 6}});
    lamp.rangeMetres = 30.0;
    Camera camera;
    place(camera, {6.96, 50.94, 60.0}, {0.0, 0.0, 0.0});
    const View view = lampView(lamp, perspectiveView(camera));
    const auto sees = [&](const glm::dvec3& p) {
        return classify(BoundingVolume(Sphere{at(Point<Enu>{p}), 1.0}), view.planes) !=
               Containment::Outside;
    };
    EXPECT_TRUE(sees({0, -29, 6})); // behind the camera
    EXPECT_TRUE(sees({20, 20, 0}));
    EXPECT_FALSE(sees({0, 60, 6}));
    EXPECT_FALSE(sees({-60, 0, 6}));
    EXPECT_EQ(view.pixelsPerRadian, perspectiveView(camera).pixelsPerRadian);
}
