#include "streaming/http/cache_worker.h"

#include <signal.h>

namespace gnomon {
namespace {

constexpr std::size_t kMostBytesToWrite = std::size_t(128) << 20;

std::size_t bytesOf(const std::optional<CacheEntry>& entry) {
    return entry ? entry->body.size() : 0;
}

} // namespace

CacheWorker::CacheWorker(std::unique_ptr<HttpCache> cache) : cache_(std::move(cache)) {
    thread_ = std::thread([this] { run(); });
}

CacheWorker::~CacheWorker() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
        lookups_.clear();
    }
    wake_.notify_all();
    thread_.join();
}

void CacheWorker::find(const Digest& name, std::function<void(std::optional<CacheEntry>)> found) {
    {
        const std::lock_guard lock(mutex_);
        lookups_.push_back({name, std::move(found)});
    }
    wake_.notify_all();
}

void CacheWorker::store(const Digest& name, CacheEntry entry) {
    post({name, std::move(entry)});
}

void CacheWorker::remove(const Digest& name) {
    post({name, std::nullopt});
}

void CacheWorker::post(Write write) {
    {
        const std::lock_guard lock(mutex_);
        const std::size_t bytes = bytesOf(write.entry);
        if (bytesToWrite_ + bytes > kMostBytesToWrite)
            return;
        bytesToWrite_ += bytes;
        writes_.push_back(std::move(write));
    }
    wake_.notify_all();
}

void CacheWorker::run() {
    sigset_t all; // signals are for the program's main thread
    sigfillset(&all);
    for (const int ours : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP})
        sigdelset(&all, ours);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    std::unique_lock lock(mutex_);
    for (;;) {
        wake_.wait(lock, [&] { return stop_ || !lookups_.empty() || !writes_.empty(); });
        if (!lookups_.empty()) {
            Lookup lookup = std::move(lookups_.front());
            lookups_.pop_front();
            lock.unlock();
            lookup.found(cache_->find(lookup.name));
            lookup = {};
            lock.lock();
        } else if (!writes_.empty()) {
            Write write = std::move(writes_.front());
            writes_.pop_front();
            lock.unlock();
            if (write.entry)
                cache_->store(write.name, *write.entry);
            else
                cache_->remove(write.name);
            lock.lock();
            bytesToWrite_ -= bytesOf(write.entry);
        } else if (stop_) {
            return;
        }
    }
}

} // namespace gnomon
