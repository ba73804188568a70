// Terrain as a whole: what opens and what does not, its facts, its heights anywhere, its tree.
#include "geo/bounds.h"
#include "tests/streaming/terrain_support.h"

#include <map>
#include <set>
#include <thread>

using namespace gnomon;
using namespace gnomon::test;

namespace {

TerrainOptions inSystem(const std::string& crs) {
    TerrainOptions options;
    options.crs = crs;
    return options;
}

// Heights between pixels' centres as a straight look at the file gives them.
double bilinear(const Heights2d& h, glm::dvec2 p) {
    if (!(p.x >= 0 && p.y >= 0 && p.x <= h.width - 1 && p.y <= h.height - 1))
        return kNoHeight;
    const int x = std::min(int(p.x), h.width - 2), y = std::min(int(p.y), h.height - 2);
    const double u = p.x - x, v = p.y - y;
    return (1 - v) * ((1 - u) * h.at(x, y) + u * h.at(x + 1, y)) +
           v * ((1 - u) * h.at(x, y + 1) + u * h.at(x + 1, y + 1));
}

} // namespace

TEST(Terrain, TellsItsFacts) {
    RasterLook look;
    look.transform = {356000, 2, 0, 5700000, 0, -1};
    look.copyright = "Somebody";
    look.overviews = true;
    Heights2d h = roughHills(300, 200);
    h.values[0] = kNoHeight;
    TerrainOptions options;
    options.raiseMetres = 10.0;
    double last = -1.0;
    int calls = 0;
    options.progress = [&](double share) {
        EXPECT_GE(share, last);
        last = share;
        ++calls;
    };
    const auto terrain = openTerrain(writeRaster("facts", h, look), options);
    ASSERT_TRUE(terrain);
    const TerrainFacts& facts = terrain->facts();
    EXPECT_EQ(facts.crs, "EPSG:25832");
    EXPECT_EQ(facts.columns, 300);
    EXPECT_EQ(facts.rows, 200);
    EXPECT_NEAR(facts.cellMetres, 1.0, 1e-3); // the grid's scale is not one everywhere
    EXPECT_TRUE(facts.hasOverviews);
    EXPECT_TRUE(facts.errorIsBound);
    EXPECT_NEAR(facts.dataShare, 1.0 - 1.0 / 60000.0, 1e-9);
    const auto [low, high] = std::minmax_element(h.values.begin() + 1, h.values.end());
    EXPECT_NEAR(facts.minHeightMetres, *low + 10.0, 1e-4);
    EXPECT_NEAR(facts.maxHeightMetres, *high + 10.0, 1e-4);
    EXPECT_EQ(facts.credits, std::vector<std::string>{"Somebody"});
    const GdalPlaces gdal(look);
    EXPECT_NEAR(facts.extent[0], std::min(gdal.lonLat(0, 0).x, gdal.lonLat(0, 199).x), 1e-7);
    EXPECT_NEAR(facts.extent[3], std::max(gdal.lonLat(0, 0).y, gdal.lonLat(299, 0).y), 1e-7);
    EXPECT_GT(calls, 0);
    EXPECT_EQ(last, 1.0);
}

TEST(Terrain, OfNoDataAtAllIsOneClearLine) {
    const Heights2d none(40, 30, [](int, int) { return double(kNoHeight); });
    EXPECT_NE(whyNot(writeRaster("empty", none)).find("has no data anywhere"), std::string::npos);
    Heights2d lone = none;
    lone.values[123] = 5.0f;
    EXPECT_NE(whyNot(writeRaster("lone", lone)).find("single pixels"), std::string::npos);
    const Heights2d thin(1, 30, [](int, int) { return 1.0; });
    EXPECT_NE(whyNot(writeRaster("thin", thin)).find("one pixel wide"), std::string::npos);
}

