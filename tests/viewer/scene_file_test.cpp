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

TEST(SceneFile, SaysOfEachLayerWhatItsFilesLack) {
    const auto scene = parse(R"({"layers":[
        {"terrain":"dem.tif","look":"ramp"},
        {"imagery":"road.csv","crs":"EPSG:32756","color":"#5a0060"},
        {"buildings":"houses.geojson","height":6,"height-attribute":"h"},
        {"barriers":"walls.geojson","from":"2021-07-14T18:00:00Z","height":1.5,"width":0.4},
        {"water":"flood.nc","variable":"zs","kind":"stage","start":"2021-07-14T12:00:00Z",
         "step":"1h","colors":"natural","most":3,"dry":0.05},
        {"depth":["a.tif","b.tif"],"step":"15min"}, {"trees":"t.gpkg"}, {"lamps":"l.geojson"}]})");
    ASSERT_TRUE(bool(scene)) << scene.error().message();
    EXPECT_TRUE(scene->problems.empty());
    const auto& layers = scene->layers;
    ASSERT_EQ(layers.size(), 8u);
    EXPECT_EQ(layers[0].kind, InputKind::Terrain);
    EXPECT_EQ(layers[0].look, TerrainLook::Ramp);
    EXPECT_EQ(layers[1].color, (std::array<std::uint8_t, 3>{0x5a, 0x00, 0x60}));
    EXPECT_EQ(layers[2].heightMetres, 6);
    EXPECT_EQ(layers[2].heightAttribute, "h");
    EXPECT_EQ(formatUtc(*layers[3].from), "2021-07-14T18:00:00Z");
    EXPECT_EQ(layers[3].widthMetres, 0.4);
    EXPECT_EQ(layers[4].kind, InputKind::Water);
    EXPECT_EQ(layers[4].waterKind, WaterKind::Stage);
    EXPECT_EQ(layers[4].variable, "zs");
    EXPECT_EQ(layers[4].stepSeconds, 3600);
    EXPECT_EQ(layers[4].colors, WaterColors::Natural);
    EXPECT_EQ(layers[4].most, 3);
    EXPECT_EQ(layers[4].dryMetres, 0.05);
    EXPECT_EQ(layers[5].waterKind, WaterKind::Depth);
    EXPECT_EQ(layers[5].path, "dir/a.tif");
    EXPECT_EQ(layers[5].steps, std::vector<std::string>{"dir/b.tif"});
    EXPECT_EQ(layers[5].stepSeconds, 900);
    EXPECT_EQ(layers[7].kind, InputKind::Lamps);
}

TEST(SceneFile, UnknownKeysAreSaidAndIgnored) {
    const auto scene = parse(R"({"layers":[{"tileset":"t.json","colour":"red"}],"title":"x"})");
    ASSERT_TRUE(bool(scene));
    ASSERT_EQ(scene->problems.size(), 2u);
    EXPECT_EQ(scene->problems[0].severity, Problem::Severity::Warning);
}

TEST(SceneFile, RefusesWhatIsWrong) {
    for (const char* text : {"",
                             "[]",
                             "{}",
                             R"({"layers":{}})",
                             R"({"layers":[1]})",
                             R"({"layers":[{}]})",
                             R"({"layers":[{"tileset":1}]})",
                             R"({"layers":[{"tileset":"a","model":"b"}]})",
                             R"({"layers":[{"model":"a","place":[1,2]}]})",
                             R"({"layers":[{"model":"a","place":[1,95,0]}]})",
                             R"({"layers":[{"model":"a","place":[1,"2",0]}]})",
                             R"({"layers":[{"model":"a","up":"x"}]})",
                             R"({"layers":[{"model":"a","heights":"x"}]})",
                             R"({"layers":[{"terrain":["a","b"]}]})",
                             R"({"layers":[{"depth":[]}]})",
                             R"({"layers":[{"depth":"a","step":"soon"}]})",
                             R"({"layers":[{"depth":"a","kind":"x"}]})",
                             R"({"layers":[{"barriers":"a","from":"noon"}]})",
                             R"({"layers":[{"imagery":"a","color":"red"}]})",
                             R"({"layers":[{"terrain":"a","depth":"b"}]})",
                             R"({"layers":[],"time":"noon"})",
                             R"({"layers":[],"camera":[]})",
                             R"({"layers":[],"camera":{"lon":1}})",
                             R"({"layers":[],"ground":"deep"})"}) {
        const auto scene = parse(text);
        ASSERT_FALSE(bool(scene)) << text;
        EXPECT_EQ(scene.error().kind, ErrorKind::Input);
        EXPECT_EQ(scene.error().message().find('\n'), std::string::npos);
    }
}
