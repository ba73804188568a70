// The little of HTTP/1.1 that a server of files needs: a request's head, one byte range.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon::test {

struct Request {
    std::string method, target, version;
    std::vector<std::pair<std::string, std::string>> headers;

    // Of any letter case; the first one, empty when there is none.
    std::string header(const std::string& name) const;
    bool accepts(const std::string& encoding) const; // "gzip" in Accept-Encoding, not with q=0
    bool keepsAlive() const;
};

// Takes the first whole head off the front of `bytes`; nothing while it is not all there. A head
// that is none has an empty method.
std::optional<Request> takeRequest(std::string& bytes);

struct ByteRange {
    std::uint64_t first = 0, last = 0;
};
struct RangeAsked {
    bool any = false;               // one range, in bytes
    std::optional<ByteRange> range; // none: it lies outside the file
};
RangeAsked rangeOf(const std::string& header, std::uint64_t size);

// Path within the folder: percent-decoded, without query; none when it would leave it.
std::optional<std::string> pathOf(const std::string& target);

bool sameName(const std::string& a, const std::string& b); // of headers: any letter case

} // namespace gnomon::test
