// The fast selection against the plain one, over trees of every kind a file may make; and
// viewerRequestVolume.
#include "tests/streaming/reference_selection.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

#include <random>

namespace gnomon {
namespace {

using namespace testing;
using Tiles = std::vector<TileIndex>;

struct Dice {
    std::mt19937 random;
    unsigned below(unsigned n) { return unsigned(random() % n); }
    double between(double a, double b) { return a + (b - a) * (random() / 4294967296.0); }
};

// A slab of x as a box, straight or sheared, or as the sphere around it.
std::string someVolume(Dice& dice, double x0, double x1) {
    const double half = (x1 - x0) / 2;
    const std::string centre = number(x0 + half) + ",50,50,";
    const unsigned kind = dice.below(6);
    if (kind == 0)
        return R"("boundingVolume":{"sphere":[)" + centre + number(half + 71.0) + "]}";
    const std::string shear = kind == 1 ? number(0.3 * half) : "0";
    return R"("boundingVolume":{"box":[)" + centre + number(half) + ",0,0, " + shear +
           ",50,0, 0,0,50]}";
}

std::string someTile(Dice& dice, double x0, double x1, double error, int depth) {
    const unsigned n = depth == 0 || dice.below(6) == 0 ? 0 : 1 + dice.below(4);
    std::string children;
    for (unsigned i = 0; i < n; ++i)
        children += (i ? "," : "") + someTile(dice, x0 + (x1 - x0) * i / n,
                                              x0 + (x1 - x0) * (i + 1) / n, error * 0.4, depth - 1);
    std::string more = dice.below(3) ? R"("refine":"REPLACE")" : R"("refine":"ADD")";
    if (dice.below(8) == 0)
        more += R"(,"viewerRequestVolume":{"sphere":[)" + number(dice.between(-400, 1400)) +
                ",50,50," + number(dice.between(50, 900)) + "]}";
    switch (dice.below(8)) {
    case 0: // nothing of its own
        return tile(someVolume(dice, x0, x1), error, "", children, more);
    case 1: // two, of which one lies in a corner
        more +=
            R"(,"contents":[{"uri":"a.glb"},{"uri":"b.glb",)" + box(x0, x0 + (x1 - x0) / 8) + "}]";
        return tile(someVolume(dice, x0, x1), error, "", children, more);
    case 2: // a tileset to come
        return tile(someVolume(dice, x0, x1), error, n ? "c.glb" : "below.json", children, more);
    default:
        return tile(someVolume(dice, x0, x1), error, "c.glb", children, more);
    }
}

TileTree someTree(Dice& dice) {
    auto tree = parse(tileset(someTile(dice, 0, 1024, dice.between(20, 400), 5)));
    EXPECT_TRUE(tree);
    // Some of the tilesets below have come.
    for (TileIndex i = 0, n = tree->size(); i < n; ++i)
        if (tree->node(i).content == ContentKind::ExternalTileset && dice.below(2) == 0)
            EXPECT_FALSE(tree->attachExternal(
                i, bytesOf(tileset(someTile(dice, 300, 400, dice.between(1, 100), 2)))));
    const unsigned readyOfTen = dice.below(11);
    for (TileIndex i = 0; i < tree->size(); ++i) {
        if (tree->node(i).state == LoadState::Ready && !tree->node(i).hasMesh())
            continue;
        const bool ready = dice.below(10) < readyOfTen && tree->node(i).hasMesh();
        tree->setState(i, ready                ? LoadState::Ready
                          : dice.below(8) == 0 ? LoadState::Failed
                          : dice.below(2)      ? LoadState::Loading
                                               : LoadState::Unloaded);
    }
    return std::move(*tree);
}

Vector<Ecef> someDirection(Dice& dice) {
    return normalize(
        Vector<Ecef>{{dice.between(-1, 1), dice.between(-1, 1), dice.between(-1, 1) + 1e-3}});
}

std::vector<View> someViews(Dice& dice) {
    std::vector<View> views(1 + dice.below(6));
    for (std::size_t i = 0; i < views.size(); ++i) {
        View& view = views[i];
        view.eye = {{dice.between(-600, 1600), dice.between(-100, 200), dice.between(0, 400)}};
        view.forward = someDirection(dice);
        for (unsigned n = dice.below(6); n > 0; --n)
            view.planes.push_back(
                {someDirection(dice),
                 {{dice.between(-200, 1200), dice.between(0, 100), dice.between(0, 100)}}});
        if (i > 0 && dice.below(3)) { // a light's
            view.pixelMetres = dice.between(0.05, 5.0);
            view.pixelGrowth = dice.below(2) ? dice.between(0.0, 0.01) : 0.0;
            view.growthFromMetres = dice.between(0.0, 100.0);
        } else {
            view.pixelsPerRadian = dice.between(100, 2000);
        }
        view.weight = dice.below(4) ? 1.0 : dice.between(0.0, 1.0);
    }
    return views;
}

TEST(SelectAgainstReference, SaysTheSameOfEveryTree) {
    std::size_t drawn = 0, asked = 0, standIns = 0, failed = 0;
    for (unsigned seed = 0; seed < 3000; ++seed) {
        Dice dice{std::mt19937(seed)};
        const TileTree tree = someTree(dice);
        const std::vector<View> views = someViews(dice);
        SelectOptions options;
        options.maximumScreenSpaceError = dice.between(0.5, 60.0);
        options.loadAncestors = dice.below(2) == 0;
        const Selection fast = select(tree, views, options);
        const ReferenceSelection plain(tree, views, options);
        ASSERT_EQ(fast.drawDepthFirst, plain.draw) << "seed " << seed;
        const std::set<TileIndex> draw(plain.draw.begin(), plain.draw.end());
        ASSERT_EQ(fast.draw, Tiles(draw.begin(), draw.end())) << "seed " << seed;
        ASSERT_EQ(fast.wanted, Tiles(plain.wanted.begin(), plain.wanted.end())) << "seed " << seed;
        ASSERT_EQ(fast.failed, Tiles(plain.failed.begin(), plain.failed.end())) << "seed " << seed;
        ASSERT_EQ(fast.visited, plain.visited) << "seed " << seed;
        std::vector<LoadRequest> load = plain.load;
        std::stable_sort(load.begin(), load.end(),
                         [](const auto& a, const auto& b) { return a.priority < b.priority; });
        ASSERT_EQ(fast.load.size(), load.size()) << "seed " << seed;
        for (std::size_t i = 0; i < load.size(); ++i) {
            ASSERT_EQ(fast.load[i].tile, load[i].tile) << "seed " << seed;
            ASSERT_EQ(fast.load[i].priority, load[i].priority) << "seed " << seed;
        }
        drawn += fast.draw.size();
        asked += load.size();
        failed += fast.failed.size();
        for (const TileIndex i : fast.draw)
            standIns += !plain.wanted.count(i);
    }
    EXPECT_GT(drawn, 3000u) << "the trees are too easy";
    EXPECT_GT(asked, 3000u);
    EXPECT_GT(failed, 1000u);
    EXPECT_GT(standIns, 300u);
}

TEST(SelectAgainstReference, SaysTheSameOfATreeSoLargeThatFewOfItAreDrawn) {
    Dice dice{std::mt19937(7)};
    std::string children;
    for (int i = 0; i < 5000; ++i)
        children += (i ? "," : "") + tile(box(i, i + 1), 0, "c.glb");
    auto tree = parse(tileset(tile(box(0, 5000), 1e6, "", children, R"("refine":"ADD")")));
    ASSERT_TRUE(tree);
    for (TileIndex i = 1; i < tree->size(); i += 2)
        tree->setState(i, LoadState::Ready);
    for (const double until : {0.0, 1.0, 30.0, 70.0, 100.0, 2500.0, 5000.0}) {
        View view = viewFrom(0, 50, 50);
        view.planes = {{{{-1, 0, 0}}, {{until, 0, 0}}}};
        const Selection fast = select(*tree, {&view, 1}, {});
        const ReferenceSelection plain(*tree, {&view, 1}, {});
        const std::set<TileIndex> draw(plain.draw.begin(), plain.draw.end());
        EXPECT_EQ(fast.draw, Tiles(draw.begin(), draw.end()));
        EXPECT_EQ(fast.wanted, Tiles(plain.wanted.begin(), plain.wanted.end()));
    }
}

const std::string kNearOnly = R"("viewerRequestVolume":{"box":[50,50,50,200,0,0,0,200,0,0,0,200]})";

TEST(ViewerRequestVolume, TheTileAndAllBelowIsThereForAnEyeInsideOnly) {
    auto tree = parse(tileset(
        tile(box(0, 100), 1e6, "r.glb",
             tile(box(0, 50), 1e6, "near.glb", tile(box(0, 50), 0, "below.glb"), kNearOnly) + "," +
                 tile(box(50, 100), 0, "always.glb"),
             R"("refine":"ADD")")));
    ASSERT_TRUE(tree);
    const View inside = viewFrom(-149, 50, 50), outside = viewFrom(-151, 50, 50);
    EXPECT_EQ(select(*tree, {&inside, 1}, {}).wanted, (Tiles{0, 1, 2, 3}));
    const Selection far = select(*tree, {&outside, 1}, {});
    EXPECT_EQ(far.wanted, (Tiles{0, 2}));
    EXPECT_EQ(far.load.size(), 2u) << "what is not there is not asked for";
    EXPECT_TRUE(far.failed.empty());
}

TEST(ViewerRequestVolume, TheCameraDecidesForTheLights) {
    auto tree = parse(tileset(tile(box(0, 100), 0, "a.glb", {}, kNearOnly)));
    ASSERT_TRUE(tree);
    View light; // its eye is inside
    light.eye = {{50, 50, 50}};
    light.forward = {{0, 0, -1}};
    light.pixelMetres = 1.0;
    const View farCamera[] = {viewFrom(1000, 50, 50), light};
    EXPECT_TRUE(select(*tree, farCamera, {}).wanted.empty());
    light.eye = {{5000, 50, 50}};
    const View nearCamera[] = {viewFrom(50, 50, 50), light};
    EXPECT_EQ(select(*tree, nearCamera, {}).wanted, Tiles{0});
}

TEST(ViewerRequestVolume, AReplacedTileStaysWhileAllItsChildrenAreOutOfReach) {
    const std::string near = tile(box(0, 50), 0, "a.glb", {}, kNearOnly) + "," +
                             tile(box(50, 100), 0, "b.glb", {}, kNearOnly);
    auto tree = parse(tileset(tile(box(0, 100), 1e6, "r.glb", near, R"("refine":"REPLACE")")));
    ASSERT_TRUE(tree);
    const View inside = viewFrom(50, 50, 50), outside = viewFrom(-151, 50, 50);
    EXPECT_EQ(select(*tree, {&inside, 1}, {}).wanted, (Tiles{1, 2}));
    EXPECT_EQ(select(*tree, {&outside, 1}, {}).wanted, Tiles{0});
    for (TileIndex i = 0; i < tree->size(); ++i)
        tree->setState(i, LoadState::Ready);
    EXPECT_EQ(select(*tree, {&outside, 1}, {}).draw, Tiles{0});
    tree->setState(0, LoadState::Unloaded);
    EXPECT_TRUE(select(*tree, {&outside, 1}, {}).draw.empty())
        << "they do not stand in for it either";
}

TEST(ViewerRequestVolume, WhatItsTilesetHoldsIsNotReadFromOutside) {
    auto tree = parse(tileset(tile(box(0, 100), 1e6, "e.json", {}, kNearOnly)));
    ASSERT_TRUE(tree);
    const View outside = viewFrom(-151, 50, 50), inside = viewFrom(50, 50, 50);
    EXPECT_TRUE(select(*tree, {&outside, 1}, {}).complete());
    EXPECT_EQ(select(*tree, {&inside, 1}, {}).load.size(), 1u);
}

} // namespace
} // namespace gnomon
