// Terrain from a raster of heights: a quadtree of tiles cut on the fly in worker threads, each
// level every second sample of the level below. A tile's geometric error is the largest height by
// which its surface and the raster's own (linear between the centres of pixels) differ anywhere in
// it.
#pragma once

#include "geo/crs.h"
#include "streaming/content_maker.h"
#include "streaming/terrain/drape.h"
#include "streaming/terrain/ground_heights.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

namespace gnomon {

enum class TerrainLook {
    Plain,     // one calm colour, lit
    Ramp,      // coloured by height, lit
    RampUnlit, // coloured by height, no shading by slope; shadows stay
};

struct TerrainOptions {
    std::optional<std::string> crs; // for files that name none
    // Of a file of several variables (NetCDF): the one that is meant.
    std::optional<std::string> variable;
    Heights heights = Heights::Ellipsoidal;
    double raiseMetres = 0.0;
    TerrainLook look = TerrainLook::Plain;
    // Rasters of more pixels than this are not read at opening: errors of coarse tiles are
    // estimated then, those of fine ones found as they are needed. 4e8 take some 10 s.
    std::int64_t mostPixelsRead = 400'000'000;
    // Long work at opening, 0…1. May be null.
    std::function<void(double share)> progress;
};

struct TerrainFacts {
    std::string crs; // the raster's, or the one given
    int columns = 0, rows = 0;
    double cellMetres = 0; // at its middle, the smaller side
    bool hasOverviews = false;
    double minHeightMetres = 0, maxHeightMetres = 0; // above the ellipsoid
    double dataShare = 1;                            // of pixels with data
    // Where it is coloured by height: what the first and the last colour stand for, in the raster's
    // own heights.
    std::optional<std::array<double, 2>> rampHeights;
    double rootErrorMetres = 0; // of the coarsest tile
    bool errorIsBound = true; // false: estimated, the raster being too large to be read at opening
    std::array<double, 4> extent{}; // west, south, east, north, degrees
    std::vector<std::string> notes; // what was taken for granted
    std::vector<std::string> credits;
};

class Terrain : public GroundHeights {
  public:
    // Fails in one line for what is no raster of heights, has no place (and no `crs`), or holds no
    // data at all.
    static Result<std::shared_ptr<const Terrain>> open(const std::string& path,
                                                       const TerrainOptions& options);
    virtual const TerrainFacts& facts() const = 0;
    std::optional<std::array<double, 4>> extent() const override { return facts().extent; }
    // Its tiles. Where one of `above` has ground this one makes room; `drapes` are painted on, the
    // last on top.
    virtual MadeTileset tiles(std::vector<std::shared_ptr<const GroundHeights>> above,
                              std::vector<std::shared_ptr<const Drape>> drapes) const = 0;
};

// A quantized-mesh pyramid (layer.json) or a single .terrain tile, as the same.
Result<std::shared_ptr<const Terrain>> openQuantizedMesh(const std::string& path,
                                                         const TerrainOptions& options);
// The same by a path in a source.
class Source;
Result<std::shared_ptr<const Terrain>> openQuantizedMesh(std::shared_ptr<const Source> source,
                                                         const std::string& path,
                                                         const TerrainOptions& options);

} // namespace gnomon
