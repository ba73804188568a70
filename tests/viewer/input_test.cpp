#include "tests/viewer/files.h"
#include "viewer/input.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace std::string_literals;

namespace {

const std::string kTileset = R"({"root":{"boundingVolume":{}},"asset":{"version":"1.0"}})";
const std::string kScene = R"({"layers":[]})";

std::string features(const std::string& geometry, const std::string& properties = "{}") {
    return R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":)" +
           properties + R"(,"geometry":)" + geometry + "}]}";
}
const std::string kPoints =
    features(R"({"type":"Point","coordinates":[7,50]})", R"({"crown_width":5})");
const std::string kGrid = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
                          "NODATA_value -9999\n";

std::string kindOf(const std::string& argument) {
    const auto input = identifyInput(argument);
    return input ? nameOf(input->kind) : "error: " + input.error().message();
}

} // namespace

TEST(Input, IsKnownByContentWhateverItsName) {
    const test::Folder folder;
    EXPECT_EQ(kindOf(folder.write("tiles.txt", kTileset)), "tileset");
    EXPECT_EQ(kindOf(folder.write("tileset.json", kScene)), "scene");
    EXPECT_EQ(kindOf(folder.write("a.json", R"({"asset":{"version":"2.0"},"meshes":[]})")),
              "model");
    EXPECT_EQ(kindOf(folder.write("a.tif", "glTF\2\0\0\0"s)), "model");
    EXPECT_EQ(kindOf(folder.write("a.png", "b3dm\1\0\0\0"s)), "model");
    EXPECT_EQ(kindOf(folder.write("bom.json", "\xef\xbb\xbf \n" + kTileset)), "tileset");
    // Some exporters write numbers JSON has no words for.
    EXPECT_EQ(kindOf(folder.write("nan.json",
                                  R"({"asset":{},"root":{"geometricError":NaN,"x":-Infinity}})")),
              "tileset");
}

TEST(Input, AFolderStandsForItsOneSceneElseItsTileset) {
    const test::Folder folder;
    EXPECT_NE(kindOf(folder.path()).find("neither a *.scene.json nor a tileset.json"),
              std::string::npos);
    folder.write("b.scene.json", kScene);
    EXPECT_EQ(kindOf(folder.path()), "scene");
    folder.write("a.scene.json", kScene);
    EXPECT_NE(kindOf(folder.path()).find("name one"), std::string::npos);
    folder.write("tileset.json", kTileset);
    EXPECT_EQ(kindOf(folder.path()), "tileset");
    EXPECT_EQ(identifyInput(folder.path())->path, folder / "tileset.json");
    std::filesystem::remove(folder / "a.scene.json");
    EXPECT_EQ(identifyInput(folder.path())->path, folder / "b.scene.json");
    EXPECT_EQ(kindOf("tileset=" + folder.path()), "tileset"); // as one is free to insist
    EXPECT_EQ(identifyInput(folder.path(), InputKind::Tileset)->path, folder / "tileset.json");
    std::filesystem::remove(folder / "b.scene.json");
    EXPECT_EQ(kindOf(folder.path()), "tileset");
    std::filesystem::create_directory(folder / "c.scene.json"); // a folder is no scene file
    EXPECT_EQ(kindOf(folder.path()), "tileset");
}

TEST(Input, OtherKindsAreRefusedByName) {
    const test::Folder folder;
    const std::pair<std::string, const char*> cases[] = {
        {"II*\0rest"s, "TIFF"},
        {"\x89HDF\r\n", "NetCDF or HDF5"},
        {"CDF\1", "NetCDF"},
        {"ncols 3\n", "ASCII raster"},
        {"SQLite format 3\0"s, "cannot be read as features"},
        {"\0\0\x27\x0a"s, "cannot be read as features"},
        {"\x89PNG\r\n\x1a\n"s, "PNG"},
        {"\x1f\x8b\x08"s, "gzip"},
        {R"({"type":"FeatureCollection","features":[]})", "no feature with a shape"},
        {R"({"type":"Topology","objects":{}})", "TopoJSON"},
        {R"({"keyframes":[]})", "--camera"},
        {R"({"root":{}})", "asset"},
        {R"({"foo":1})", "neither"},
        {"[1,2]", "list"},
        {"{\"asset\":", "not valid JSON"},
        {"hello", "not a kind"},
        {"", "empty"},
    };
    for (const auto& [content, words] : cases) {
        const auto input = identifyInput(folder.write("file", content));
        ASSERT_FALSE(bool(input)) << content;
        EXPECT_NE(input.error().message().find(words), std::string::npos)
            << input.error().message();
    }
    EXPECT_EQ(identifyInput(folder / "none").error().kind, ErrorKind::Input);
    EXPECT_EQ(identifyInput("https://example.org/tileset.json").error().kind, ErrorKind::Usage);
}

TEST(Input, EveryFormatOfATileIsAModel) {
    const test::Folder folder;
    for (const char* magic : {"glTF", "b3dm", "i3dm", "cmpt", "pnts"})
        EXPECT_EQ(kindOf(folder.write("file", magic)), "model") << magic;
}

