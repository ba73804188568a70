#include "bench/parallel.h"

#include "bench/reference.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace gnomon::bench {

namespace {

// How often the calling thread reports while the others work.
constexpr std::chrono::milliseconds kReportInterval(50);

struct Blocks {
    Blocks(std::size_t all, std::size_t each) : count(all), block(std::max<std::size_t>(each, 1)) {}

    const std::size_t count, block;
    std::atomic<std::size_t> next{0}, done{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    std::condition_variable changed;
    unsigned running = 0; // threads besides the caller

    // One block of what is left; false when there is none.
    bool workOnce(const BlockWork& work) {
        if (stop)
            return false;
        const std::size_t begin = next.fetch_add(block);
        if (begin >= count)
            return false;
        const std::size_t end = std::min(begin + block, count);
        work(begin, end);
        done += end - begin;
        return true;
    }
    void workOn(const BlockWork& work) {
        while (workOnce(work)) {
        }
        const std::lock_guard lock(mutex);
        --running;
        changed.notify_one();
    }
    bool waitForOthers() {
        std::unique_lock lock(mutex);
        return changed.wait_for(lock, kReportInterval, [&] { return running == 0; });
    }
};

} // namespace

bool inParallelWhile(std::size_t count, std::size_t block, unsigned threads, const BlockWork& work,
                     const std::function<bool(std::size_t done)>& goOn) {
    Blocks blocks(count, block);
    if (threads == 0)
        threads = std::max(1u, std::thread::hardware_concurrency());
    const std::size_t useful = (count + blocks.block - 1) / blocks.block;
    threads = unsigned(std::min<std::size_t>(threads, useful));
    std::vector<std::thread> others;
    for (unsigned i = 1; i < threads; ++i) {
        {
            const std::lock_guard lock(blocks.mutex);
            ++blocks.running;
        }
        try {
            others.emplace_back([&] { blocks.workOn(work); });
        } catch (const std::system_error&) { // no more threads to be had: fewer do it as well
            const std::lock_guard lock(blocks.mutex);
            --blocks.running;
            break;
        }
    }
    const auto report = [&] {
        if (!blocks.stop && goOn && !goOn(blocks.done))
            blocks.stop = true;
    };
    while (blocks.workOnce(work))
        report();
    while (!blocks.waitForOthers())
        report();
    for (std::thread& other : others)
        other.join();
    if (blocks.done == count && goOn)
        goOn(count);
    return blocks.done == count;
}

void inParallel(std::size_t count, std::size_t block, unsigned threads, const BlockWork& work) {
    inParallelWhile(count, block, threads, work, {});
}

} // namespace gnomon::bench
