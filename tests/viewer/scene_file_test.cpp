#include "viewer/scene_file.h"

#include <gtest/gtest.h>

using namespace gnomon;

namespace {

Result<SceneFile> parse(const std::string& text) {
    return parseSceneFile(text, "dir", "s.json");
}

} // namespace

TEST(SceneFile, NamesLayersRelativeToItself) {
    const auto scene = parse(R"({
        "layers": [ {"tileset": "b/tileset.json", "crs": "EPSG:25832", "heights": "egm96"},
                    {"model": "/m/tower.glb", "place": [6.9, 50.9, 50, 30], "raise": 2, "up": "z"} ],
        "time": "2021-07-14T18:00 Europe/Berlin",
        "camera": {"lon": 6.96, "lat": 50.94, "height": 300, "heading": 30, "pitch": -25},
        "ground": 12.5 })");
    ASSERT_TRUE(bool(scene)) << scene.error().message();
    ASSERT_EQ(scene->layers.size(), 2u);
    EXPECT_EQ(scene->layers[0].path, "dir/b/tileset.json");
    EXPECT_EQ(scene->layers[0].crs, "EPSG:25832");
    EXPECT_EQ(scene->layers[0].heights, Heights::Egm96);
    EXPECT_EQ(scene->layers[1].path, "/m/tower.glb");
    EXPECT_EQ(scene->layers[1].placement->headingDegrees, 30);
    EXPECT_EQ(scene->layers[1].up, ModelUp::Z);
    EXPECT_EQ(formatUtc(*scene->time), "2021-07-14T16:00:00Z");
    EXPECT_EQ(scene->camera->orientation.pitchDegrees, -25);
    EXPECT_EQ(scene->ground->heightMetres, 12.5);
    EXPECT_TRUE(scene->problems.empty());
}

TEST(SceneFile, LayersOfLaterKindsAreLeftOutByName) {
    const auto scene = parse(R"({"layers":[{"terrain":"dem.tif"},{"tileset":"t.json"},
                                           {"water":"flood.nc","variable":"zs"}]})");
    ASSERT_TRUE(bool(scene));
    EXPECT_EQ(scene->layers.size(), 1u);
    ASSERT_EQ(scene->problems.size(), 2u);
    EXPECT_EQ(scene->problems[0].severity, Problem::Severity::Error);
    EXPECT_EQ(scene->problems[0].uri, "s.json: layer 1");
    EXPECT_NE(scene->problems[1].reason.find("water"), std::string::npos);
}

TEST(SceneFile, UnknownKeysAreSaidAndIgnored) {
    const auto scene = parse(R"({"layers":[{"tileset":"t.json","colour":"red"}],"title":"x"})");
    ASSERT_TRUE(bool(scene));
    ASSERT_EQ(scene->problems.size(), 2u);
    EXPECT_EQ(scene->problems[0].severity, Problem::Severity::Warning);
}

TEST(SceneFile, RefusesWhatIsWrong) {
    for (const char* text :
         {"", "[]", "{}", R"({"layers":{}})", R"({"layers":[1]})", R"({"layers":[{}]})",
          R"({"layers":[{"tileset":1}]})", R"({"layers":[{"tileset":"a","model":"b"}]})",
          R"({"layers":[{"model":"a","place":[1,2]}]})",
          R"({"layers":[{"model":"a","place":[1,95,0]}]})",
          R"({"layers":[{"model":"a","place":[1,"2",0]}]})",
          R"({"layers":[{"model":"a","up":"x"}]})", R"({"layers":[{"model":"a","heights":"x"}]})",
          R"({"layers":[],"time":"noon"})", R"({"layers":[],"camera":[]})",
          R"({"layers":[],"camera":{"lon":1}})", R"({"layers":[],"ground":"deep"})"}) {
        const auto scene = parse(text);
        ASSERT_FALSE(bool(scene)) << text;
        EXPECT_EQ(scene.error().kind, ErrorKind::Input);
        EXPECT_EQ(scene.error().message().find('\n'), std::string::npos);
    }
}
