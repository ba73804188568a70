// Tilesets whose coordinates are those of a map projection, held against PROJ point by point.
#include "geo/crs.h"
#include "streaming/inventory.h"
#include "tests/viewer/files.h"
#include "tests/viewer/houses_support.h"
#include "viewer/crs_frame.h"
#include "viewer/scene.h"
#include "viewer/scene_placement.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon {

using namespace test;

namespace {

struct City {
    const char* crs;
    glm::dvec3 centre; // in the system
};
const City kLyon{"EPSG:3946", {1842000, 5175000, 220}};
const City kCologne{"EPSG:3857", {774800, 6610000, 100}};

// One house a tile, 100 m across, on a cross of places up to 10 km from the centre. `rootTransform`
// places the root; the houses' own coordinates stay small.
const std::vector<glm::dvec2> kPlaces = {{0, 0},     {10000, 0},  {-10000, 0},
                                         {0, 10000}, {0, -10000}, {7000, 7000}};
const House kHouse{{-50, -50, 0}, {50, 50, 30}, 0};

Json matrix(const glm::dmat4& m) {
    Json out = Json::array();
    for (int i = 0; i < 16; ++i) {
        out.push_back(m[i / 4][i % 4]);
    }
    return out;
}

glm::dmat4 shiftedAndTurned(const glm::dvec3& by, double degrees) {
    const double a = degrees * kRadiansPerDegree;
    glm::dmat4 m(1.0);
    m[0] = {std::cos(a), std::sin(a), 0, 0};
    m[1] = {-std::sin(a), std::cos(a), 0, 0};
    m[3] = glm::dvec4(by, 1.0);
    return m;
}

Json boxJson(const glm::dvec3& centre, const glm::dvec3& half) {
    return {{"box", {centre.x, centre.y, centre.z, half.x, 0, 0, 0, half.y, 0, 0, 0, half.z}}};
}

Json tilesetOf(Json root) {
    return {{"asset", {{"version", "1.0"}, {"gltfUpAxis", "Z"}}},
            {"geometricError", 100},
            {"root", std::move(root)}};
}

Json houseTile(const glm::dvec2& place, const std::string& uri = "house.b3dm") {
    return {{"boundingVolume", boxJson({0, 0, 15}, {50, 50, 15})},
            {"geometricError", 0},
            {"transform", matrix(shiftedAndTurned({place, 0.0}, 30.0))},
            {"content", {{"uri", uri}}}};
}

Json wholeCity(const glm::dmat4& rootTransform) {
    Json children = Json::array();
    for (const glm::dvec2& place : kPlaces) {
        children.push_back(houseTile(place));
    }
    return {{"boundingVolume", boxJson({0, 0, 15}, {10100, 10100, 15})},
            {"geometricError", 50},
            {"refine", "ADD"},
            {"transform", matrix(rootTransform)},
            {"children", children}};
}

Scene openIn(const Folder& folder, const City& city, const Json& tileset, bool* failed = nullptr) {
    folder.write("house.b3dm", housesB3dm({kHouse}, {"house"}));
    SceneOptions options;
    options.inputs = {folder.write("tileset.json", tileset.dump())};
    options.crs = city.crs;
    Result<Scene> scene = openScene(options);
    if (failed) {
        *failed = !scene;
    }
    EXPECT_TRUE(scene) << scene.error().message();
    return scene ? std::move(scene).value() : Scene{};
}

double distanceOutside(const BoundingVolume& volume, Point<Ecef> p) {
    return distanceTo(volume, p);
}

// How far the houses' corners lie from where PROJ has them, at worst; each must also be inside its
// tile's volume, and that inside the root's.
double worstOffMetres(Scene& scene, const City& city, const std::vector<glm::dmat4>& crsFromTile) {
    StreamedTileset& tileset = *scene.layers.at(0).tileset;
    EXPECT_FALSE(expandAll(tileset));
    const CrsToEcef crs = CrsToEcef::create(city.crs, Heights::Ellipsoidal).value();
    std::vector<Point<Ecef>> expected;
    for (const glm::dmat4& m : crsFromTile) {
        const std::vector<float> corners = boxCorners(kHouse.low, kHouse.high);
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            const glm::dvec4 p(corners[i], corners[i + 1], corners[i + 2], 1.0);
            expected.push_back(crs(glm::dvec3(m * p)).value());
        }
    }
    double worst = 0.0;
    std::size_t vertices = 0;
    for (TileIndex t = 0; t < tileset.tree().size(); ++t) {
        const LoadRequest request{t, 0.0};
        tileset.request({&request, 1});
        tileset.waitForAll();
        tileset.poll();
        const auto content = tileset.content(t);
        for (const Mesh& mesh : content ? content->meshes : std::vector<Mesh>{}) {
            for (const glm::vec3& local : mesh.positions) {
                const Point<Ecef> p{mesh.origin.xyz +
                                    scene.ecefFromAnchor.axes() * glm::dvec3(local)};
                double nearest = INFINITY;
                for (const Point<Ecef>& e : expected) {
                    nearest = std::min(nearest, length(p - e));
                }
                worst = std::max(worst, nearest);
                ++vertices;
                EXPECT_LT(distanceOutside(tileset.tree().node(t).volume, p), 0.01);
                EXPECT_LT(distanceOutside(tileset.tree().node(0).volume, p), 0.01);
            }
        }
    }
    EXPECT_GE(vertices, 8 * crsFromTile.size());
    return worst;
}

