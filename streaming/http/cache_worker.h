// The cache on a thread of its own, so that a slow disk holds up neither the network nor a caller.
#pragma once

#include "streaming/http/cache.h"

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace gnomon {

class CacheWorker {
  public:
    explicit CacheWorker(std::unique_ptr<HttpCache> cache);
    ~CacheWorker(); // writes what is to be written; looks nothing up any more
    CacheWorker(const CacheWorker&) = delete;
    CacheWorker& operator=(const CacheWorker&) = delete;

    // Looking up goes before writing. `found` is called on the thread.
    void find(const Digest& name, std::function<void(std::optional<CacheEntry>)> found);
    // Dropped when the disk is far behind.
    void store(const Digest& name, CacheEntry entry);
    void remove(const Digest& name);
    bool isOwnThread() const { return thread_.get_id() == std::this_thread::get_id(); }

  private:
    struct Lookup {
        Digest name;
        std::function<void(std::optional<CacheEntry>)> found;
    };
    struct Write {
        Digest name;
        std::optional<CacheEntry> entry; // none: remove
    };
    void run();
    void post(Write write);

    std::unique_ptr<HttpCache> cache_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::deque<Lookup> lookups_;
    std::deque<Write> writes_;
    std::size_t bytesToWrite_ = 0;
    bool stop_ = false;
    std::thread thread_;
};

} // namespace gnomon
