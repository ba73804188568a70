#include "streaming/subtree.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace gnomon {
namespace {

using namespace testing;

Bytes binarySubtree(std::string json, Bytes binary) {
    json.resize((json.size() + 7) / 8 * 8, ' ');
    binary.resize((binary.size() + 7) / 8 * 8);
    Bytes out = bytesOf("subt");
    const auto put = [&](std::uint64_t value, int bytes) {
        for (int i = 0; i < bytes; ++i)
            out.push_back(std::byte(value >> (8 * i)));
    };
    put(1, 4);
    put(json.size(), 8);
    put(binary.size(), 8);
    const Bytes text = bytesOf(json);
    out.insert(out.end(), text.begin(), text.end());
    out.insert(out.end(), binary.begin(), binary.end());
    return out;
}

std::string implicitTileset(const std::string& scheme, int subtreeLevels, int availableLevels,
                            const std::string& volume) {
    return tileset("{" + volume + R"(,"geometricError":64,"refine":"REPLACE",
        "content":{"uri":"c/{level}_{x}_{y}_{z}.glb"},
        "implicitTiling":{"subdivisionScheme":")" +
                   scheme + R"(","subtreeLevels":)" + std::to_string(subtreeLevels) +
                   R"(,"availableLevels":)" + std::to_string(availableLevels) +
                   R"(,"subtrees":{"uri":"s/{level}_{x}_{y}_{z}.subtree"}}})");
}

const std::string kUnitBox = R"("boundingVolume":{"box":[0,0,0,8,0,0,0,8,0,0,0,8]})";

Failure attach(TileTree& tree, TileIndex tile, const Bytes& bytes) {
    auto subtree = parseSubtree(bytes, tree.node(tile).path, tree.subdivision(tile),
                                tree.subtreeLevels(tile), {});
    if (!subtree)
        return subtree.error();
    return tree.attachSubtree(tile, *subtree);
}

std::set<std::string> paths(const TileTree& tree, ContentKind kind) {
    std::set<std::string> out;
    for (TileIndex i = 0; i < tree.size(); ++i)
        if (tree.node(i).content == kind)
            out.insert(tree.node(i).path);
    return out;
}

TEST(Subtree, ReadsBitsLeastSignificantFirstInMortonOrder) {
    auto tree = parse(implicitTileset("QUADTREE", 3, 4, kUnitBox));
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_EQ(tree->node(0).content, ContentKind::Subtree);
    EXPECT_EQ(tree->node(0).path, "s/0_0_0_0.subtree");
    // Level 0: tile 0. Level 1: 1 + Morton 2 (x 0, y 1). Level 2: 5 + Morton 9 (child 1 of 2: x 1,
    // y 2). Child subtrees of that: Morton 9 * 4 + 3 = 39 (x 3, y 5).
    Bytes bits(16);
    bits[0] = std::byte((1 << 0) | (1 << 3));
    bits[1] = std::byte(1 << 6); // 5 + 9 = 14
    bits[8 + 39 / 8] = std::byte(1 << (39 % 8));
    const Bytes file = binarySubtree(
        R"({"buffers":[{"byteLength":16}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":3},
        {"buffer":0,"byteOffset":8,"byteLength":8}],"tileAvailability":{"bitstream":0},
        "contentAvailability":[{"bitstream":0}],"childSubtreeAvailability":{"bitstream":1}})",
        bits);
    const Failure failure = attach(*tree, 0, file);
    ASSERT_FALSE(failure) << failure->message();
    EXPECT_EQ(paths(*tree, ContentKind::Mesh),
              (std::set<std::string>{"c/0_0_0_0.glb", "c/1_0_1_0.glb", "c/2_1_2_0.glb"}));
    EXPECT_EQ(paths(*tree, ContentKind::Subtree), (std::set<std::string>{"s/3_3_5_0.subtree"}));
    ASSERT_EQ(tree->size(), 4u);
    const TileNode& deep = tree->node(2);
    EXPECT_EQ(deep.path, "c/2_1_2_0.glb");
    EXPECT_DOUBLE_EQ(deep.geometricErrorMetres, 16.0) << "halves at each level";
    const auto& volume = std::get<OrientedBox>(deep.volume);
    EXPECT_EQ(volume.centre.xyz, glm::dvec3(-8 + 1.5 * 4, -8 + 2.5 * 4, 0));
    EXPECT_EQ(volume.halfAxes[0], glm::dvec3(2, 0, 0));
    EXPECT_EQ(volume.halfAxes[2], glm::dvec3(0, 0, 8)) << "a quadtree leaves heights whole";
}

