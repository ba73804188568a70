#include "streaming/memory_ledger.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <thread>
#include <vector>

namespace gnomon {
namespace {

using Use = MemoryLedger::Use;
using namespace std::chrono_literals;

// Tiles that are only numbers and sizes.
struct Tiles final : MemoryLedger::Owner {
    MemoryLedger& ledger;
    std::map<std::uint32_t, std::pair<MemoryLedger::Hold, MemoryLedger::Place>> kept;
    std::vector<std::uint32_t> dropped;

    explicit Tiles(MemoryLedger& of) : ledger(of) {}
    ~Tiles() {
        for (auto& [item, entry] : kept)
            ledger.leave(entry.second);
    }
    void add(std::uint32_t item, std::size_t bytes, bool used = true) {
        auto hold = ledger.take(Use::Decoded, bytes);
        ASSERT_TRUE(hold);
        kept[item] = {std::move(*hold), ledger.enter(*this, item, used)};
    }
    void use(std::uint32_t item) { ledger.use(kept.at(item).second); }
    void drop(std::uint32_t item) override {
        ledger.leave(kept.at(item).second);
        kept.erase(item);
        dropped.push_back(item);
    }
};

TEST(MemoryLedger, GivesNothingBeyondTheCap) {
    MemoryLedger ledger(100);
    auto a = ledger.take(Use::Decoded, 60);
    ASSERT_TRUE(a);
    EXPECT_FALSE(ledger.take(Use::Gpu, 41));
    auto b = ledger.take(Use::Gpu, 40);
    ASSERT_TRUE(b);
    EXPECT_EQ(ledger.held(), 100u);
    EXPECT_EQ(ledger.held(Use::Gpu), 40u);
    EXPECT_FALSE(b->resize(41));
    EXPECT_TRUE(b->resize(10));
    EXPECT_TRUE(a->resize(90));
    EXPECT_EQ(ledger.held(), 100u);
    a.reset();
    b.reset();
    EXPECT_EQ(ledger.held(), 0u);
    EXPECT_EQ(ledger.most(), 100u);
}

TEST(MemoryLedger, AHoldMayBeSplitBetweenUses) {
    MemoryLedger ledger(100);
    auto whole = ledger.take(Use::Decoding, 100);
    MemoryLedger::Hold decoded = whole->split(Use::Decoded, 70);
    MemoryLedger::Hold gpu = whole->split(Use::Gpu, 30);
    EXPECT_EQ(whole->bytes(), 0u);
    EXPECT_EQ(ledger.held(Use::Decoding), 0u);
    EXPECT_EQ(ledger.held(Use::Decoded), 70u);
    EXPECT_EQ(ledger.held(Use::Gpu), 30u);
    MemoryLedger::Hold moved = std::move(decoded);
    decoded.reset();
    EXPECT_EQ(ledger.held(), 100u);
    moved.reset();
    EXPECT_EQ(ledger.held(), 30u);
    EXPECT_EQ(ledger.most(), 100u);
}

TEST(MemoryLedger, DropsTheLongestUnusedOfAllOwnersButNothingUsedNow) {
    MemoryLedger ledger(100);
    Tiles city(ledger), terrain(ledger);
    city.add(1, 20);
    terrain.add(1, 20);
    ledger.nextMoment();
    city.add(2, 20);
    terrain.add(2, 20);
    ledger.nextMoment();
    city.use(1);
    EXPECT_TRUE(ledger.makeRoom(40));
    EXPECT_EQ(terrain.dropped, (std::vector<std::uint32_t>{1}));
    EXPECT_TRUE(city.dropped.empty());
    EXPECT_TRUE(ledger.makeRoom(80)); // city 2, then terrain 2: as they were used
    EXPECT_EQ(city.dropped, (std::vector<std::uint32_t>{2}));
    EXPECT_EQ(terrain.dropped, (std::vector<std::uint32_t>{1, 2}));
    EXPECT_FALSE(ledger.makeRoom(81)) << "city 1 is used now";
    EXPECT_EQ(city.kept.size(), 1u);
    ledger.nextMoment();
    EXPECT_TRUE(ledger.makeRoom(100));
}

TEST(MemoryLedger, WhatNobodyUsedYetGoesAfterWhatWasUsedBefore) {
    MemoryLedger ledger(100);
    Tiles tiles(ledger);
    tiles.add(1, 25);
    ledger.nextMoment();
    tiles.add(2, 25);
    tiles.add(3, 25, false);
    tiles.add(4, 25);
    EXPECT_TRUE(ledger.makeRoom(25));
    EXPECT_TRUE(ledger.makeRoom(50));
    EXPECT_FALSE(ledger.makeRoom(51));
    EXPECT_EQ(tiles.dropped, (std::vector<std::uint32_t>{1, 3}));
}

TEST(MemoryLedger, AnImpatientDecodeIsRefusedAndAPatientOneWaits) {
    MemoryLedger ledger(100);
    Tiles tiles(ledger);
    tiles.add(1, 80);
    const std::atomic<bool> never = false;
    EXPECT_FALSE(ledger.beginDecode(30, false, never));
    std::atomic<bool> granted = false;
    std::thread worker([&] {
        const auto turn = ledger.beginDecode(30, true, never);
        EXPECT_TRUE(turn && !turn->alone && turn->hold.bytes() == 30);
        granted = true;
        ledger.endDecode();
    });
    while (ledger.waitingBytes() == 0)
        std::this_thread::sleep_for(1ms);
    EXPECT_EQ(ledger.waitingBytes(), 30u);
    EXPECT_TRUE(ledger.starving());
    EXPECT_FALSE(ledger.makeRoom(30)) << "used now";
    EXPECT_FALSE(granted);
    ledger.nextMoment();
    EXPECT_TRUE(ledger.makeRoom(30));
    worker.join();
    EXPECT_TRUE(granted);
    EXPECT_EQ(ledger.held(), 0u);
    EXPECT_FALSE(ledger.starving());
}

TEST(MemoryLedger, WhoStarvesGetsAllThatIsLeftAndIsTold) {
    MemoryLedger ledger(100);
    Tiles tiles(ledger);
    tiles.add(1, 80);
    const std::atomic<bool> never = false;
    std::thread worker([&] {
        auto turn = ledger.beginDecode(1000, true, never);
        ASSERT_TRUE(turn);
        EXPECT_TRUE(turn->alone);
        EXPECT_EQ(turn->hold.bytes(), 20u);
        EXPECT_FALSE(turn->hold.resize(21));
        turn.reset();
        ledger.endDecode();
    });
    while (!ledger.starving())
        std::this_thread::sleep_for(1ms);
    ledger.grantRest();
    worker.join();
    EXPECT_EQ(ledger.held(), 80u);
    EXPECT_EQ(ledger.most(), 100u);
}

TEST(MemoryLedger, WhoWaitsCanBeStopped) {
    MemoryLedger ledger(10);
    std::atomic<bool> stop = false;
    std::thread worker([&] { EXPECT_FALSE(ledger.beginDecode(11, true, stop)); });
    while (ledger.waitingBytes() == 0)
        std::this_thread::sleep_for(1ms);
    stop = true;
    ledger.wake();
    worker.join();
    EXPECT_EQ(ledger.waitingBytes(), 0u);
}

TEST(MemoryLedger, OtherThingsOfASceneTakeTheRoomOfTiles) {
    MemoryLedger ledger(100);
    Tiles tiles(ledger);
    tiles.add(1, 60);
    tiles.add(2, 40);
    ledger.nextMoment();
    ledger.setOther(50);
    EXPECT_EQ(ledger.held(), 90u);
    EXPECT_EQ(tiles.dropped.size(), 1u);
    EXPECT_FALSE(ledger.take(Use::Decoded, 11));
    ledger.setOther(0);
    EXPECT_TRUE(ledger.take(Use::Decoded, 60));
    EXPECT_EQ(ledger.most(), 100u);
}

TEST(MemoryLedger, ManyThreadsNeverPassTheCap) {
    MemoryLedger ledger(1000);
    std::atomic<bool> stop = false, over = false;
    std::atomic<unsigned> done = 0;
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            std::uint32_t random = t + 1;
            for (int i = 0; i < 3000; ++i) {
                random = random * 1664525u + 1013904223u;
                auto turn = ledger.beginDecode(random >> 16 & 0x1ff, true, stop);
                if (!turn)
                    return;
                over = over || ledger.held() > ledger.cap();
                random = random * 1664525u + 1013904223u;
                (void)turn->hold.resize(random >> 16 & 0x1ff);
                turn.reset();
                ledger.endDecode();
                ++done;
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_FALSE(over);
    EXPECT_EQ(done, 12000u);
    EXPECT_EQ(ledger.held(), 0u);
    EXPECT_LE(ledger.most(), ledger.cap());
}

} // namespace
} // namespace gnomon
