// Attributes found by the names that people usually give them, however spelt: "Höhe (m)", hoehe_m
// and HOEHE are one.
#pragma once

#include "streaming/features/features.h"

#include <span>
#include <string>
#include <string_view>

namespace gnomon {

// Lower-case letters and digits only, umlauts written out.
std::string plainText(std::string_view text);

using AttributeNames = std::span<const std::string_view>; // plain, the best first

// The first of `names` that the feature has with a value, also where a unit follows the name
// ("hoehe_m") or a Shapefile cut it at ten characters ("kronendurc").
struct FoundAttribute {
    std::string_view name; // as the file spells it
    const AttributeValue* value = nullptr;
    explicit operator bool() const { return value != nullptr; }
};
FoundAttribute findAttribute(const Feature& feature, AttributeNames names);

// 12.5, "12.5", "12,5 m", "40 ft", "6-9 m" (its middle); none for anything else.
std::optional<double> metresIn(const AttributeValue& value);
// As a message shows it.
std::string textOf(const AttributeValue& value);

} // namespace gnomon