std::vector<glm::dmat4> houses(const glm::dmat4& root) {
    std::vector<glm::dmat4> out;
    for (const glm::dvec2& place : kPlaces) {
        out.push_back(root * shiftedAndTurned({place, 0.0}, 30.0));
    }
    return out;
}

// 50 m from the middle of its tile a house is off by the Earth's curve, 0.4 mm, and by what the
// scale changes over it: in Mercator at 51 degrees 0.5 mm.
constexpr double kTouchingMetres = 0.003;

} // namespace

TEST(ProjectedTileset, EveryHouseStandsWhereProjHasItTenKilometresFromTheMiddleToo) {
    for (const City& city : {kLyon, kCologne}) {
        for (const double turn : {0.0, 70.0}) {
            Folder folder;
            const glm::dmat4 root = shiftedAndTurned(city.centre, turn);
            Scene scene = openIn(folder, city, tilesetOf(wholeCity(root)));
            ASSERT_EQ(scene.layers.size(), 1u);
            EXPECT_LT(worstOffMetres(scene, city, houses(root)), kTouchingMetres) << city.crs;
        }
    }
}

TEST(ProjectedTileset, SoDoThoseOfExternalTilesets) {
    Folder folder;
    folder.write("sub/tileset.json", tilesetOf(houseTile({3000, 0}, "../house.b3dm")).dump());
    const glm::dmat4 root = shiftedAndTurned(kLyon.centre, 20.0);
    Json tile = houseTile({6000, 500}, "sub/tileset.json");
    tile["boundingVolume"] = boxJson({3000, 0, 15}, {100, 100, 15});
    Scene scene = openIn(folder, kLyon,
                         tilesetOf({{"boundingVolume", boxJson({0, 0, 15}, {9999, 9999, 15})},
                                    {"geometricError", 50},
                                    {"refine", "ADD"},
                                    {"transform", matrix(root)},
                                    {"children", {tile}}}));
    const glm::dmat4 house =
        root * shiftedAndTurned({6000, 500, 0}, 30.0) * shiftedAndTurned({3000, 0, 0}, 30.0);
    EXPECT_LT(worstOffMetres(scene, kLyon, {house}), kTouchingMetres);
}

