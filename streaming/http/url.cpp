#include "streaming/http/url.h"

#include "streaming/http/http.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace gnomon {
namespace {

// What servers take in a request line; longer ones are answered with 414 anyway.
constexpr std::size_t kMaxUrlBytes = 8192;

constexpr std::string_view kScheme[] = {"http", "https"};

bool isAlnum(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z')
            c = char(c - 'A' + 'a');
    return out;
}

// Escapes what may not stand in a path or a query as it is; an escape that is there stays.
std::string escaped(std::string_view text) {
    constexpr std::string_view kStands = "-._~!$&'()*+,;=:@/?%[]|";
    constexpr char kHex[] = "0123456789ABCDEF";
    std::string out;
    out.reserve(text.size());
    for (const char c : text) {
        if (isAlnum(c) || kStands.find(c) != std::string_view::npos) {
            out.push_back(c);
        } else {
            const auto byte = static_cast<unsigned char>(c);
            out += {'%', kHex[byte >> 4], kHex[byte & 15]};
        }
    }
    return out;
}

// "." and "..", also escaped, as browsers have it: 0 for neither.
int dots(std::string_view segment) {
    int count = 0;
    while (!segment.empty()) {
        if (segment.front() == '.')
            segment.remove_prefix(1);
        else if (lower(segment.substr(0, 3)) == "%2e")
            segment.remove_prefix(3);
        else
            return 0;
        if (++count > 2)
            return 0;
    }
    return count;
}

// RFC 3986, 5.2.4. Above the top `..` leads nowhere.
std::string withoutDotSegments(std::string_view path) {
    std::vector<std::string_view> kept;
    bool folder = path.empty();
    for (std::size_t at = 1; at <= path.size();) {
        const std::size_t slash = path.find('/', at);
        const std::string_view segment = path.substr(at, slash - at);
        const bool last = slash == std::string_view::npos;
        const int d = dots(segment);
        if (d == 2 && !kept.empty())
            kept.pop_back();
        if (d == 0 && !(last && segment.empty()))
            kept.push_back(segment);
        folder = last && (d > 0 || segment.empty());
        if (last)
            break;
        at = slash + 1;
    }
    std::string out;
    for (const std::string_view segment : kept)
        out.append("/").append(segment);
    return folder || out.empty() ? out + "/" : out;
}

Error refused(const char* reason) {
    return {"", reason, ErrorKind::Input};
}

// A name or an address; what getaddrinfo makes of it is judged when a connection is opened.
bool isHost(std::string_view host) {
    if (host.size() > 255 || host.empty())
        return false;
    if (host.front() == '[')
        return host.size() > 2 && host.back() == ']' &&
               host.find_first_not_of("0123456789abcdefABCDEF:.", 1) == host.size() - 1;
    return std::all_of(host.begin(), host.end(), [](char c) {
        return isAlnum(c) || c == '-' || c == '.' || c == '_' || static_cast<signed char>(c) < 0;
    });
}

Failure readAuthority(std::string_view authority, Url& url) {
    if (const std::size_t at = authority.rfind('@'); at != std::string_view::npos) {
        url.user = authority.substr(0, at);
        authority.remove_prefix(at + 1);
    }
    const std::size_t bracket = authority.rfind(']');
    const std::size_t colon = authority.find(':', bracket == std::string_view::npos ? 0 : bracket);
    url.host = lower(authority.substr(0, colon));
    if (url.host.empty())
        return refused("has no host");
    if (!isHost(url.host))
        return refused("has a host that cannot be one");
    url.port = url.scheme == "https" ? 443 : 80;
    if (colon == std::string_view::npos || colon + 1 == authority.size())
        return {};
    const std::string_view digits = authority.substr(colon + 1);
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), url.port);
    if (error != std::errc() || end != digits.data() + digits.size() || url.port == 0)
        return refused("has a port that cannot be one");
    return {};
}

