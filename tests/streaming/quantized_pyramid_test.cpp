#include "tests/streaming/quantized_mesh_folders.h"

namespace gnomon {
namespace {

TEST(QuantizedPyramid, TilesTellWhatLiesBelowThem) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"metadataAvailability\":2"));
    const Tiles tiles = {{0, 0, 0}, {0, 1, 0}, {1, 2, 1}, {1, 3, 1}, {1, 2, 0}, {1, 3, 0},
                         {2, 4, 2}, {2, 5, 2}, {2, 4, 3}, {2, 5, 3}, {3, 8, 4}, {3, 9, 4}};
    PyramidSpec spec;
    spec.change = [&](const QuantizedPlace& place, PlainTile& tile) {
        if (place.level % 2 != 0)
            return;
        const auto told = [&](const QuantizedPlace& p) { // all but one that is there
            return tiles.count({p.level, p.x, p.y}) && !(p == QuantizedPlace{3, 9, 4});
        };
        std::string levels;
        for (unsigned below = 1; below <= 2; ++below) {
            std::string ranges;
            for (std::uint32_t y = place.y << below; y < (place.y + 1) << below; ++y)
                for (std::uint32_t x = place.x << below; x < (place.x + 1) << below; ++x)
                    if (told({place.level + below, x, y}))
                        ranges += std::string(ranges.empty() ? "" : ",") +
                                  "{\"startX\":" + std::to_string(x) +
                                  ",\"endX\":" + std::to_string(x) +
                                  ",\"startY\":" + std::to_string(y) +
                                  ",\"endY\":" + std::to_string(y) + "}";
            levels += (below > 1 ? ",[" : "[") + ranges + "]";
        }
        tile.extensions.push_back({4, textBytes("{\"available\":[" + levels + "]}", true)});
    };
    writeTiles(folder / "", tiles, spec);
    auto pyramid = QuantizedPyramid::open(folder / "layer.json");
    ASSERT_TRUE(pyramid);
    EXPECT_TRUE((*pyramid)->has({2, 5, 3}));
    EXPECT_TRUE((*pyramid)->has({3, 8, 4}));
    EXPECT_FALSE((*pyramid)->has({3, 9, 4})) << "there, but not told of";
    EXPECT_FALSE((*pyramid)->has({1, 0, 0}));
    const Shown all = shown(opened(folder / "")->tiles({}, {}));
    EXPECT_TRUE(all.complete);
    EXPECT_NE(std::find(all.paths.begin(), all.paths.end(), "3/9/4"), all.paths.end())
        << "cut from its parent";
}

TEST(QuantizedPyramid, ParentsFillInButNeverFromOutsideTheFolder) {
    const TemporaryFolder folder;
    writeText(folder / "own/layer.json",
              layerText("\"available\":" + availableOf({{0, 0, 0}, {0, 1, 0}, {1, 2, 1}}) +
                        ",\"attribution\":\"<a href='x'>Mine</a>\",\"parentUrl\":\"./base\""));
    writeText(folder / "own/base/layer.json",
              layerText("\"available\":" + availableOf({{0, 0, 0}, {0, 1, 0}, {1, 3, 1}}) +
                        ",\"attribution\":\"Base\",\"parentUrl\":\"../\""));
    writeTiles(folder / "own", {{0, 0, 0}, {0, 1, 0}, {1, 2, 1}});
    writeTiles(folder / "own/base", {{0, 0, 0}, {0, 1, 0}, {1, 3, 1}});
    auto pyramid = QuantizedPyramid::open(folder / "own/layer.json");
    ASSERT_TRUE(pyramid) << pyramid.error().message();
    EXPECT_TRUE((*pyramid)->has({1, 3, 1}));
    EXPECT_NE((*pyramid)->describe({1, 3, 1}).find("base/1/3/1"), std::string::npos);
    EXPECT_EQ((*pyramid)->describe({0, 0, 0}).find("base"), std::string::npos);
    EXPECT_EQ((*pyramid)->credits(), (std::vector<std::string>{"Mine", "Base"}));
    ASSERT_EQ((*pyramid)->notes().size(), 1u) << "it is its own grandparent";
    EXPECT_NE((*pyramid)->notes()[0].find("own parent"), std::string::npos);

    for (const char* parent : {"../own/base", "/etc", "http://example.com/base", "%2e%2e/own"}) {
        writeText(folder / "lean/layer.json",
                  layerText("\"available\":" + availableOf({{0, 0, 0}}) + ",\"parentUrl\":\"" +
                            parent + "\""));
        writeTiles(folder / "lean", {{0, 0, 0}});
        auto lean = QuantizedPyramid::open(folder / "lean/layer.json");
        ASSERT_TRUE(lean);
        ASSERT_EQ((*lean)->notes().size(), 1u) << parent;
        EXPECT_NE((*lean)->notes()[0].find("parent is left out"), std::string::npos);
        EXPECT_FALSE((*lean)->has({1, 3, 1}));
    }
}

