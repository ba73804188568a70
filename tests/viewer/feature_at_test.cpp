#include "viewer/feature_at.h"

#include "streaming/raycast.h"
#include "tests/streaming/tree_support.h"
#include "tests/viewer/houses_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace gnomon {

using namespace test;

namespace {

// A coarse root that is replaced by two tiles, of which each has two houses; over the west one
// hangs a roof of no feature.
std::shared_ptr<testing::MemorySource> smallCity(const char* refine = "REPLACE") {
    auto source = std::make_shared<testing::MemorySource>();
    const auto add = [&](const std::string& name, const std::string& b3dm) {
        source->files[name] = test::bytesOf(b3dm);
    };
    add("coarse.b3dm", housesB3dm({{{-50, -50, 0}, {50, 50, 3}, 0}}, {"block"}));
    add("west.b3dm", housesB3dm({{{-40, -5, 0}, {-30, 5, 10}, 0},
                                 {{-20, -5, 1}, {-10, 5, 20}, 1},
                                 {{-40, -5, 30}, {-30, 5, 31}, -1}},
                                {"w0", "w1"}));
    add("east.b3dm", housesB3dm({{{10, -5, 0}, {20, 5, 7}, 0}}, {"e0"}));
    const auto tile = [](float x0, float x1, const char* uri, double error) {
        return Json{{"boundingVolume", boxVolume({x0, -50, 0}, {x1, 50, 40})},
                    {"geometricError", error},
                    {"content", {{"uri", uri}}}};
    };
    Json root = tile(-50, 50, "coarse.b3dm", 50);
    root["refine"] = refine;
    root["transform"] = transformAt(kHousesPlace);
    root["children"] = {tile(-50, 0, "west.b3dm", 0), tile(0, 50, "east.b3dm", 0)};
    const Json tileset = {{"asset", {{"version", "1.0"}, {"gltfUpAxis", "Z"}}},
                          {"geometricError", 100},
                          {"root", root}};
    source->files["tileset.json"] = test::bytesOf(tileset.dump());
    return source;
}

std::optional<TileFeature> at(StreamedTileset& tileset, double east, double north) {
    return featureAt(tileset, lonLatOf(east, north), glm::dmat3(1.0), testing::soon());
}

} // namespace

TEST(FeatureAt, FindsTheHouseItsPropertiesAndItsHeight) {
    const auto tileset = testing::open(smallCity());
    ASSERT_TRUE(tileset);
    const auto house = at(*tileset, -15, 1);
    ASSERT_TRUE(house);
    EXPECT_EQ(house->id, "w1");
    EXPECT_EQ(house->feature, 1u);
    EXPECT_EQ(house->tile, "west.b3dm");
    ASSERT_EQ(house->properties.size(), 1u);
    EXPECT_EQ(house->properties[0].value, PropertyValue("w1"));
    EXPECT_NEAR(house->topMetres, kHousesPlace.heightMetres + 20, 1e-3);
    EXPECT_NEAR(house->baseMetres, kHousesPlace.heightMetres + 1, 1e-3);
}

TEST(FeatureAt, SurfacesWithoutARowDoNotHideTheHouseBelow) {
    const auto tileset = testing::open(smallCity());
    const auto house = at(*tileset, -35, 0);
    ASSERT_TRUE(house);
    EXPECT_EQ(house->id, "w0");
    EXPECT_NEAR(house->topMetres, kHousesPlace.heightMetres + 10, 1e-3);
}

TEST(FeatureAt, LoadsTheFinestTilesOverThePlaceAndNoOthers) {
    const auto source = smallCity();
    const auto tileset = testing::open(source);
    ASSERT_TRUE(at(*tileset, 15, 0));
    EXPECT_EQ(source->order, (std::vector<std::string>{"tileset.json", "east.b3dm"}));
    EXPECT_FALSE(at(*tileset, 500, 0));
    EXPECT_EQ(source->order.size(), 2u);
    EXPECT_FALSE(at(*tileset, 5, 0)) << "beside the house: the coarse block is not asked";
    EXPECT_FALSE(std::count(source->order.begin(), source->order.end(), "coarse.b3dm"));
}

TEST(FeatureAt, FindsAHouseThatItsTilesBoxDoesNotHold) {
    const auto source = smallCity();
    source->files["east.b3dm"] =
        test::bytesOf(housesB3dm({{{60, -5, 0}, {70, 5, 7}, 0}}, {"astray"}));
    const auto tileset = testing::open(source);
    const auto house = at(*tileset, 65, 0);
    ASSERT_TRUE(house);
    EXPECT_EQ(house->id, "astray");
}

TEST(FeatureAt, OfTilesThatAddUpTheHighestCounts) {
    const auto tileset = testing::open(smallCity("ADD"));
    EXPECT_EQ(at(*tileset, 15, 0)->id, "e0");
    EXPECT_EQ(at(*tileset, 5, 0)->id, "block");
}

