// Files that take their time to come, many at once, as from a far server; and some never, or not at
// once. On a thread of its own.
#pragma once

#include "tests/streaming/tree_support.h"

#include <condition_variable>
#include <functional>
#include <set>

namespace gnomon::testing {

class FarSource : public Source {
  public:
    using Clock = std::chrono::steady_clock;

    std::map<std::string, Bytes> files;
    std::atomic<std::chrono::microseconds> delay{std::chrono::microseconds(1000)};
    bool jitter = false;
    unsigned atOnce = 20;
    std::uint32_t seed = 0; // of the jitter
    // What becomes of the n-th read of a path, from 1; null: what `files` says.
    std::function<std::optional<Error>(const std::string& path, int n)> fault;

    FarSource() : thread_([this] { run(); }) {}
    ~FarSource() override {
        {
            const std::lock_guard lock(mutex_);
            stop_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }

    Result<Bytes> read(const std::string& path) const override {
        std::this_thread::sleep_for(delay.load());
        const std::lock_guard lock(mutex_);
        return answer(path);
    }
    std::string describe(const std::string& path) const override { return path; }
    unsigned readsAtOnce() const override { return atOnce; }

    ReadId start(const std::string& path, Done done) const override {
        const std::lock_guard lock(mutex_);
        const ReadId id = ++ids_;
        std::uint32_t hash = (seed + std::uint32_t(id)) * 2654435761u;
        hash ^= hash >> 15;
        const auto wait = jitter ? delay.load() * (hash % 5) / 2 : delay.load();
        reads_.emplace(Clock::now() + wait, Read{id, path, std::move(done)});
        order.push_back(path);
        most = std::max(most, reads_.size());
        wake_.notify_all();
        return id;
    }
    void cancel(ReadId id) const override {
        std::unique_lock lock(mutex_);
        for (auto at = reads_.begin(); at != reads_.end(); ++at)
            if (at->second.id == id) {
                reads_.erase(at);
                ++cancelled;
                return;
            }
        idle_.wait(lock, [&] { return calling_ != id; });
    }

    // With the lock of a test that looks while reads are under way.
    std::size_t underWay() const {
        const std::lock_guard lock(mutex_);
        return reads_.size();
    }
    std::vector<std::string> started() const {
        const std::lock_guard lock(mutex_);
        return order;
    }
    std::map<std::string, int> tries() const {
        const std::lock_guard lock(mutex_);
        return tries_;
    }
    mutable std::size_t most = 0, cancelled = 0;

  private:
    struct Read {
        ReadId id = 0;
        std::string path;
        Done done;
    };

    Result<Bytes> answer(const std::string& path) const {
        const int n = ++tries_[path];
        if (fault)
            if (auto error = fault(path, n))
                return *error;
        const auto it = files.find(path);
        if (it == files.end())
            return Error{path, "no such file"};
        return it->second;
    }

    void run() {
        std::unique_lock lock(mutex_);
        while (!stop_) {
            if (reads_.empty()) {
                wake_.wait(lock);
                continue;
            }
            const Clock::time_point due = reads_.begin()->first;
            if (due > Clock::now()) {
                wake_.wait_until(lock, due);
                continue;
            }
            Read read = std::move(reads_.begin()->second);
            reads_.erase(reads_.begin());
            Result<Bytes> bytes = answer(read.path);
            calling_ = read.id;
            lock.unlock();
            read.done(std::move(bytes));
            lock.lock();
            calling_ = 0;
            idle_.notify_all();
        }
    }

    mutable std::mutex mutex_;
    mutable std::condition_variable wake_, idle_;
    mutable std::multimap<Clock::time_point, Read> reads_;
    mutable std::map<std::string, int> tries_;
    mutable std::vector<std::string> order;
    mutable ReadId ids_ = 0, calling_ = 0;
    bool stop_ = false;
    std::thread thread_;
};

} // namespace gnomon::testing
