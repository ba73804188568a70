#include "streaming/selection.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace gnomon {
namespace {

using namespace testing;

using Tiles = std::vector<TileIndex>;

// A tree over x from 0 to 1024; each tile has 0 or 2…4 children that share its length.
std::string randomTile(std::mt19937& random, double x0, double x1, double error, int depth,
                       bool mixed, int& count) {
    std::string children;
    const unsigned n = depth == 0 || random() % 5 == 0 ? 0 : 2 + unsigned(random() % 3);
    for (unsigned i = 0; i < n; ++i) {
        const double a = x0 + (x1 - x0) * i / n, b = x0 + (x1 - x0) * (i + 1) / n;
        children += (i ? "," : "") + randomTile(random, a, b, error * 0.4, depth - 1, mixed, count);
    }
    const std::string uri =
        random() % 8 == 0 && n > 0 ? "" : "t" + std::to_string(count++) + ".glb";
    const bool add = mixed && random() % 3 == 0;
    return tile(box(x0, x1), error, uri, children,
                add ? R"("refine":"ADD")" : R"("refine":"REPLACE")");
}

TileTree randomTree(unsigned seed, bool mixed) {
    std::mt19937 random(seed);
    int count = 0;
    auto tree = parse(tileset(randomTile(random, 0, 1024, 200, 5, mixed, count)));
    EXPECT_TRUE(tree);
    return std::move(*tree);
}

void setAll(TileTree& tree, LoadState state) {
    for (TileIndex i = 0; i < tree.size(); ++i)
        if (tree.node(i).hasMesh())
            tree.setState(i, state);
}

void setRandom(TileTree& tree, std::mt19937& random, bool someFail) {
    for (TileIndex i = 0; i < tree.size(); ++i)
        if (tree.node(i).hasMesh()) {
            const unsigned dice = unsigned(random() % 10);
            tree.setState(i, dice < 5                ? LoadState::Ready
                             : dice == 5 && someFail ? LoadState::Failed
                             : dice < 8              ? LoadState::Unloaded
                                                     : LoadState::Loading);
        }
}

bool contains(const Tiles& tiles, TileIndex tile) {
    return std::binary_search(tiles.begin(), tiles.end(), tile);
}

Tiles pathTo(const TileTree& tree, TileIndex tile) {
    Tiles path;
    for (; tile != kNoTile; tile = tree.node(tile).parent)
        path.push_back(tile);
    return path;
}

int drawnOn(const TileTree& tree, TileIndex leaf, const Tiles& draw) {
    int n = 0;
    for (const TileIndex tile : pathTo(tree, leaf))
        n += contains(draw, tile);
    return n;
}

TEST(Select, IsAPureFunction) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        TileTree tree = randomTree(seed, true);
        std::mt19937 random(seed);
        setRandom(tree, random, true);
        const View views[] = {viewFrom(-300, 50, 50), viewFrom(900, 50, 500, 300)};
        const Selection a = select(tree, views, {});
        const Selection b = select(tree, views, {});
        EXPECT_EQ(a.draw, b.draw);
        EXPECT_EQ(a.failed, b.failed);
        ASSERT_EQ(a.load.size(), b.load.size());
        for (std::size_t i = 0; i < a.load.size(); ++i) {
            EXPECT_EQ(a.load[i].tile, b.load[i].tile);
            EXPECT_EQ(a.load[i].priority, b.load[i].priority);
            EXPECT_TRUE(i == 0 || a.load[i - 1].priority <= a.load[i].priority);
        }
        EXPECT_TRUE(std::is_sorted(a.draw.begin(), a.draw.end()));
        EXPECT_EQ(std::adjacent_find(a.draw.begin(), a.draw.end()), a.draw.end());
        Tiles sorted = a.drawDepthFirst;
        std::sort(sorted.begin(), sorted.end());
        EXPECT_EQ(sorted, a.draw);
    }
}