// Of "/path?query#fragment"; either may be missing.
void readPathAndQuery(std::string_view text, Url& url) {
    text = text.substr(0, text.find('#'));
    const std::size_t mark = text.find('?');
    url.hasQuery = mark != std::string_view::npos;
    url.query = url.hasQuery ? escaped(text.substr(mark + 1)) : std::string();
    std::string path(text.substr(0, mark));
    std::replace(path.begin(), path.end(), '\\', '/');
    url.path = withoutDotSegments(escaped(path));
}

// The scheme's length with its colon; 0 without one.
std::size_t schemeLength(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == ':')
            return i > 0 && !(text[0] >= '0' && text[0] <= '9') ? i + 1 : 0;
        if (!isAlnum(c) && c != '+' && c != '-' && c != '.')
            return 0;
    }
    return 0;
}

Failure checkText(std::string_view text) {
    if (text.size() > kMaxUrlBytes)
        return refused("is longer than 8 kB");
    for (const char c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            return refused("has a control character in it");
    return {};
}

bool isSlash(char c) {
    return c == '/' || c == '\\';
}

// What follows "scheme:".
Result<Url> parseAfterScheme(std::string scheme, std::string_view rest) {
    Url url;
    url.scheme = std::move(scheme);
    if (rest.size() < 2 || !isSlash(rest[0]) || !isSlash(rest[1]))
        return refused("has no // after its scheme");
    rest.remove_prefix(2);
    const std::size_t end = std::min(rest.find_first_of("/\\?#"), rest.size());
    if (Failure wrong = readAuthority(rest.substr(0, end), url))
        return *wrong;
    readPathAndQuery(rest.substr(end), url);
    return url;
}

bool looksSecret(const std::string& key) {
    constexpr std::array kWords = {"key",  "token", "sig",     "secret", "auth",
                                   "pass", "pwd",   "session", "cred",   "jwt"};
    const std::string name = lower(key);
    return std::any_of(kWords.begin(), kWords.end(),
                       [&](const char* word) { return name.find(word) != std::string::npos; });
}

} // namespace

std::string Url::text() const {
    return scheme + "://" + host + (isDefaultPort() ? "" : ":" + std::to_string(port)) + path +
           (hasQuery ? "?" + query : "");
}

Result<Url> parseUrl(std::string_view text) {
    if (Failure wrong = checkText(text))
        return *wrong;
    const std::size_t length = schemeLength(text);
    const std::string scheme = lower(text.substr(0, length == 0 ? 0 : length - 1));
    if (std::find(std::begin(kScheme), std::end(kScheme), scheme) == std::end(kScheme))
        return refused("begins neither with http: nor with https:");
    return parseAfterScheme(scheme, text.substr(length));
}

Result<Url> resolveUrl(const Url& base, std::string_view reference) {
    if (Failure wrong = checkText(reference))
        return *wrong;
    while (!reference.empty() && reference.front() == ' ')
        reference.remove_prefix(1);
    while (!reference.empty() && reference.back() == ' ')
        reference.remove_suffix(1);
    if (reference.empty() || reference.front() == '#')
        return refused("refers to the file it stands in");
    Result<Url> url = base;
    if (const std::size_t length = schemeLength(reference)) {
        const std::string scheme = lower(reference.substr(0, length - 1));
        if (std::find(std::begin(kScheme), std::end(kScheme), scheme) == std::end(kScheme))
            return Error{"", "has the scheme " + scheme + ", which is not allowed here",
                         ErrorKind::Input};
        url = parseAfterScheme(scheme, reference.substr(length));
    } else if (reference.size() >= 2 && isSlash(reference[0]) && isSlash(reference[1])) {
        url = parseAfterScheme(base.scheme, reference);
    } else if (isSlash(reference[0])) {
        readPathAndQuery(reference, *url);
    } else if (reference[0] == '?') {
        readPathAndQuery(base.path + std::string(reference), *url);
    } else {
        readPathAndQuery(base.path.substr(0, base.path.rfind('/') + 1) + std::string(reference),
                         *url);
    }
    if (!url)
        return url;
    if (url->host != base.host || url->scheme != base.scheme || url->port != base.port) {
        if (!url->user.empty())
            return refused("has a user's name in it");
        if (base.scheme == "https" && url->scheme == "http")
            return refused("leads from https back to http");
    }
    url->user.clear();
    return url;
}

