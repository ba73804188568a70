#include "tests/viewer/files.h"
#include "viewer/camera_path.h"
#include "viewer/fit_camera.h"
#include "viewer/place/place.h"
#include "viewer/scene.h"
#include "viewer/scene_placement.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;

namespace {

Result<Scene> open(const std::string& input, std::optional<Placement> placement = {}) {
    SceneOptions options;
    options.inputs = {input};
    options.placement = placement;
    return openScene(options);
}

std::string smallPlace(const test::Folder& folder, const Geodetic& at, const std::string& name) {
    PlaceOptions options;
    options.folder = folder / name;
    options.buildings = 3;
    options.at = at;
    EXPECT_TRUE(bool(writePlace(options)));
    return options.folder;
}

const Problem* noteIn(const Scene& scene) {
    for (const Problem& problem : scene.problems)
        if (problem.severity == Problem::Severity::Note)
            return &problem;
    return nullptr;
}

} // namespace

TEST(Scene, AmsterdamStandsOnTheEarthByItself) {
    GNOMON_NEEDS_DATA("tiles-amsterdam-b3dm");
    const auto scene = open(test::data("tiles-amsterdam-b3dm"));
    ASSERT_TRUE(bool(scene)) << scene.error().message();
    ASSERT_EQ(scene->layers.size(), 1u);
    EXPECT_EQ(scene->layers[0].kind, "tileset");
    EXPECT_FALSE(scene->layers[0].placedByUser);
    EXPECT_NEAR(scene->anchor.longitudeDegrees, 4.92, 0.05);
    EXPECT_NEAR(scene->anchor.latitudeDegrees, 52.39, 0.03);
    EXPECT_NEAR(scene->anchor.heightMetres, 44, 5); // the city's ground above the ellipsoid
    EXPECT_GT(scene->radiusMetres, 1000);
    EXPECT_LT(scene->radiusMetres, 10000);
    EXPECT_TRUE(scene->problems.empty());
}

TEST(Scene, MarsIsNotOnTheEarthUnlessPlaced) {
    GNOMON_NEEDS_DATA("tiles-mars-terrain-replace");
    const std::string mars = test::data("tiles-mars-terrain-replace");
    const auto refused = open(mars);
    ASSERT_FALSE(bool(refused));
    EXPECT_EQ(refused.error().kind, ErrorKind::Input);
    EXPECT_NE(refused.error().reason.find("--place"), std::string::npos);
    EXPECT_NE(refused.error().reason.find("--crs"), std::string::npos);

    const auto scene = open(mars, Placement{{6.96, 50.94, 50}, 0});
    ASSERT_TRUE(bool(scene)) << scene.error().message();
    EXPECT_TRUE(scene->layers[0].placedByUser);
    const Problem* note = noteIn(*scene);
    ASSERT_TRUE(note);
    EXPECT_NE(note->reason.find("up axis y"), std::string::npos);
    // 323 x 242 m across and 64 m high: lying flat.
    EXPECT_NEAR(scene->radiusMetres, std::hypot(162, 121), 5);
    EXPECT_GT(scene->heightMetres, 20);
    EXPECT_LT(scene->heightMetres, 66);
    EXPECT_GT(scene->anchor.heightMetres, 49);
}

TEST(Scene, UpIsWhatTheUserSays) {
    GNOMON_NEEDS_DATA("tiles-mars-terrain-replace");
    SceneOptions options;
    options.inputs = {test::data("tiles-mars-terrain-replace")};
    options.placement = Placement{{6.96, 50.94, 500}, 0};
    options.up = ModelUp::Z;
    const auto standing = openScene(options);
    ASSERT_TRUE(bool(standing));
    EXPECT_FALSE(noteIn(*standing));
    EXPECT_GT(standing->heightMetres, 150); // on its edge
}

TEST(Scene, FramesThatAreNoPlaceOnEarthAreKnown) {
    const auto box = [](glm::dvec3 centre, double half) -> BoundingVolume {
        return OrientedBox{{centre}, glm::dmat3(half)};
    };
    EXPECT_TRUE(standsOnEarth(box(ecefOf({4.9, 52.4, 40}).xyz, 1000)));
    EXPECT_TRUE(standsOnEarth(box(ecefOf({0, 90, -11000}).xyz, 10)));
    EXPECT_TRUE(standsOnEarth(box({0, 0, 0}, 6.4e6))); // the whole globe
    EXPECT_TRUE(standsOnEarth(makeRegion(-180, -90, 180, 90, 0, 9000)));
    EXPECT_FALSE(standsOnEarth(box({0, 0, 0}, 500)));
    EXPECT_FALSE(standsOnEarth(box({216, 32, 90}, 160)));             // Mars
    EXPECT_FALSE(standsOnEarth(box({356000, 5699000, 100}, 1000)));   // UTM
    EXPECT_FALSE(standsOnEarth(box({775000, 6610000, 100}, 1000)));   // Web Mercator
    EXPECT_FALSE(standsOnEarth(box({1842000, 5175000, 200}, 20000))); // Lambert, zone 46
    EXPECT_FALSE(standsOnEarth(box({0, 0, 0}, 1e5)));
}

