// The bytes of one tile of a quantized mesh (quantized-mesh-1.0), decoded and checked: every count,
// index and length is taken for a lie until it was held against the bytes that are there.
#pragma once

#include "geo/result.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

// Of u, v and height in a tile: the eastern or northern side, the highest place.
inline constexpr int kQuantizedMost = 32767;

// Tiles there are in one level, borders included.
struct TileRange {
    std::uint32_t startX = 0, startY = 0, endX = 0, endY = 0;
};
using TileRanges = std::vector<TileRange>;

// The header by itself is enough for a tile's volume.
struct QuantizedHeader {
    glm::dvec3 centre{0.0}; // ECEF
    double minHeightMetres = 0, maxHeightMetres = 0;
    glm::dvec3 sphereCentre{0.0}; // ECEF
    double sphereRadiusMetres = 0;
};

struct QuantizedTile {
    QuantizedHeader header;
    std::vector<std::uint16_t> u, v, height;          // 0…kQuantizedMost
    std::vector<std::uint32_t> indices;               // counter-clockwise seen from above
    std::vector<std::array<std::uint8_t, 2>> normals; // octahedral, ECEF; empty: none
    std::size_t edgeVertices = 0;                     // said to lie on its four sides
    std::size_t waterMaskBytes = 0;                   // not looked at
    // What it tells about the levels below its own, the next one first.
    std::optional<std::vector<TileRanges>> availableBelow;
    std::optional<double> geometricErrorMetres;
    std::vector<std::string> extensions; // as they are called
    std::vector<std::string> warnings;

    double heightMetres(double quantized) const {
        return header.minHeightMetres +
               (header.maxHeightMetres - header.minHeightMetres) * (quantized / kQuantizedMost);
    }
};

// As in the file, perhaps compressed with gzip. `name` is for messages only.
Result<QuantizedTile> decodeQuantizedTile(std::span<const std::byte> bytes,
                                          const std::string& name);
// All but the triangles: header, and what the metadata extension says.
struct QuantizedSummary {
    QuantizedHeader header;
    std::optional<std::vector<TileRanges>> availableBelow;
    std::optional<double> geometricErrorMetres;
};
Result<QuantizedSummary> readQuantizedSummary(std::span<const std::byte> bytes,
                                              const std::string& name);

} // namespace gnomon
