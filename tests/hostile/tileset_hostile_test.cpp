// HOSTILE.md, items 18 to 24: tilesets that go round in circles, swell, or stand nowhere.
#include "streaming/inventory.h"
#include "streaming/subtree.h"
#include "tests/hostile/confined.h"
#include "tests/streaming/glb_builder.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon {
namespace {

using namespace testing;
using test::Outcome;
using test::runConfined;

bool mentions(const std::vector<LeftOut>& all, const std::string& text) {
    return std::any_of(all.begin(), all.end(), [&](const LeftOut& out) {
        return out.error.message().find(text) != std::string::npos;
    });
}

bool mentions(const std::vector<std::string>& all, const std::string& text) {
    return std::any_of(all.begin(), all.end(), [&](const std::string& line) {
        return line.find(text) != std::string::npos;
    });
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

// All of a tileset, and how it went; in a process of its own.
Outcome takeAll(const std::map<std::string, std::string>& files, const std::string& words,
                double seconds = test::kMostSeconds) {
    test::Confinement how;
    how.cpuSeconds = seconds;
    return runConfined(
        [&] {
            auto source = std::make_shared<MemorySource>();
            for (const auto& [path, text] : files)
                source->files[path] = bytesOf(text);
            const auto tileset = open(source);
            if (!tileset)
                return std::string("not opened");
            bool said = words.empty();
            if (const Failure failure = expandAll(*tileset))
                said = said || failure->message().find(words) != std::string::npos;
            for (const FailedTile& failed : tileset->failures())
                said = said || failed.error.message().find(words) != std::string::npos;
            return std::string(said ? "" : "nobody said: " + words);
        },
        how);
}

void expectFine(const Outcome& outcome) {
    EXPECT_EQ(outcome.trouble(), "");
    EXPECT_EQ(outcome.said, "");
    std::printf("    %.2f s, %zu MiB\n", outcome.cpuSeconds, outcome.peakBytes >> 20);
}

} // namespace

TEST(HostileTileset, Item18AnExternalTilesetThatContainsItselfIsRefused) {
    const std::string self = tileset(tile(box(0, 10), 8, "tileset.json"));
    auto tree = parse(self);
    ASSERT_TRUE(tree);
    const Failure failure = tree->attachExternal(0, bytesOf(self));
    ASSERT_TRUE(failure);
    EXPECT_NE(failure->reason.find("contains itself"), std::string::npos);

    auto a = parse(tileset(tile(box(0, 10), 8, "b.json")), "a.json");
    ASSERT_TRUE(a);
    ASSERT_FALSE(a->attachExternal(0, bytesOf(tileset(tile(box(0, 10), 8, "a.json")))));
    EXPECT_TRUE(a->attachExternal(1, bytesOf(tileset(tile(box(0, 10), 8, "b.json")))));
}

TEST(HostileTileset, Item18ExternalTilesetsAreNotNestedDeeperThanSixteen) {
    auto tree = parse(tileset(tile(box(0, 10), 8, "0.json")));
    ASSERT_TRUE(tree);
    unsigned depth = 0;
    for (; depth < 100; ++depth)
        if (tree->attachExternal(
                tree->size() - 1,
                bytesOf(tileset(tile(box(0, 10), 8, std::to_string(depth + 1) + ".json")))))
            break;
    EXPECT_EQ(depth, kMaxExternalDepth);
}

TEST(HostileTileset, Item18ACircleOfFilesFailsWhereItClosesAndSiblingsAreDrawn) {
    auto source = std::make_shared<MemorySource>();
    const auto add = [&](const char* path, const char* next, const char* model) {
        source->files[path] = bytesOf(tileset(tile(
            box(0, 100), 100, "", tile(box(0, 50), 50, next) + "," + tile(box(50, 100), 0, model),
            R"("refine":"ADD")")));
        source->files[model] = glb(1);
    };
    add("tileset.json", "b.json", "1.glb");
    add("b.json", "c.json?again=1", "2.glb");
    add("c.json", "./x/../tileset.json#there", "3.glb");
    const auto tileset = open(source);
    ASSERT_TRUE(tileset);
    const View view = viewFrom(50, 50, 50);
    const Settled settled = settle(*tileset, {&view, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 3u);
    ASSERT_EQ(tileset->failures().size(), 1u);
    EXPECT_NE(tileset->failures()[0].error.message().find("contains itself"), std::string::npos);
}

TEST(HostileTileset, Item18AnEmptyUriIsLeftOut) {
    const auto tree =
        parse(tileset("{" + box(0, 1) + R"(,"geometricError":1,"content":{"uri":""},"children":[)" +
                      tile(box(0, 1), 0, "fine.glb") + "]}"));
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_EQ(tree->facts().leftOut.size(), 1u);
    EXPECT_NE(tree->facts().leftOut[0].error.reason.find("empty"), std::string::npos);
    EXPECT_EQ(tree->node(1).path, "fine.glb");
}

// No circle, but sixteen files that each name the next ten times: 10^16 tiles.
TEST(HostileTileset, Item18FilesThatMultiplyEndAtTheMostTilesThereMayBe) {
    std::map<std::string, std::string> files;
    for (int i = 0; i < 16; ++i) {
        std::string children;
        for (int k = 0; k < 10; ++k)
            // An error to be warned of each.
            children += (k ? "," : "") + tile(box(0, 10), -1, std::to_string(i + 1) + ".json");
        files[i == 0 ? "tileset.json" : std::to_string(i) + ".json"] =
            tileset(tile(box(0, 10), 2, "", children));
    }
    // A few kilobytes, but a hundred thousand reads of them: the full tree, and the program.
    const Outcome outcome = takeAll(files, "more than", 60.0);
    EXPECT_EQ(outcome.trouble(test::kMostBytes + (std::size_t(64) << 20)), "");
    EXPECT_EQ(outcome.said, "");
    std::printf("    %.2f s, %zu MiB\n", outcome.cpuSeconds, outcome.peakBytes >> 20);
}

TEST(HostileTileset, Item19ImplicitBombsAreRefusedBeforeAnythingIsAllocated) {
    const auto deep = parse(implicitTileset("QUADTREE", 30, 30, kUnitBox));
    ASSERT_FALSE(deep);
    EXPECT_NE(deep.error().reason.find("subtreeLevels 30"), std::string::npos);
    EXPECT_FALSE(parse(implicitTileset("OCTREE", 2'000'000'000, 30, kUnitBox)));
    EXPECT_FALSE(parse(implicitTileset("QUADTREE", -1, 30, kUnitBox)));
    EXPECT_FALSE(parse(implicitTileset("QUADTREE", 0, 30, kUnitBox)));

    auto wide = parse(implicitTileset("QUADTREE", 12, 24, kUnitBox));
    ASSERT_TRUE(wide);
    const Failure failure = attach(*wide, 0, bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":1}})"));
    ASSERT_TRUE(failure);
    EXPECT_EQ(wide->size(), 1u);
}

// Every subtree says that all it may have is there: 4^21 tiles by a file of 150 bytes.
TEST(HostileTileset, Item19SubtreesWithoutEndStopAtTheMostTilesThereMayBe) {
    auto tree = parse(implicitTileset("QUADTREE", 7, 21, kUnitBox));
    ASSERT_TRUE(tree) << tree.error().message();
    const Bytes all = bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":1}})");
    TileIndex next = 0;
    Failure failure;
    for (; !failure && next < tree->size(); ++next)
        if (tree->node(next).content == ContentKind::Subtree)
            failure = attach(*tree, next, all);
    ASSERT_TRUE(failure);
    EXPECT_NE(failure->reason.find("more than"), std::string::npos) << failure->reason;
    EXPECT_TRUE(tree->isFull());
    EXPECT_LE(tree->size(), kMaxTilesOfSubtrees);
}

// One template that leads away is one error, not one for each of 87,381 tiles.
TEST(HostileTileset, Item19ATemplateThatLeadsAwayIsToldOnce) {
    std::string text = implicitTileset("QUADTREE", 9, 9, kUnitBox);
    text.replace(text.find("c/{level}"), 2, "../../");
    auto tree = parse(text);
    ASSERT_TRUE(tree) << tree.error().message();
    ASSERT_FALSE(attach(*tree, 0, bytesOf(R"({"tileAvailability":{"constant":1},
        "contentAvailability":[{"constant":1}],"childSubtreeAvailability":{"constant":0}})")));
    EXPECT_EQ(tree->size(), 87381u);
    ASSERT_EQ(tree->facts().leftOut.size(), 1u);
    EXPECT_NE(tree->facts().leftOut[0].error.reason.find("leads out"), std::string::npos);
}

// A template is put in for every tile: a long one would fill the memory by the number of tiles.
TEST(HostileTileset, Item19ALongTemplateDoesNotMultiply) {
    const struct {
        std::size_t characters;
        int levels;
        const char* words;
    } cases[] = {{900'000, 9, "longer than 4096"}, {4000, 9, "more than"}, {1000, 9, ""}};
    for (const auto& c : cases) {
        std::string text = implicitTileset("QUADTREE", c.levels, c.levels, kUnitBox);
        text.replace(text.find("c/{level}"), 2, std::string(c.characters, 'c') + "/");
        const std::map<std::string, std::string> files = {
            {"tileset.json", text},
            {"s/0_0_0_0.subtree",
             R"({"tileAvailability":{"constant":1},"contentAvailability":)"
             R"([{"constant":1}],"childSubtreeAvailability":{"constant":0}})"}};
        expectFine(takeAll(files, c.words));
    }
}

TEST(HostileTileset, Item20TakesAHundredThousandNestedChildren) {
    constexpr int kDepth = 100'000;
    std::string text;
    const std::string head = R"({"boundingVolume":{"sphere":[0,0,0,9]},"geometricError":1,)"
                             R"("content":{"uri":"a.glb"},"children":[)";
    for (int i = 0; i < kDepth; ++i)
        text += head;
    for (int i = 0; i < kDepth; ++i)
        text += "]}";
    const auto tree = parse(tileset(text));
    ASSERT_TRUE(tree) << tree.error().message();
    EXPECT_EQ(tree->size(), TileIndex(kDepth));
    EXPECT_EQ(tree->node(kDepth - 1).level, 0xffff);
    // And one wrong at the very bottom is named in a line of sensible length.
    std::string bad;
    for (int i = 0; i < kDepth; ++i)
        bad += head;
    bad += "5";
    for (int i = 0; i < kDepth; ++i)
        bad += "]}";
    const auto named = parse(tileset(bad));
    ASSERT_TRUE(named);
    ASSERT_EQ(named->facts().leftOut.size(), 1u);
    EXPECT_LT(named->facts().leftOut[0].error.message().size(), 400u);
    // Nesting that is no tile at all.
    EXPECT_FALSE(parse(std::string(200'000, '[')));
    EXPECT_FALSE(parse(std::string(200'000, '[') + std::string(200'000, ']')));
}

TEST(HostileTileset, Item20TakesAHundredThousandSiblings) {
    std::string children = tile(box(0, 1), 0, "a.glb");
    const std::string one = "," + children;
    for (int i = 1; i < 100'000; ++i)
        children += one;
    const auto tree = parse(tileset(tile(box(0, 1), 1, "", children)));
    ASSERT_TRUE(tree);
    EXPECT_EQ(tree->node(0).childCount, 100'000u);
}

TEST(HostileTileset, Item20CountsFlawsInsteadOfNamingAMillion) {
    std::string children = "1";
    for (int i = 1; i < 50'000; ++i)
        children += ",1";
    const auto tree = parse(tileset(tile(box(0, 1), 1, "a.glb", children)));
    ASSERT_TRUE(tree);
    EXPECT_LE(tree->facts().leftOut.size(), 1001u);
    EXPECT_TRUE(mentions(tree->facts().leftOut, "49000 more"));
}

TEST(HostileTileset, Item20AMillionTilesAreReadAndOneMoreThanTheMostIsRefused) {
    const std::string one = R"({"boundingVolume":{"sphere":[0,0,0,1]},"geometricError":0})";
    std::string children = one;
    for (std::size_t i = 2; i < 1'000'000; ++i)
        children += "," + one;
    const std::string million = tileset(tile(box(0, 1), 1, "", children));
    for (std::size_t i = 1'000'000; i < kMaxTiles + 1; ++i)
        children += "," + one;
    const std::string tooMany = tileset(tile(box(0, 1), 1, "", children));
    test::Confinement how;
    how.cpuSeconds = 30.0;
    const Outcome read = runConfined(
        [&] {
            const auto tree = parse(million);
            if (!tree)
                return tree.error().message();
            const View view = viewFrom(0.5, 0.5, 0.5);
            return std::string(tree->size() == 1'000'000 &&
                                       select(*tree, {&view, 1}, {}).visited > 999'999
                                   ? ""
                                   : "not all were seen");
        },
        how);
    EXPECT_EQ(read.trouble(std::size_t(3) << 30), "");
    EXPECT_EQ(read.said, "");
    std::printf("    %zu MB: %.2f s, %zu MiB\n", million.size() / 1'000'000, read.cpuSeconds,
                read.peakBytes >> 20);
    const Outcome refused = runConfined(
        [&] {
            const auto tree = parse(tooMany);
            return tree ? "taken" : tree.error().reason;
        },
        how);
    EXPECT_NE(refused.said.find("more than " + std::to_string(kMaxTiles)), std::string::npos)
        << refused.said;
}

TEST(HostileTileset, Item21WhatStandsNowhereIsLeftOutAndNamed) {
    struct Case {
        const char *child, *reason;
    };
    const Case cases[] = {
        {R"({"geometricError":1})", "boundingVolume"},
        {R"(17)", "no object"},
        {R"({"boundingVolume":{"box":[1,2,3]},"geometricError":1})", "12 finite numbers"},
        {R"({"boundingVolume":{"box":[1,2,3,4,5,6,7,8,9,"x",11,12]},"geometricError":1})",
         "12 finite numbers"},
        {R"({"boundingVolume":{"sphere":[0,0,0,-1]},"geometricError":1})", "negative radius"},
        {R"({"boundingVolume":{"sphere":[0,0,1e300,1]},"geometricError":1})", "1e12"},
        {R"({"boundingVolume":{"region":[0,0.3,0.1,0.2,0,1]},"geometricError":1})", "south"},
        {R"({"boundingVolume":{"region":[0,-3,0.1,3,0,1]},"geometricError":1})", "radians"},
        {R"({"boundingVolume":{"sphere":[0,0,0,1]},"geometricError":1,
             "transform":[0,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]})",
         "singular"},
        {R"({"boundingVolume":{"sphere":[0,0,0,1]},"geometricError":1,
             "transform":[1e300,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]})",
         "1e12"},
        {R"({"boundingVolume":{"sphere":[0,0,0,1]},"geometricError":1,
             "transform":[NaN,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]})",
         "16 finite numbers"},
        {R"({"boundingVolume":{"sphere":[0,0,0,1]},"geometricError":1,"transform":"here"})",
         "16 finite numbers"},
        {R"({"boundingVolume":{"sphere":[0,0,0,1]},"geometricError":1,
             "transform":[1,0,0,7,0,1,0,0,0,0,1,0,0,0,0,1]})",
         "not affine"},
        {R"({"boundingVolume":{"extensions":{"3DTILES_bounding_volume_S2":{"token":"89c6c7"}}},
             "geometricError":1})",
         "S2"},
    };
    for (const Case& c : cases) {
        const auto tree = parse(tileset(tile(box(0, 10), 8, "r.glb",
                                             tile(box(0, 5), 4, "before.glb") + "," + c.child +
                                                 "," + tile(box(5, 10), 4, "after.glb"))));
        ASSERT_TRUE(tree) << c.child << tree.error().message();
        ASSERT_EQ(tree->node(0).childCount, 2u) << c.child;
        EXPECT_EQ(tree->node(2).path, "after.glb");
        ASSERT_EQ(tree->facts().leftOut.size(), 1u) << c.child;
        EXPECT_NE(tree->facts().leftOut[0].error.reason.find(c.reason), std::string::npos)
            << tree->facts().leftOut[0].error.message();
        EXPECT_EQ(tree->facts().leftOut[0].error.subject, "tileset.json: root.children[1]");
        // The same as a root is an error of the file.
        EXPECT_FALSE(parse(tileset(c.child))) << c.child;
    }
}

TEST(HostileTileset, Item21AZeroVolumeBoxIsSelectedAndNothingIsNotFinite) {
    for (const char* volume :
         {R"("boundingVolume":{"box":[5,5,5,0,0,0,0,0,0,0,0,0]})",
          R"("boundingVolume":{"box":[5,5,5,1,0,0,1,0,0,1,0,0]})", // all along one line
          R"("boundingVolume":{"sphere":[5,5,5,0]})",
          R"("boundingVolume":{"region":[0.1,0.1,0.1,0.1,0,0]})",
          R"("boundingVolume":{"region":[0.1,0.1,0.2,0.2,9,-9]})",
          R"("boundingVolume":{"region":[0,-1.5707963267948966,0,1.5707963267948966,0,0]})"}) {
        const auto tree =
            parse(tileset("{" + std::string(volume) +
                          R"(,"geometricError":10,"content":{"uri":"a.glb"},"children":[{)" +
                          volume + R"(,"geometricError":0,"content":{"uri":"b.glb"}}]})"));
        ASSERT_TRUE(tree) << volume << tree.error().message();
        for (const View& view : {viewFrom(5, 5, 5), viewFrom(0, 0, 0), viewFrom(6.4e6, 1, 1)}) {
            const Selection selection = select(*tree, {&view, 1}, {});
            ASSERT_EQ(selection.wanted.size(), 1u) << volume;
            for (const LoadRequest& request : selection.load)
                EXPECT_TRUE(std::isfinite(request.priority)) << volume;
        }
    }
}

TEST(HostileTileset, Item22GeometricErrorsAreClampedAndSaid) {
    const auto tree =
        parse(tileset(tile(box(0, 10), 8, "",
                           tile(box(0, 1), -3, "") + "," + tile(box(0, 1), 99, "") + ",{" +
                               box(0, 1) + "},{" + box(0, 1) + R"(,"geometricError":NaN},{)" +
                               box(0, 1) + R"(,"geometricError":1e999})")));
    ASSERT_TRUE(tree) << tree.error().message();
    const double expected[] = {0.0, 8.0, 4.0, 4.0, 4.0};
    for (TileIndex i = 0; i < 5; ++i) {
        EXPECT_DOUBLE_EQ(tree->node(1 + i).geometricErrorMetres, expected[i]) << i;
        EXPECT_TRUE(mentions(tree->facts().warnings,
                             "root.children[" + std::to_string(i) + "]: geometricError"))
            << i;
    }
}

// 3.1 to -3.1 radians of longitude is the short way round.
TEST(HostileTileset, Item23RegionsAcrossTheAntimeridianAndAtThePolesAreSeenFromBothSides) {
    struct Case {
        const char* region;
        Geodetic inside, outside;
    };
    const Case cases[] = {
        {"[3.1,-0.2,-3.1,0.2,0,100]", {179.5, 0, 50}, {170, 0, 50}},
        {"[3.1,-0.2,-3.1,0.2,0,100]", {-179.5, 0, 50}, {-170, 0, 50}},
        {"[-3.141592653589793,1.5,3.141592653589793,1.5707963267948966,0,100]",
         {45, 89.99, 50},
         {45, 80, 50}},
        {"[-3.141592653589793,-1.5707963267948966,3.141592653589793,-1.5,0,100]",
         {-135, -90, 50},
         {45, -80, 50}},
        {"[-6.2,1.5,6.2,1.6,0,100]", {0, 89.9, 50}, {0, 80, 50}}, // a turn too many, past the pole
    };
    for (const Case& c : cases) {
        const auto tree = parse(tileset(R"({"boundingVolume":{"region":)" + std::string(c.region) +
                                        R"(},"geometricError":10,"content":{"uri":"a.glb"}})"));
        if (!tree) { // or refused with the reason
            EXPECT_NE(tree.error().reason.find("radians"), std::string::npos) << c.region;
            continue;
        }
        const BoundingVolume& volume = tree->node(0).volume;
        EXPECT_EQ(distanceTo(volume, ecefOf(c.inside)), 0.0) << c.region;
        // The true distance is tens of kilometres or more, and no bound may exceed it.
        const double distance = distanceTo(volume, ecefOf(c.outside));
        EXPECT_GT(distance, 1000.0) << c.region;
        EXPECT_LT(distance, 2.5e6) << c.region;
    }
}

TEST(HostileTileset, Item24AB3dmOfNoFeaturesIsReadAndHeadersThatDisagreeAreNamed) {
    test::GlbBuilder builder;
    builder.triangles(test::boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), test::boxTriangles());
    const std::string glb = builder.text();
    const std::string good = test::b3dmOf(glb, R"({"BATCH_LENGTH":0}  )");
    const auto content = test::decode(good);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 12u);
    EXPECT_TRUE(test::decode(test::b3dmOf(glb))) << "no feature table at all";

    const auto lies = [&](std::size_t at, std::uint32_t value) {
        std::string text = good;
        for (std::size_t i = 0; i < 4; ++i)
            text[at + i] = char(value >> (8 * i));
        return text;
    };
    const std::uint32_t size = std::uint32_t(good.size());
    for (const auto& [at, value, words] : {std::tuple(std::size_t(4), 2u, "version 2"),
                                           {8, size + 1, "bytes"},
                                           {8, 0xffffffffu, "bytes"},
                                           {8, 27u, "shorter than its header"},
                                           {12, size, "longer"},
                                           {12, 0xffffffffu, "longer"},
                                           {16, 0x20000000u, "longer"},
                                           {20, size, "longer"},
                                           {12, 17u, "other than glTF"},
                                           {8, 48u, "without a glTF"}}) {
        const auto read = test::decode(lies(at, value));
        ASSERT_FALSE(read) << at << " " << value;
        EXPECT_NE(read.error().reason.find(words), std::string::npos)
            << at << " " << value << ": " << read.error().reason;
    }
}

// What a server might send a client that goes by names: the lists of two files are united.
TEST(HostileTileset, ManyNamesOfExtensionsAreNoHang) {
    const auto names = [](int from) {
        std::string out;
        for (int i = 0; i < 90'000; ++i)
            out += (i ? ",\"" : "\"") + std::to_string(from + i) + "\"";
        return R"("extensionsUsed":[)" + out + "]";
    };
    const std::map<std::string, std::string> files = {
        {"tileset.json", tileset(tile(box(0, 10), 2, "b.json"), names(100'000))},
        {"b.json", tileset(tile(box(0, 10), 1, ""), names(300'000))}};
    expectFine(takeAll(files, ""));
}

} // namespace gnomon
