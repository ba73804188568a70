#include "streaming/json_text.h"

#include <nlohmann/json.hpp>

#include <charconv>

namespace gnomon {
namespace {

bool isWordChar(char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '+' ||
           c == '-' || c == '.';
}

bool isFiniteWord(std::string_view word) {
    if (word == "true" || word == "false" || word == "null")
        return true;
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    // from_chars reads "nan" and "inf"; JSON numbers begin with a digit or a minus and a digit.
    const std::size_t digit = word.front() == '-' ? 1 : 0;
    const bool isNumber = digit < word.size() && word[digit] >= '0' && word[digit] <= '9';
    if (error == std::errc::result_out_of_range)
        return false;
    // What is neither is left for the parser to name.
    return isNumber || !(word == "NaN" || word == "-NaN" || word == "Infinity" ||
                         word == "-Infinity" || word == "nan" || word == "inf" || word == "-inf");
}

} // namespace

std::string_view asText(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string withoutNonFinite(std::string_view json) {
    std::string out;
    out.reserve(json.size());
    for (std::size_t i = 0; i < json.size();) {
        if (json[i] == '"') {
            std::size_t end = i + 1;
            while (end < json.size() && json[end] != '"')
                end += json[end] == '\\' ? 2 : 1;
            end = end < json.size() ? end + 1 : json.size();
            out.append(json, i, end - i);
            i = end;
        } else if (isWordChar(json[i])) {
            std::size_t end = i;
            while (end < json.size() && isWordChar(json[end]))
                ++end;
            const std::string_view word = json.substr(i, end - i);
            out += isFiniteWord(word) ? word : std::string_view("null");
            i = end;
        } else {
            out.push_back(json[i++]);
        }
    }
    return out;
}

namespace {

// Collects the outermost keys; everything below is skipped.
struct OuterKeys : nlohmann::json_sax<nlohmann::json> {
    int depth = 0;
    bool isObject = false, root = false, gltf = false;

    bool null() override { return depth > 0; }
    bool boolean(bool) override { return depth > 0; }
    bool number_integer(number_integer_t) override { return depth > 0; }
    bool number_unsigned(number_unsigned_t) override { return depth > 0; }
    bool number_float(number_float_t, const string_t&) override { return depth > 0; }
    bool string(string_t&) override { return depth > 0; }
    bool binary(binary_t&) override { return depth > 0; }
    bool start_object(std::size_t) override {
        isObject = isObject || depth == 0;
        return ++depth > 0;
    }
    bool key(string_t& name) override {
        if (depth != 1)
            return true;
        root = root || name == "root";
        gltf = gltf || name == "meshes" || name == "buffers" || name == "nodes" || name == "scenes";
        return !root;
    }
    bool end_object() override { return --depth >= 0; }
    bool start_array(std::size_t) override { return depth++ > 0; }
    bool end_array() override { return --depth >= 0; }
    bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception&) override {
        return false;
    }
};

} // namespace

JsonKind sniffJson(std::span<const std::byte> bytes) {
    std::string_view text = asText(bytes);
    if (text.substr(0, 3) == "\xef\xbb\xbf")
        text.remove_prefix(3);
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos || text[first] != '{')
        return JsonKind::NotJson;
    OuterKeys keys;
    nlohmann::json::sax_parse(text, &keys);
    if (keys.root)
        return JsonKind::Tileset;
    return keys.gltf ? JsonKind::Gltf : JsonKind::Other;
}

} // namespace gnomon
