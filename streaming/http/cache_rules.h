// What may be kept of a response and for how long: RFC 9111 for a private cache of GETs. Without a
// word from the server a response is asked about again every time; there is no guessing.
#pragma once

#include "streaming/http/response.h"
#include "streaming/http/sha256.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct CacheFacts {
    std::int64_t storedAt = 0, freshUntil = 0; // seconds since 1970
    std::string etag, lastModified;
    std::string varyNames; // request headers of ours that the answer depends on: "accept,x-key"
    Digest varyValues{};   // of what we sent for them
    Digest answeredBy{};   // the address that the validators belong to: redirects may lead away

    bool canBeAsked() const { return !etag.empty() || !lastModified.empty(); }
    // A clock that was set back makes everything stale.
    bool isFresh(std::int64_t now) const { return now >= storedAt && now < freshUntil; }
};

bool forbidsKeeping(const ResponseHead& head); // no-store
// Nothing for a response that must not be kept. `sent` are the user's headers that went along;
// `redirected` ones are never fresh, as the way may change.
std::optional<CacheFacts> factsToKeep(const ResponseHead& head, std::int64_t now,
                                      const std::vector<std::string>& sent, bool redirected);
// After 304: what of it is new.
std::optional<CacheFacts> refreshedFacts(const CacheFacts& old, const ResponseHead& head,
                                         std::int64_t now, const std::vector<std::string>& sent,
                                         bool redirected);
// Whether what was kept is what a request with these headers would get.
bool fitsHeaders(const CacheFacts& facts, const std::vector<std::string>& sent);

} // namespace gnomon
