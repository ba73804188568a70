#include "tests/faults/http_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <sstream>

namespace gnomon::test {

namespace {

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(" \t");
    const auto last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::optional<std::uint64_t> numberIn(const std::string& text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

} // namespace

bool sameName(const std::string& a, const std::string& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
        return std::tolower(x) == std::tolower(y);
    });
}

std::string Request::header(const std::string& name) const {
    for (const auto& [key, value] : headers)
        if (sameName(key, name))
            return value;
    return {};
}

bool Request::accepts(const std::string& encoding) const {
    std::istringstream list(header("Accept-Encoding"));
    for (std::string item; std::getline(list, item, ',');) {
        const auto semicolon = item.find(';');
        if (sameName(trimmed(item.substr(0, semicolon)), encoding))
            return semicolon == std::string::npos || item.find("q=0", semicolon) == item.npos ||
                   item.find("q=0.", semicolon) != item.npos;
    }
    return false;
}

bool Request::keepsAlive() const {
    const std::string connection = header("Connection");
    if (version == "HTTP/1.0")
        return sameName(connection, "keep-alive");
    return !sameName(connection, "close");
}

std::optional<Request> takeRequest(std::string& bytes) {
    const auto end = bytes.find("\r\n\r\n");
    if (end == std::string::npos)
        return std::nullopt;
    std::istringstream head(bytes.substr(0, end));
    bytes.erase(0, end + 4);
    Request request;
    head >> request.method >> request.target >> request.version;
    if (!request.version.starts_with("HTTP/1."))
        return Request{};
    std::string line;
    std::getline(head, line);
    while (std::getline(head, line)) {
        if (line.ends_with('\r'))
            line.pop_back();
        const auto colon = line.find(':');
        if (colon != std::string::npos)
            request.headers.emplace_back(line.substr(0, colon), trimmed(line.substr(colon + 1)));
    }
    return request;
}

RangeAsked rangeOf(const std::string& header, std::uint64_t size) {
    const std::string unit = "bytes=";
    const auto dash = header.find('-');
    if (!header.starts_with(unit) || dash == std::string::npos ||
        header.find(',') != std::string::npos)
        return {};
    const auto first = numberIn(header.substr(unit.size(), dash - unit.size()));
    const auto last = numberIn(header.substr(dash + 1));
    if (!first && !last)
        return {};
    if (!first) // the last so many bytes
        return {true, *last == 0 || size == 0
                          ? std::nullopt
                          : std::optional(ByteRange{size - std::min(*last, size), size - 1})};
    if (*first >= size || (last && *last < *first))
        return {true, std::nullopt};
    return {true, ByteRange{*first, std::min(last.value_or(size - 1), size - 1)}};
}

std::optional<std::string> pathOf(const std::string& target) {
    const std::string coded = target.substr(0, target.find_first_of("?#"));
    std::string path;
    for (std::size_t i = 0; i < coded.size(); ++i) {
        if (coded[i] != '%') {
            path += coded[i];
            continue;
        }
        unsigned value = 0;
        const char* digits = coded.data() + i + 1;
        if (i + 2 >= coded.size() ||
            std::from_chars(digits, digits + 2, value, 16).ptr != digits + 2)
            return std::nullopt;
        path += char(value);
        i += 2;
    }
    if (!path.starts_with('/') || path.find('\0') != std::string::npos)
        return std::nullopt;
    std::istringstream parts(path);
    for (std::string part; std::getline(parts, part, '/');)
        if (part == "..")
            return std::nullopt;
    return path.substr(1);
}

} // namespace gnomon::test
