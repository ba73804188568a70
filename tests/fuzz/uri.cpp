// resolveUri(): base, a zero byte, uri.
// words: streaming/source.cpp
#include "tests/fuzz/fuzz.h"

#include "streaming/source.h"

namespace gnomon::fuzz {

namespace {

bool isWeb(std::string_view url, std::string_view scheme) {
    return url.size() > scheme.size() && std::equal(scheme.begin(), scheme.end(), url.begin(),
                                                    [](char a, char b) { return a == (b | 0x20); });
}

std::string encoded(const std::string& path) {
    std::string out;
    for (const char c : path) {
        char text[4];
        std::snprintf(text, sizeof text, "%%%02X", unsigned(static_cast<unsigned char>(c)));
        out += c == '/' ? "/" : text;
    }
    return out;
}

void checkFile(const std::string& base, const std::string& resolved) {
    demand(staysInside(resolved), "a resolved path stays inside the input's folder");
    demand(resolved.size() < base.size() + 4096 * 64, "no path grows without end");
    // Named by its every byte it is the same file.
    const auto again = resolveUri("", encoded(resolved));
    demand(again && *again == resolved, "percent-encoding a path names the same file");
}

void checkWeb(const std::string& base, const std::string& resolved) {
    demand(isWeb(resolved, "https://") || isWeb(resolved, "http://"),
           "what the web names is on the web");
    demand(!isWeb(base, "https://") || isWeb(resolved, "https://"), "https stays https");
    demand(isPlainLine(resolved), "no control characters in a URL");
    demand(resolved.find(' ') == std::string::npos, "no space in a URL");
    demand(resolved.find('#') == std::string::npos, "no fragment is sent");
    const std::size_t host = resolved.find("://") + 3;
    demand(host < resolved.size() && resolved[host] != '/', "a URL has a host");
    const auto again = resolveUri(resolved, resolved);
    demand(again && *again == resolved, "a resolved URL resolves to itself");
}

} // namespace

void fuzzOne(Span bytes) {
    const std::vector<Span> parts = partsOf(bytes);
    const std::string base(textOf(parts[0]));
    const std::string uri(textOf(parts.size() > 1 ? parts[1] : parts[0]));
    // Bases are not hostile: what the user named, or what came out of here before.
    const bool web = isWeb(base, "http://") || isWeb(base, "https://");
    const auto cleanBase = web ? resolveUri(base, base) : resolveUri("", base);
    for (const std::string& from : {std::string("city/tileset.json"), std::string("tileset.json"),
                                    std::string("https://example.com/a/b/tileset.json?key=1"),
                                    cleanBase ? *cleanBase : std::string("a/b/c/d")}) {
        const auto resolved = resolveUri(from, uri);
        if (!resolved)
            demandReadable(resolved.error());
        else if (isWeb(from, "http://") || isWeb(from, "https://"))
            checkWeb(from, *resolved);
        else
            checkFile(from, *resolved);
    }
}

} // namespace gnomon::fuzz