TEST(ProjectedTileset, SoDoThoseOfImplicitTilings) {
    Folder folder;
    // Level 1 has one tile, the south-east; its content is all there is.
    folder.write("s.json", R"({"buffers":[{"uri":"b.bin","byteLength":1}],
        "bufferViews":[{"buffer":0,"byteLength":1}],"tileAvailability":{"bitstream":0},
        "contentAvailability":[{"bitstream":0}],"childSubtreeAvailability":{"constant":0}})");
    folder.write("b.bin", std::string(1, char(1 | 1 << 2)));
    folder.write("0_0_0.glb", housesGlb({{{-9990, 9990, 0}, {-9980, 9995, 5}, 0}}).text());
    const House house{{4950, -5050, 0}, {5050, -4950, 30}, 0}; // in the middle of its tile
    folder.write("1_1_0.glb", housesGlb({house}).text());
    const glm::dmat4 root = shiftedAndTurned(kCologne.centre, 0.0);
    Json tileset = tilesetOf({{"boundingVolume", boxJson({0, 0, 15}, {10000, 10000, 15})},
                              {"geometricError", 50},
                              {"refine", "ADD"},
                              {"transform", matrix(root)},
                              {"content", {{"uri", "{level}_{x}_{y}.glb"}}},
                              {"implicitTiling",
                               {{"subdivisionScheme", "QUADTREE"},
                                {"subtreeLevels", 2},
                                {"availableLevels", 2},
                                {"subtrees", {{"uri", "s.json"}}}}}});
    tileset["asset"]["version"] = "1.1";
    Scene scene = openIn(folder, kCologne, tileset);
    StreamedTileset& streamed = *scene.layers.at(0).tileset;
    ASSERT_FALSE(expandAll(streamed));
    ASSERT_EQ(streamed.tree().size(), 2u);
    const LoadRequest request{1, 0.0};
    streamed.request({&request, 1});
    streamed.waitForAll();
    streamed.poll();
    const auto content = streamed.content(1);
    ASSERT_TRUE(content);
    const CrsToEcef crs = CrsToEcef::create(kCologne.crs, Heights::Ellipsoidal).value();
    const Mesh& mesh = content->meshes.at(0);
    for (const glm::vec3& local : mesh.positions) {
        const Point<Ecef> p{mesh.origin.xyz + scene.ecefFromAnchor.axes() * glm::dvec3(local)};
        double nearest = INFINITY;
        const std::vector<float> corners = boxCorners(house.low, house.high);
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            const glm::dvec3 corner(corners[i], corners[i + 1], corners[i + 2]);
            nearest = std::min(nearest, length(p - *crs(kCologne.centre + corner)));
        }
        EXPECT_LT(nearest, kTouchingMetres);
        EXPECT_LT(distanceTo(streamed.tree().node(1).volume, p), 0.01);
    }
    // The tile's far corner is where PROJ has it, or the volume reaches that far.
    EXPECT_EQ(distanceTo(streamed.tree().node(1).volume,
                         *crs(kCologne.centre + glm::dvec3(9999, -9999, 15))),
              0.0);
}

TEST(ProjectedTileset, IsLiftedByRaise) {
    Folder folder;
    const glm::dmat4 root = shiftedAndTurned(kLyon.centre, 0.0);
    folder.write("house.b3dm", housesB3dm({kHouse}, {"house"}));
    SceneOptions options;
    options.inputs = {folder.write("tileset.json", tilesetOf(wholeCity(root)).dump())};
    options.crs = kLyon.crs;
    options.raiseMetres = 47.5;
    Result<Scene> scene = openScene(options);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_LT(worstOffMetres(*scene, kLyon, houses(shiftedAndTurned({0, 0, 47.5}, 0.0) * root)),
              kTouchingMetres);
}

