#include "streaming/load_queue.h"
#include "tests/streaming/far_source.h"

#include <gtest/gtest.h>

namespace gnomon {
namespace {

using namespace testing;
using namespace std::chrono_literals;

std::shared_ptr<FarSource> files(unsigned count) {
    auto source = std::make_shared<FarSource>();
    for (unsigned i = 0; i < count; ++i)
        source->files["t" + std::to_string(i)] = glb(2);
    return source;
}

struct Queue {
    std::shared_ptr<MemoryLedger> ledger = std::make_shared<MemoryLedger>(std::size_t(64) << 20);
    LoadQueue queue;
    std::vector<LoadResult> results;

    Queue(std::shared_ptr<const Source> source, unsigned workers)
        : queue(std::move(source), workers, ledger) {}

    void ask(const std::vector<TileIndex>& order, std::size_t urgent) {
        queue.retain(order, urgent);
        std::vector<LoadJob> jobs;
        for (std::size_t i = 0; i < order.size(); ++i) {
            LoadJob job;
            job.tile = order[i];
            job.kind = ContentKind::Mesh;
            job.path = "t" + std::to_string(order[i]);
            job.rank = i;
            job.isUrgent = i < urgent;
            jobs.push_back(std::move(job));
        }
        queue.add(std::move(jobs));
    }
    void finish() {
        while (queue.outstanding() > 0) {
            for (LoadResult& result : queue.takeResults())
                results.push_back(std::move(result));
            std::this_thread::sleep_for(200us);
        }
    }
};

std::vector<TileIndex> numbers(TileIndex count) {
    std::vector<TileIndex> out;
    for (TileIndex i = 0; i < count; ++i)
        out.push_back(i);
    return out;
}

TEST(LoadQueue, KeepsAsManyReadsUnderWayAsAreWorthIt) {
    const auto source = files(100);
    source->delay = 5ms;
    source->atOnce = 16;
    Queue queue(source, 2);
    const auto begin = std::chrono::steady_clock::now();
    queue.ask(numbers(100), 100);
    queue.finish();
    EXPECT_EQ(queue.results.size(), 100u);
    for (const LoadResult& result : queue.results)
        EXPECT_TRUE(std::holds_alternative<std::shared_ptr<const TileContent>>(result.value));
    EXPECT_EQ(source->most, 16u);
    // One after the other they would take half a second.
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 300ms);
}

TEST(LoadQueue, StartsReadsInOrderOfUrgency) {
    const auto source = files(40);
    source->delay = 2ms;
    source->atOnce = 4;
    Queue queue(source, 1);
    std::vector<TileIndex> order = numbers(40);
    std::reverse(order.begin(), order.end());
    queue.ask(order, order.size());
    queue.finish();
    const std::vector<std::string> started = source->started();
    ASSERT_EQ(started.size(), 40u);
    for (std::size_t i = 0; i < 40; ++i)
        EXPECT_EQ(started[i], "t" + std::to_string(39 - i));
}

TEST(LoadQueue, CancelsReadsThatAreNotWantedAnyMore) {
    const auto source = files(64);
    source->delay = 10s;
    source->atOnce = 20;
    Queue queue(source, 2);
    queue.ask(numbers(64), 64);
    while (source->underWay() < 20)
        std::this_thread::sleep_for(1ms);
    const TileIndex wanted[] = {3, 50};
    const std::vector<TileIndex> dropped = queue.queue.retain(wanted, 2);
    EXPECT_EQ(dropped.size(), 62u);
    while (source->underWay() != 2) // 3, under way before, and 50, started now
        std::this_thread::sleep_for(1ms);
    EXPECT_EQ(source->cancelled, 19u);
    EXPECT_EQ(queue.queue.outstanding(), 2u);
    queue.queue.retain({}, 0);
    EXPECT_EQ(queue.queue.outstanding(), 0u);
    EXPECT_TRUE(queue.queue.quiet());
}

TEST(LoadQueue, WhatIsAskedForAgainRightAfterItWasCancelledComes) {
    const auto source = files(30);
    source->delay = 300us;
    source->jitter = true;
    Queue queue(source, 2);
    std::size_t came = 0;
    for (int round = 0; round < 200; ++round) {
        queue.ask(numbers(30), 30);
        if (round % 3)
            std::this_thread::sleep_for(std::chrono::microseconds(round * 7 % 900));
        queue.queue.retain({}, 0);
        // What was being worked on is still here; it may not be asked for twice.
        while (!queue.queue.quiet())
            std::this_thread::sleep_for(50us);
        came += queue.queue.takeResults().size();
    }
    queue.ask(numbers(30), 30);
    queue.finish();
    EXPECT_EQ(queue.results.size(), 30u);
    EXPECT_GT(came, 0u);
    queue.results.clear();
    EXPECT_EQ(queue.ledger->held(), 0u);
}

TEST(LoadQueue, EndsSoonWithSixtyFourReadsUnderWay) {
    const auto source = files(64);
    source->delay = 60s;
    source->atOnce = 64;
    auto queue = std::make_unique<Queue>(source, 2);
    queue->ask(numbers(64), 64);
    while (source->underWay() < 64)
        std::this_thread::sleep_for(1ms);
    const auto begin = std::chrono::steady_clock::now();
    queue.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
    EXPECT_EQ(source->underWay(), 0u);
}

// A glTF whose texture or buffer never comes must not hold up the end either.
TEST(LoadQueue, EndsSoonWhileADecoderWaitsForAFileBeside) {
    const auto source = std::make_shared<FarSource>();
    source->files["t0"] = bytesOf(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"byteLength":36,"uri":"b.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3,
        "min":[0,0,0],"max":[1,1,0]}]})");
    source->delay = 100ms;
    auto queue = std::make_unique<Queue>(source, 1);
    queue->ask({0}, 1);
    while (source->started().empty())
        std::this_thread::sleep_for(1ms);
    source->delay = 60s;
    while (source->started().size() < 2)
        std::this_thread::sleep_for(1ms);
    EXPECT_EQ(source->started()[1], "b.bin");
    const auto begin = std::chrono::steady_clock::now();
    queue.reset();
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
}

