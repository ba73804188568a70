// Addresses on the web: base, a zero byte, reference.
// words: streaming/http/url.cpp streaming/http/address_filter.cpp
#include "tests/fuzz/fuzz.h"

#include "streaming/http/address_filter.h"
#include "streaming/http/url.h"

namespace gnomon::fuzz {

namespace {

constexpr const char* kSecret = "=s3cr3t";

std::size_t countOf(std::string_view text, std::string_view what) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + 1))
        ++count;
    return count;
}

void checkUrl(const Url& url) {
    demand(url.scheme == "http" || url.scheme == "https", "the web has two schemes");
    demand(!url.host.empty() && isPlainLine(url.host) &&
               url.host.find_first_of("/?#@\\ ") == std::string::npos,
           "a host is a name");
    demand(url.path.starts_with("/"), "a path begins with a slash");
    const std::string text = url.text();
    demand(isPlainLine(text) && text.find_first_of(" #") == std::string::npos,
           "an address is one word without fragment");
    for (const std::string_view dots : {"/./", "/../"})
        demand(url.path.find(dots) == std::string::npos, "no dot segments are left");
    demand(!url.path.ends_with("/..") && !url.path.ends_with("/."), "no dot segments at the end");
    const auto again = parseUrl(text);
    demand(again && again->text() == text && sameServer(*again, url),
           "what was put together reads as the same");
    demand(url.user.empty() || text.find('@') == std::string::npos ||
               text.find('@') > text.find('/', 8),
           "a user's name is not in what is asked for");
    demandReadable(withoutSecrets(text));
    (void)isPrivateHost(url.host);
    Url filled = url;
    addQueryFields(filled, queryFields(url));
    demand(filled.text() == text, "what is there is not added again");
    addQueryFields(filled, {{"key", kSecret}});
    demand(countOf(withoutSecrets(filled.text()), kSecret) <= countOf(text, kSecret),
           "a key is not shown");
}

} // namespace

void fuzzOne(Span bytes) {
    const std::vector<Span> parts = partsOf(bytes);
    const auto base = parseUrl(textOf(parts[0]));
    if (base)
        checkUrl(*base);
    else
        demandReadable(base.error().reason);
    const Url from = base ? *base : *parseUrl("https://example.com/a/b/tileset.json?key=1");
    const std::string_view reference = textOf(parts.back());
    const auto url = resolveUrl(from, reference);
    if (!url) {
        demandReadable(url.error().reason);
        return;
    }
    checkUrl(*url);
    demand(url->user.empty(), "a document names no user");
    demand(from.scheme == "http" || url->scheme == "https", "https stays https");
    demand(!mayCarrySecrets(from, *url) || bareHost(from.host) == bareHost(url->host),
           "secrets go to no other host");
}

} // namespace gnomon::fuzz