TEST(Select, ReplaceNeverShowsAHoleNorTwoLevelsAtOnce) {
    int standIns = 0, complete = 0;
    for (unsigned seed = 0; seed < 400; ++seed) {
        TileTree tree = randomTree(seed, false);
        std::mt19937 random(seed);
        setRandom(tree, random, false);
        const bool rootReady = tree.node(0).hasMesh() && seed % 4 != 0;
        if (rootReady)
            tree.setState(0, LoadState::Ready);
        SelectOptions options;
        options.loadAncestors = seed % 2 == 0;
        const View view = viewFrom(-200.0 + double(random() % 1000), 50, 300, 400);
        const Selection s = select(tree, {&view, 1}, options);
        complete += s.complete();
        for (TileIndex leaf = 0; leaf < tree.size(); ++leaf) {
            if (tree.node(leaf).childCount)
                continue;
            const int drawn = drawnOn(tree, leaf, s.draw);
            EXPECT_LE(drawn, 1) << "seed " << seed << " tile " << leaf;
            if (rootReady || s.complete()) {
                EXPECT_EQ(drawn, 1) << "seed " << seed << " tile " << leaf;
            }
        }
        for (const TileIndex tile : s.draw) {
            EXPECT_EQ(tree.node(tile).state, LoadState::Ready);
            standIns += !contains(s.wanted, tile);
        }
        for (const LoadRequest& request : s.load)
            EXPECT_NE(tree.node(request.tile).state, LoadState::Ready);
    }
    EXPECT_GT(standIns, 100) << "the trees were too easy";
    EXPECT_GT(complete, 3);
}

TEST(Select, MixedRefinementNeverDrawsAReplacedTileOverItsChildren) {
    for (unsigned seed = 0; seed < 300; ++seed) {
        TileTree tree = randomTree(seed, true);
        std::mt19937 random(seed);
        setRandom(tree, random, true);
        const View view = viewFrom(double(random() % 1000), 50, 300, 400);
        const Selection s = select(tree, {&view, 1}, {});
        for (const TileIndex tile : s.draw)
            for (TileIndex up = tree.node(tile).parent; up != kNoTile; up = tree.node(up).parent)
                EXPECT_FALSE(tree.node(up).refine == Refine::Replace && contains(s.draw, up))
                    << "seed " << seed;
    }
}

TEST(Select, OnceEverythingWantedIsReadyTheWantedIsWhatIsDrawn) {
    for (unsigned seed = 0; seed < 100; ++seed) {
        TileTree tree = randomTree(seed, true);
        const View view = viewFrom(-100, 50, 50);
        Selection s = select(tree, {&view, 1}, {});
        std::size_t asked = 0;
        while (!s.complete()) {
            for (const LoadRequest& request : s.load)
                tree.setState(request.tile, LoadState::Ready);
            asked += s.load.size();
            s = select(tree, {&view, 1}, {});
        }
        EXPECT_EQ(s.draw, s.wanted);
        EXPECT_EQ(asked, s.draw.size()) << "nothing is loaded that the picture does not show";
    }
}

TEST(Select, LoadsAncestorsToStandInOnlyWhenAskedTo) {
    auto parsed = parse(tileset(tile(box(0, 100), 100, "r.glb",
                                     tile(box(0, 50), 50, "m.glb", tile(box(0, 50), 0, "a.glb")) +
                                         "," + tile(box(50, 100), 0, "b.glb"),
                                     R"("refine":"REPLACE")")));
    ASSERT_TRUE(parsed);
    const TileTree& tree = *parsed;
    const View view = viewFrom(50, 50, 50); // inside: to the leaves
    const Selection lean = select(tree, {&view, 1}, {});
    SelectOptions options;
    options.loadAncestors = true;
    const Selection rich = select(tree, {&view, 1}, options);
    EXPECT_EQ(lean.load.size(), 2u);
    EXPECT_EQ(rich.load.size(), 4u);
    EXPECT_EQ(rich.load.front().tile, 0u) << "coarse first";
    EXPECT_EQ(rich.wanted, lean.wanted);
    for (const LoadRequest& request : lean.load)
        EXPECT_EQ(tree.node(request.tile).childCount, 0u);
}

TEST(Select, FinerTilesStandInForACoarserOneThatIsNotThereYet) {
    auto tree =
        parse(tileset(tile(box(0, 100), 10, "r.glb",
                           tile(box(0, 50), 0, "a.glb") + "," + tile(box(50, 100), 0, "b.glb"),
                           R"("refine":"REPLACE")")));
    ASSERT_TRUE(tree);
    tree->setState(1, LoadState::Ready);
    tree->setState(2, LoadState::Ready);
    const View far = viewFrom(-1e5, 0, 0);
    const Selection s = select(*tree, {&far, 1}, {});
    EXPECT_EQ(s.draw, (Tiles{1, 2}));
    ASSERT_EQ(s.load.size(), 1u);
    EXPECT_EQ(s.load[0].tile, 0u);
    tree->setState(2, LoadState::Unloaded);
    EXPECT_TRUE(select(*tree, {&far, 1}, {}).draw.empty()) << "half a picture is none";
}

