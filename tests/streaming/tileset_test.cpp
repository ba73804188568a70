#include "streaming/tileset.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon {
namespace {

using namespace testing;

bool mentions(const std::vector<std::string>& all, const std::string& text) {
    return std::any_of(all.begin(), all.end(), [&](const std::string& line) {
        return line.find(text) != std::string::npos;
    });
}

TEST(Tileset, KeepsChildrenSideBySideAndInOrder) {
    const auto tree = parse(
        tileset(tile(box(0, 100), 10, "r.glb",
                     tile(box(0, 50), 5, "a.glb",
                          tile(box(0, 25), 0, "aa.glb") + "," + tile(box(25, 50), 0, "ab.glb")) +
                         "," + tile(box(50, 100), 5, "b.glb", tile(box(50, 75), 0, "ba.glb")),
                     R"("refine":"REPLACE")")));
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_EQ(tree->size(), 6u);
    const TileNode& root = tree->node(0);
    ASSERT_EQ(root.childCount, 2u);
    const TileNode& a = tree->node(root.firstChild);
    const TileNode& b = tree->node(root.firstChild + 1);
    EXPECT_EQ(a.path, "a.glb");
    EXPECT_EQ(b.path, "b.glb");
    EXPECT_EQ(tree->node(a.firstChild).path, "aa.glb");
    EXPECT_EQ(tree->node(a.firstChild + 1).path, "ab.glb");
    EXPECT_EQ(tree->node(b.firstChild).path, "ba.glb");
    EXPECT_EQ(tree->node(a.firstChild).level, 2);
    EXPECT_TRUE(tree->facts().warnings.empty());
}

TEST(Tileset, AcceptsTheVersionsThereAreAndNamesOthers) {
    const std::string root = tile(box(0, 1), 1, "a.glb");
    for (const char* version : {"0.0", "1.0", "1.1"})
        EXPECT_TRUE(
            parse(R"({"asset":{"version":")" + std::string(version) + R"("},"root":)" + root + "}"))
            << version;
    const auto future = parse(R"({"asset":{"version":"2.0"},"root":)" + root + "}");
    ASSERT_FALSE(future);
    EXPECT_NE(future.error().reason.find("2.0"), std::string::npos);
    EXPECT_FALSE(parse(R"({"asset":{},"root":)" + root + "}"));
    EXPECT_FALSE(parse(R"({"root":)" + root + "}"));
}

TEST(Tileset, NamesAnUnknownRequiredExtension) {
    const std::string root = tile(box(0, 1), 1, "a.glb");
    EXPECT_TRUE(parse(tileset(root, R"("extensionsRequired":["3DTILES_content_gltf"])")));
    const auto unknown = parse(tileset(root, R"("extensionsRequired":["VENDOR_magic"])"));
    ASSERT_FALSE(unknown);
    EXPECT_NE(unknown.error().reason.find("VENDOR_magic"), std::string::npos);
}

TEST(Tileset, ReadsRefineInAnyCaseAndHandsItDown) {
    const auto tree =
        parse(tileset(tile(box(0, 10), 8, "",
                           tile(box(0, 5), 4, "", tile(box(0, 2), 2, ""), R"("refine":"Replace")") +
                               "," + tile(box(5, 10), 4, "", "", R"("refine":"sideways")"),
                           R"("refine":"add")")));
    ASSERT_TRUE(tree);
    EXPECT_EQ(tree->node(0).refine, Refine::Add);
    EXPECT_EQ(tree->node(1).refine, Refine::Replace);
    EXPECT_EQ(tree->node(2).refine, Refine::Add);
    EXPECT_EQ(tree->node(3).refine, Refine::Replace);
    EXPECT_TRUE(mentions(tree->facts().warnings, "root.children[1]: refine"));
    const auto missing = parse(tileset(tile(box(0, 1), 1, "a.glb")));
    ASSERT_TRUE(missing);
    EXPECT_EQ(missing->node(0).refine, Refine::Replace);
    EXPECT_TRUE(mentions(missing->facts().warnings, "refine is missing"));
}

TEST(Tileset, ReadsTheOldNameOfUri) {
    const auto tree =
        parse(tileset("{" + box(0, 1) + R"(,"geometricError":1,"content":{"url":"a.b3dm?x=1"}})"));
    ASSERT_TRUE(tree);
    EXPECT_EQ(tree->node(0).path, "a.b3dm");
    EXPECT_EQ(tree->node(0).content, ContentKind::Mesh);
}

TEST(Tileset, TellsContentsByTheirNamesUntilTheyAreRead) {
    const auto kind = [](const char* uri) {
        return parse(tileset(tile(box(0, 1), 1, uri)))->node(0).content;
    };
    EXPECT_EQ(kind("a.json"), ContentKind::ExternalTileset);
    EXPECT_EQ(kind("a.JSON?x#y"), ContentKind::ExternalTileset);
    EXPECT_EQ(kind("a.GLB"), ContentKind::Mesh);
    EXPECT_EQ(kind("tile17"), ContentKind::Unknown);
}

TEST(Tileset, KeepsEveryOneOfSeveralContents) {
    for (const char* contents : {R"("contents":[{"uri":"a.glb"},{"uri":"b.glb"},{"uri":"c.glb"}])",
                                 R"("extensions":{"3DTILES_multiple_contents":
             {"contents":[{"uri":"a.glb"},{"uri":"b.glb"},{"uri":"c.glb"}]}})",
                                 R"("extensions":{"3DTILES_multiple_contents":
             {"content":[{"uri":"a.glb"},{"uri":"b.glb"},{"uri":"c.glb"}]}})"}) {
        const auto tree =
            parse(tileset(tile(box(0, 1), 1, "", tile(box(0, 1), 0, "d.glb"), contents)));
        ASSERT_TRUE(tree);
        std::set<std::string> paths;
        for (TileIndex i = 0; i != kNoTile; i = tree->node(i).nextContent)
            paths.insert(tree->node(i).path);
        EXPECT_EQ(paths, (std::set<std::string>{"a.glb", "b.glb", "c.glb"}));
        ASSERT_EQ(tree->node(0).childCount, 1u);
        EXPECT_EQ(tree->node(tree->node(0).firstChild).path, "d.glb");
    }
}