TEST(Subtree, SplitsHeightsInAnOctree) {
    auto tree = parse(implicitTileset("octree", 2, 2, kUnitBox));
    ASSERT_TRUE(tree) << tree.error().message();
    Bytes bits(8);
    bits[0] = std::byte(1 | (1 << (1 + 5))); // Morton 5: x 1, y 0, z 1
    const Bytes file = binarySubtree(
        R"({"buffers":[{"byteLength":8}],"bufferViews":[{"buffer":0,"byteLength":8}],
        "tileAvailability":{"bitstream":0},"contentAvailability":[{"constant":1}],
        "childSubtreeAvailability":{"constant":0}})",
        bits);
    ASSERT_FALSE(attach(*tree, 0, file));
    ASSERT_EQ(tree->size(), 2u);
    EXPECT_EQ(tree->node(1).path, "c/1_1_0_1.glb");
    const auto& volume = std::get<OrientedBox>(tree->node(1).volume);
    EXPECT_EQ(volume.centre.xyz, glm::dvec3(4, -4, 4));
    EXPECT_EQ(volume.halfAxes[2], glm::dvec3(0, 0, 4));
}

TEST(Subtree, SplitsRegionsAlsoAcrossTheAntimeridian) {
    auto tree = parse(implicitTileset("QUADTREE", 2, 2,
                                      R"("boundingVolume":{"region":[3.1,0.1,-3.1,0.3,-10,90]})"));
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_FALSE(attach(*tree, 0, bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":0}})")));
    ASSERT_EQ(tree->size(), 5u);
    const auto& south = std::get<Region>(tree->node(1).volume);
    const auto& east = std::get<Region>(tree->node(2).volume);
    EXPECT_NEAR(south.westDegrees, 3.1 / kRadiansPerDegree, 1e-9);
    EXPECT_NEAR(std::abs(south.eastDegrees), 180.0, 1e-9);
    EXPECT_NEAR(std::abs(east.westDegrees), 180.0, 1e-9);
    EXPECT_NEAR(east.eastDegrees, -3.1 / kRadiansPerDegree, 1e-9);
    EXPECT_NEAR(south.northDegrees, 0.2 / kRadiansPerDegree, 1e-9);
    EXPECT_DOUBLE_EQ(south.maxHeightMetres, 90.0);
}

TEST(Subtree, ReadsJsonOldNamesAndSeveralContents) {
    auto tree = parse(tileset("{" + kUnitBox + R"(,"geometricError":64,"refine":"ADD",
        "extensions":{"3DTILES_multiple_contents":{"content":[{"uri":"a{level}{x}{y}.glb"},
        {"uri":"b{level}{x}{y}.glb"}]},"3DTILES_implicit_tiling":{"subdivisionScheme":"QUADTREE",
        "subtreeLevels":2,"maximumLevel":1,"subtrees":{"uri":"s.subtree"}}}})"));
    ASSERT_TRUE(tree) << tree.error().message();
    const Bytes external(8, std::byte(0xff));
    const auto read = [&](const std::string& uri) -> Result<Bytes> {
        EXPECT_EQ(uri, "bits.bin");
        return external;
    };
    const auto subtree = parseSubtree(bytesOf(R"({"buffers":[{"uri":"bits.bin","byteLength":8}],
        "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":1}],
        "tileAvailability":{"bufferView":0},"childSubtreeAvailability":{"constant":0},
        "extensions":{"3DTILES_multiple_contents":{"contentAvailability":
        [{"constant":1},{"bufferView":0}]}}})"),
                                      "s.subtree", Subdivision::Quadtree, 2, read);
    ASSERT_TRUE(subtree) << subtree.error().message();
    ASSERT_FALSE(tree->attachSubtree(0, *subtree));
    EXPECT_EQ(paths(*tree, ContentKind::Mesh).size(), 10u);
    EXPECT_EQ(tree->node(0).childCount, 4u);
    EXPECT_NE(tree->node(0).nextContent, kNoTile);
    EXPECT_EQ(tree->facts().subtrees, 1u);
}

