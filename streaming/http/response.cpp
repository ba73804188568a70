#include "streaming/http/response.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace gnomon {
namespace {

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
}

struct Status {
    int code;
    const char* words;
};
// Our words, not the server's: it may say anything.
constexpr std::array kStatuses = {
    Status{400, "Bad Request"},     Status{401, "Unauthorized"},
    Status{403, "Forbidden"},       Status{404, "Not Found"},
    Status{405, "Not Allowed"},     Status{407, "Proxy Authentication Required"},
    Status{408, "Request Timeout"}, Status{410, "Gone"},
    Status{414, "URI Too Long"},    Status{429, "Too Many Requests"},
    Status{500, "Server Error"},    Status{501, "Not Implemented"},
    Status{502, "Bad Gateway"},     Status{503, "Service Unavailable"},
    Status{504, "Gateway Timeout"},
};

} // namespace

bool equalNoCase(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
    const auto from = text.find_first_not_of(" \t\r\n");
    if (from == std::string_view::npos)
        return {};
    return text.substr(from, text.find_last_not_of(" \t\r\n") - from + 1);
}

void ResponseHead::addLine(std::string_view line) {
    bytes_ += line.size();
    if (line.starts_with("HTTP/")) {
        fields_.clear();
        status = 0;
        if (const auto space = line.find(' '); space != std::string_view::npos)
            std::from_chars(line.data() + space + 1, line.data() + line.size(), status);
        return;
    }
    const auto colon = line.find(':');
    if (colon == std::string_view::npos)
        return;
    // RFC 9110, 5.5: no control characters but tabs. Some fields go back to the server in a request
    // of ours (ETag), where a line break would be a field of its making.
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (std::any_of(value.begin(), value.end(), [](char c) {
            return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f;
        }))
        return;
    std::string name(trimmed(line.substr(0, colon)));
    std::transform(name.begin(), name.end(), name.begin(), lower);
    fields_.emplace_back(std::move(name), value);
}

std::string ResponseHead::get(std::string_view name) const {
    std::string out;
    for (const auto& [key, value] : fields_)
        if (equalNoCase(key, name))
            out += (out.empty() ? "" : ", ") + value;
    return out;
}

std::string ResponseHead::statusInWords() const {
    for (const Status& known : kStatuses)
        if (known.code == status)
            return std::to_string(status) + " " + known.words;
    return std::to_string(status);
}

} // namespace gnomon
