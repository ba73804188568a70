// The layer.json of a quantized mesh: how its tiles are named, which there are, and whose they are.
// Private to quantized_mesh*.cpp and layer_json.cpp, since it shows the JSON library.
#pragma once

#include "streaming/terrain/quantized_mesh_tile.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <vector>

namespace gnomon {

struct LayerJson {
    bool webMercator = false;           // EPSG:3857, one tile at level 0; else EPSG:4326, two
    bool rowsFromNorth = false;         // "xyz"; else "tms"
    std::vector<std::string> templates; // with {z}, {x}, {y}, {version}
    std::string version = "1.0.0";
    bool saysAvailable = false;
    std::vector<TileRanges> available; // by level; rows from the south, whatever the scheme
    // Levels from one tile that tells what lies below it to the next; 0: none does.
    unsigned metadataLevels = 0;
    std::string parentUrl;   // empty: none
    std::string attribution; // without markup
    std::vector<std::string> extensions;
    std::vector<std::string> warnings;

    // The uri of a tile, relative to the layer.json. `y` counts from the south.
    std::string uriOf(unsigned level, std::uint32_t x, std::uint32_t y) const;
};

// Rows in one level.
std::uint64_t rowsOf(unsigned level);
std::uint64_t columnsOf(unsigned level, bool webMercator);

Result<LayerJson> parseLayerJson(std::span<const std::byte> bytes, const std::string& name);

// Checked for its depth and size; throws BadContent. No object where it is no JSON.
nlohmann::json parsedJson(std::span<const std::byte> text);
// "available" of a layer.json or a tile's metadata; what is no range is left out and counted.
std::vector<TileRanges> tileRanges(const nlohmann::json& levels, std::size_t& wrong);

} // namespace gnomon
