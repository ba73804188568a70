// A quantized mesh with what lies above it and what is painted on it, and the tiles of that.
// Private to quantized_mesh*.cpp.
#pragma once

#include "streaming/terrain/quantized_mesh_pyramid.h"
#include "streaming/terrain/terrain.h"

namespace gnomon {

// What brings a tile's own heights to heights above the ellipsoid: the geoid, where that is what
// they are above, and what the user raises them by.
class HeightShift {
  public:
    HeightShift(Heights heights, double raiseMetres) : heights_(heights), raise_(raiseMetres) {}
    // Fails where the geoid cannot be had.
    Failure prepare(const std::array<double, 4>& extent);
    double at(glm::dvec2 place) const; // in the prepared tile's own units
    double least() const;
    double most() const;

  private:
    Heights heights_;
    double raise_;
    int columns_ = 0, rows_ = 0; // of the geoid's heights over the tile; 0: there is none
    std::vector<double> geoid_;
};

struct QuantizedCore {
    std::string path;
    std::unique_ptr<const QuantizedPyramid> pyramid;
    TerrainLook look = TerrainLook::Plain;
    Heights heights = Heights::Ellipsoidal;
    double raiseMetres = 0;
    double lowest = 0, highest = 0; // of its own heights
    TerrainFacts facts;

    // By how much a tile's surface is off, as it says itself, else by the usual rule: a quarter of
    // the equator over the 65 samples a side that a tile of level 0 stands for.
    double errorOf(const QuantizedPlace& place) const;
};

struct QuantizedScene {
    std::shared_ptr<const QuantizedCore> core;
    std::vector<std::shared_ptr<const GroundHeights>> above;
    std::vector<std::shared_ptr<const Drape>> drapes;

    // How much of an extent other ground covers, by looks at a grid of places.
    enum class Covered { Nothing, Part, All };
    Covered coverage(const std::array<double, 4>& extent) const;
    bool isNearAbove(const std::array<double, 4>& extent) const;
};

// Where a tile is cut for other ground: cells a side.
inline constexpr int kRoomCells = 64;

std::string nameOf(const QuantizedPlace& place); // "9/759/335"
std::optional<QuantizedPlace> quantizedPlaceNamed(const std::string& name);

// quantized_mesh_tree.cpp
std::vector<MadeTile> quantizedTiles(const QuantizedScene& scene);
std::vector<MadeTile> quantizedTilesBelow(const QuantizedScene& scene, const QuantizedPlace& place);
// quantized_mesh_content.cpp
Result<TileContent> makeQuantizedTile(const QuantizedScene& scene, const QuantizedPlace& place,
                                      const DecodeOptions& options);

} // namespace gnomon