TEST(Terrain, NeedsASystemAndTakesTheOneGivenOnlyThen) {
    const Heights2d h = roughHills(50, 40);
    RasterLook look;
    look.epsg = 0;
    look.proj = "";
    const std::string nameless = writeRaster("nameless", h, look);
    EXPECT_NE(whyNot(nameless).find("--crs"), std::string::npos);
    EXPECT_NE(whyNot(nameless, inSystem("EPSG:0")).find("--crs"), std::string::npos);
    const auto given = openTerrain(nameless, inSystem("EPSG:32633"));
    ASSERT_TRUE(given);
    EXPECT_EQ(given->facts().crs, "EPSG:32633");
    EXPECT_NEAR(given->facts().extent[0], 12.9, 0.1);
    const auto own = openTerrain(writeRaster("named", h), inSystem("EPSG:32633"));
    ASSERT_TRUE(own);
    EXPECT_EQ(own->facts().crs, "EPSG:25832");
    EXPECT_NEAR(own->facts().extent[0], 6.93, 0.01);
}

TEST(Terrain, SamplesAsGdalsPixelsAndPlacesSay) {
    Heights2d h = roughHills(700, 430, 8);
    for (int i = 0; i < 3000; ++i)
        h.values[std::size_t(i * 97 % int(h.values.size()))] = kNoHeight;
    std::vector<RasterLook> looks(3);
    looks[1].transform = {400000, 3, 4, 5800000, -4, 3};
    looks[2].epsg = 4326;
    looks[2].transform = {179.95, 1.0 / 3600, 0, -17, 0, -1.0 / 3600};
    for (const RasterLook& look : looks) {
        const GdalPlaces gdal(look);
        const auto terrain = openTerrain(writeRaster("sample", h, look));
        ASSERT_TRUE(terrain);
        std::mt19937 random(5);
        std::uniform_real_distribution<double> x(-20.0, h.width + 20.0), y(-20.0, h.height + 20.0);
        std::vector<glm::dvec2> pixels, places;
        for (int i = 0; i < 3000; ++i) {
            pixels.emplace_back(x(random), y(random));
            places.push_back(gdal.lonLat(pixels.back().x, pixels.back().y));
        }
        std::vector<double> heights(places.size());
        terrain->sample(places, heights);
        int there = 0;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double expected = bilinear(h, pixels[i]);
            EXPECT_EQ(std::isnan(expected), std::isnan(heights[i])) << pixels[i].x;
            if (!std::isnan(expected)) {
                EXPECT_NEAR(heights[i], expected, 1e-3);
                ++there;
            }
        }
        EXPECT_GT(there, 1500);
        // Pixels' own centres, up to the last ones.
        EXPECT_NEAR(terrain->at(gdal.lonLat(h.width - 1, 3)), double(h.at(h.width - 1, 3)), 1e-4);
        EXPECT_NEAR(terrain->at(gdal.lonLat(5, h.height - 1)), double(h.at(5, h.height - 1)), 1e-4);
    }
}

TEST(Terrain, SamplesTheSameFromManyThreadsOfAFileTooLargeForMemory) {
    const Heights2d h = roughHills(2800, 2600, 6); // more than is kept at full resolution
    const RasterLook look;
    const auto terrain = openTerrain(writeRaster("threaded", h, look));
    ASSERT_TRUE(terrain);
    const auto box = terrain->facts().extent;
    std::vector<glm::dvec2> places;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int i = 0; i < 20000; ++i)
        places.emplace_back(box[0] + share(random) * (box[2] - box[0]),
                            box[1] + share(random) * (box[3] - box[1]));
    std::array<std::vector<double>, 3> heights;
    std::vector<std::thread> threads;
    for (auto& out : heights)
        threads.emplace_back([&] {
            out.resize(places.size());
            terrain->sample(places, out);
        });
    for (std::thread& thread : threads)
        thread.join();
    const GdalPlaces gdal(look);
    for (std::size_t i = 0; i < places.size(); i += 37) {
        const double expected = bilinear(h, gdal.pixel(places[i]));
        for (const auto& out : heights) {
            EXPECT_EQ(std::isnan(expected), std::isnan(out[i]));
            if (!std::isnan(expected)) {
                EXPECT_NEAR(out[i], expected, 1e-3);
            }
        }
    }
}

