// What a server says before the body, line by line, and what a cache makes of it. Lines from the
// word "304" on are of a second answer.
// words: streaming/http/response.cpp streaming/http/cache_rules.cpp streaming/http/retry.cpp
#include "tests/fuzz/fuzz.h"

#include "streaming/http/cache_rules.h"
#include "streaming/http/retry.h"

namespace gnomon::fuzz {

namespace {

constexpr std::int64_t kNow = 1'800'000'000;
constexpr std::int64_t kManyYears = std::int64_t(200) * 366 * 86400;

bool isOneLine(std::string_view text) {
    return std::all_of(text.begin(), text.end(), [](char c) {
        return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
    });
}

void checkFacts(const CacheFacts& facts, const ResponseHead& head,
                const std::vector<std::string>& sent) {
    demand(!forbidsKeeping(head), "what is forbidden is not kept");
    // They go into a request of ours: a line break would be a header of the server's making.
    demand(isOneLine(facts.etag) && isOneLine(facts.lastModified), "what is sent back is one line");
    demand(facts.storedAt <= kNow && facts.freshUntil <= kNow + kManyYears &&
               facts.freshUntil >= -kManyYears,
           "times that a calendar has");
    demand(!facts.isFresh(facts.storedAt - 1), "nothing is fresh before it was there");
    demand(fitsHeaders(facts, sent), "what was kept fits what it was asked with");
}

void checkHead(const ResponseHead& head, const std::vector<std::string>& sent) {
    demandReadable(head.statusInWords());
    demand(head.get("ETag") == head.get("etag"), "names have no case");
    if (const auto wait = retryAfter(head, kNow))
        demand(wait->count() >= 0, "a wait is no step back");
    if (const auto facts = factsToKeep(head, kNow, sent, false))
        checkFacts(*facts, head, sent);
    if (const auto facts = factsToKeep(head, kNow, sent, true))
        demand(!facts->isFresh(kNow) && !facts->isFresh(kNow + 1), "a redirect is never fresh");
}

} // namespace

void fuzzOne(Span bytes) {
    const std::vector<std::string> sent = {"Accept: */*", "X-Key: abc"};
    std::string_view text = textOf(bytes);
    ResponseHead first, second;
    bool later = false;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = text.substr(0, end);
        later = later || line.find("304") != line.npos;
        (later ? second : first).addLine(line);
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    checkHead(first, sent);
    checkHead(second, sent);
    const auto facts = factsToKeep(first, kNow, sent, false);
    if (!facts)
        return;
    if (const auto refreshed = refreshedFacts(*facts, second, kNow + 60, sent, false)) {
        demand(isOneLine(refreshed->etag) && isOneLine(refreshed->lastModified),
               "what is sent back is one line");
        demand(refreshed->storedAt <= kNow + 60, "nothing is from the future");
    }
}

} // namespace gnomon::fuzz
