// From a decoded tile of a quantized mesh to its surface on the Earth, whole or cut to a part of
// it. Private to quantized_mesh*.cpp.
#pragma once

#include "streaming/terrain/quantized_mesh_tile.h"
#include "streaming/terrain/terrain_surface.h"

#include <glm/vec2.hpp>

#include <array>
#include <optional>
#include <vector>

namespace gnomon {

// A tile's place in its tree; y counts from the south.
struct QuantizedPlace {
    unsigned level = 0;
    std::uint32_t x = 0, y = 0;

    bool operator==(const QuantizedPlace&) const = default;
    QuantizedPlace parent() const { return {level - 1, x / 2, y / 2}; }
    QuantizedPlace child(unsigned i) const {
        return {level + 1, 2 * x + (i & 1), 2 * y + (i >> 1)};
    }
};
inline constexpr unsigned kDeepestLevel = 30;

// West, south, east, north in degrees.
std::array<double, 4> extentOf(const QuantizedPlace& place, bool webMercator);
// Across its middle and down.
glm::dvec2 metresOf(const std::array<double, 4>& extent);

// Part of a tile, in its own quantized units.
struct QuantizedWindow {
    double west = 0, south = 0, east = kQuantizedMost, north = kQuantizedMost;
};

struct QuantizedPart {
    QuantizedWindow window;
    std::vector<glm::dvec2> places; // u, v
    std::vector<double> heights;    // metres, as the tile has them
    std::vector<glm::vec3> normals; // ECEF; empty: none
    std::vector<std::uint32_t> indices;
};

QuantizedPart wholeOf(QuantizedTile tile);
// Cut along the window's sides and along as many lines each way as make `cells` cells of it, so
// that no triangle is larger than one. Nothing for a tile whose triangles lie over each other so
// often that their pieces cannot be held.
std::optional<QuantizedPart> cutOut(const QuantizedTile& tile, const QuantizedWindow& window,
                                    int cells);

// Longitude and latitude in degrees of places in a tile: both run evenly, also in tiles of a
// Mercator tree, as those who show such tiles have always taken them.
glm::dvec2 lonLatOf(glm::dvec2 place, const std::array<double, 4>& extent);

// Without texture coordinates. The part's heights must be above the ellipsoid by now; its triangles
// and normals are taken from it. Normals that do not look up are left out, which `warnings` tells.
TerrainSurface surfaceOf(QuantizedPart& part, const std::array<double, 4>& tileExtent,
                         std::vector<std::string>& warnings);

// How high the surface is that is drawn: on the plane of the triangle over a place.
class QuantizedHeights {
  public:
    // `heights`: of the part's vertices, above the ellipsoid.
    QuantizedHeights(QuantizedPart part, const std::array<double, 4>& tileExtent);
    double at(glm::dvec2 lonLat) const; // NaN where there is no triangle
    std::size_t bytes() const;

  private:
    bool heightIn(std::uint32_t triangle, glm::dvec2 place, glm::dvec2 lonLat,
                  double& height) const;

    QuantizedPart part_;
    std::array<double, 4> extent_;
    int side_ = 1;                                  // cells of the index
    std::vector<std::uint32_t> starts_, triangles_; // by cell
};

} // namespace gnomon