TEST(Terrain, AddsTheGeoidToHeightsAboveTheSea) {
    const Heights2d h = roughHills(60, 50);
    const std::string path = writeRaster("sea", h);
    TerrainOptions options;
    options.heights = Heights::Egm96;
    const auto sea = openTerrain(path, options), ellipsoid = openTerrain(path);
    ASSERT_TRUE(sea && ellipsoid);
    const glm::dvec2 place = GdalPlaces(RasterLook{}).lonLat(20, 20);
    const double geoid = *egm96GeoidHeight(place.x, place.y);
    EXPECT_GT(geoid, 40.0);
    EXPECT_NEAR(sea->at(place) - ellipsoid->at(place), geoid, 1e-6);
    EXPECT_NEAR(sea->facts().minHeightMetres - ellipsoid->facts().minHeightMetres, geoid, 0.1);
}

TEST(Terrain, TreeIsWholeNestedAndItsErrorsNeverGrowDownwards) {
    const Heights2d h = roughHills(900, 513);
    const auto terrain = openTerrain(writeRaster("tree", h));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    std::set<TileId> seen;
    for (std::size_t i = 0; i < made.tiles.size(); ++i) {
        const MadeTile& tile = made.tiles[i];
        const TileId id = idOf(tile.path);
        EXPECT_TRUE(seen.insert(id).second) << tile.path;
        EXPECT_EQ(tile.refine, Refine::Replace);
        if (i == 0)
            continue;
        const MadeTile& parent = made.tiles[tile.parent];
        const TileId above = idOf(parent.path);
        EXPECT_EQ(above, (TileId{id.level + 1, id.x / 2, id.y / 2}));
        EXPECT_LE(tile.geometricErrorMetres, parent.geometricErrorMetres);
        EXPECT_EQ(tile.geometricErrorMetres == 0.0, id.level == 0);
    }
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 8; ++x)
            EXPECT_TRUE(seen.contains({0, x, y})) << x << " " << y;
    EXPECT_TRUE(TileTree::ofTiles("tree", made.tiles));
}

TEST(Terrain, ErrorsDoNotGrowDownwardsEvenWhereACoarseSurfaceIsTheNearerOne) {
    // Between pixels at 0 and 10 every fourth one at -10 draws the finer surface away.
    const Heights2d h(601, 300, [](int x, int) {
        return x % 2 == 1 ? 10.0 : x % 4 == 2 ? -10.0 : 0.0;
    });
    const auto terrain = openTerrain(writeRaster("comb", h));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    for (std::size_t i = 1; i < made.tiles.size(); ++i)
        EXPECT_LE(made.tiles[i].geometricErrorMetres,
                  made.tiles[made.tiles[i].parent].geometricErrorMetres);
    EXPECT_NEAR(made.tiles[0].geometricErrorMetres, 15.0, 0.01);
}

TEST(Terrain, BranchesEndWhereThereIsNoData) {
    Heights2d h = roughHills(900, 500);
    for (int y = 0; y < h.height; ++y)
        for (int x = 300; x < h.width; ++x)
            h.values[std::size_t(y * h.width + x)] = kNoHeight;
    const auto terrain = openTerrain(writeRaster("branches", h));
    ASSERT_TRUE(terrain);
    for (const MadeTile& tile : terrain->tiles({}, {}).tiles) {
        const TileId id = idOf(tile.path);
        EXPECT_LT(id.x * (128 << id.level), 300) << tile.path;
    }
}