TEST(Scene, PlacedFramesTurnClockwiseAndStandUp) {
    for (const Geodetic& where :
         {Geodetic{6.96, 50.94, 50}, Geodetic{0, 90, 0}, Geodetic{180, -45, 0}}) {
        const Transform<Enu, Ecef> enu = rigidInverse(ecefFromEnu(where));
        const auto at = [&](FrameUp up, glm::dvec3 p) {
            return enu(placedFrame({where, 90}, 2.0, up)(Point<Tile>{p})).xyz;
        };
        const auto near = [](glm::dvec3 a, glm::dvec3 b) { return glm::length(a - b) < 1e-8; };
        EXPECT_TRUE(near(at(FrameUp::Z, {0, 0, 0}), {0, 0, 2}));    // raised
        EXPECT_TRUE(near(at(FrameUp::Z, {0, 10, 0}), {10, 0, 2}));  // y looks east
        EXPECT_TRUE(near(at(FrameUp::Z, {10, 0, 0}), {0, -10, 2})); // x looks south
        EXPECT_TRUE(near(at(FrameUp::Z, {0, 0, 10}), {0, 0, 12}));
        EXPECT_TRUE(near(at(FrameUp::Y, {0, 10, 0}), {0, 0, 12}));
        EXPECT_TRUE(near(at(FrameUp::Y, {0, 0, -10}), {10, 0, 2}));
        EXPECT_TRUE(near(at(FrameUp::MinusY, {0, -10, 0}), {0, 0, 12}));
        EXPECT_TRUE(near(at(FrameUp::MinusY, {0, 0, 10}), {10, 0, 2}));
    }
}

TEST(Scene, AnUprightFrameTellsItsOriginAtAPoleByItsAxes) {
    for (const Geodetic& at :
         {Geodetic{6.96, 50.94, 100}, Geodetic{30, 90, 5}, Geodetic{-120, -90, 5}}) {
        Transform<Ecef, Enu> enu = ecefFromEnu(at);
        if (std::abs(at.latitudeDegrees) == 90) // as a file may have it: exactly on the axis
            enu.matrix[3].x = enu.matrix[3].y = 0.0;
        const auto origin = uprightOrigin(Transform<Ecef, Tile>{enu.matrix});
        ASSERT_TRUE(origin);
        EXPECT_NEAR(origin->longitudeDegrees, at.longitudeDegrees, 1e-9);
        EXPECT_NEAR(origin->heightMetres, at.heightMetres, 1e-6);
    }
    EXPECT_FALSE(uprightOrigin({})); // ECEF itself
    EXPECT_FALSE(uprightOrigin(placedFrame({{6.96, 50.94, 0}, 0}, 0, FrameUp::Y)));
}

