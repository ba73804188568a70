#include "streaming/http/cache_rules.h"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>
#include <ctime>

namespace gnomon {
namespace {

constexpr std::int64_t kYearSeconds = 31'536'000;
// A Last-Modified this close to the answer's own Date may hide a change within the same second
// (RFC 9110, 8.8.2.2).
constexpr std::int64_t kStrongSeconds = 2;

struct CacheControl {
    bool noStore = false, noCache = false;
    std::optional<std::int64_t> maxAge;
};

// What is no number is as good as none at all: stale at once.
std::int64_t secondsIn(std::string_view text) {
    text = trimmed(text);
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"')
        text = text.substr(1, text.size() - 2);
    std::int64_t seconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (error == std::errc::result_out_of_range)
        return kYearSeconds;
    if (error != std::errc() || end != text.data() + text.size())
        return 0;
    return std::clamp<std::int64_t>(seconds, 0, kYearSeconds);
}

// The next of a list with commas between, which do not count inside quotes.
std::string_view takeListed(std::string_view& list) {
    bool quoted = false;
    std::size_t end = 0;
    for (; end < list.size() && (quoted || list[end] != ','); ++end)
        quoted ^= list[end] == '"';
    const std::string_view item = trimmed(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
    return item;
}

CacheControl cacheControlOf(const ResponseHead& head) {
    CacheControl control;
    const std::string text = head.get("cache-control");
    for (std::string_view list = text; !list.empty();) {
        const std::string_view item = takeListed(list);
        const std::string_view name = trimmed(item.substr(0, item.find('=')));
        const bool hasValue = item.find('=') != std::string_view::npos;
        if (equalNoCase(name, "no-store"))
            control.noStore = true;
        else if (equalNoCase(name, "no-cache"))
            control.noCache = true;
        else if (equalNoCase(name, "max-age") && hasValue)
            control.maxAge = secondsIn(item.substr(item.find('=') + 1));
    }
    if (text.empty() && head.get("pragma").find("no-cache") != std::string::npos)
        control.noCache = true;
    return control;
}

std::optional<std::int64_t> dateIn(const std::string& text) {
    const std::time_t date = text.empty() ? -1 : curl_getdate(text.c_str(), nullptr);
    return date < 0 ? std::nullopt : std::optional<std::int64_t>(date);
}

std::int64_t freshUntil(const ResponseHead& head, const CacheControl& control, std::int64_t now) {
    if (control.noCache)
        return now;
    std::int64_t lifetime = 0;
    if (control.maxAge) {
        lifetime = *control.maxAge;
    } else if (const std::string expires = head.get("expires"); !expires.empty()) {
        const std::int64_t date = dateIn(head.get("date")).value_or(now);
        lifetime = dateIn(expires).value_or(date) - date;
    }
    return now + std::clamp<std::int64_t>(lifetime - secondsIn(head.get("age")), 0, kYearSeconds);
}

std::string valuesSent(const std::string& names, const std::vector<std::string>& sent) {
    std::string values;
    for (std::string_view list = names; !list.empty();) {
        const std::string_view name = takeListed(list);
        for (const std::string& header : sent)
            if (equalNoCase(trimmed(std::string_view(header).substr(0, header.find(':'))), name))
                values += header + "\n";
    }
    return values;
}

// False for "*": nobody knows what the answer depends on. Names that we never send, or always with
// the same value, do not matter.
bool readVary(const ResponseHead& head, const std::vector<std::string>& sent, CacheFacts& facts) {
    const std::string vary = head.get("vary");
    for (std::string_view list = vary; !list.empty();) {
        const std::string name(takeListed(list));
        if (name == "*")
            return false;
        if (equalNoCase(name, "accept-encoding") || equalNoCase(name, "user-agent"))
            continue;
        facts.varyNames += (facts.varyNames.empty() ? "" : ",") + name;
    }
    facts.varyValues = sha256(valuesSent(facts.varyNames, sent));
    return true;
}

void readValidators(const ResponseHead& head, std::int64_t now, CacheFacts& facts) {
    facts.etag = head.get("etag");
    const std::string modified = head.get("last-modified");
    const auto when = dateIn(modified);
    if (when && *when + kStrongSeconds <= dateIn(head.get("date")).value_or(now))
        facts.lastModified = modified;
}

} // namespace

bool forbidsKeeping(const ResponseHead& head) {
    return cacheControlOf(head).noStore;
}

std::optional<CacheFacts> factsToKeep(const ResponseHead& head, std::int64_t now,
                                      const std::vector<std::string>& sent, bool redirected) {
    const CacheControl control = cacheControlOf(head);
    CacheFacts facts;
    // No tile is a web page: it is somebody's way of saying that something is wrong.
    const bool page = trimmed(head.get("content-type")).starts_with("text/html");
    if (control.noStore || page || !readVary(head, sent, facts))
        return {};
    facts.storedAt = now;
    facts.freshUntil = redirected ? now : freshUntil(head, control, now);
    readValidators(head, now, facts);
    return facts;
}

std::optional<CacheFacts> refreshedFacts(const CacheFacts& old, const ResponseHead& head,
                                         std::int64_t now, const std::vector<std::string>& sent,
                                         bool redirected) {
    const CacheControl control = cacheControlOf(head);
    if (control.noStore)
        return {};
    CacheFacts facts = old;
    if (!head.get("vary").empty()) {
        facts.varyNames.clear();
        if (!readVary(head, sent, facts))
            return {};
    }
    facts.storedAt = now;
    facts.freshUntil = redirected ? now : freshUntil(head, control, now);
    if (const std::string etag = head.get("etag"); !etag.empty())
        facts.etag = etag;
    return facts;
}

bool fitsHeaders(const CacheFacts& facts, const std::vector<std::string>& sent) {
    return sha256(valuesSent(facts.varyNames, sent)) == facts.varyValues;
}

} // namespace gnomon