TEST(Tileset, MakesAChildOfAnExternalTilesetBesideChildren) {
    const auto tree = parse(tileset(tile(box(0, 1), 1, "ext.json", tile(box(0, 1), 0, "d.glb"))));
    ASSERT_TRUE(tree);
    ASSERT_EQ(tree->node(0).childCount, 2u);
    EXPECT_EQ(tree->node(0).content, ContentKind::None);
    EXPECT_EQ(tree->node(tree->node(0).firstChild + 1).path, "ext.json");
}

TEST(Tileset, MultipliesTransformsAndScalesErrorsWithThem) {
    const auto tree = parse(tileset(
        tile(box(0, 1), 8, "",
             tile(box(0, 1), 4, "a.glb", "", R"("transform":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1])"),
             R"("transform":[2,0,0,0,0,2,0,0,0,0,2,0,100,0,0,1])")));
    ASSERT_TRUE(tree);
    EXPECT_EQ(tree->ecefFromTile(1).origin().xyz, glm::dvec3(110, 0, 0));
    EXPECT_DOUBLE_EQ(tree->node(1).geometricErrorMetres, 8.0);
    const auto& volume = std::get<OrientedBox>(tree->node(1).volume);
    EXPECT_DOUBLE_EQ(volume.centre.xyz.x, 111.0);
    EXPECT_DOUBLE_EQ(volume.halfAxes[1].y, 100.0);
}

TEST(Tileset, LeavesRegionsWhereTheyAre) {
    const auto tree =
        parse(tileset(tile(R"("boundingVolume":{"region":[0.1,0.2,0.11,0.21,-5,30]})", 8, "a.glb",
                           "", R"("transform":[1,0,0,0,0,1,0,0,0,0,1,0,6000000,0,0,1])")));
    ASSERT_TRUE(tree);
    const auto& region = std::get<Region>(tree->node(0).volume);
    EXPECT_NEAR(region.westDegrees, 0.1 * 180 / M_PI, 1e-12);
    EXPECT_NEAR(region.northDegrees, 0.21 * 180 / M_PI, 1e-12);
    EXPECT_DOUBLE_EQ(region.maxHeightMetres, 30.0);
}

