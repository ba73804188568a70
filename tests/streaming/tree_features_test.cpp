// What tilesets say beside their tiles: viewer request volumes, groups, metadata and extensions of
// 3D Tiles 1.0 and 1.1 that must not be in the way.
#include "streaming/inventory.h"
#include "streaming/subtree.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace gnomon {
namespace {

using namespace testing;

TEST(ViewerRequestVolume, IsPlacedAsTheTileIs) {
    const auto tree = parse(tileset(tile(box(0, 100), 10, "r.glb", {},
                                         R"("transform":[1,0,0,0, 0,1,0,0, 0,0,1,0, 1000,0,0,1],
        "viewerRequestVolume":{"sphere":[1,2,3,40]})")));
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_TRUE(tree->node(0).viewerRequestVolume);
    const auto& sphere = std::get<Sphere>(*tree->node(0).viewerRequestVolume);
    EXPECT_EQ(sphere.centre.xyz, glm::dvec3(1001, 2, 3));
    EXPECT_EQ(sphere.radiusMetres, 40.0);
}

TEST(ViewerRequestVolume, ThatCannotBeUsedIsIgnoredAndSaid) {
    const auto tree = parse(
        tileset(tile(box(0, 100), 10, "r.glb", {}, R"("viewerRequestVolume":{"sphere":[1,2,3]})")));
    ASSERT_TRUE(tree);
    EXPECT_FALSE(tree->node(0).viewerRequestVolume);
    ASSERT_FALSE(tree->facts().warnings.empty());
    EXPECT_NE(tree->facts().warnings[0].find("viewerRequestVolume"), std::string::npos);
}

TEST(ViewerRequestVolume, IsKeptByAnImplicitTilingsRootAlone) {
    auto tree = parse(tileset(R"({"boundingVolume":{"box":[0,0,0,8,0,0,0,8,0,0,0,8]},
        "geometricError":64,"refine":"ADD","content":{"uri":"{level}.glb"},
        "viewerRequestVolume":{"sphere":[0,0,0,100]},
        "implicitTiling":{"subdivisionScheme":"QUADTREE","subtreeLevels":2,"availableLevels":2,
        "subtrees":{"uri":"s"}}})"));
    ASSERT_TRUE(tree) << tree.error().message();
    const auto subtree = parseSubtree(bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":0}})"),
                                      "s", Subdivision::Quadtree, 2, {});
    ASSERT_TRUE(subtree);
    ASSERT_FALSE(tree->attachSubtree(0, *subtree));
    ASSERT_EQ(tree->size(), 5u);
    EXPECT_TRUE(tree->node(0).viewerRequestVolume);
    EXPECT_FALSE(tree->node(1).viewerRequestVolume);
}

TEST(Metadata, OfTilesetsTilesGroupsAndContentsIsInNobodysWay) {
    for (const char* extensions :
         {R"("extensionsUsed":["3DTILES_metadata"],"extensionsRequired":["3DTILES_metadata"],
             "extensions":{"3DTILES_metadata":{"schema":{"classes":{}},"groups":{},
             "statistics":{},"tileset":{"class":"x"}}})",
          R"("schema":{"id":"s","classes":{"a":{"properties":{"p":{"type":"STRING"}}}}},
             "metadata":{"class":"a","properties":{"p":"v"}},
             "groups":[{"class":"a"}],"statistics":{"classes":{"a":{"count":3}}})",
          R"("schemaUri":"there/is/none.json","metadata":7,"groups":"x","statistics":[])"}) {
        const std::string root =
            R"({"boundingVolume":{"box":[0,0,0,8,0,0,0,8,0,0,0,8]},"geometricError":64,
            "refine":"Add","metadata":{"class":"a","properties":{"p":"v"}},
            "content":{"uri":"a.glb","group":0,"metadata":{"class":"a"}},
            "extensions":{"3DTILES_metadata":{"class":"a"}}})";
        const auto tree = parse(tileset(root, extensions));
        ASSERT_TRUE(tree) << tree.error().message();
        EXPECT_EQ(tree->node(0).path, "a.glb");
        EXPECT_TRUE(tree->facts().warnings.empty()) << tree->facts().warnings[0];
    }
}

TEST(Metadata, OfSubtreesIsInNobodysWay) {
    const auto read = [](const std::string& more) {
        return parseSubtree(bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":0},)" +
                                    more + "}"),
                            "s", Subdivision::Quadtree, 2, {});
    };
    EXPECT_TRUE(read(R"("propertyTables":[{"class":"t","count":5,"properties":{}}],
        "tileMetadata":0,"contentMetadata":[1],"subtreeMetadata":{"class":"s"})"));
    EXPECT_TRUE(read(R"("propertyTables":"none","tileMetadata":-7,"contentMetadata":{})"));
    EXPECT_TRUE(read(R"("extensions":{"3DTILES_metadata":{"propertyTables":[]}})"));
}

// The mesh of every tile of a real octree lies in the cell that its place in the subtrees implies.
TEST(SampleTiles, MeshesOfAnOctreeLieInTheirCells) {
    const char* given = std::getenv("GNOMON_DATA");
    const std::filesystem::path folder =
        (given ? std::filesystem::path(given)
               : std::filesystem::path(GNOMON_SOURCE_DIR) / "../shared/data") /
        "tiles-cesium-1.1-samples/1.1/SparseImplicitOctree";
    if (!std::filesystem::exists(folder))
        GTEST_SKIP() << "no " << folder;
    const auto tileset = StreamedTileset::open(fileSource(folder.string()), "tileset.json", {}, {});
    ASSERT_TRUE(tileset) << tileset.error().message();
    ASSERT_FALSE(expandAll(**tileset));
    const TileTree& tree = (*tileset)->tree();
    EXPECT_EQ(tree.size(), 58u);
    std::size_t meshes = 0;
    for (TileIndex i = 0; i < tree.size(); ++i) {
        const LoadRequest request{i, 0.0};
        (*tileset)->request({&request, 1});
        (*tileset)->waitForAll();
        (*tileset)->poll();
        const auto content = (*tileset)->content(i);
        for (const Mesh& mesh : content ? content->meshes : std::vector<Mesh>{}) {
            ++meshes;
            const double size = boundingSphere(tree.node(i).volume).radiusMetres;
            EXPECT_LT(distanceTo(tree.node(i).volume, mesh.box.centre), 0.01 * size)
                << tree.name(i);
            EXPECT_LT(mesh.radiusMetres, 1.05 * size) << tree.name(i);
        }
    }
    EXPECT_EQ(meshes, 31u);
}

} // namespace
} // namespace gnomon
