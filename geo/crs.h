// Any coordinate reference system PROJ knows, and EGM96 heights, to ECEF.
#pragma once

#include "geo/ellipsoid.h"
#include "geo/result.h"

#include <glm/vec2.hpp>

#include <memory>
#include <span>
#include <string>

namespace gnomon {

enum class Heights { Ellipsoidal, Egm96 };

// x, y in the CRS's own order of east, north (or longitude, latitude in degrees), z in metres.
// One object per thread.
class CrsToEcef {
  public:
    // `crs`: "EPSG:25832", a WKT or PROJ string. A compound or 3D CRS brings its own
    // heights; for any other, z is metres above the WGS 84 ellipsoid or EGM96, as `heights` says.
    // What only a grid can give that is not installed is an error that names the grid.
    static Result<CrsToEcef> create(const std::string& crs, Heights heights);
    CrsToEcef(CrsToEcef&&) noexcept;
    CrsToEcef& operator=(CrsToEcef&&) noexcept;
    ~CrsToEcef();

    Result<Point<Ecef>> operator()(const glm::dvec3& xyz) const;
    Result<Geodetic> geodetic(const glm::dvec3& xyz) const;
    // The way back: east and north of places in degrees; NaN where the CRS has none.
    void eastNorth(std::span<const glm::dvec2> lonLat, std::span<glm::dvec2> out) const;
    // Its third axis says what heights mean (a compound or 3D CRS).
    bool hasOwnHeights() const;
    // East, north, up of the CRS's own axes near `origin` (a tangent frame: grid north, grid
    // scale), so that a tileset in a projected CRS can be put on the Earth as one rigid piece.
    Result<Transform<Ecef, Tile>> ecefFromCrsNear(const glm::dvec3& origin) const;

  private:
    struct State;
    explicit CrsToEcef(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// Height of the EGM96 geoid above the ellipsoid.
Result<double> egm96GeoidHeight(double longitudeDegrees, double latitudeDegrees);

} // namespace gnomon
