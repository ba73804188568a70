// Where the parts of a JSON text are, without building any of it: a table of a million values
// costs its text and four bytes a value. The text must be known to be well formed; of one that is
// not, parts may be wrong, but never outside it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

struct JsonMember {
    std::string_view key; // as written, between its quotes
    std::string_view value;
};
// Nothing in what is no object, or no array. One after another, so that many take no memory.
void eachJsonMember(std::string_view object, const std::function<void(const JsonMember&)>& take);
void eachJsonElement(std::string_view array, const std::function<void(std::string_view)>& take);
std::vector<JsonMember> jsonMembers(std::string_view object);
std::vector<std::string_view> jsonElements(std::string_view array);

// By a key without escapes; of several the last, as parsers have it. Empty when there is none.
std::string_view jsonMember(std::string_view object, std::string_view key);

// The value that begins at `at`.
std::string_view jsonValueAt(std::string_view text, std::size_t at);

} // namespace gnomon
