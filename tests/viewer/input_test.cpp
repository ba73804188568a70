#include "tests/viewer/files.h"
#include "viewer/input.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace std::string_literals;

namespace {

const std::string kTileset = R"({"root":{"boundingVolume":{}},"asset":{"version":"1.0"}})";
const std::string kScene = R"({"layers":[]})";

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
    EXPECT_NE(kindOf(folder.path()).find("neither a *.scene.json nor tileset.json"),
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
        {"SQLite format 3\0"s, "GeoPackage"},
        {"\0\0\x27\x0a"s, "Shapefile"},
        {"i3dm", "i3dm"},
        {"cmpt", "cmpt"},
        {"pnts", "pnts"},
        {R"({"type":"FeatureCollection","features":[]})", "GeoJSON"},
        {R"({"type":"CityJSON","version":"1.1"})", "CityJSON"},
        {R"({"format":"quantized-mesh-1.0","tiles":[]})", "layer.json"},
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

TEST(Input, AKindMayBeInsistedOn) {
    const test::Folder folder;
    const std::string path = folder.write("t.json", kTileset);
    EXPECT_EQ(kindOf("tileset=" + path), "tileset");
    EXPECT_NE(kindOf("model=" + path).find("this is a tileset"), std::string::npos);
    EXPECT_NE(kindOf("terrain=" + path).find("this is a tileset"), std::string::npos);
    EXPECT_NE(kindOf("imagery=" + path).find("imagery="), std::string::npos);
    EXPECT_NE(kindOf("foo=" + path).find("no such kind"), std::string::npos);
    EXPECT_EQ(identifyInput("imagery=" + path).error().kind, ErrorKind::Usage);
    // A file may well have such a name.
    EXPECT_EQ(kindOf(folder.write("x=y.json", kTileset)), "tileset");
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