// The depth reached on the way to each leaf.
std::vector<int> depths(const TileTree& tree, const Tiles& draw) {
    std::vector<int> out;
    for (TileIndex leaf = 0; leaf < tree.size(); ++leaf) {
        if (tree.node(leaf).childCount)
            continue;
        int depth = -1;
        for (const TileIndex tile : pathTo(tree, leaf))
            if (contains(draw, tile))
                depth = std::max<int>(depth, tree.node(tile).level);
        out.push_back(depth);
    }
    return out;
}

TEST(Select, RefinesMonotonouslyWithTheErrorAllowedAndTheDistance) {
    for (unsigned seed = 0; seed < 30; ++seed) {
        TileTree tree = randomTree(seed, false);
        setAll(tree, LoadState::Ready);
        std::vector<int> before;
        for (const double sse : {1e9, 256.0, 64.0, 16.0, 4.0, 1.0, 0.01}) {
            const View view = viewFrom(-500, 50, 50);
            SelectOptions options;
            options.maximumScreenSpaceError = sse;
            const auto now = depths(tree, select(tree, {&view, 1}, options).draw);
            for (std::size_t i = 0; i < before.size(); ++i)
                EXPECT_GE(now[i], before[i]);
            before = now;
        }
        before.clear();
        for (const double x : {-1e6, -1e5, -1e4, -1e3, -100.0, -1.0}) {
            const View view = viewFrom(x, 50, 50);
            const auto now = depths(tree, select(tree, {&view, 1}, {}).draw);
            for (std::size_t i = 0; i < before.size(); ++i)
                EXPECT_GE(now[i], before[i]);
            before = now;
        }
    }
}

TEST(Select, TheWorstViewWins) {
    TileTree tree = randomTree(3, false);
    setAll(tree, LoadState::Ready);
    const View far = viewFrom(-1e5, 50, 50), near = viewFrom(-1, 50, 50);
    const View both[] = {far, near};
    EXPECT_EQ(select(tree, both, {}).draw, select(tree, {&near, 1}, {}).draw);
    EXPECT_NE(select(tree, both, {}).draw, select(tree, {&far, 1}, {}).draw);
    View light; // orthographic, a texel of 1 cm
    light.eye = {{0, 0, 1e6}};
    light.forward = {{0, 0, -1}};
    light.pixelMetres = 0.01;
    const Selection leaves = select(tree, {&light, 1}, {});
    for (const TileIndex tile : leaves.draw)
        EXPECT_EQ(tree.node(tile).childCount, 0u);
    const View withLight[] = {far, light};
    EXPECT_EQ(select(tree, withLight, {}).draw, leaves.draw);
    light.weight = 1e-9;
    EXPECT_EQ(select(tree, {&light, 1}, {}).draw, select(tree, {&far, 1}, {}).draw);
}

TEST(Select, RefinesToTheLeavesWhenTheCameraIsInside) {
    auto tree = parse(tileset(
        tile(box(0, 100), 1e-9, "r.glb", tile(box(0, 100), 0, "a.glb"), R"("refine":"REPLACE")")));
    ASSERT_TRUE(tree);
    setAll(*tree, LoadState::Ready);
    const View inside = viewFrom(50, 50, 50);
    EXPECT_EQ(select(*tree, {&inside, 1}, {}).draw, Tiles{1});
    const View outside = viewFrom(-50, 50, 50);
    EXPECT_EQ(select(*tree, {&outside, 1}, {}).draw, Tiles{0});
}

TEST(Select, CullsOnlyWhatIsOutsideInEveryView) {
    auto tree = parse(tileset(tile(
        box(0, 100), 100, "", tile(box(0, 40), 0, "a.glb") + "," + tile(box(60, 100), 0, "b.glb"),
        R"("refine":"ADD")")));
    ASSERT_TRUE(tree);
    setAll(*tree, LoadState::Ready);
    View left = viewFrom(50, 50, 50), right = left;
    left.planes = {{{{-1, 0, 0}}, {{50, 0, 0}}}};
    right.planes = {{{{1, 0, 0}}, {{50, 0, 0}}}};
    EXPECT_EQ(select(*tree, {&left, 1}, {}).draw, Tiles{1});
    EXPECT_EQ(select(*tree, {&right, 1}, {}).draw, Tiles{2});
    const View both[] = {left, right};
    EXPECT_EQ(select(*tree, both, {}).draw, (Tiles{1, 2}));
    EXPECT_TRUE(select(*tree, {}, {}).draw.empty());
}

