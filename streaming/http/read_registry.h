// Who waits for what: every read that was started and neither answered nor cancelled.
#pragma once

#include "streaming/source.h"

#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>

namespace gnomon {

class ReadRegistry {
  public:
    Source::ReadId add(Source::Done done);
    bool isWanted(Source::ReadId id) const;
    // Calls its `done`, unless it was cancelled.
    void finish(Source::ReadId id, Result<Bytes> result);
    // Waits for a `done` that is being called, unless that is who calls.
    void cancel(Source::ReadId id);
    void finishAll(const Error& error);

  private:
    mutable std::mutex mutex_;
    std::condition_variable called_;
    Source::ReadId last_ = 0;
    std::map<Source::ReadId, Source::Done> open_;
    std::map<Source::ReadId, std::thread::id> calling_;
};

} // namespace gnomon