// Some writers leave beside it the availability of the only content that readers without the
// extension know.
TEST(Subtree, TheMultipleContentsExtensionSpeaksForAllContents) {
    const std::string text = tileset("{" + kUnitBox + R"(,"geometricError":64,"refine":"ADD",
        "extensions":{"3DTILES_multiple_contents":{"content":[{"uri":"a.glb"},{"uri":"b.glb"}]},
        "3DTILES_implicit_tiling":{"subdivisionScheme":"QUADTREE",
        "subtreeLevels":1,"maximumLevel":0,"subtrees":{"uri":"s.subtree"}}}})");
    const std::string first = R"({"tileAvailability":{"constant":1},
        "childSubtreeAvailability":{"constant":0},"contentAvailability":{"constant":1})";
    auto tree = parse(text);
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_FALSE(attach(*tree, 0, bytesOf(first + R"(,"extensions":{"3DTILES_multiple_contents":
        {"contentAvailability":[{"constant":1},{"constant":1}]}}})")));
    EXPECT_EQ(paths(*tree, ContentKind::Mesh), (std::set<std::string>{"a.glb", "b.glb"}));
    EXPECT_TRUE(tree->facts().warnings.empty());
    // Without it, what is lost is said.
    auto less = parse(text);
    ASSERT_TRUE(less);
    ASSERT_FALSE(attach(*less, 0, bytesOf(first + "}")));
    EXPECT_EQ(paths(*less, ContentKind::Mesh), (std::set<std::string>{"a.glb"}));
    ASSERT_EQ(less->facts().warnings.size(), 1u);
    EXPECT_NE(less->facts().warnings[0].find("names 2 contents, its subtrees tell of 1"),
              std::string::npos)
        << less->facts().warnings[0];
}

TEST(Subtree, ContentsThatAreNotToldOfAreSaidOnceAndNoneIsNoFault) {
    auto tree = parse(implicitTileset("QUADTREE", 1, 3, kUnitBox));
    ASSERT_TRUE(tree);
    const std::string all =
        R"({"tileAvailability":{"constant":1},"childSubtreeAvailability":{"constant":1})";
    ASSERT_FALSE(attach(*tree, 0, bytesOf(all + "}")));
    EXPECT_TRUE(tree->facts().warnings.empty()) << "a subtree without contents";
    const Bytes two = bytesOf(all + R"(,"contentAvailability":[{"constant":1},{"constant":1}]})");
    for (TileIndex tile = 1; tile <= 4; ++tile)
        ASSERT_FALSE(attach(*tree, tile, two));
    EXPECT_EQ(tree->facts().warnings.size(), 1u);
}

