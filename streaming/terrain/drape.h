// What is painted on terrain: pictures with a place (any raster GDAL reads), polygons in one
// colour.
#pragma once

#include "geo/crs.h"
#include "geo/result.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

struct DrapeOptions {
    std::optional<std::string> crs;                // for files that name none
    std::array<std::uint8_t, 3> color{90, 90, 96}; // sRGB; of polygons
};

class Drape {
  public:
    virtual ~Drape() = default;
    // West, south, east, north in degrees, around all of it.
    virtual std::array<double, 4> extent() const = 0;
    // The size of its own pixels on the ground: finer textures show no more. Infinite for what has
    // none.
    virtual double texelMetres() const = 0;
    // Paints over `rgba` (sRGB, a = 255 where something was painted) at places given row by row,
    // `width` a row, neighbours in the picture being neighbours on the ground. Fails in one line
    // when the file cannot be read. From several threads at once.
    virtual Failure paint(std::span<const glm::dvec2> lonLat, int width,
                          std::span<std::uint8_t> rgba) const = 0;
};

// A raster of one (grey or palette), three or four bands, or of polygons: GeoJSON, GeoPackage,
// Shapefile, a CSV of the vertices of one polygon. `notes`: what was taken for granted.
Result<std::shared_ptr<const Drape>> openDrape(const std::string& path, const DrapeOptions& options,
                                               std::vector<std::string>& notes);

} // namespace gnomon
