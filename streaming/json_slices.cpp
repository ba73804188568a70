#include "streaming/json_slices.h"

#include <algorithm>

namespace gnomon {

namespace {

constexpr std::string_view kSpace = " \t\r\n";

std::size_t skipSpace(std::string_view text, std::size_t at) {
    return std::min(text.find_first_not_of(kSpace, at), text.size());
}

// Behind the string that begins at `at`.
std::size_t endOfString(std::string_view text, std::size_t at) {
    for (std::size_t i = at + 1; i < text.size(); ++i) {
        if (text[i] == '\\') {
            ++i;
        } else if (text[i] == '"') {
            return i + 1;
        }
    }
    return text.size();
}

std::size_t endOfValue(std::string_view text, std::size_t at) {
    std::size_t depth = 0;
    for (std::size_t i = at; i < text.size();) {
        const char c = text[i];
        if (c == '"') {
            i = endOfString(text, i);
        } else if (c == '{' || c == '[') {
            ++depth;
            ++i;
            continue;
        } else if (c == '}' || c == ']') {
            if (depth == 0) {
                return i;
            }
            --depth;
            ++i;
        } else if (depth > 0) {
            ++i;
            continue;
        } else {
            i = std::min(text.find_first_of(" \t\r\n,]}:", i + 1), text.size());
        }
        if (depth == 0) {
            return i;
        }
    }
    return text.size();
}

// Calls `take` with where each part of an object or array begins; `take` returns where it ends.
template <class Take>
void eachPart(std::string_view text, char open, const Take& take) {
    std::size_t at = skipSpace(text, 0);
    if (at == text.size() || text[at] != open) {
        return;
    }
    at = skipSpace(text, at + 1);
    while (at < text.size() && text[at] != '}' && text[at] != ']') {
        const std::size_t end = take(at);
        at = skipSpace(text, std::max(end, at + 1));
        if (at < text.size() && text[at] == ',') {
            at = skipSpace(text, at + 1);
        }
    }
}

} // namespace

std::string_view jsonValueAt(std::string_view text, std::size_t at) {
    if (at >= text.size()) {
        return {};
    }
    return text.substr(at, endOfValue(text, at) - at);
}

void eachJsonMember(std::string_view object, const std::function<void(const JsonMember&)>& take) {
    eachPart(object, '{', [&](std::size_t at) {
        const std::size_t keyEnd = endOfString(object, at);
        const std::size_t colon = skipSpace(object, keyEnd);
        const std::size_t begin = skipSpace(object, std::min(colon + 1, object.size()));
        const std::string_view value = jsonValueAt(object, begin);
        if (keyEnd >= at + 2) {
            take({object.substr(at + 1, keyEnd - at - 2), value});
        }
        return begin + value.size();
    });
}

void eachJsonElement(std::string_view array, const std::function<void(std::string_view)>& take) {
    eachPart(array, '[', [&](std::size_t at) {
        const std::string_view value = jsonValueAt(array, at);
        take(value);
        return at + value.size();
    });
}

std::vector<JsonMember> jsonMembers(std::string_view object) {
    std::vector<JsonMember> out;
    eachJsonMember(object, [&](const JsonMember& member) { out.push_back(member); });
    return out;
}

std::vector<std::string_view> jsonElements(std::string_view array) {
    std::vector<std::string_view> out;
    eachJsonElement(array, [&](std::string_view value) { out.push_back(value); });
    return out;
}

std::string_view jsonMember(std::string_view object, std::string_view key) {
    std::string_view found;
    eachJsonMember(object, [&](const JsonMember& member) {
        if (member.key == key) {
            found = member.value;
        }
    });
    return found;
}

} // namespace gnomon
