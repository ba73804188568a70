// From a surface of any triangles to the meshes of a tile, with skirts, and the picture painted on
// it. What quantized meshes need; a raster's own tiles are grids and made as such.
#pragma once

#include "streaming/content.h"
#include "streaming/terrain/drape.h"

#include <glm/vec2.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace gnomon {

// One entry a vertex in each vector.
struct TerrainSurface {
    Point<Ecef> origin;                 // near all of it
    std::vector<glm::dvec3> positions;  // from the origin, ECEF's axes
    std::vector<glm::vec3> normals;     // any length, ECEF's axes; empty: made from the triangles
    std::vector<glm::vec2> places;      // in the tile, 0…1: what meshes are cut by
    std::vector<glm::vec2> uvs;         // empty: none
    std::vector<std::uint32_t> indices; // counter-clockwise seen from above
    // Edges at the tile's border, the surface to the left seen from above; each belongs to one
    // triangle.
    std::vector<std::array<std::uint32_t, 2>> borders;
    double skirtMetres = 0;     // how far skirts hang down, 0: none
    glm::dvec2 sizeMetres{0.0}; // across and down the tile, about
};

// Cuts it into meshes of material 0 and adds to the facts. Triangles without an area are dropped
// and counted.
void addMeshes(TileContent& content, const TerrainSurface& surface, const DecodeOptions& options);

// What drapes ask of a tile's picture.
struct PictureNeed {
    std::vector<std::shared_ptr<const Drape>> drapes; // those that reach into the tile
    glm::ivec2 texels{0, 0};                          // 0 without any
    // The rule that refines tiles knows heights only: what the picture lacks of its drapes' detail
    // as an error in metres. 0 when it shows all.
    double errorMetres = 0;
};
// For a tile of this extent (west, south, east, north in degrees).
PictureNeed pictureNeed(std::span<const std::shared_ptr<const Drape>> drapes,
                        const std::array<double, 4>& extent, glm::dvec2 sizeMetres);

} // namespace gnomon