bool sameServer(const Url& a, const Url& b) {
    return a.scheme == b.scheme && a.host == b.host && a.port == b.port;
}

bool mayCarrySecrets(const Url& named, const Url& asked) {
    return sameServer(named, asked) ||
           (named.host == asked.host && named.scheme == "http" && asked.scheme == "https" &&
            named.isDefaultPort() && asked.isDefaultPort());
}

std::string bareHost(std::string_view host) {
    if (host.size() > 2 && host.front() == '[' && host.back() == ']')
        host = host.substr(1, host.size() - 2);
    if (!host.empty() && host.back() == '.')
        host.remove_suffix(1);
    return lower(host);
}

std::vector<QueryField> queryFields(const Url& url) {
    std::vector<QueryField> fields;
    std::string_view rest = url.query;
    while (!rest.empty()) {
        const std::size_t end = rest.find('&');
        const std::string_view field = rest.substr(0, end);
        const std::size_t equals = field.find('=');
        if (!field.empty())
            fields.emplace_back(field.substr(0, equals), equals == std::string_view::npos
                                                             ? std::string_view{}
                                                             : field.substr(equals));
        rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    }
    return fields;
}

void addQueryFields(Url& url, const std::vector<QueryField>& fields) {
    const std::vector<QueryField> there = queryFields(url);
    for (const auto& [key, value] : fields) {
        if (std::any_of(there.begin(), there.end(),
                        [&name = key](const QueryField& field) { return field.first == name; }))
            continue;
        url.query += (url.query.empty() ? "" : "&") + key + value;
        url.hasQuery = true;
    }
}

std::string withoutSecrets(std::string_view uri, const std::vector<std::string>& secretKeys) {
    std::string out(uri.substr(0, uri.find('?')));
    // A user's name and password before the host.
    if (const std::size_t from = out.find("//"); from != std::string::npos) {
        const std::size_t end = std::min(out.find('/', from + 2), out.size());
        if (const std::size_t at = out.rfind('@', end);
            at != std::string::npos && at > from && at < end)
            out.erase(from + 2, at - from - 1);
    }
    if (out.size() >= uri.size() || uri.find('?') == std::string_view::npos)
        return out;
    std::string_view rest = uri.substr(uri.find('?') + 1);
    for (char before = '?';; before = '&') {
        const std::size_t end = rest.find('&');
        const std::string_view field = rest.substr(0, end);
        const std::string key(field.substr(0, field.find('=')));
        const bool secret = looksSecret(key) || std::find(secretKeys.begin(), secretKeys.end(),
                                                          key) != secretKeys.end();
        out += before;
        out += secret && key.size() < field.size() ? key + "=..." : std::string(field);
        if (end == std::string_view::npos)
            return out;
        rest.remove_prefix(end + 1);
    }
}

std::string textWithoutSecrets(std::string_view text) {
    std::string out;
    for (;;) {
        // The scheme's end is what all addresses have in common, in any letter case.
        const std::size_t mark = text.find("://");
        if (mark == std::string_view::npos)
            return out.append(text);
        const std::size_t end = std::min(text.find_first_of(" \t\n\"'<>()", mark), text.size());
        out.append(text.substr(0, mark));
        out += withoutSecrets(text.substr(mark, end - mark));
        text.remove_prefix(end);
    }
}

bool isWebAddress(const std::string& uri) {
    const std::string start = lower(std::string_view(uri).substr(0, 8));
    return start.starts_with("http://") || start.starts_with("https://");
}

} // namespace gnomon