TEST(Scene, GeometryTellsUpOnlyWhenItIsASheet) {
    const auto contentOf = [](std::vector<glm::vec3> positions,
                              std::vector<std::uint32_t> indices) {
        auto content = std::make_shared<TileContent>();
        content->meshes.emplace_back();
        content->meshes.back().positions = std::move(positions);
        content->meshes.back().indices = std::move(indices);
        return std::vector<std::shared_ptr<const TileContent>>{content};
    };
    const std::vector<std::uint32_t> quad{0, 1, 2, 0, 2, 3};
    EXPECT_EQ(upFromGeometry(contentOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, quad)),
              ModelUp::Z);
    EXPECT_EQ(upFromGeometry(contentOf({{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}, quad)),
              ModelUp::Y);
    EXPECT_FALSE(upFromGeometry(contentOf({{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}}, quad)));
    // A tetrahedron is closed.
    EXPECT_FALSE(upFromGeometry(contentOf({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                          {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2})));
    EXPECT_FALSE(upFromGeometry({}));
}

// Its anchor is where it was put, so all that is fixed to the anchor (shadow maps' texels, the sun
// by azimuth) is the same there.
TEST(Scene, TheBuiltInPlaceIsTheSameSceneAnywhere) {
    const test::Folder folder;
    const auto cologne = open(smallPlace(folder, {6.96, 50.94, 100}, "a"));
    ASSERT_TRUE(bool(cologne)) << cologne.error().message();
    const TileNode& root = cologne->layers[0].tileset->tree().node(TileTree::root());
    const glm::dvec3 centre =
        rigidInverse(cologne->ecefFromAnchor)(boundingSphere(root.volume).centre).xyz;
    int i = 0;
    for (const Geodetic& at :
         {Geodetic{30, -90, 100}, Geodetic{180, 0, 100}, Geodetic{86.9, 27.98, 8848}}) {
        const auto there = open(smallPlace(folder, at, std::to_string(++i)));
        ASSERT_TRUE(bool(there)) << there.error().message();
        EXPECT_LE(length(there->ecefFromAnchor.origin() - ecefOf(at)), 1e-7);
        const TileNode& node = there->layers[0].tileset->tree().node(TileTree::root());
        const glm::dvec3 c =
            rigidInverse(there->ecefFromAnchor)(boundingSphere(node.volume).centre).xyz;
        EXPECT_LE(glm::length(c - centre), 1e-6) << at.latitudeDegrees;
        // The terrain round it follows the ellipsoid, which is not as curved everywhere.
        EXPECT_NEAR(there->radiusMetres, cologne->radiusMetres, 2.0);
        EXPECT_NEAR(there->heightMetres, cologne->heightMetres, 0.1);
    }
}

TEST(Scene, TheBuiltInPlacesSceneAndFlightAreRead) {
    const test::Folder folder;
    const std::string place = smallPlace(folder, {6.96, 50.94, 100}, "a");
    const auto scene = open(place + "/place.scene.json");
    ASSERT_TRUE(bool(scene)) << scene.error().message();
    EXPECT_EQ(scene->layers.size(), 3u);
    EXPECT_EQ(scene->waters.size(), 1u);
    EXPECT_GT(scene->lamps.size(), 8u);
    for (const Problem& problem : scene->problems)
        EXPECT_NE(problem.severity, Problem::Severity::Error) << problem.reason;
    const auto flight = CameraPath::load(place + "/flight.json", 45.0);
    ASSERT_TRUE(bool(flight)) << flight.error().message();
    EXPECT_GT(flight->endSeconds(), 1);
}

TEST(Scene, WhatCannotBeOpenedIsLeftOutWhileTheRestIsShown) {
    const test::Folder folder;
    const std::string place = smallPlace(folder, {6.96, 50.94, 100}, "a");
    SceneOptions options;
    options.inputs = {folder / "none", place};
    const auto scene = openScene(options);
    ASSERT_TRUE(bool(scene));
    EXPECT_EQ(scene->layers.size(), 3u);
    std::vector<std::string> errors;
    for (const Problem& problem : scene->problems)
        if (problem.severity == Problem::Severity::Error)
            errors.push_back(problem.uri);
    EXPECT_EQ(errors, std::vector<std::string>{folder / "none"});

    options.inputs = {folder / "none"};
    ASSERT_FALSE(bool(openScene(options)));
    EXPECT_EQ(openScene(options).error().subject, folder / "none");
}

TEST(Scene, ASceneFilesLayersArePlacedEachByItself) {
    GNOMON_NEEDS_DATA("tiles-mars-terrain-replace");
    const test::Folder folder;
    const std::string mars =
        std::filesystem::absolute(test::data("tiles-mars-terrain-replace/tileset.json")).string();
    const std::string file = folder.write("two.scene.json", R"({"layers":[{"tileset":")" + mars +
                                                                R"(","place":[6.96,50.94,50]},
                             {"tileset":")" + mars + R"(","place":[6.97,50.94,50,90]},
                             {"terrain":"dem.tif"}], "ground":"none"})");
    const auto scene = open(file);
    ASSERT_TRUE(bool(scene)) << scene.error().message();
    ASSERT_EQ(scene->layers.size(), 2u);
    EXPECT_NEAR(scene->anchor.longitudeDegrees, 6.965, 0.006);
    EXPECT_FALSE(scene->ground->automatic);
    bool terrainSaid = false;
    for (const Problem& problem : scene->problems)
        terrainSaid |= problem.severity == Problem::Severity::Error &&
                       problem.uri.find("dem.tif") != std::string::npos;
    EXPECT_TRUE(terrainSaid);
}

TEST(FitCamera, TheWholeSceneIsInThePicture) {
    Scene scene;
    for (const double radius : {10.0, 1000.0, 50000.0})
        for (const auto& [width, height] : {std::pair{1280, 720}, std::pair{300, 900}}) {
            scene.anchor = {6.96, 50.94, 40};
            scene.ecefFromAnchor = ecefFromEnu(scene.anchor);
            scene.radiusMetres = radius;
            const Camera camera = fitCamera(scene, width, height, 45 * kRadiansPerDegree);
            double nearest = 1e9; // to the picture's edge, as a share of its half size
            for (int i = 0; i < 360; ++i) {
                const double angle = i * kRadiansPerDegree;
                const Vector<Ecef> p =
                    scene.ecefFromAnchor(
                        Point<Enu>{{radius * std::cos(angle), radius * std::sin(angle), 0}}) -
                    camera.position;
                const double depth = dot(camera.forward, p);
                ASSERT_GT(depth, 0);
                const double x = dot(camera.right, p) / depth / camera.tanHalfWidth();
                const double y = dot(camera.up, p) / depth / camera.tanHalfHeight();
                nearest = std::min({nearest, 1 - std::abs(x), 1 - std::abs(y)});
            }
            EXPECT_GT(nearest, 0);
            EXPECT_LT(nearest, 0.2); // and it fills it
            const Vector<Ecef> up = scene.ecefFromAnchor(Vector<Enu>{{0, 0, 1}});
            EXPECT_NEAR(std::asin(dot(camera.forward, up)) / kRadiansPerDegree, -35, 1e-9);
        }
}