TEST(QuantizedPyramid, OtherSchemesAndMercatorTreesAreRead) {
    const Tiles tiles = {{5, 17, 20}};
    for (const bool webMercator : {false, true})
        for (const bool fromNorth : {false, true}) {
            const TemporaryFolder folder;
            Tiles told;
            for (const auto& [z, x, y] : tiles)
                told.insert({z, x, fromNorth ? (1u << z) - 1 - y : y});
            writeText(folder / "layer.json",
                      layerText(std::string("\"scheme\":\"") + (fromNorth ? "xyz" : "tms") +
                                "\",\"projection\":\"" + (webMercator ? "EPSG:3857" : "EPSG:4326") +
                                "\",\"available\":" + availableOf(told)));
            PyramidSpec spec;
            spec.webMercator = webMercator;
            spec.fromNorth = fromNorth;
            writeTiles(folder / "", tiles, spec);
            const auto terrain = opened(folder / "layer.json");
            ASSERT_TRUE(terrain);
            EXPECT_EQ(terrain->facts().crs, webMercator ? "EPSG:3857" : "EPSG:4326");
            const auto e = terrain->facts().extent;
            const auto own = extentOf({5, 17, 20}, webMercator);
            for (std::size_t i = 0; i < 4; ++i)
                EXPECT_NEAR(e[i], own[i], 1e-12);
            const glm::dvec2 p(0.5 * (e[0] + e[2]), 0.6 * e[1] + 0.4 * e[3]);
            // Of triangles some 100 km wide, 200 m below the ellipsoid's arc between them.
            EXPECT_NEAR(terrain->at(p), hills(p.x, p.y), 600.0);
        }
    // Web Mercator's rows: from 66.5 degrees north to 79.2, of the known table.
    const auto top = extentOf({3, 0, 6}, true);
    EXPECT_NEAR(top[1], 66.51326044, 1e-7);
    EXPECT_NEAR(top[3], 79.17133464, 1e-7);
    EXPECT_NEAR(extentOf({0, 0, 0}, true)[3], 85.05112878, 1e-7);
}

TEST(QuantizedPyramid, ATileByItselfIsPlacedByItsPathOrItsSphere) {
    if (fileBytes(qmeshData("tile.terrain")).empty())
        GTEST_SKIP() << "no " << qmeshData("tile.terrain");
    const auto placeIn = [](const std::string& path) {
        const auto pyramid = QuantizedPyramid::open(path);
        EXPECT_TRUE(pyramid) << (pyramid ? "" : pyramid.error().message());
        return pyramid ? (*pyramid)->roots()[0] : QuantizedPlace{};
    };
    EXPECT_EQ(placeIn(qmeshData("tile.terrain")), (QuantizedPlace{0, 0, 0}));
    EXPECT_EQ(placeIn(qmeshData("tile.metadataavailability.terrain")), (QuantizedPlace{0, 0, 0}));
    EXPECT_EQ(placeIn(qmeshData("9_759_335/9_759_335.terrain")), (QuantizedPlace{9, 759, 335}));
    EXPECT_EQ(placeIn(qmeshData("tile.32bitIndices.terrain")), (QuantizedPlace{15, 19297, 23803}));
    // Without a name that tells, and with one that lies.
    const TemporaryFolder folder;
    writeFile(folder / "everest.terrain", fileBytes(qmeshData("9_759_335/9_759_335.terrain")));
    writeFile(folder / "7/3/5.terrain", fileBytes(qmeshData("9_759_335/9_759_335.terrain")));
    EXPECT_EQ(placeIn(folder / "everest.terrain"), (QuantizedPlace{9, 759, 335}));
    EXPECT_EQ(placeIn(folder / "7/3/5.terrain"), (QuantizedPlace{9, 759, 335}));
    PlainTile tile = gridTile(extentOf({12, 4000, 3000}, false), 8, hills);
    writeFile(folder / "a.terrain", written(tile));
    EXPECT_EQ(placeIn(folder / "a.terrain"), (QuantizedPlace{12, 4000, 3000}));
    tile.sphere[3] *= 30.0;
    writeFile(folder / "b.terrain", written(tile));
    EXPECT_NE(refusal(folder / "b.terrain").find("where it belongs"), std::string::npos);
    tile.sphere[3] = NAN;
    writeFile(folder / "b.terrain", written(tile));
    EXPECT_NE(refusal(folder / "b.terrain").find("where it belongs"), std::string::npos);
    writeFile(folder / "12/4000/3000.terrain", written(tile));
    EXPECT_EQ(placeIn(folder / "12/4000/3000.terrain"), (QuantizedPlace{12, 4000, 3000}));
}

