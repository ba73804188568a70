// Rasters of numbers with a place that GDAL reads (GeoTIFF, ESRI ASCII grid, NetCDF…), a window at
// a time, from several threads at once. For the user's own local files only: bytes from a network
// never come here.
#pragma once

#include "geo/result.h"

#include <glm/vec2.hpp>

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

struct RasterOptions {
    // Of a file of several: the one meant. Without, the only one that says it is ground.
    std::optional<std::string> variable;
    bool severalBands = false; // steps of time, say; heights have one
    bool anyUnit = false;      // else its values are lengths, and are read in metres
};

class Raster {
  public:
    // Numbers with a place. Fails, in one line, for everything else: what cannot be read, pictures,
    // files of several variables of which none is named, rasters that are placed by points or not
    // at all.
    static Result<Raster> open(const std::string& path, const RasterOptions& options = {});
    Raster(Raster&&) noexcept;
    Raster& operator=(Raster&&) noexcept;
    ~Raster();

    int width() const;
    int height() const;
    int bands() const;
    // East and north (or longitude and latitude) in its coordinate reference system; column and row
    // count from the upper left corner, so a pixel's centre is at +0.5.
    glm::dvec2 at(double column, double row) const;
    // The way back.
    glm::dvec2 pixelOf(glm::dvec2 position) const;
    // Rows run clockwise of columns, as in a picture with north up; false for rasters that are
    // stored from the south.
    bool rowsRunSouth() const;
    // Well-known text; none when the file names no system.
    const std::optional<std::string>& crs() const;
    std::string crsName() const; // "EPSG:25832", else the system's own name
    const std::vector<std::string>& credits() const;
    const std::vector<std::string>& notes() const; // what was taken for granted
    std::vector<int> overviewFactors() const;      // ascending; empty without
    glm::ivec2 blockSize() const;                  // of what is read at once, in pixels

    // Row by row, in metres; NaN where the file has no data. The window must lie in the raster.
    Result<std::vector<float>> read(int column, int row, int columns, int rows, int band = 1) const;
    Failure readInto(int column, int row, int columns, int rows, std::span<float> out,
                     int band = 1) const;
    // Every `step`-th pixel's own value (no mean), the first at column, row.
    Failure sampleInto(int column, int row, int step, int columns, int rows,
                       std::span<float> out) const;
    // The whole as an overview holds it, `factor` being one of overviewFactors(); its pixels are
    // means of the raster's, or picked from them.
    Result<std::vector<float>> readOverview(int factor, int column, int row, int columns,
                                            int rows) const;
    glm::ivec2 overviewSize(int factor) const;

  private:
    struct State;
    explicit Raster(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
