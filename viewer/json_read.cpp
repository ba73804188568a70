#include "viewer/json_read.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>

namespace gnomon {

namespace {

// The library's messages carry an id in brackets and line breaks; only the plain words are wanted.
std::string plainWords(const char* what) {
    std::string text = what;
    if (const auto end = text.find("] "); end != std::string::npos)
        text.erase(0, end + 2);
    std::replace(text.begin(), text.end(), '\n', ' ');
    constexpr std::size_t kLongest = 200;
    if (text.size() > kLongest)
        text.resize(kLongest);
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = ' ';
    return text;
}

std::string inWords(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

} // namespace

Result<nlohmann::json> parseJson(const std::string& text, const std::string& name) {
    try {
        return nlohmann::json::parse(text);
    } catch (const std::exception& e) {
        return Error{name, "not valid JSON: " + plainWords(e.what())};
    }
}

FieldReader::FieldReader(const nlohmann::json& object, std::string file, std::string where)
    : object_(object), file_(std::move(file)), where_(std::move(where)) {
    if (!object_.is_object())
        fail("must be an object");
}

bool FieldReader::has(const char* key) const {
    return object_.is_object() && object_.contains(key);
}

void FieldReader::fail(const std::string& reason) {
    if (!failure_)
        failure_ = Error{file_, where_.empty() ? reason : where_ + ": " + reason};
}

double FieldReader::number(const char* key, double min, double max) {
    if (!has(key)) {
        fail(std::string("\"") + key + "\" is missing");
        return std::clamp(0.0, min, max);
    }
    return numberOr(key, 0.0, min, max);
}

double FieldReader::numberOr(const char* key, double fallback, double min, double max) {
    return optionalNumber(key, min, max).value_or(fallback);
}

std::optional<double> FieldReader::optionalNumber(const char* key, double min, double max) {
    if (!has(key))
        return std::nullopt;
    const auto& field = object_.at(key);
    if (!field.is_number()) {
        fail(std::string("\"") + key + "\" must be a number");
        return std::nullopt;
    }
    const double value = field.get<double>();
    if (!(value >= min && value <= max)) {
        fail(std::string("\"") + key + "\" is " + inWords(value) + ", must be " + inWords(min) +
             " to " + inWords(max));
        return std::nullopt;
    }
    return value;
}

std::optional<std::string> FieldReader::optionalText(const char* key) {
    if (!has(key))
        return std::nullopt;
    const auto& field = object_.at(key);
    if (!field.is_string()) {
        fail(std::string("\"") + key + "\" must be text");
        return std::nullopt;
    }
    return field.get<std::string>();
}

std::vector<std::string> FieldReader::others(std::initializer_list<const char*> known) const {
    std::vector<std::string> found;
    if (!object_.is_object())
        return found;
    for (const auto& [key, value] : object_.items()) {
        const auto same = [&k = key](const char* name) { return k == name; };
        if (std::none_of(known.begin(), known.end(), same))
            found.push_back(key);
    }
    return found;
}

void FieldReader::refuseOthers(std::initializer_list<const char*> known) {
    for (const std::string& key : others(known))
        fail("\"" + key + "\" is not known here");
}

} // namespace gnomon
