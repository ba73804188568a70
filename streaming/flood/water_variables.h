// What the variables of a water model are, by what they say of themselves: their part in the water
// by their names, and the coordinate reference system in their attributes.
#pragma once

#include "streaming/flood/unstructured_arrays.h"

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace gnomon {

enum class WaterRole { Stage, Depth, Bed, VelocityX, VelocityY, None };

struct NamedRole {
    const char* name;
    WaterRole role;
};

// The standard names of the CF conventions, and those that models write in their place; in order,
// the surest first.
std::span<const NamedRole> standardNames();

// Null when none of them is called so.
const NamedRole* findName(std::span<const NamedRole> names, std::string_view name);

inline constexpr std::array kEpsgAttributes = {"EPSG_code", "epsg_code", "EPSG", "epsg"};
// None without that attribute; 0: there is no system in it.
std::optional<long> epsgIn(const ArrayVariable& variable, const char* attribute);
// Well-known text of a system.
std::optional<std::string> systemTextIn(const ArrayVariable& variable);

} // namespace gnomon