TEST(FeatureAt, IsTheSameAlongTheScenesOwnAxes) {
    const auto tileset = testing::open(smallCity());
    const glm::dmat3 axes = ecefFromEnu({-75.0, 39.0, 0.0}).axes();
    tileset->setMeshAxes(axes);
    const auto house = featureAt(*tileset, lonLatOf(-15, 1), axes, testing::soon());
    ASSERT_TRUE(house);
    EXPECT_EQ(house->id, "w1");
    EXPECT_NEAR(house->topMetres, kHousesPlace.heightMetres + 20, 1e-3);
    EXPECT_NEAR(house->baseMetres, kHousesPlace.heightMetres + 1, 1e-3);
}

TEST(FeatureAt, SaysWhenATileCouldNotBeHad) {
    const auto source = smallCity();
    source->files.erase("east.b3dm");
    const auto tileset = testing::open(source);
    bool complete = true;
    EXPECT_FALSE(featureAt(*tileset, lonLatOf(15, 0), glm::dmat3(1.0), testing::soon(), &complete));
    EXPECT_FALSE(complete);
    EXPECT_TRUE(featureAt(*tileset, lonLatOf(-15, 0), glm::dmat3(1.0), testing::soon(), &complete));
    EXPECT_TRUE(complete);
}

TEST(Raycast, MeetsAllTrianglesOfABoxFromBothSidesInOrder) {
    const auto content = test::decode(housesGlb({{{-1, -1, -1}, {1, 1, 1}, 3}}));
    ASSERT_TRUE(content);
    const auto hits =
        castRay(*content, glm::dmat3(1.0), Point<Ecef>{{0.2, 0.3, 10}}, Vector<Ecef>{{0, 0, -1}});
    ASSERT_EQ(hits.size(), 2u);
    EXPECT_DOUBLE_EQ(hits[0].metres, 9.0);
    EXPECT_DOUBLE_EQ(hits[1].metres, 11.0);
    EXPECT_EQ(hits[0].feature, 3u);
    EXPECT_EQ(
        castRay(*content, glm::dmat3(1.0), Point<Ecef>{{0.2, 0.3, 0}}, Vector<Ecef>{{0, 0, -1}})
            .size(),
        1u)
        << "nothing behind the start";
    EXPECT_TRUE(
        castRay(*content, glm::dmat3(1.0), Point<Ecef>{{3, 0, 10}}, Vector<Ecef>{{0, 0, -1}})
            .empty());
}

TEST(Raycast, NoRayThroughTheSeamOfTwoTrianglesIsLost) {
    const auto content = test::decode(housesGlb({{{0, 0, 0}, {7, 3, 1}, 0}}));
    ASSERT_TRUE(content);
    for (int i = 1; i < 200; ++i) {
        const double s = i / 200.0; // along the diagonal of the top
        for (const glm::dvec2 p : {glm::dvec2(7 * s, 3 * s), glm::dvec2(7 * s, 3 - 3 * s)}) {
            EXPECT_GE(castRay(*content, glm::dmat3(1.0), Point<Ecef>{{p.x, p.y, 9}},
                              Vector<Ecef>{{0, 0, -1}})
                          .size(),
                      2u)
                << i;
        }
    }
}

// Every roof of a real city is found again from above, with a row of the file's.
TEST(FeatureAt, FindsEveryRoofOfAmsterdam) {
    const std::string folder = dataFolder() + "/tiles-amsterdam-b3dm";
    auto tileset = StreamedTileset::open(fileSource(folder), "tileset.json", {}, {});
    if (!tileset) {
        GTEST_SKIP() << "tiles-amsterdam-b3dm is not here";
    }
    std::minstd_rand random(7);
    std::vector<Point<Ecef>> roofs;
    for (TileIndex i = 0; i < (*tileset)->tree().size(); ++i) {
        const LoadRequest request{i, 0.0};
        (*tileset)->request({&request, 1});
        (*tileset)->waitForAll();
        (*tileset)->poll();
        const auto content = (*tileset)->content(i);
        for (const Mesh& mesh : content ? content->meshes : std::vector<Mesh>{}) {
            for (std::uint32_t t = std::uint32_t(random() % 97); t < mesh.triangles(); t += 97) {
                glm::dvec3 centre(0.0);
                for (int k = 0; k < 3; ++k) {
                    centre +=
                        glm::dvec3(mesh.positions[mesh.indices[3 * t + std::uint32_t(k)]]) / 3.0;
                }
                const Point<Ecef> p{mesh.origin.xyz + centre};
                const glm::dvec3 normal = decodeOct(mesh.faceNormals[t]);
                if (std::abs(glm::dot(normal, ellipsoidNormal(p).xyz)) > 0.5) { // no wall
                    roofs.push_back(p);
                }
            }
        }
    }
    ASSERT_GT(roofs.size(), 20u);
    for (const Point<Ecef>& roof : roofs) {
        const Geodetic g = geodeticOf(roof);
        const auto found = featureAt(**tileset, {g.longitudeDegrees, g.latitudeDegrees},
                                     glm::dmat3(1.0), testing::soon());
        ASSERT_TRUE(found) << g.longitudeDegrees << ' ' << g.latitudeDegrees;
        EXPECT_GE(found->topMetres, g.heightMetres - 0.01);
        EXPECT_LE(found->baseMetres, found->topMetres);
        ASSERT_EQ(found->properties.size(), 1u);
        EXPECT_EQ(found->properties[0].name, "blockid");
    }
}

} // namespace gnomon
