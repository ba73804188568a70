// Where a raster's pixels are on the Earth. PROJ takes a microsecond a point; within a tile places
// are interpolated instead (Chebyshev, in the ellipsoid's normal), where that was checked to change
// them by less than kPlaceSlackMetres. Heights are never interpolated.
#pragma once

#include "geo/crs.h"
#include "streaming/terrain/raster.h"

#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace gnomon {

// The rounding of floats in a tile is larger.
inline constexpr double kPlaceSlackMetres = 1e-6;

// At (N + h) n: the ellipsoid's unit normal n there, and the height above it.
struct PlacedPixel {
    glm::dvec3 up{0.0};
    double heightMetres = 0.0;

    Point<Ecef> ecef() const { return ecefAt(heightMetres); }
    Point<Ecef> ecefAt(double metres) const;
    glm::dvec2 lonLat() const; // degrees
};

// Columns and rows at which places are wanted, in pixels, whole numbers being pixels' centres. On
// exact lines every place is PROJ's own, so that tiles that share such a line agree to the last
// bit.
struct PixelLines {
    std::vector<double> columns, rows;
    std::vector<bool> exactColumn, exactRow; // empty: none
};

class TerrainPlace {
  public:
    // `raster` must outlive it.
    static Result<std::unique_ptr<const TerrainPlace>>
    create(const Raster& raster, const std::string& crs, Heights heights, double raiseMetres);

    // `height` as the raster has it.
    Result<PlacedPixel> at(glm::dvec2 pixel, double height) const;
    // Row by row. Where `heights` (one a place) is NaN the height is, too, and the place holds for
    // height 0. Without heights: of height 0 all.
    Result<std::vector<PlacedPixel>> at(const PixelLines& lines,
                                        std::span<const float> heights) const;
    // In pixels; NaN for what the CRS has no place for.
    void pixelsOf(std::span<const glm::dvec2> lonLat, std::span<glm::dvec2> out) const;
    // What the raster's `heights` at `pixels` are above the ellipsoid; NaN stays.
    void heightsAt(std::span<const glm::dvec2> lonLat, std::span<const glm::dvec2> pixels,
                   std::span<double> heights) const;

  private:
    TerrainPlace(const Raster& raster, std::string crs, Heights heights, double raiseMetres)
        : raster_(raster), crs_(std::move(crs)), heights_(heights), raise_(raiseMetres) {}
    class Lease;
    Result<PlacedPixel> exact(const CrsToEcef& crs, glm::dvec2 pixel, double height) const;
    bool interpolate(const CrsToEcef& crs, const PixelLines& lines,
                     std::vector<PlacedPixel>& out) const;
    Failure placeHeights(std::span<const float> heights, std::vector<PlacedPixel>& out) const;

    const Raster& raster_;
    std::string crs_;
    Heights heights_;
    double raise_;
    bool ownHeights_ = false;
    bool periodic_ = false; // eastings are longitudes in degrees: 360 more is the same place
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<CrsToEcef>> idle_; // one object a thread
};

} // namespace gnomon
