// Addresses on the web, by RFC 3986 as browsers read it: taken apart once, checked, and put
// together again, so that nobody after us can read the same text in another way.
#pragma once

#include "geo/result.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gnomon {

struct Url {
    std::string scheme; // http or https
    std::string user;   // "name:password" as written; never a part of text()
    std::string host;   // lower case; a v6 address in its brackets
    std::uint16_t port = 0;
    std::string path; // begins with a slash; without dot segments
    std::string query;
    bool hasQuery = false;

    std::string text() const; // as it is asked for
    bool isDefaultPort() const { return port == (scheme == "https" ? 443 : 80); }
};

// The error's reason reads on after the address: "has no host".
Result<Url> parseUrl(std::string_view text);
// What `reference`, found in a document that came from `base`, means. Refuses other schemes, a way
// back from https to http, and a user's name in it.
Result<Url> resolveUrl(const Url& base, std::string_view reference);

bool sameServer(const Url& a, const Url& b); // scheme, host and port
// What was meant for `named` may go to `asked`: the same server, or the same host's usual https
// where its usual http was named.
bool mayCarrySecrets(const Url& named, const Url& asked);
// Lower case, without the root's dot and a v6 address's brackets: to compare with.
std::string bareHost(std::string_view host);

using QueryField = std::pair<std::string, std::string>; // as written
std::vector<QueryField> queryFields(const Url& url);
// Adds those that `url` has not.
void addQueryFields(Url& url, const std::vector<QueryField>& fields);

// For messages: values that may be secrets are dots; those of `secretKeys` and of keys that look
// like it. Of any text that has a query in it.
std::string withoutSecrets(std::string_view uri, const std::vector<std::string>& secretKeys = {});
// The same for every address that stands somewhere in a text.
std::string textWithoutSecrets(std::string_view text);

} // namespace gnomon
