// Single values of a tileset.json, checked. For tileset_json.cpp and tileset_values.cpp only, since
// it shows the JSON library.
#pragma once

#include "streaming/tileset.h"

#include <nlohmann/json.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace gnomon::tilesetjson {

using nlohmann::json;

// The Moon is 4e8 m away; what is written larger than this is no place but a mistake.
constexpr double kMaxCoordinateMetres = 1e12;

// Null when `object` is none or lacks it.
const json* member(const json& object, const char* key);
const json* extension(const json& object, const char* key);

std::optional<double> finiteNumber(const json* value);
std::optional<std::int64_t> integer(const json* value); // 3.0 is one too
template <std::size_t N>
std::optional<std::array<double, N>> finiteNumbers(const json& value) {
    if (!value.is_array() || value.size() != N)
        return std::nullopt;
    std::array<double, N> out{};
    for (std::size_t i = 0; i < N; ++i) {
        const auto number = finiteNumber(&value[i]);
        if (!number)
            return std::nullopt;
        out[i] = *number;
    }
    return out;
}

std::vector<std::string> strings(const json* value);

std::string lowered(std::string text);
// One line of at most 200 characters, for messages.
std::string shown(std::string text);

double largestScale(const glm::dmat4& m);
// Why the matrix cannot place a tile; null when it can.
const char* flawOf(const glm::dmat4& m);
// By the ending; Unknown when it tells nothing.
ContentKind kindByName(const std::string& path);
// In ECEF. The error has the reason only.
Result<BoundingVolume> readVolume(const json* value, const Transform<Ecef, Tile>& ecefFromTile);

// Everything but the root: what the file is, and whether it can be read. `path` is for messages.
Failure readHead(const json& document, const std::string& path, TilesetFacts& facts);
// After readHead().
UpAxis upAxisOf(const json& document, UpAxis inherited);

} // namespace gnomon::tilesetjson
