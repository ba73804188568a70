// One read() on its way through cache and network.
#pragma once

#include "streaming/http/cache.h"
#include "streaming/http/transfer.h"

#include <memory>

namespace gnomon {

struct WebRequest {
    Source::ReadId id = 0;
    Url url;                             // as asked for, with the user's query
    std::string shown;                   // the same for messages
    Url named;                           // of the source: what the user named
    std::vector<std::string> secretKeys; // of the query, not to be shown
    std::string wrong;                   // why it cannot be asked for at all
    std::shared_ptr<const Bytes> there;  // was read before: is only handed over
    Digest name{};                       // in the cache
    std::optional<CacheEntry> stale;

    // Of the attempt under way.
    Url current; // where redirects have led
    unsigned attempt = 1, redirects = 0;
    bool mayKeep = true; // no step on the way forbids it
    Transfer::Clock::time_point begun, notBefore;
};
using WebRequestPtr = std::unique_ptr<WebRequest>;

} // namespace gnomon
