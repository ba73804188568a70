#include "streaming/http/read_registry.h"

namespace gnomon {

Source::ReadId ReadRegistry::add(Source::Done done) {
    const std::lock_guard lock(mutex_);
    open_.emplace(++last_, std::move(done));
    return last_;
}

bool ReadRegistry::isWanted(Source::ReadId id) const {
    const std::lock_guard lock(mutex_);
    return open_.count(id) > 0;
}

void ReadRegistry::finish(Source::ReadId id, Result<Bytes> result) {
    Source::Done done;
    {
        const std::lock_guard lock(mutex_);
        const auto at = open_.find(id);
        if (at == open_.end())
            return;
        done = std::move(at->second);
        open_.erase(at);
        calling_.emplace(id, std::this_thread::get_id());
    }
    done(std::move(result));
    done = nullptr; // what it holds goes before anybody is told that it is over
    {
        const std::lock_guard lock(mutex_);
        calling_.erase(id);
    }
    called_.notify_all();
}

void ReadRegistry::cancel(Source::ReadId id) {
    Source::Done dropped;
    std::unique_lock lock(mutex_);
    if (const auto at = open_.find(id); at != open_.end()) {
        dropped = std::move(at->second);
        open_.erase(at);
        lock.unlock(); // `dropped` may hold anything
        return;
    }
    called_.wait(lock, [&] {
        const auto at = calling_.find(id);
        return at == calling_.end() || at->second == std::this_thread::get_id();
    });
}

void ReadRegistry::finishAll(const Error& error) {
    for (;;) {
        Source::ReadId id = 0;
        {
            const std::lock_guard lock(mutex_);
            if (open_.empty())
                return;
            id = open_.begin()->first;
        }
        finish(id, error);
    }
}

} // namespace gnomon
