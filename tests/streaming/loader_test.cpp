#include "streaming/inventory.h"
#include "streaming/loader.h"
#include "tests/streaming/gzipped.h"
#include "tests/streaming/tree_support.h"

#include <gtest/gtest.h>

namespace gnomon {
namespace {

using namespace testing;
using namespace std::chrono_literals;

// 64 leaves under one REPLACE root, the middle level without content.
std::shared_ptr<MemorySource> city(unsigned trianglesPerTile = 2) {
    auto source = std::make_shared<MemorySource>();
    std::string middle;
    for (int m = 0; m < 8; ++m) {
        std::string leaves;
        for (int i = 0; i < 8; ++i) {
            const int n = m * 8 + i;
            const std::string uri = "t" + std::to_string(n) + ".glb";
            leaves += (i ? "," : "") + tile(box(n * 10, n * 10 + 10), 0, uri);
            source->files[uri] = glb(trianglesPerTile);
        }
        middle += (m ? "," : "") + tile(box(m * 80, m * 80 + 80), 20, "", leaves);
    }
    source->files["root.glb"] = glb(1);
    source->files["tileset.json"] =
        bytesOf(tileset(tile(box(0, 640), 100, "root.glb", middle, R"("refine":"REPLACE")")));
    return source;
}

const View kInside = viewFrom(320, 50, 50);

TEST(Loader, LoadsExactlyWhatTheFinishedPictureShows) {
    const auto source = city();
    const auto tileset = open(source);
    ASSERT_TRUE(tileset);
    const Settled settled = settle(*tileset, {&kInside, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 64u);
    EXPECT_EQ(tileset->tilesLoaded(), 64u) << "and not the root";
    EXPECT_TRUE(tileset->failures().empty());
    EXPECT_TRUE(tileset->idle());
    std::size_t bytes = 0;
    for (const TileIndex drawn : settled.selection.draw) {
        const auto content = tileset->content(drawn);
        ASSERT_TRUE(content);
        EXPECT_EQ(content->facts.format, "glb");
        bytes += content->bytes();
    }
    EXPECT_EQ(tileset->decodedBytes(), bytes);
    // Nothing more to do: at once, and nothing is read again.
    const unsigned reads = source->reads;
    EXPECT_TRUE(settle(*tileset, {&kInside, 1}, {}, soon()).complete);
    EXPECT_EQ(source->reads, reads);
}

TEST(Loader, AFailedTileIsNamedAndItsSiblingsGoOn) {
    const auto source = city();
    source->files.erase("t7.glb");
    source->files["t9.glb"] = bytesOf("this is no glb at all, whatever its name says");
    source->files["t11.glb"] = {};
    const auto tileset = open(source);
    const Settled settled = settle(*tileset, {&kInside, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 61u);
    EXPECT_EQ(settled.selection.failed.size(), 3u);
    ASSERT_EQ(tileset->failures().size(), 3u);
    EXPECT_EQ(tileset->failures()[0].error.message(), "t7.glb: no such file");
    EXPECT_TRUE(tileset->failures()[0].unreadable);
    EXPECT_EQ(tileset->failures()[1].error.subject, "t9.glb");
    EXPECT_FALSE(tileset->failures()[1].unreadable);
    const unsigned reads = source->reads;
    settle(*tileset, {&kInside, 1}, {}, soon());
    EXPECT_EQ(source->reads, reads) << "failed for good is not asked for again";
}

TEST(Loader, ADeadlineEndsTheWaitAndTheRestComesLater) {
    const auto source = city();
    source->delay = 20ms;
    LoaderOptions options;
    options.workers = 2;
    const auto tileset = open(source, options);
    const auto begin = std::chrono::steady_clock::now();
    const Settled late = settle(*tileset, {&kInside, 1}, {}, begin + 100ms);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
    EXPECT_FALSE(late.complete);
    EXPECT_FALSE(late.overBudget);
    EXPECT_FALSE(late.selection.load.empty());
    EXPECT_TRUE(settle(*tileset, {&kInside, 1}, {}, soon()).complete);
}

TEST(Loader, WhatIsNoLongerWantedIsNotStarted) {
    const auto source = city();
    source->delay = 10ms;
    LoaderOptions options;
    options.workers = 1;
    const auto tileset = open(source, options);
    Selection all = select(tileset->tree(), {&kInside, 1}, {});
    ASSERT_EQ(all.load.size(), 64u);
    tileset->request(all.load);
    std::this_thread::sleep_for(25ms);
    const LoadRequest last = all.load.back();
    tileset->request({&last, 1});
    while (tileset->wait(1000ms))
        tileset->poll();
    EXPECT_EQ(tileset->tree().node(last.tile).state, LoadState::Ready);
    EXPECT_LT(source->reads, 10u);
    unsigned loading = 0;
    for (TileIndex i = 0; i < tileset->tree().size(); ++i)
        loading += tileset->tree().node(i).state == LoadState::Loading;
    EXPECT_EQ(loading, 0u);
    EXPECT_TRUE(tileset->idle());
}

TEST(Loader, MostUrgentComesFirst) {
    const auto source = city();
    source->delay = 2ms;
    LoaderOptions options;
    options.workers = 1;
    const auto tileset = open(source, options);
    Selection all = select(tileset->tree(), {&kInside, 1}, {});
    std::vector<std::string> expected{"tileset.json"};
    for (const LoadRequest& request : all.load)
        expected.push_back(tileset->tree().node(request.tile).path);
    tileset->request(all.load);
    while (tileset->wait(1000ms))
        tileset->poll();
    EXPECT_EQ(source->order, expected);
}

TEST(Loader, EvictsTheLeastRecentlyDrawnAndNeverWhatIsKept) {
    const auto source = city(100);
    const std::size_t each = [&] {
        const auto probe = open(source);
        settle(*probe, {&kInside, 1}, {}, soon());
        return probe->decodedBytes() / 64;
    }();
    LoaderOptions options;
    options.memoryBytes = each * 22; // and a little for what is being decoded
    const auto tileset = open(source, options);
    View left = kInside, right = kInside;
    left.planes = {{{{-1, 0, 0}}, {{95, 0, 0}}}};  // tiles 0…9
    right.planes = {{{{1, 0, 0}}, {{545, 0, 0}}}}; // tiles 54…63
    View middle = kInside;
    middle.planes = {{{{1, 0, 0}}, {{305, 0, 0}}}, {{{-1, 0, 0}}, {{355, 0, 0}}}}; // 30…35
    const auto a = settle(*tileset, {&left, 1}, {}, soon());
    ASSERT_TRUE(a.complete);
    ASSERT_EQ(a.selection.draw.size(), 10u);
    const auto b = settle(*tileset, {&right, 1}, {}, soon());
    ASSERT_TRUE(b.complete);
    ASSERT_LE(tileset->decodedBytes(), options.memoryBytes);
    const auto again = settle(*tileset, {&left, 1}, {}, soon()); // drawn now, so b is older
    ASSERT_TRUE(again.complete);
    ASSERT_EQ(tileset->tilesLoaded(), 20u);
    const auto c = settle(*tileset, {&middle, 1}, {}, soon());
    ASSERT_TRUE(c.complete);
    EXPECT_LE(tileset->decodedBytes(), options.memoryBytes);
    for (const TileIndex tile : a.selection.draw)
        EXPECT_TRUE(tileset->content(tile));
    unsigned gone = 0;
    for (const TileIndex tile : b.selection.draw) {
        gone += tileset->content(tile) == nullptr;
        EXPECT_EQ(tileset->tree().node(tile).state == LoadState::Ready,
                  tileset->content(tile) != nullptr);
    }
    EXPECT_GE(gone, 4u);
    EXPECT_LE(gone, 7u);
}

TEST(Loader, SaysWhenTheViewItselfDoesNotFit) {
    const auto source = city(100);
    LoaderOptions options;
    options.memoryBytes = 20'000;
    const auto tileset = open(source, options);
    const Settled settled = settle(*tileset, {&kInside, 1}, {}, soon());
    EXPECT_TRUE(settled.overBudget);
    EXPECT_FALSE(settled.complete);
    const Settled again = settle(*tileset, {&kInside, 1}, {}, soon());
    EXPECT_TRUE(again.overBudget);
    // Asking for less is the way out.
    SelectOptions coarse;
    coarse.maximumScreenSpaceError = 1e12;
    const View outside = viewFrom(-1000, 50, 50);
    const Settled fits = settle(*tileset, {&outside, 1}, coarse, soon());
    EXPECT_TRUE(fits.complete);
    EXPECT_FALSE(fits.overBudget);
    EXPECT_LE(tileset->decodedBytes(), options.memoryBytes);
}

TEST(Loader, QuitsPromptlyWithLoadsInFlight) {
    const auto source = city();
    source->delay = 200ms;
    auto tileset = open(source);
    ASSERT_TRUE(tileset);
    const Selection all = select(tileset->tree(), {&kInside, 1}, {});
    ASSERT_EQ(all.load.size(), 64u);
    tileset->request(all.load);
    std::this_thread::sleep_for(20ms);
    const auto begin = std::chrono::steady_clock::now();
    tileset.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
}

// A tileset that grows: two levels of external tilesets, the second known by content only, and
// some that fail.
std::shared_ptr<MemorySource> growing() {
    auto source = std::make_shared<MemorySource>();
    std::string first;
    for (int i = 0; i < 6; ++i) {
        const std::string name = "e" + std::to_string(i) + ".json";
        first += (i ? "," : "") + tile(box(i * 100, i * 100 + 100), 90, name);
        std::string second;
        for (int k = 0; k < 4; ++k) {
            const std::string inner = "x" + std::to_string(i) + std::to_string(k);
            const double x = i * 100 + k * 25;
            second += (k ? "," : "") + tile(box(x, x + 25), 40, inner);
            if ((i + k) % 5 == 0)
                source->files[inner] = bytesOf("rubbish");
            else if ((i + k) % 5 == 1)
                source->files[inner] = glb(3);
            else
                source->files[inner] = bytesOf(tileset(tile(box(x, x + 25), 10, inner + ".glb")));
            source->files[inner + ".glb"] = glb(2);
        }
        if (i != 4)
            source->files[name] = bytesOf(
                tileset(tile(box(i * 100, i * 100 + 100), 80, "m" + std::to_string(i) + ".glb",
                             second, R"("refine":"ADD")")));
        if (i != 2)
            source->files["m" + std::to_string(i) + ".glb"] = glb(1);
    }
    source->files["tileset.json"] =
        bytesOf(tileset(tile(box(0, 600), 100, "", first, R"("refine":"REPLACE")")));
    return source;
}

std::string account(const StreamedTileset& tileset, const Settled& settled) {
    std::string text;
    for (const TileIndex tile : settled.selection.drawDepthFirst)
        text += std::to_string(tile) + "=" + tileset.tree().name(tile) + " ";
    text += "| ";
    for (const FailedTile& failed : tileset.failures())
        text += std::to_string(failed.tile) + "=" + failed.error.message() + " ";
    return text + "| " + std::to_string(tileset.tree().size());
}

TEST(Loader, TheSameRunGivesTheSameTreeWhateverTheTiming) {
    std::string first;
    for (int run = 0; run < 20; ++run) {
        const auto source = growing();
        source->delay = std::chrono::microseconds(200 + 150 * (run % 4));
        source->jitter = true;
        source->reads = unsigned(run * 7);
        LoaderOptions options;
        options.workers = 1 + unsigned(run % 6);
        const auto tileset = open(source, options);
        ASSERT_TRUE(tileset);
        View narrow = viewFrom(150, 50, 50);
        narrow.planes = {{{{-1, 0, 0}}, {{350, 0, 0}}}};
        ASSERT_TRUE(settle(*tileset, {&narrow, 1}, {}, soon()).complete);
        const View all = viewFrom(300, 50, 50);
        const Settled settled = settle(*tileset, {&all, 1}, {}, soon());
        ASSERT_TRUE(settled.complete);
        const std::string text = account(*tileset, settled);
        if (run == 0)
            first = text;
        EXPECT_EQ(text, first) << "run " << run;
    }
    EXPECT_NE(first.find("x03.glb"), std::string::npos) << first;
    EXPECT_NE(first.find("e4.json: no such file"), std::string::npos) << first;
}

// As a web server would send them; and one packed twice, which is none.
TEST(Loader, TilesetsMayBeCompressed) {
    auto source = std::make_shared<MemorySource>();
    source->files["tileset.json"] = gzipped(bytesOf(
        tileset(tile(box(0, 100), 100, "",
                     tile(box(0, 50), 50, "a.json") + "," + tile(box(50, 100), 50, "twice.json"),
                     R"("refine":"ADD")"))));
    source->files["a.json"] = gzipped(bytesOf(tileset(tile(box(0, 50), 0, "a.glb"))));
    source->files["a.glb"] = gzipped(glb(2));
    source->files["twice.json"] = gzipped(source->files["a.json"]);
    const auto tileset = open(source);
    ASSERT_TRUE(tileset);
    const View view = viewFrom(50, 50, 50);
    const Settled settled = settle(*tileset, {&view, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 1u);
    ASSERT_EQ(tileset->failures().size(), 1u);
    EXPECT_NE(tileset->failures()[0].error.message().find("twice.json"), std::string::npos);
}

TEST(Loader, ATilesetThatContainsItselfFailsThatTileOnly) {
    auto source = std::make_shared<MemorySource>();
    source->files["tileset.json"] = bytesOf(
        tileset(tile(box(0, 100), 100, "",
                     tile(box(0, 50), 50, "tileset.json") + "," + tile(box(50, 100), 0, "b.glb"),
                     R"("refine":"ADD")")));
    source->files["b.glb"] = glb(1);
    const auto tileset = open(source);
    const View view = viewFrom(50, 50, 50);
    const Settled settled = settle(*tileset, {&view, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 1u);
    ASSERT_EQ(tileset->failures().size(), 1u);
    EXPECT_NE(tileset->failures()[0].error.message().find("tileset.json: is an external tileset "
                                                          "that contains itself"),
              std::string::npos);
}

TEST(Loader, ASingleModelIsATilesetOfOneTile) {
    auto source = std::make_shared<MemorySource>();
    source->files["house.glb"] = glb(3);
    source->files["tileset.json"] = bytesOf("rubbish");
    auto model = StreamedTileset::open(source, "house.glb", {}, {});
    ASSERT_TRUE(model) << model.error().message();
    EXPECT_EQ((*model)->tree().size(), 1u);
    const View view = viewFrom(0, 0, 0);
    const Settled settled = settle(**model, {&view, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 1u);
    EXPECT_EQ(source->reads, 1u);
    EXPECT_FALSE(StreamedTileset::open(source, "none.glb", {}, {}));
    const auto rubbish = StreamedTileset::open(source, "tileset.json", {}, {});
    ASSERT_FALSE(rubbish);
    EXPECT_EQ(rubbish.error().message(), "tileset.json: is not JSON");
}

TEST(Loader, ThousandsOfTeleportsKeepBytesWithinTheBudget) {
    const auto source = city(20);
    LoaderOptions options;
    options.workers = 2;
    const auto tileset = open(source, options);
    settle(*tileset, {&kInside, 1}, {}, soon());
    const std::size_t whole = tileset->decodedBytes();
    LoaderOptions tight = options;
    tight.memoryBytes = whole / 4;
    const auto streamed = open(source, tight);
    for (int jump = 0; jump < 2000; ++jump) {
        View view = kInside;
        const double x = double((jump * 7919) % 600);
        view.planes = {{{{1, 0, 0}}, {{x, 0, 0}}}, {{{-1, 0, 0}}, {{x + 60, 0, 0}}}};
        const Settled settled = settle(*streamed, {&view, 1}, {}, soon());
        ASSERT_TRUE(settled.complete);
        ASSERT_LE(streamed->decodedBytes(), tight.memoryBytes);
        for (const TileIndex drawn : settled.selection.draw)
            ASSERT_TRUE(streamed->content(drawn));
    }
}

TEST(Inventory, CountsWhatThereIsAndNamesWhatIsMissing) {
    const auto source = growing();
    const auto tileset = open(source);
    std::size_t calls = 0;
    const Inventory inventory = takeInventory(*tileset, [&](std::size_t done, std::size_t total) {
        ++calls;
        EXPECT_LE(done, total);
    });
    EXPECT_GT(calls, 0u);
    EXPECT_EQ(tileset->decodedBytes(), 0u) << "nothing is kept";
    std::uint64_t contents = 0;
    for (const auto& [format, n] : inventory.contents)
        contents += n;
    std::uint64_t expected = 0, missing = 1 + 1, broken = 0; // e4.json, m2.glb
    for (int i = 0; i < 6; ++i) {
        if (i == 4)
            continue;
        expected += i != 2;
        for (int k = 0; k < 4; ++k) {
            broken += (i + k) % 5 == 0;
            expected += (i + k) % 5 != 0;
        }
    }
    EXPECT_EQ(contents, expected);
    std::uint64_t unreadable = 0;
    for (const FailedTile& failed : inventory.failures)
        unreadable += failed.unreadable;
    EXPECT_EQ(unreadable, missing);
    EXPECT_EQ(inventory.failures.size(), missing + broken);
    EXPECT_EQ(inventory.refine, (std::set<Refine>{Refine::Add, Refine::Replace}));
}

} // namespace
} // namespace gnomon