TEST(Select, AContentsOwnVolumeCullsTheContentOnly) {
    auto tree = parse(tileset("{" + box(0, 100) +
                              R"(,"geometricError":0,"content":{"uri":"a.glb","boundingVolume":
        {"box":[90,50,50,5,0,0,0,5,0,0,0,5]}}})"));
    ASSERT_TRUE(tree);
    View left = viewFrom(50, 50, 50);
    left.planes = {{{{-1, 0, 0}}, {{50, 0, 0}}}};
    const Selection s = select(*tree, {&left, 1}, {});
    EXPECT_TRUE(s.draw.empty());
    EXPECT_TRUE(s.load.empty());
}

TEST(Select, AddDrawsParentAndChildren) {
    auto tree = parse(tileset(tile(
        box(0, 100), 100, "r.glb",
        tile(box(0, 40), 0, "a.glb") + "," + tile(box(60, 100), 0, "b.glb"), R"("refine":"ADD")")));
    ASSERT_TRUE(tree);
    tree->setState(0, LoadState::Ready);
    tree->setState(2, LoadState::Ready);
    const View view = viewFrom(50, 50, 50);
    const Selection s = select(*tree, {&view, 1}, {});
    EXPECT_EQ(s.draw, (Tiles{0, 2}));
    ASSERT_EQ(s.load.size(), 1u);
    EXPECT_EQ(s.load[0].tile, 1u);
}

TEST(Select, LooksThroughReplaceTilesWithoutContent) {
    for (const char* uri : {"", "broken.glb"}) {
        auto tree =
            parse(tileset(tile(box(0, 100), 10, uri,
                               tile(box(0, 50), 0, "a.glb") + "," + tile(box(50, 100), 0, "b.glb"),
                               R"("refine":"REPLACE")")));
        ASSERT_TRUE(tree);
        setAll(*tree, LoadState::Ready);
        if (*uri)
            tree->setState(0, LoadState::Failed);
        const View far = viewFrom(-1e7, 0, 0);
        const Selection s = select(*tree, {&far, 1}, {});
        EXPECT_EQ(s.draw, (Tiles{1, 2}));
        EXPECT_EQ(s.failed, *uri ? Tiles{0} : Tiles{}) << "what is missing is said";
        EXPECT_TRUE(s.complete());
    }
}

TEST(Select, SiblingsOfAFailedTileAreDrawnAndItIsNamed) {
    auto tree =
        parse(tileset(tile(box(0, 100), 100, "r.glb",
                           tile(box(0, 50), 0, "a.glb") + "," + tile(box(50, 100), 0, "b.glb"),
                           R"("refine":"REPLACE")")));
    ASSERT_TRUE(tree);
    setAll(*tree, LoadState::Ready);
    tree->setState(1, LoadState::Failed);
    const View view = viewFrom(50, 50, 50);
    const Selection s = select(*tree, {&view, 1}, {});
    EXPECT_EQ(s.draw, Tiles{2});
    EXPECT_EQ(s.failed, Tiles{1});
    EXPECT_TRUE(s.complete());
}

TEST(Select, WaitsForATilesetBelowAReplacedTile) {
    auto tree = parse(tileset(
        tile(box(0, 100), 100, "r.glb", tile(box(0, 100), 50, "e.json"), R"("refine":"REPLACE")")));
    ASSERT_TRUE(tree);
    tree->setState(0, LoadState::Ready);
    const View view = viewFrom(50, 50, 50);
    Selection s = select(*tree, {&view, 1}, {});
    EXPECT_EQ(s.draw, Tiles{0});
    ASSERT_EQ(s.load.size(), 1u);
    EXPECT_EQ(s.load[0].tile, 1u);
    ASSERT_FALSE(tree->attachExternal(1, bytesOf(tileset(tile(box(0, 100), 0, "x.glb")))));
    s = select(*tree, {&view, 1}, {});
    EXPECT_EQ(s.draw, Tiles{0});
    ASSERT_EQ(s.load.size(), 1u);
    EXPECT_EQ(s.load[0].tile, 2u);
    tree->setState(2, LoadState::Ready);
    s = select(*tree, {&view, 1}, {});
    EXPECT_EQ(s.draw, Tiles{2});
    EXPECT_TRUE(s.complete());
}