TEST(Tileset, FailsAContentWhoseUriLeadsAwayButKeepsTheTile) {
    for (const char* uri : {"../a.glb", "/etc/passwd", "file:///etc/passwd", "%2e%2e/a.glb"}) {
        const auto tree = parse(tileset(tile(box(0, 10), 8, uri, tile(box(0, 10), 0, "fine.glb"))));
        ASSERT_TRUE(tree);
        EXPECT_EQ(tree->node(0).state, LoadState::Failed) << uri;
        EXPECT_EQ(tree->node(0).childCount, 1u);
        ASSERT_EQ(tree->facts().leftOut.size(), 1u);
        EXPECT_EQ(tree->facts().leftOut[0].tile, 0u);
    }
    const auto empty =
        parse(tileset("{" + box(0, 1) + R"(,"geometricError":1,"content":{"uri":""}})"));
    ASSERT_TRUE(empty);
    EXPECT_EQ(empty->facts().leftOut.size(), 1u);
}

TEST(Tileset, RefusesWhatIsNoTileset) {
    for (const char* text :
         {"", " ", "{", "[]", "17", "null", "{}", R"({"asset":{"version":"1.0"}})",
          R"({"asset":{"version":"1.0"},"root":[]})", "b3dm\x01", "<html>"}) {
        const auto tree = parse(text);
        ASSERT_FALSE(tree) << text;
        EXPECT_EQ(tree.error().kind, ErrorKind::Input);
        EXPECT_EQ(tree.error().subject.substr(0, 12), "tileset.json");
    }
}

TEST(ExternalTileset, HangsBelowItsTileAndTakesOverWhatItDoesNotSay) {
    auto tree = parse(tileset(tile(box(0, 10), 8, "",
                                   tile(box(0, 5), 4, "sub/ext.json", "",
                                        R"("transform":[1,0,0,0,0,1,0,0,0,0,1,0,100,0,0,1])") +
                                       "," + tile(box(5, 10), 4, "b.glb"),
                                   R"("refine":"ADD")"),
                              R"("extras":0)"));
    ASSERT_TRUE(tree);
    const std::string external =
        R"({"asset":{"version":"1.0","gltfUpAxis":"Z"},"geometricError":4,"root":)" +
        tile(box(0, 5), 4, "c.glb", tile(box(0, 2), 0, "../d.glb")) + "}";
    const Failure failure = tree->attachExternal(1, bytesOf(external));
    ASSERT_FALSE(failure) << failure->message();
    EXPECT_EQ(tree->node(1).state, LoadState::Ready);
    ASSERT_EQ(tree->node(1).childCount, 1u);
    const TileNode& root = tree->node(tree->node(1).firstChild);
    EXPECT_EQ(root.path, "sub/c.glb") << "relative to the external file";
    EXPECT_EQ(root.refine, Refine::Add);
    EXPECT_EQ(root.gltfUpAxis, UpAxis::Z);
    EXPECT_EQ(root.parent, 1u);
    EXPECT_EQ(root.level, 1);
    EXPECT_EQ(std::get<OrientedBox>(root.volume).centre.xyz.x, 102.5);
    const TileNode& below = tree->node(root.firstChild);
    EXPECT_EQ(below.path, "d.glb");
    EXPECT_EQ(tree->facts().externals, 1u);
}

TEST(ExternalTileset, KeepsTheUpAxisOfTheFileThatRefersToIt) {
    auto tree = parse(R"({"asset":{"version":"1.0","gltfUpAxis":"Z"},"root":)" +
                      tile(box(0, 10), 8, "e.json") + "}");
    ASSERT_TRUE(tree);
    ASSERT_FALSE(tree->attachExternal(0, bytesOf(tileset(tile(box(0, 5), 4, "c.glb")))));
    EXPECT_EQ(tree->node(1).gltfUpAxis, UpAxis::Z);
}

TEST(ExternalTileset, MayBeUsedTwiceSideBySide) {
    auto tree = parse(tileset(tile(
        box(0, 10), 8, "", tile(box(0, 5), 4, "e.json") + "," + tile(box(5, 10), 4, "e.json"))));
    ASSERT_TRUE(tree);
    const Bytes external = bytesOf(tileset(tile(box(0, 5), 4, "x.glb")));
    EXPECT_FALSE(tree->attachExternal(1, external));
    EXPECT_FALSE(tree->attachExternal(2, external));
    EXPECT_EQ(tree->size(), 5u);
}

} // namespace
} // namespace gnomon
