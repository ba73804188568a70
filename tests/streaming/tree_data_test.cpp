// Public data sets, end to end: what is in them is known from their own descriptions.
#include "streaming/inventory.h"
#include "streaming/subtree.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace gnomon {
namespace {

namespace fs = std::filesystem;
using namespace testing;

fs::path dataFolder() {
    const char* given = std::getenv("GNOMON_DATA");
    return given ? fs::path(given) : fs::path(GNOMON_SOURCE_DIR) / "../shared/data";
}

#define NEEDS_DATA(name)                                                                           \
    const fs::path folder = dataFolder() / name;                                                   \
    if (!fs::exists(folder))                                                                       \
    GTEST_SKIP() << "no data set " << name << " in " << dataFolder()

std::unique_ptr<StreamedTileset> openIn(const fs::path& folder, const std::string& file) {
    auto opened = StreamedTileset::open(fileSource(folder.string()), file, {}, {});
    EXPECT_TRUE(opened) << opened.error().message();
    return opened ? std::move(*opened) : nullptr;
}

std::uint64_t total(const Inventory& inventory) {
    std::uint64_t n = 0;
    for (const auto& [format, count] : inventory.contents)
        n += count;
    return n;
}

TEST(AmsterdamTiles, HasTenContentsOnTheEarth) {
    NEEDS_DATA("tiles-amsterdam-b3dm");
    const auto tileset = openIn(folder, "tileset.json");
    ASSERT_TRUE(tileset);
    const Inventory inventory = takeInventory(*tileset, {});
    EXPECT_EQ(inventory.contents.at("b3dm"), 10u);
    EXPECT_TRUE(inventory.failures.empty());
    EXPECT_EQ(inventory.refine.count(Refine::Add), 1u);
    ASSERT_TRUE(inventory.bounds);
    EXPECT_NEAR(inventory.bounds->westDegrees, 4.9, 0.1);
    EXPECT_NEAR(inventory.bounds->northDegrees, 52.37, 0.1);
}

TEST(DelawareTiles, HasFiftyNineContentsUnderTwentyNineSubtrees) {
    NEEDS_DATA("tiles-delaware-implicit");
    const auto tileset = openIn(folder, "tileset.json");
    ASSERT_TRUE(tileset);
    EXPECT_EQ(tileset->tree().facts().version, "1.0");
    const Inventory inventory = takeInventory(*tileset, {});
    EXPECT_EQ(inventory.contents.at("b3dm"), 59u);
    EXPECT_EQ(inventory.subtrees, 29u);
    EXPECT_TRUE(inventory.failures.empty());
    EXPECT_EQ(inventory.levels, 5u);
    ASSERT_TRUE(inventory.bounds);
    EXPECT_NEAR(inventory.bounds->westDegrees, -75.6, 0.05);
}

TEST(DelawareTiles, EachTilesMeshLiesInItsOwnRegion) {
    NEEDS_DATA("tiles-delaware-implicit");
    const auto tileset = openIn(folder, "tileset.json");
    ASSERT_TRUE(tileset);
    const View everything = viewFrom(1237929.375, -4795306.0, 4005629.75, 1e9);
    SelectOptions finest;
    finest.maximumScreenSpaceError = 1e-9;
    const Settled settled = settle(*tileset, {&everything, 1}, finest, soon(60));
    ASSERT_TRUE(settled.complete);
    ASSERT_EQ(settled.selection.draw.size(), 59u);
    const TileTree& tree = tileset->tree();
    for (const TileIndex tile : settled.selection.draw)
        for (const Mesh& mesh : tileset->content(tile)->meshes)
            EXPECT_LT(distanceTo(tree.node(tile).volume, mesh.box.centre), 50.0)
                << tree.name(tile) << ": wrong bit order would put it kilometres away";
}

TEST(MarsTiles, HasAllContentsInEveryVariant) {
    NEEDS_DATA("tiles-mars-terrain-replace");
    struct Case {
        const char* file;
        std::uint64_t contents;
        std::vector<std::string> missing;
    };
    const Case cases[] = {
        {"tileset.json", 293, {}},
        {"tileset-no-root-content.json", 292, {}},
        {"tileset-no-midtile-content.json", 292, {}},
        {"tileset-broken-root-content.json", 292, {"root-non-existent.b3dm"}},
        {"tileset-external-with-url-params.json", 293, {}},
        {"tileset-external-broken.json", 272, {"nonexistent.json"}},
    };
    for (const Case& c : cases) {
        const auto tileset = openIn(folder, c.file);
        ASSERT_TRUE(tileset) << c.file;
        const Inventory inventory = takeInventory(*tileset, {});
        EXPECT_EQ(total(inventory), c.contents) << c.file;
        EXPECT_EQ(inventory.levels, 5u) << c.file;
        std::vector<std::string> missing;
        for (const FailedTile& failed : inventory.failures)
            missing.push_back(fs::path(failed.error.subject).filename().string());
        EXPECT_EQ(missing, c.missing) << c.file;
    }
}

TEST(MarsTiles, EveryVariantSettlesFromFarAndNear) {
    NEEDS_DATA("tiles-mars-terrain-replace");
    for (const char* file : {"tileset.json", "tileset-no-root-content.json",
                             "tileset-no-midtile-content.json", "tileset-broken-root-content.json",
                             "tileset-external.json", "tileset-external-broken.json"}) {
        const auto tileset = openIn(folder, file);
        ASSERT_TRUE(tileset);
        for (const double distance : {1e6, 3000.0, 500.0, 0.0}) {
            const View view = viewFrom(216 - distance, 32, 90);
            const std::uint64_t before = tileset->tilesLoaded();
            const Settled settled = settle(*tileset, {&view, 1}, {}, soon(60));
            ASSERT_TRUE(settled.complete) << file;
            EXPECT_FALSE(settled.selection.draw.empty()) << file << " at " << distance;
            EXPECT_EQ(settled.selection.draw, settled.selection.wanted) << file;
            EXPECT_LE(tileset->tilesLoaded() - before, settled.selection.wanted.size());
        }
    }
}

TEST(SampleTiles, SparseImplicitTilingsHaveTheirContents) {
    NEEDS_DATA("tiles-cesium-1.1-samples");
    const auto count = [&](const fs::path& sub, const char* ending) {
        std::size_t n = 0;
        for (const auto& entry : fs::directory_iterator(sub))
            n += entry.path().extension() == ending;
        return n;
    };
    for (const char* name : {"SparseImplicitQuadtree", "SparseImplicitOctree"}) {
        const fs::path sub = folder / "1.1" / name;
        const auto tileset = openIn(sub, "tileset.json");
        ASSERT_TRUE(tileset);
        const Inventory inventory = takeInventory(*tileset, {});
        EXPECT_EQ(total(inventory), count(sub / "content", ".glb")) << name;
        EXPECT_EQ(inventory.subtrees, count(sub / "subtrees", ".subtree")) << name;
        EXPECT_TRUE(inventory.failures.empty()) << name;
    }
}

} // namespace
} // namespace gnomon
