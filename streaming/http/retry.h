// When to ask again.
#pragma once

#include "streaming/http/response.h"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace gnomon {

bool isPassingStatus(int status); // 408, 429 and 5xx that say no more than "not now"

// Before attempt `attempt` + 1, where the first is 1: doubles each time. A half of it is jitter, so
// that requests that failed together do not come back together; the same for the same address and
// attempt.
std::chrono::milliseconds backoff(std::chrono::milliseconds first, unsigned attempt,
                                  std::string_view url);

// Retry-After: seconds or a date. `now` in seconds since 1970.
std::optional<std::chrono::seconds> retryAfter(const ResponseHead& head, std::int64_t now);

} // namespace gnomon
