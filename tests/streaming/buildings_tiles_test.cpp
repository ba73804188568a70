#include "buildings_support.h"

#include "streaming/loader.h"

#include <set>

namespace gnomon::test {
namespace {

// A city of squares, a few large among many small.
std::vector<Feature> city(int across) {
    std::vector<Feature> features;
    for (int y = 0; y < across; ++y)
        for (int x = 0; x < across; ++x) {
            const double size = x % 10 == 0 && y % 10 == 0 ? 25.0 : 8.0 + (x + y) % 5;
            features.push_back(feature(FeatureShape::Polygon, {box(30.0 * x, 30.0 * y, size, size)},
                                       {{"height", 6.0 + (x * y) % 3}}));
        }
    return features;
}

TEST(TilesOfBuildings, HoldEveryBuildingOnceTheLargestFirst) {
    const auto buildings = buildingsOf(city(60), flatGround(40.0));
    const MadeTileset made = buildings->tiles();
    ASSERT_GT(made.tiles.size(), 4u);
    std::set<std::uint32_t> seen;
    std::vector<double> smallest(made.tiles.size(), 1e9);
    for (std::size_t i = 0; i < made.tiles.size(); ++i) {
        const MadeTile& tile = made.tiles[i];
        EXPECT_EQ(tile.refine, Refine::Add);
        const TileContent content = test::made(made, tile.path);
        expectSound(content, tile);
        std::set<std::uint32_t> own;
        for (const Mesh& mesh : content.meshes)
            own.insert(mesh.features.begin(), mesh.features.end());
        EXPECT_GE(own.size(), 100u);
        EXPECT_LE(own.size(), 1000u);
        for (const std::uint32_t b : own) {
            EXPECT_TRUE(seen.insert(b).second) << "once";
            const double size =
                b % 10 == 0 && b / 60 % 10 == 0 ? 25.0 : 8.0 + double((b % 60 + b / 60) % 5);
            smallest[i] = std::min(smallest[i], size);
        }
        if (tile.parent != kNoTile) {
            EXPECT_LE(tile.geometricErrorMetres, made.tiles[tile.parent].geometricErrorMetres);
        }
    }
    EXPECT_EQ(seen.size(), 3600u);
    EXPECT_EQ(*seen.rbegin(), 3599u);
    EXPECT_GE(smallest[0], 11.0) << "small ones are for the finer tiles";
    EXPECT_GT(made.tiles[0].geometricErrorMetres, 0.0);
    EXPECT_EQ(made.tiles.back().geometricErrorMetres, 0.0);
    EXPECT_TRUE(TileTree::ofTiles("test", made.tiles));
}

TEST(TilesOfBuildings, AreTheSameBytesEveryTime) {
    const auto one = buildingsOf(city(40), flatGround(40.0))->tiles();
    const auto two = buildingsOf(city(40), flatGround(40.0))->tiles();
    ASSERT_EQ(one.tiles.size(), two.tiles.size());
    for (const MadeTile& tile : one.tiles)
        EXPECT_TRUE(sameBytes(test::made(one, tile.path), test::made(two, tile.path)));
    EXPECT_FALSE(one.maker->make("no such tile", {}));
    EXPECT_FALSE(one.maker->make("99999", {}));
}

TEST(TilesOfBuildings, CarryTheNumberThatBuildingsAreAskedBy) {
    const auto buildings = buildingsOf(city(40), flatGround(40.0));
    const MadeTileset made = buildings->tiles();
    for (const MadeTile& tile : made.tiles)
        for (const Mesh& mesh : test::made(made, tile.path).meshes)
            for (std::size_t i = 0; i < mesh.positions.size(); i += 97) {
                const Point<Ecef> p{mesh.origin.xyz + hereAxes() * glm::dvec3(mesh.positions[i])};
                const Geodetic place = geodeticOf(p);
                const BuildingFound found = buildings->building(mesh.features[i]);
                EXPECT_LE(place.heightMetres, found.topMetres + 1e-3);
                const int number = std::stoi(found.id);
                const glm::dvec2 corner = glm::dvec2(30.0 * (number % 40), 30.0 * (number / 40));
                const glm::dvec2 here =
                    metres({place.longitudeDegrees, place.latitudeDegrees}) - corner;
                EXPECT_TRUE(here.x > -0.01 && here.y > -0.01 && here.x < 25.01 && here.y < 25.01);
            }
}

TEST(ABuildingAtAPlace, IsFoundByItsOutlineWithItsHoles) {
    std::vector<Feature> features = city(60);
    features.push_back(feature(FeatureShape::Polygon,
                               {box(-100, -100, 50, 50), box(-80, -80, 10, 10)},
                               {{"name", std::string("ring")}}));
    features.push_back(
        feature(FeatureShape::Polygon, {box(1, 1, 4, 4)}, {{"height", 90.0}})); // on the first
    const auto buildings = buildingsOf(features, flatGround(40.0));
    const auto idAt = [&](double east, double north) {
        const auto found = buildings->at(glm::dvec2(at(east, north)));
        return found ? found->id : "none";
    };
    EXPECT_EQ(idAt(-90, -90), "3600");
    EXPECT_EQ(idAt(-75, -75), "none") << "in its hole";
    EXPECT_EQ(idAt(-49, -90), "none");
    EXPECT_EQ(idAt(2, 2), "3601") << "the highest";
    EXPECT_EQ(idAt(24, 24), "0");
    for (int i = 0; i < 3600; i += 37)
        EXPECT_EQ(idAt(30.0 * (i % 60) + 7.0, 30.0 * (i / 60) + 7.0), std::to_string(i));
    EXPECT_FALSE(buildings->at({NAN, 50.0}));
    EXPECT_FALSE(buildings->at({0.0, 0.0}));
    const auto ring = buildings->at(glm::dvec2(at(-90, -90)));
    ASSERT_TRUE(ring);
    EXPECT_EQ(std::get<std::string>(ring->attributes.at(0).second), "ring");
}

TEST(BuildingsAcrossTheAntimeridian, AreOneCity) {
    const auto ring = [](double lon) {
        const auto wrap = [](double x) { return std::remainder(x, 360.0); };
        return FeatureRing{{wrap(lon), 10.0, NAN},
                           {wrap(lon + 2e-4), 10.0, NAN},
                           {wrap(lon + 2e-4), 10.0002, NAN},
                           {wrap(lon), 10.0002, NAN}};
    };
    const auto buildings = buildingsOf({feature(FeatureShape::Polygon, {ring(179.999)}),
                                        feature(FeatureShape::Polygon, {ring(179.9999)}),
                                        feature(FeatureShape::Polygon, {ring(-179.999)})},
                                       flatGround(0.0));
    ASSERT_TRUE(buildings);
    EXPECT_EQ(buildings->at({179.9991, 10.0001})->id, "0");
    EXPECT_EQ(buildings->at({180.0, 10.0001})->id, "1");
    EXPECT_EQ(buildings->at({-179.99995, 10.0001})->id, "1");
    EXPECT_EQ(buildings->at({-179.9989, 10.0001})->id, "2");
    EXPECT_LT(boundingSphere(buildings->tiles().tiles[0].volume).radiusMetres, 1000.0);
    const Measured m = measured(*buildings);
    EXPECT_EQ(m.triangles, 36u);
    EXPECT_EQ(m.closed, 36u);
}

TEST(TilesOfBuildings, StreamLikeAnyTileset) {
    const auto buildings = buildingsOf(city(40), flatGround(40.0));
    auto streamed = StreamedTileset::ofMade(buildings->tiles(), "city", {});
    ASSERT_TRUE(streamed) << streamed.error().message();
    EXPECT_GT((*streamed)->tree().size(), 1u);
}

} // namespace
} // namespace gnomon::test
