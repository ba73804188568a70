// The vertices of one tile: placed, with normals, on the ground of what lies above where there is
// some. A ring of samples around the tile comes along: normals and skirts need what lies beyond.
#pragma once

#include "streaming/terrain/terrain_data.h"

namespace gnomon {

struct TerrainPatch {
    glm::ivec2 cells{0, 0};
    glm::ivec2 before{0, 0}, after{0, 0}; // samples beyond the tile: 1, or 0 at the raster's end
    std::vector<double> columns, rows;    // in pixels, the ring included
    std::vector<float> heights;           // the raster's own; NaN without data
    std::vector<PlacedPixel> places;      // as they are drawn
    std::vector<glm::dvec3> positions;    // of these, ECEF
    std::vector<char> covered;            // lies on ground above; empty: none does

    int width() const { return cells.x + 1 + before.x + after.x; }
    // Vertices of the tile are 0 … cells; one less and one more lie in the ring.
    std::size_t index(int column, int row) const {
        return std::size_t(row + before.y) * std::size_t(width()) + std::size_t(column + before.x);
    }
    bool inside(int column, int row) const {
        return column >= -before.x && row >= -before.y && column <= cells.x + after.x &&
               row <= cells.y + after.y;
    }
    bool has(int column, int row) const {
        return inside(column, row) && !std::isnan(places[index(column, row)].heightMetres);
    }
    // A triangle is drawn where all corners have data, but not all lie on other ground.
    bool draws(glm::ivec2 a, glm::ivec2 b, glm::ivec2 c) const;
    // By height along both directions of the grid, from either side where there is one.
    glm::dvec3 normal(int column, int row) const;
};

Result<TerrainPatch> makePatch(const TerrainScene& scene, const TileName& name);

} // namespace gnomon