TEST(Terrain, VolumesHoldTheirTilesAndAreTight) {
    std::vector<RasterLook> looks(4);
    looks[3].epsg = 3035; // a tile wide enough for the Earth to bend in it, and askew
    looks[3].transform = {2.6e6, 1500, 3900, 2.6e6, 3900, -1500};
    looks[1].epsg = 4326;
    looks[1].transform = {7, 0.01, 0, 60, 0, -0.01}; // parallels bend
    looks[2].epsg = 3995;
    looks[2].transform = {-30000, 100, 0, 30000, 0, -100}; // about the pole
    for (const RasterLook& look : looks) {
        const Heights2d h = roughHills(400, 330);
        const auto terrain = openTerrain(writeRaster("volumes", h, look));
        ASSERT_TRUE(terrain);
        const MadeTileset made = terrain->tiles({}, {});
        const GdalPlaces gdal(look);
        for (const MadeTile& tile : made.tiles) {
            SCOPED_TRACE(tile.path);
            const TileContent content = contentOf(made, tile.path);
            double farthest = 0.0;
            for (const Mesh& mesh : content.meshes)
                for (std::uint32_t i = 0; i < 3 * mesh.castingTriangles(); ++i)
                    farthest = std::max(farthest,
                                        distanceTo(tile.volume, vertexOf(mesh, mesh.indices[i])));
            EXPECT_LE(farthest, 1e-3);
            // The raster itself stays within, too: children are never seen where parents are not.
            const TileId id = idOf(tile.path);
            for (int y = id.y * (128 << id.level);
                 y < std::min(h.height, (id.y + 1) * (128 << id.level)); y += 9)
                for (int x = id.x * (128 << id.level);
                     x < std::min(h.width, (id.x + 1) * (128 << id.level)); x += 9)
                    ASSERT_LE(distanceTo(tile.volume, gdal.ecef(x, y, h.at(x, y))), 1e-3);
            const auto& box = std::get<OrientedBox>(tile.volume);
            if (&look == &looks[0]) {
                EXPECT_LT(glm::length(box.halfAxes[2]), 25.0);
            }
        }
    }
}

TEST(Terrain, TooLargeToBeReadIsLookedAtWhereItIsNeeded) {
    const Heights2d h = roughHills(2500, 2200, 4);
    const std::string path = writeRaster("lazy", h, [] {
        RasterLook look;
        look.overviews = true;
        return look;
    }());
    TerrainOptions options;
    options.mostPixelsRead = 1000;
    const auto lazy = openTerrain(path, options), read = openTerrain(path);
    ASSERT_TRUE(lazy && read);
    EXPECT_FALSE(lazy->facts().errorIsBound);
    ASSERT_EQ(lazy->facts().notes.size(), 1u);
    EXPECT_NEAR(lazy->facts().rootErrorMetres, read->facts().rootErrorMetres, 8.0);
    const MadeTileset made = lazy->tiles({}, {});
    EXPECT_LT(made.tiles.size(), 20u);
    std::map<std::string, double> errors;
    for (const MadeTile& tile : read->tiles({}, {}).tiles)
        errors[tile.path] = tile.geometricErrorMetres;
    std::size_t found = 0;
    for (const MadeTile& tile : allTiles(made)) {
        const TileId id = idOf(tile.path);
        ASSERT_TRUE(errors.contains(tile.path)) << tile.path;
        if (id.level < 4) {
            EXPECT_DOUBLE_EQ(tile.geometricErrorMetres, errors[tile.path]) << tile.path;
        }
        ++found;
    }
    EXPECT_EQ(found, errors.size());
    EXPECT_FALSE(contentOf(made, "2/1/1").meshes.empty());
}

TEST(Terrain, RefusesTilesThatAreNoneOfIts) {
    const auto terrain = openTerrain(writeRaster("names", roughHills(300, 200)));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    for (const char* path :
         {"", "x", "0/0", "0/0/0/0", "99/0/0", "0/-1/0", "0/3/0", "-9/0/0", "2/0/1"})
        EXPECT_FALSE(made.maker->make(path, {})) << path;
    EXPECT_TRUE(made.maker->make("0/2/1", {}));
}
