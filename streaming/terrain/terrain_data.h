// What the tiles of a raster's terrain are cut from. Private to terrain*.cpp.
#pragma once

#include "streaming/terrain/height_samples.h"
#include "streaming/terrain/terrain.h"
#include "streaming/terrain/terrain_place.h"

#include <memory>
#include <optional>

namespace gnomon {

struct TerrainData {
    explicit TerrainData(Raster opened)
        : raster(std::move(opened)), levels{{raster.width(), raster.height()}} {}

    std::string path;
    Raster raster;
    HeightLevels levels;
    std::unique_ptr<const TerrainPlace> place;
    std::unique_ptr<const HeightSamples> samples;
    TerrainLook look = TerrainLook::Plain;
    TerrainFacts facts;
    // By level; those below `knownFrom` are empty: they are looked at when they are asked for.
    std::vector<LevelTiles> tiles;
    int knownFrom = 0;
    std::vector<double> usualError; // by level, where it is not known
    double lowest = 0, highest = 0; // of the raster's own heights
    double longerCellMetres = 0;    // the larger side of a pixel, at the raster's middle

    double cellMetres(int level) const { return longerCellMetres * double(1 << level); }
    const TileHeights* known(int level, glm::ivec2 tile) const {
        return level >= knownFrom ? &tiles[std::size_t(level)].at(tile) : nullptr;
    }
    // How far the tile's surface is from the raster's in height, and by the Earth's curvature
    // below its chords.
    double heightError(int level, glm::ivec2 tile) const;
    double heightError(int level, const TileHeights& heights) const;
};

// A rectangle in longitude and latitude: west, south, east, north in degrees. East may be smaller
// than west beyond the antimeridian.
using GeographicBox = std::array<double, 4>;
bool overlap(const GeographicBox& a, const GeographicBox& b);

// Terrain with what lies above it and what is painted on it.
struct TerrainScene {
    std::shared_ptr<const TerrainData> data;
    std::vector<std::shared_ptr<const GroundHeights>> above;
    std::vector<std::shared_ptr<const Drape>> drapes;
    double finestTexelMetres = 0; // of the drapes; 0 without
    std::vector<double> lattice;  // by level: positions of its tiles are multiples of it

    // Tiles below level 0 are parts of one, for finer textures: half the cells each.
    static int cellsOf(int level) { return level >= 0 ? kTileCells : kTileCells >> -level; }
    static constexpr int kLowestLevel = -7; // of one cell
    HeightLevels::Span span(int level, glm::ivec2 tile) const;
    GeographicBox boxOf(int level, glm::ivec2 tile) const;
    bool isDraped(const GeographicBox& box) const;
    // Texels across and down for a draped tile, and their size.
    struct Texels {
        glm::ivec2 count{0, 0};
        double metres = 0;
        bool coarse = false; // the drapes hold more
    };
    Texels texelsOf(int level, glm::ivec2 tile) const;
};

// "3/1/0"; nothing for what is none of its tiles.
struct TileName {
    int level = 0;
    glm::ivec2 tile{0, 0};
};
std::string nameOf(int level, glm::ivec2 tile);
std::optional<TileName> tileNamed(const TerrainScene& scene, const std::string& path);

// terrain_tree.cpp
MadeTileset terrainTiles(std::shared_ptr<const TerrainScene> scene,
                         std::shared_ptr<const ContentMaker> maker);
Result<std::vector<MadeTile>> terrainTilesBelow(const TerrainScene& scene, const TileName& name);
// terrain_tile.cpp
Result<TileContent> makeTerrainTile(const TerrainScene& scene, const TileName& name,
                                    const DecodeOptions& options);
inline constexpr glm::vec3 kTerrainColor{0.52f, 0.53f, 0.45f}; // sRGB; a calm grey-green

} // namespace gnomon