TEST(QuantizedPyramid, LayersThatCannotBeUsedAreRefusedInALineThatSaysWhy) {
    const TemporaryFolder folder;
    const auto with = [&](const std::string& text) {
        writeText(folder / "layer.json", text);
        const std::string line = refusal(folder / "layer.json");
        EXPECT_EQ(line.find('\n'), std::string::npos);
        return line;
    };
    EXPECT_NE(with("{\"format\":\"heightmap-1.0\",\"tiles\":[\"x\"]}").find("heightmap-1.0"),
              std::string::npos);
    EXPECT_NE(with("{\"format\":\"quantized-mesh-1.0\",\"tiles\":[]}").find("no tiles"),
              std::string::npos);
    EXPECT_NE(with("{\"format\":\"quantized-mesh-1.0\",\"tiles\":[\"a\"],\"projection\":"
                   "\"EPSG:2154\"}")
                  .find("EPSG:2154"),
              std::string::npos);
    EXPECT_NE(with("{").find("JSON"), std::string::npos);
    EXPECT_NE(with(std::string(1000, '[')), "was opened");
    EXPECT_NE(with("{" + std::string(1000, '[')).find("nested"), std::string::npos);
    EXPECT_NE(with(layerText("\"available\":[[{\"startX\":0,\"startY\":0,\"endX\":1,\"endY\":0}]]"))
                  .find("none of the first"),
              std::string::npos);
    EXPECT_NE(with(layerText("\"available\":[[{\"startX\":0,\"startY\":0,\"endX\":4294967295,"
                             "\"endY\":4294967295}]]")),
              "was opened");
    writeText(folder / "up.json", "{\"format\":\"quantized-mesh-1.0\",\"tiles\":"
                                  "[\"../{z}/{x}/{y}.terrain\"]}");
    EXPECT_NE(refusal(folder / "up.json"), "was opened");
    EXPECT_NE(refusal(folder / "none.json"), "was opened");
}

TEST(QuantizedPyramid, ATileThatCannotBeReadFailsByNameAndItsSiblingsGoOn) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf(kSparse)));
    writeTiles(folder / "", kSparse);
    Bytes half = fileBytes(folder / "1/3/1.terrain");
    half.resize(half.size() / 2);
    writeFile(folder / "1/3/1.terrain", half);
    const Shown all = shown(opened(folder / "")->tiles({}, {}));
    ASSERT_EQ(all.tileset->failures().size(), 1u);
    EXPECT_NE(all.tileset->failures()[0].error.message().find("1/3/1.terrain"), std::string::npos);
    EXPECT_EQ(all.paths.size(), 10u);
}

TEST(QuantizedPyramid, TilesThatAreToldOfAndNotThereAreSaidOnceAndShownAsTheirParentsAre) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf(kSparse)));
    writeTiles(folder / "", kSparse);
    std::filesystem::remove(folder / "2/5/3.terrain");
    const auto terrain = opened(folder / "");
    ASSERT_EQ(terrain->facts().notes.size(), 1u);
    EXPECT_NE(terrain->facts().notes[0].find("1 of the 12 tiles"), std::string::npos);
    const Shown all = shown(terrain->tiles({}, {}));
    EXPECT_TRUE(all.complete && all.tileset->failures().empty());
}

} // namespace
} // namespace gnomon