TEST(Subtree, GoesOnInChildSubtreesUpToTheAvailableLevels) {
    auto tree = parse(implicitTileset("QUADTREE", 2, 3, kUnitBox));
    ASSERT_TRUE(tree);
    const Bytes all = bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":1}})");
    ASSERT_FALSE(attach(*tree, 0, all));
    ASSERT_EQ(paths(*tree, ContentKind::Subtree).size(), 16u);
    const TileIndex last = tree->size() - 1;
    EXPECT_EQ(tree->node(last).path, "s/2_3_3_0.subtree");
    ASSERT_FALSE(attach(*tree, last, all));
    EXPECT_EQ(tree->node(last).content, ContentKind::Mesh);
    EXPECT_EQ(tree->node(last).path, "c/2_3_3_0.glb");
    EXPECT_EQ(tree->node(last).childCount, 0u) << "level 2 is the last of 3";
    EXPECT_TRUE(attach(*tree, last, all)) << "a subtree is attached once";
}

TEST(Subtree, RefusesImplicitTilingOfASphereOrAnUnknownScheme) {
    EXPECT_FALSE(
        parse(implicitTileset("QUADTREE", 2, 2, R"("boundingVolume":{"sphere":[0,0,0,1]})")));
    EXPECT_FALSE(parse(implicitTileset("HEXTREE", 2, 2, kUnitBox)));
    EXPECT_FALSE(parse(implicitTileset("QUADTREE", 2, 0, kUnitBox)));
}

TEST(Subtree, RefusesEveryTruncationAndLie) {
    Bytes bits(16, std::byte(0xff));
    const Bytes good = binarySubtree(
        R"({"buffers":[{"byteLength":16}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":3},
        {"buffer":0,"byteOffset":8,"byteLength":8}],"tileAvailability":{"bitstream":0},
        "contentAvailability":[{"bitstream":0}],"childSubtreeAvailability":{"bitstream":1}})",
        bits);
    const auto accepted = [](const Bytes& bytes) {
        return bool(parseSubtree(bytes, "s", Subdivision::Quadtree, 3, {}));
    };
    ASSERT_TRUE(accepted(good));
    for (std::size_t n = 0; n < good.size(); ++n)
        EXPECT_FALSE(accepted(Bytes(good.begin(), good.begin() + std::ptrdiff_t(n)))) << n;
    for (const std::size_t at : {4u, 11u, 15u, 16u, 23u}) { // version and lengths
        Bytes lie = good;
        lie[at] = std::byte(0xff);
        EXPECT_FALSE(accepted(lie)) << at;
    }
    const char* const bad[] = {
        R"({})",
        R"({"tileAvailability":17})",
        R"({"tileAvailability":{"constant":2}})",
        R"({"tileAvailability":{"constant":-1}})",
        R"({"tileAvailability":{"bitstream":0}})",
        R"({"tileAvailability":{"bitstream":0},"bufferViews":[{"buffer":0,"byteLength":3}]})",
        R"({"tileAvailability":{"bitstream":0},"bufferViews":[{"buffer":0,"byteLength":3}],
            "buffers":[{"byteLength":3}]})",
        R"({"tileAvailability":{"bitstream":0},"bufferViews":[{"buffer":0,"byteLength":3}],
            "buffers":[{"byteLength":3,"uri":"away.bin"}]})",
        R"({"tileAvailability":{"constant":1},"contentAvailability":[7]})",
    };
    for (const char* text : bad)
        EXPECT_FALSE(accepted(bytesOf(text))) << text;
    const auto wrap = binarySubtree(
        R"({"buffers":[{"byteLength":16}],"bufferViews":[{"buffer":0,
        "byteOffset":18446744073709551615,"byteLength":3}],"tileAvailability":{"bitstream":0}})",
        bits);
    EXPECT_FALSE(accepted(wrap)) << "offset plus length wraps";
}

TEST(Subtree, CountsAvailabilityLikeItsBits) {
    Availability bits;
    bits.bits = {std::byte(0b10110001), std::byte(0b00000111)};
    EXPECT_EQ(bits.available(8), 4u);
    EXPECT_EQ(bits.available(10), 6u);
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < 16; ++i)
        n += bits[i];
    EXPECT_EQ(bits.available(16), n);
    EXPECT_EQ((Availability{{}, true}.available(7)), 7u);
}

} // namespace
} // namespace gnomon
