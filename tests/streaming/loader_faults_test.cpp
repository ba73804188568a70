// What a loader does when files do not come, come late, or come too large.
#include "tests/streaming/far_source.h"

#include <gtest/gtest.h>

namespace gnomon {
namespace {

using namespace testing;
using namespace std::chrono_literals;

// Leaves of 10 m in a row under one root that they replace.
std::shared_ptr<FarSource> row(int leaves, unsigned triangles = 2) {
    auto source = std::make_shared<FarSource>();
    std::string tiles;
    for (int i = 0; i < leaves; ++i) {
        const std::string uri = "t" + std::to_string(i) + ".glb";
        tiles += (i ? "," : "") + tile(box(i * 10, i * 10 + 10), 0, uri);
        source->files[uri] = glb(triangles);
    }
    source->files["root.glb"] = glb(1);
    source->files["tileset.json"] = bytesOf(
        tileset(tile(box(0, leaves * 10), 100, "root.glb", tiles, R"("refine":"REPLACE")")));
    return source;
}

std::unique_ptr<StreamedTileset> openFar(std::shared_ptr<const Source> source,
                                         LoaderOptions options = {}) {
    options.firstWait = 2ms;
    options.longestWait = 20ms;
    auto opened = StreamedTileset::open(std::move(source), "tileset.json", {}, options);
    return opened ? std::move(*opened) : nullptr;
}

Error busy(const std::string& path) {
    return {path, "busy", ErrorKind::Transient};
}

const View kInside = viewFrom(50, 50, 50);

TEST(LoaderFaults, SettlingTriesAgainUntilItsDeadline) {
    for (const unsigned atOnce : {0u, 20u}) {
        const auto source = row(20);
        source->atOnce = atOnce;
        source->fault = [](const std::string& path, int n) -> std::optional<Error> {
            if (path == "t3.glb" && n < 12)
                return busy(path);
            return std::nullopt;
        };
        const auto tileset = openFar(source);
        ASSERT_TRUE(tileset);
        const Settled settled = settle(*tileset, {&kInside, 1}, {}, soon());
        EXPECT_TRUE(settled.complete);
        EXPECT_EQ(settled.selection.draw.size(), 20u);
        EXPECT_EQ(source->tries()["t3.glb"], 12);
        EXPECT_TRUE(tileset->failures().empty());
    }
}

TEST(LoaderFaults, WhenTheDeadlinePassesTheTileIsLateAndSaysWhyNotFailed) {
    const auto source = row(20);
    source->fault = [](const std::string& path, int) -> std::optional<Error> {
        if (path == "t3.glb")
            return busy(path);
        return std::nullopt;
    };
    const auto tileset = openFar(source);
    const auto begin = std::chrono::steady_clock::now();
    const Settled late = settle(*tileset, {&kInside, 1}, {}, begin + 150ms);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
    EXPECT_FALSE(late.complete);
    EXPECT_FALSE(late.overBudget);
    ASSERT_EQ(late.selection.load.size(), 1u);
    const TileIndex tile = late.selection.load[0].tile;
    EXPECT_EQ(tileset->tree().node(tile).path, "t3.glb");
    ASSERT_TRUE(tileset->lastFault(tile));
    EXPECT_EQ(tileset->lastFault(tile)->reason, "busy");
    EXPECT_TRUE(tileset->failures().empty());
    // With waits that double up to 20 ms: about ten times in 150 ms, not hundreds.
    EXPECT_GT(source->tries()["t3.glb"], 3);
    EXPECT_LT(source->tries()["t3.glb"], 30);
}

TEST(LoaderFaults, ItComesInALaterFrameWhenTheFaultHasPassed) {
    const auto source = row(20);
    std::atomic<bool> down = true;
    source->fault = [&](const std::string& path, int) -> std::optional<Error> {
        if (down && path != "tileset.json")
            return busy(path);
        return std::nullopt;
    };
    const auto tileset = openFar(source);
    const Settled late =
        settle(*tileset, {&kInside, 1}, {}, std::chrono::steady_clock::now() + 60ms);
    EXPECT_FALSE(late.complete);
    EXPECT_EQ(late.selection.load.size(), 20u);
    down = false;
    const Settled settled = settle(*tileset, {&kInside, 1}, {}, soon());
    EXPECT_TRUE(settled.complete);
    EXPECT_EQ(settled.selection.draw.size(), 20u);
    EXPECT_EQ(tileset->lastFault(settled.selection.draw[0]), nullptr);
}

TEST(LoaderFaults, AWindowTriesAFewTimesAndThenShowsTheRest) {
    const auto source = row(20);
    source->fault = [](const std::string& path, int) -> std::optional<Error> {
        if (path == "t3.glb")
            return busy(path);
        return std::nullopt;
    };
    LoaderOptions options;
    options.attempts = 3;
    const auto tileset = openFar(source, options);
    for (int frame = 0; frame < 2000 && tileset->failures().empty(); ++frame) {
        tileset->request(select(tileset->tree(), {&kInside, 1}, {16.0, true}).load);
        tileset->wait(5ms);
        tileset->poll();
    }
    ASSERT_EQ(tileset->failures().size(), 1u);
    EXPECT_EQ(tileset->failures()[0].error.message(), "t3.glb: busy");
    EXPECT_EQ(source->tries()["t3.glb"], 3);
}

TEST(LoaderFaults, ReadsOfTilesNoLongerWantedAreCancelled) {
    const auto source = row(40);
    source->delay = 0ms;
    const auto tileset = openFar(source);
    source->delay = 10s;
    const Selection all = select(tileset->tree(), {&kInside, 1}, {});
    tileset->request(all.load);
    while (source->underWay() < 20)
        std::this_thread::sleep_for(1ms);
    tileset->request({});
    EXPECT_EQ(source->underWay(), 0u);
    EXPECT_TRUE(tileset->idle());
    for (const LoadRequest& request : all.load)
        EXPECT_EQ(tileset->tree().node(request.tile).state, LoadState::Unloaded);
}

TEST(LoaderFaults, QuitsAtOnceWithSixtyFourReadsInFlight) {
    const auto source = row(64);
    source->atOnce = 64;
    source->delay = 0ms;
    auto tileset = openFar(source);
    source->delay = 60s;
    tileset->request(select(tileset->tree(), {&kInside, 1}, {}).load);
    while (source->underWay() < 64)
        std::this_thread::sleep_for(1ms);
    const auto begin = std::chrono::steady_clock::now();
    tileset.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
    EXPECT_EQ(source->underWay(), 0u);
}

TEST(LoaderFaults, AStopEndsSettlingAtOnce) {
    const auto source = row(20);
    source->delay = 0ms;
    const auto tileset = openFar(source);
    source->delay = 30s;
    StreamedTileset* const one = tileset.get();
    const auto begin = std::chrono::steady_clock::now();
    const SettledAll settled =
        settle(std::span(&one, 1), {std::span(&kInside, 1), {}, soon(60), [&] {
                                        return std::chrono::steady_clock::now() > begin + 50ms;
                                    }});
    EXPECT_FALSE(settled.complete);
    EXPECT_FALSE(settled.overBudget);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
}

// A content that is slow to make: a tile that is being decoded cannot be called back.
struct Slow : ContentMaker {
    mutable std::atomic<int> started{0}, finished{0};
    Result<TileContent> make(const std::string&, const DecodeOptions&) const override {
        ++started;
        std::this_thread::sleep_for(60ms);
        ++finished;
        TileContent content;
        content.meshes.emplace_back();
        content.meshes[0].positions.resize(1000);
        content.meshes[0].normals.resize(1000);
        content.materials.emplace_back();
        return content;
    }
    std::string describe(const std::string& path) const override { return path; }
};

MadeTileset slowTiles(const std::shared_ptr<Slow>& maker, int count) {
    MadeTileset made;
    made.maker = maker;
    const auto boxAt = [](double x, double half) {
        return BoundingVolume(OrientedBox{{{x, 50, 50}}, glm::dmat3(half)});
    };
    made.tiles.push_back({kNoTile, Refine::Add, ContentKind::None, 100.0, boxAt(50, 200), {}});
    for (int i = 0; i < count; ++i)
        made.tiles.push_back({0, Refine::Replace, ContentKind::Mesh, 0.0, boxAt(i * 10 + 5, 5),
                              "m" + std::to_string(i)});
    return made;
}

TEST(LoaderFaults, WhatIsBeingDecodedWhenItIsCancelledIsKeptAndGoesFirst) {
    const auto maker = std::make_shared<Slow>();
    LoaderOptions options;
    options.workers = 2;
    auto opened = StreamedTileset::ofMade(slowTiles(maker, 12), "slow", options);
    ASSERT_TRUE(opened);
    StreamedTileset& tileset = **opened;
    const Selection all = select(tileset.tree(), {&kInside, 1}, {});
    ASSERT_EQ(all.load.size(), 12u);
    tileset.request(all.load);
    while (maker->started < 2)
        std::this_thread::sleep_for(1ms);
    tileset.request({});
    EXPECT_EQ(maker->finished, 0);
    while (tileset.wait(1000ms))
        tileset.poll();
    EXPECT_EQ(maker->started, 2);
    EXPECT_TRUE(tileset.idle());
    EXPECT_EQ(tileset.ledger().held(MemoryLedger::Use::Decoding), 0u);
    EXPECT_EQ(tileset.ledger().held(), tileset.decodedBytes());
    unsigned ready = 0;
    for (const LoadRequest& request : all.load)
        ready += tileset.tree().node(request.tile).state == LoadState::Ready;
    EXPECT_EQ(ready, 2u);
    tileset.ledger().nextMoment();
    EXPECT_TRUE(tileset.ledger().makeRoom(tileset.ledger().cap()));
    EXPECT_EQ(tileset.ledger().held(), 0u);
    EXPECT_EQ(tileset.decodedBytes(), 0u);
}

TEST(LoaderFaults, QuitsWhileDecoding) {
    const auto maker = std::make_shared<Slow>();
    auto opened = StreamedTileset::ofMade(slowTiles(maker, 64), "slow", {});
    (*opened)->request(select((*opened)->tree(), {&kInside, 1}, {}).load);
    while (maker->started == 0)
        std::this_thread::sleep_for(1ms);
    const auto begin = std::chrono::steady_clock::now();
    opened->reset();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
    EXPECT_EQ(maker->started, maker->finished);
}

TEST(LoaderFaults, QuitsWhileDecodesWaitForRoom) {
    const auto maker = std::make_shared<Slow>();
    LoaderOptions options;
    options.workers = 4;
    options.ledger = std::make_shared<MemoryLedger>(100'000);
    auto opened = StreamedTileset::ofMade(slowTiles(maker, 64), "slow", options);
    (*opened)->request(select((*opened)->tree(), {&kInside, 1}, {}).load);
    while (options.ledger->waitingBytes() == 0)
        std::this_thread::sleep_for(1ms);
    opened->reset();
    EXPECT_EQ(options.ledger->held(), 0u);
    EXPECT_EQ(options.ledger->waitingBytes(), 0u);
}

} // namespace
} // namespace gnomon