TEST(ProjectedTileset, WithoutCrsTheLikelySystemsAreNamed) {
    Folder folder;
    folder.write("house.b3dm", housesB3dm({kHouse}, {"house"}));
    for (const City& city : {kLyon, kCologne}) {
        SceneOptions options;
        const Json tileset = tilesetOf(wholeCity(shiftedAndTurned(city.centre, 0.0)));
        options.inputs = {folder.write("tileset.json", tileset.dump())};
        const Result<Scene> scene = openScene(options);
        ASSERT_FALSE(scene);
        EXPECT_NE(scene.error().reason.find("--crs"), std::string::npos);
        EXPECT_NE(scene.error().reason.find(city.crs), std::string::npos) << scene.error().reason;
    }
}

TEST(ProjectedTileset, CoordinatesThatLookLikeEarthCentredOnesAreStillTakenByCrs) {
    // Laon in EPSG:3857: as Earth-centred coordinates it would be 2 km above the equator.
    const City laon{"EPSG:3857", {403000, 6367000, 80}};
    Folder folder;
    const glm::dmat4 root = shiftedAndTurned(laon.centre, 0.0);
    Scene scene = openIn(folder, laon, tilesetOf(wholeCity(root)));
    ASSERT_EQ(scene.layers.size(), 1u);
    EXPECT_NEAR(scene.anchor.latitudeDegrees, 49.56, 0.02);
    EXPECT_LT(worstOffMetres(scene, laon, houses(root)), kTouchingMetres);
    // A real place at the equator stays where it is.
    const Transform<Ecef, Enu> equator = ecefFromEnu({9.45, 0.0, 10.0});
    const OrientedBox box{equator.origin(),
                          glm::dmat3(3000.0 * equator.axes()[0], 3000.0 * equator.axes()[1],
                                     40.0 * equator.axes()[2])};
    EXPECT_TRUE(standsOnEarth(BoundingVolume(box)));
}

TEST(LikelySystems, HoldTheCitiesTheyAreFor) {
    struct Known {
        const char* code;
        double longitude, latitude;
    };
    for (const Known& city : {Known{"EPSG:3946", 4.83, 45.76},
                              {"EPSG:3950", 3.06, 50.63},
                              {"EPSG:3942", 9.2, 42.0},
                              {"EPSG:2154", 2.35, 48.86},
                              {"EPSG:28992", 4.9, 52.37},
                              {"EPSG:31370", 4.35, 50.85},
                              {"EPSG:2056", 8.54, 47.37},
                              {"EPSG:25832", 6.96, 50.94},
                              {"EPSG:25833", 13.4, 52.5},
                              {"EPSG:27700", -0.13, 51.5},
                              {"EPSG:3879", 24.94, 60.17},
                              {"EPSG:2180", 21.0, 52.2},
                              {"EPSG:5514", 14.42, 50.08},
                              {"EPSG:4647", 9.99, 53.55},
                              {"EPSG:3006", 18.07, 59.33},
                              {"EPSG:5070", -74.0, 40.7},
                              {"EPSG:3857", 139.7, 35.7}}) {
        const CrsToEcef crs = CrsToEcef::create(city.code, Heights::Ellipsoidal).value();
        const glm::dvec2 lonLat(city.longitude, city.latitude);
        glm::dvec2 eastNorth(0.0);
        crs.eastNorth({&lonLat, 1}, {&eastNorth, 1});
        char text[64];
        std::snprintf(text, sizeof text, "%s (%.2f, %.2f)", city.code, city.longitude,
                      city.latitude);
        const auto likely = likelySystems(eastNorth);
        EXPECT_TRUE(std::count(likely.begin(), likely.end(), text))
            << text << " at " << eastNorth.x << ' ' << eastNorth.y << ": "
            << (likely.empty() ? "nothing" : likely[0]);
    }
    EXPECT_TRUE(likelySystems({100, 200}).empty()) << "a frame of its own";
    EXPECT_TRUE(likelySystems({1e9, 0}).empty());
    EXPECT_TRUE(likelySystems({NAN, 0}).empty());
}

} // namespace gnomon
