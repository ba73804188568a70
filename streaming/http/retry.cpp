#include "streaming/http/retry.h"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <string>

namespace gnomon {
namespace {

// FNV-1a, mixed once more as its high bits are weak in short texts.
std::uint64_t hashOf(std::string_view text, std::uint64_t seed) {
    std::uint64_t h = 0xcbf29ce484222325ull ^ seed * 0x9e3779b97f4a7c15ull;
    for (const char c : text)
        h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93ull;
    return h ^ (h >> 32);
}

} // namespace

bool isPassingStatus(int status) {
    return status == 408 || status == 429 || status == 500 || (status >= 502 && status <= 504);
}

std::chrono::milliseconds backoff(std::chrono::milliseconds first, unsigned attempt,
                                  std::string_view url) {
    constexpr unsigned kMostDoublings = 16;
    const double longest =
        double(first.count()) * double(1u << std::min(attempt - 1, kMostDoublings));
    const double share = double(hashOf(url, attempt) >> 11) * 0x1p-53;
    return std::chrono::milliseconds(std::int64_t(longest * (0.5 + 0.5 * share)));
}

std::optional<std::chrono::seconds> retryAfter(const ResponseHead& head, std::int64_t now) {
    const std::string text = head.get("retry-after");
    if (text.empty())
        return {};
    std::int64_t seconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (error == std::errc() && end == text.data() + text.size())
        return std::chrono::seconds(std::max<std::int64_t>(seconds, 0));
    if (error == std::errc::result_out_of_range)
        return std::chrono::seconds::max();
    const std::time_t date = curl_getdate(text.c_str(), nullptr);
    if (date < 0)
        return {};
    return std::chrono::seconds(std::max<std::int64_t>(date - now, 0));
}

} // namespace gnomon