TEST(LoadQueue, APassingFaultOfAFileBesideIsTheTilesOwn) {
    const auto source = std::make_shared<FarSource>();
    source->files["t0"] = bytesOf(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"byteLength":36,"uri":"b.bin"}],"bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":3,
        "min":[0,0,0],"max":[1,1,0]}]})");
    source->fault = [](const std::string& path, int) -> std::optional<Error> {
        if (path == "b.bin")
            return Error{path, "busy", ErrorKind::Transient};
        return std::nullopt;
    };
    Queue queue(source, 1);
    queue.ask({0}, 1);
    queue.finish();
    ASSERT_EQ(queue.results.size(), 1u);
    const auto* error = std::get_if<Error>(&queue.results[0].value);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->kind, ErrorKind::Transient);
    EXPECT_EQ(error->message(), "b.bin: busy");
}

TEST(LoadQueue, AJobWaitsUntilItIsDue) {
    const auto source = files(2);
    source->delay = 0us;
    for (const unsigned atOnce : {0u, 8u}) {
        source->atOnce = atOnce;
        Queue queue(source, 2);
        LoadJob now, later;
        now.tile = 1;
        later.tile = 0;
        now.kind = later.kind = ContentKind::Mesh;
        now.path = "t1";
        later.path = "t0";
        now.rank = 1; // less urgent, but due
        later.notBefore = std::chrono::steady_clock::now() + 100ms;
        std::vector<LoadJob> jobs{later, now};
        queue.queue.add(std::move(jobs));
        std::this_thread::sleep_for(40ms);
        std::vector<LoadResult> first = queue.queue.takeResults();
        ASSERT_EQ(first.size(), 1u);
        EXPECT_EQ(first[0].tile, 1u);
        queue.finish();
        ASSERT_EQ(queue.results.size(), 1u);
        EXPECT_GE(std::chrono::steady_clock::now(), later.notBefore);
    }
}

TEST(LoadQueue, AResultHoldsItsRoomUntilItIsTaken) {
    const auto source = files(3);
    Queue queue(source, 2);
    queue.queue.setGpuBytes([](const TileContent&) { return std::size_t(1000); });
    queue.ask(numbers(3), 3);
    queue.finish();
    ASSERT_EQ(queue.results.size(), 3u);
    std::size_t bytes = 0;
    for (const LoadResult& result : queue.results) {
        const auto& content = std::get<std::shared_ptr<const TileContent>>(result.value);
        EXPECT_EQ(result.decodedBytes, content->bytes());
        EXPECT_EQ(result.gpuBytes, 1000u);
        EXPECT_EQ(result.hold.bytes(), result.decodedBytes + 1000u);
        bytes += result.hold.bytes();
    }
    EXPECT_EQ(queue.ledger->held(MemoryLedger::Use::Decoding), bytes);
    queue.results.clear();
    EXPECT_EQ(queue.ledger->held(), 0u);
}

TEST(LoadQueue, WhatIsNotUrgentDoesNotWaitForRoom) {
    const auto source = files(2);
    Queue queue(source, 1);
    auto all = queue.ledger->take(MemoryLedger::Use::Other, queue.ledger->cap());
    queue.ask({0}, 0);
    queue.finish();
    ASSERT_EQ(queue.results.size(), 1u);
    EXPECT_TRUE(std::holds_alternative<NoRoom>(queue.results[0].value));
    queue.ask({1}, 1);
    while (!queue.ledger->starving())
        std::this_thread::sleep_for(1ms);
    all.reset();
    queue.finish();
    ASSERT_EQ(queue.results.size(), 2u);
    EXPECT_FALSE(std::holds_alternative<NoRoom>(queue.results[1].value));
}

} // namespace
} // namespace gnomon
