#include "streaming/features/attribute_lookup.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace gnomon {

namespace {

// The names of a Shapefile's columns end here.
constexpr std::size_t kShapefileName = 10;

// UTF-8's second byte behind 0xc3: Latin letters with marks, as they are written without.
std::string_view unmarked(unsigned char second) {
    switch (second | 0x20u) { // capitals and small letters differ in that bit
    case 0xa4:
        return "ae";
    case 0xb6:
        return "oe";
    case 0xbc:
        return "ue";
    case 0xa0:
    case 0xa1:
    case 0xa2:
        return "a";
    case 0xa8:
    case 0xa9:
    case 0xaa:
    case 0xab:
        return "e";
    case 0xb1:
        return "n";
    default:
        return second == 0x9f ? "ss" : "";
    }
}

bool isNamed(std::string_view plain, std::size_t rawLength, std::string_view name) {
    if (plain == name)
        return true;
    if (plain.starts_with(name)) {
        const std::string_view unit = plain.substr(name.size());
        return unit == "m" || unit == "inm" || unit == "meter" || unit == "metres" ||
               unit == "metre" || unit == "meters";
    }
    // Eight, for marks such as '_' do not count in `plain`.
    return rawLength == kShapefileName && plain.size() >= 8 && name.starts_with(plain);
}

bool isBlank(const AttributeValue& value) {
    const std::string* text = std::get_if<std::string>(&value);
    return std::holds_alternative<std::monostate>(value) ||
           (text && text->find_first_not_of(" \t") == std::string::npos);
}

// Takes a number, with a comma or a point, from the front of `text`.
std::optional<double> takeNumber(std::string& text) {
    text.erase(0, text.find_first_not_of(" \t"));
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || !std::isfinite(value))
        return std::nullopt;
    text.erase(0, std::size_t(end - text.data()));
    return value;
}

std::optional<double> metresInText(std::string text) {
    std::replace(text.begin(), text.end(), ',', '.');
    if (const auto dash = text.find("\xe2\x80\x93"); dash != std::string::npos) // en dash
        text.replace(dash, 3, "-");
    std::optional<double> value = takeNumber(text);
    if (!value)
        return std::nullopt;
    text.erase(0, text.find_first_not_of(" \t"));
    if (text.starts_with('-')) {
        text.erase(0, 1);
        const std::optional<double> to = takeNumber(text);
        if (!to)
            return std::nullopt;
        value = (*value + *to) / 2.0;
    }
    const std::string unit = plainText(text);
    constexpr double kMetresPerFoot = 0.3048;
    if (unit == "ft" || unit == "feet" || text.find_first_not_of(" '") == std::string::npos)
        return text.find_first_not_of(' ') == std::string::npos ? *value : *value * kMetresPerFoot;
    if (unit == "m" || unit == "metres" || unit == "meters" || unit == "meter" || unit == "metre")
        return value;
    if (unit == "cm")
        return *value / 100.0;
    return std::nullopt;
}

} // namespace

std::string plainText(std::string_view text) {
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const unsigned char c = static_cast<unsigned char>(text[i]);
        if (c >= 'A' && c <= 'Z')
            plain += char(c - 'A' + 'a');
        else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'))
            plain += char(c);
        else if (c == 0xc3 && i + 1 < text.size())
            plain += unmarked(static_cast<unsigned char>(text[++i]));
    }
    return plain;
}

FoundAttribute findAttribute(const Feature& feature, AttributeNames names) {
    FoundAttribute best;
    std::size_t bestRank = names.size();
    for (const auto& [name, value] : feature.attributes) {
        if (isBlank(value))
            continue;
        const std::string plain = plainText(name);
        for (std::size_t rank = 0; rank < bestRank; ++rank)
            if (isNamed(plain, name.size(), names[rank])) {
                best = {name, &value};
                bestRank = rank;
            }
    }
    return best;
}

std::optional<double> metresIn(const AttributeValue& value) {
    if (const double* number = std::get_if<double>(&value))
        return std::isfinite(*number) ? std::optional(*number) : std::nullopt;
    if (const std::string* text = std::get_if<std::string>(&value))
        return metresInText(*text);
    return std::nullopt;
}

std::string textOf(const AttributeValue& value) {
    if (const std::string* text = std::get_if<std::string>(&value))
        return *text;
    if (const bool* truth = std::get_if<bool>(&value))
        return *truth ? "true" : "false";
    if (const double* number = std::get_if<double>(&value)) {
        std::array<char, 32> digits;
        const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), *number);
        return std::string(digits.data(), end.ptr);
    }
    return {};
}

} // namespace gnomon