TEST(Select, SeveralContentsOfATileComeAndGoTogether) {
    auto tree =
        parse(tileset(tile(box(0, 100), 10, "", tile(box(0, 100), 0, "leaf.glb"),
                           R"("refine":"REPLACE","contents":[{"uri":"a.glb"},{"uri":"b.glb"}])")));
    ASSERT_TRUE(tree);
    ASSERT_EQ(tree->size(), 3u);
    const View far = viewFrom(-1e6, 0, 0);
    EXPECT_EQ(select(*tree, {&far, 1}, {}).load.size(), 2u);
    const TileIndex other = tree->node(0).nextContent;
    tree->setState(0, LoadState::Ready);
    tree->setState(other, LoadState::Ready);
    EXPECT_EQ(select(*tree, {&far, 1}, {}).draw.size(), 2u);
    const View near = viewFrom(50, 50, 50);
    EXPECT_EQ(select(*tree, {&near, 1}, {}).draw.size(), 2u) << "both stand in";
    tree->setState(tree->node(0).firstChild, LoadState::Ready);
    EXPECT_EQ(select(*tree, {&near, 1}, {}).draw, Tiles{tree->node(0).firstChild});
}

TEST(Select, AsksForTheCamerasTilesFirstAndNearTheAxisFirst) {
    auto tree = parse(tileset(tile(box(0, 1000), 1000, "",
                                   tile(box(0, 10), 0, "lightOnly.glb") + "," +
                                       tile(box(900, 1000), 0, "ahead.glb") + "," +
                                       tile(box(510, 520), 0, "beside.glb"),
                                   R"("refine":"ADD")")));
    ASSERT_TRUE(tree);
    View camera = viewFrom(500, 50, 5000);
    camera.forward = normalize(Vector<Ecef>{{950.0 - 500, 0, 50.0 - 5000}});
    camera.planes = {{{{1, 0, 0}}, {{400, 0, 0}}}};
    View light = viewFrom(5, 50, 60);
    const View views[] = {camera, light};
    const Selection s = select(*tree, views, {});
    ASSERT_EQ(s.load.size(), 3u);
    EXPECT_EQ(tree->node(s.load[0].tile).path, "ahead.glb");
    EXPECT_EQ(tree->node(s.load[1].tile).path, "beside.glb");
    EXPECT_EQ(tree->node(s.load[2].tile).path, "lightOnly.glb");
}

TEST(Select, GoesDownAHundredThousandLevels) {
    constexpr int kDepth = 100'000;
    std::string text;
    for (int i = 0; i < kDepth; ++i)
        text += R"({"boundingVolume":{"sphere":[0,0,0,9]},"geometricError":1,"refine":"REPLACE",)"
                R"("content":{"uri":"a.glb"},"children":[)";
    for (int i = 0; i < kDepth; ++i)
        text += "]}";
    auto tree = parse(tileset(text));
    ASSERT_TRUE(tree);
    const View view = viewFrom(0, 0, 0);
    EXPECT_EQ(select(*tree, {&view, 1}, {}).load.size(), 1u);
    tree->setState(kDepth - 1, LoadState::Ready);
    const Selection s = select(*tree, {&view, 1}, {});
    EXPECT_EQ(s.draw, Tiles{kDepth - 1});
    EXPECT_EQ(s.visited, std::uint32_t(kDepth));
}

TEST(Select, DrawsInAnOrderThatDoesNotDependOnWhatWasReadBefore) {
    const std::string files =
        tileset(tile(box(0, 100), 100, "",
                     tile(box(0, 50), 50, "e0.json") + "," + tile(box(50, 100), 50, "e1.json"),
                     R"("refine":"ADD")"));
    const View view = viewFrom(50, 50, 50);
    std::vector<std::vector<std::string>> orders;
    for (const bool secondFirst : {false, true}) {
        auto tree = parse(files);
        ASSERT_TRUE(tree);
        for (int i = 0; i < 2; ++i) {
            const TileIndex tileIndex = secondFirst ? TileIndex(2 - i) : TileIndex(1 + i);
            ASSERT_FALSE(tree->attachExternal(
                tileIndex,
                bytesOf(tileset(tile(box(0, 50), 0, std::to_string(tileIndex) + ".glb")))));
        }
        setAll(*tree, LoadState::Ready);
        orders.emplace_back();
        for (const TileIndex drawn : select(*tree, {&view, 1}, {}).drawDepthFirst)
            orders.back().push_back(tree->node(drawn).path);
    }
    EXPECT_EQ(orders[0], orders[1]);
}

} // namespace
} // namespace gnomon