TEST(Input, AKindMayBeInsistedOn) {
    const test::Folder folder;
    const std::string path = folder.write("t.json", kTileset);
    EXPECT_EQ(kindOf("tileset=" + path), "tileset");
    EXPECT_NE(kindOf("model=" + path).find("this is a tileset"), std::string::npos);
    EXPECT_NE(kindOf("terrain=" + path).find("this is a tileset"), std::string::npos);
    EXPECT_NE(kindOf("imagery=" + path).find("this is a tileset"), std::string::npos);
    EXPECT_NE(kindOf("foo=" + path).find("no such kind"), std::string::npos);
    EXPECT_EQ(identifyInput("foo=" + path).error().kind, ErrorKind::Usage);
    const std::string points = folder.write("points.geojson", kPoints);
    for (const char* kind : {"buildings", "trees", "barriers", "lamps", "imagery"})
        EXPECT_EQ(kindOf(std::string(kind) + "=" + points), kind);
    EXPECT_NE(kindOf("tileset=" + points).find("not a tileset"), std::string::npos);
    // A file may well have such a name.
    EXPECT_EQ(kindOf(folder.write("x=y.json", kTileset)), "tileset");
}

TEST(Input, WhatAFileIsForIsGuessedAndSaid) {
    const test::Folder folder;
    const std::string area =
        features(R"({"type":"Polygon","coordinates":[[[7,50],[7.1,50],[7,50.1],[7,50]]]})");
    const std::string line = features(R"({"type":"LineString","coordinates":[[7,50],[7.1,50]]})");
    const std::string heights = kGrid + "90 91 92 93\n90 91 92 93\n90 91 92 93\n90 91 92 93\n";
    const std::string depths = kGrid + "0 0 0 0.5\n0 0 0 1\n0 0 0 1\n0 0 0 0.2\n";
    const std::pair<std::string, const char*> cases[] = {
        {folder.write("a.geojson", area), "buildings"},
        {folder.write("b.geojson", line), "barriers"},
        {folder.write("c.geojson", kPoints), "trees"},
        {folder.write("lamps.geojson", features(R"({"type":"Point","coordinates":[7,50]})")),
         "lamps"},
        {folder.write("a.asc", heights), "terrain"},
        {folder.write("b.asc", depths), "water"},
        {folder.write("flood.asc", heights), "water"},
        {folder.write("stage_1.asc", heights), "water"},
        {folder.write("dem.asc", depths), "terrain"},
    };
    for (const auto& [path, kind] : cases) {
        const auto input = identifyInput(path);
        ASSERT_TRUE(bool(input)) << input.error().message();
        EXPECT_STREQ(nameOf(input->kind), kind) << path;
        EXPECT_NE(input->guess.find("taken for"), std::string::npos) << path;
    }
    EXPECT_EQ(identifyInput(folder / "stage_1.asc")->waterKind, WaterKind::Stage);
    // Who says what it is for is not guessed for.
    const auto insisted = identifyInput("depth=" + (folder / "dem.asc"));
    ASSERT_TRUE(bool(insisted));
    EXPECT_EQ(insisted->waterKind, WaterKind::Depth);
    EXPECT_EQ(insisted->guess, "");
    const auto unknown = identifyInput(
        folder.write("d.geojson", features(R"({"type":"Point","coordinates":[7,50]})")));
    ASSERT_FALSE(bool(unknown));
    EXPECT_NE(unknown.error().reason.find("trees="), std::string::npos);
    EXPECT_EQ(kindOf(folder.write("l.json", R"({"format":"quantized-mesh-1.0","tiles":[]})")),
              "terrain");
    EXPECT_EQ(kindOf(folder.write("c.json", R"({"type":"CityJSON","version":"1.1"})")),
              "buildings");
}

TEST(Input, APatternIsOneFileAStepInTheOrderOfNames) {
    const test::Folder folder;
    for (const char* name : {"h_2.asc", "h_1.asc", "h_3.asc", "other.asc"})
        folder.write(name, kGrid);
    const auto input = identifyInput("depth=" + (folder / "h_*.asc"));
    ASSERT_TRUE(bool(input)) << input.error().message();
    EXPECT_EQ(input->path, folder / "h_1.asc");
    EXPECT_EQ(input->steps, (std::vector<std::string>{folder / "h_2.asc", folder / "h_3.asc"}));
    EXPECT_FALSE(bool(identifyInput("depth=" + (folder / "x_*.asc"))));
    EXPECT_FALSE(bool(identifyInput(folder / "h_*.asc")));
}

TEST(Input, DeepAndHugeNestingIsNoTrouble) {
    const test::Folder folder;
    std::string deep = R"({"asset":{},"root":)" + std::string(1000000, '[');
    EXPECT_NE(kindOf(folder.write("deep.json", deep)).find("not valid JSON"), std::string::npos);
    deep += std::string(1000000, ']') + "}";
    EXPECT_EQ(kindOf(folder.write("deep.json", deep)), "tileset");
}

TEST(Input, ALinkTheUserNamesIsFollowed) {
    const test::Folder folder, elsewhere;
    elsewhere.write("t/tileset.json", kTileset);
    std::filesystem::create_symlink(elsewhere / "t/tileset.json", folder / "link.json");
    const auto input = identifyInput(folder / "link.json");
    ASSERT_TRUE(bool(input));
    EXPECT_EQ(input->uri, folder / "link.json");
    EXPECT_EQ(input->path, std::filesystem::canonical(elsewhere / "t/tileset.json"));
}
