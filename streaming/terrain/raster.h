// Rasters of heights that GDAL reads (GeoTIFF, ESRI ASCII grid, NetCDF…), a window at a time. For
// the user's own local files only: bytes from a network never come here.
#pragma once

#include "geo/result.h"

#include <glm/vec2.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

class Raster {
  public:
    // One band of numbers with a place. Fails, in one line, for everything else: what cannot be
    // read, pictures of several bands, files of several variables, rasters that are placed by
    // points or not at all.
    static Result<Raster> open(const std::string& path);
    Raster(Raster&&) noexcept;
    Raster& operator=(Raster&&) noexcept;
    ~Raster();

    int width() const;
    int height() const;
    // East and north (or longitude and latitude) in its coordinate reference system; column and row
    // count from the upper left corner, so a pixel's centre is at +0.5.
    glm::dvec2 at(double column, double row) const;
    // Well-known text; none when the file names no system.
    const std::optional<std::string>& crs() const;
    std::string crsName() const; // "EPSG:25832", else the system's own name

    // Row by row, in metres; NaN where the file has no data. The window must lie in the raster.
    Result<std::vector<float>> read(int column, int row, int columns, int rows) const;

  private:
    struct State;
    explicit Raster(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
