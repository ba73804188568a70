// Results of flood models as they come: nodes that do not move, and values on them over time. Every
// format ends as this: rasters (one file a step, bands, NetCDF), observed levels at points, and
// meshes (UGRID, ANUGA .sww, HEC-RAS HDF5, TELEMAC .slf).
#pragma once

#include "geo/crs.h"
#include "geo/result.h"
#include "geo/time.h"

#include <glm/vec2.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

enum class WaterKind {
    Depth, // metres above the bed
    Stage, // height of the surface; above the ellipsoid once read
};

struct FloodGeometry {
    std::vector<glm::dvec2> lonLat; // degrees, a node
    // A node: height of the bed above the ellipsoid. Empty when the file has none: then the scene's
    // ground is the bed. NaN where there is no data.
    std::vector<float> bed;
    std::vector<float> cellArea; // square metres that a node stands for
    // Counter-clockwise seen from above; between neighbouring nodes. Empty for a grid.
    std::vector<std::array<std::uint32_t, 3>> triangles;
    // Of a grid: node = row * columns + column, two triangles between each four, and the rim's
    // nodes stand for the whole of their cells, half a cell further out than they lie. Else 0.
    int columns = 0, rows = 0;
};

class GroundHeights;

class FloodData {
  public:
    virtual ~FloodData() = default;
    virtual const FloodGeometry& geometry() const = 0;
    virtual WaterKind kind() const = 0;
    // Ascending, at least one. Absolute when the file or the user says so, else from 0 on.
    virtual const std::vector<double>& stepSeconds() const = 0; // since 1970 UTC, or the start
    virtual bool stepsAreAbsolute() const = 0;
    // A value a node; NaN: dry or no data. The bed of files that change it comes with the step.
    virtual Result<std::vector<float>> values(std::size_t step) const = 0;
    virtual bool hasVelocity() const { return false; }
    virtual Result<std::vector<glm::vec2>> velocities(std::size_t step) const; // m/s, east, north
    virtual bool isInterpolated() const { return false; } // between a few points, no model's result
    // Where the water is, of data that tells only how high it is: the same made out for this
    // ground. Null for results that know it themselves.
    virtual Result<std::shared_ptr<const FloodData>> on(const GroundHeights& ground) const;

    std::string path;               // the first of its files; may be empty
    std::string crs;                // the file's, or the one given
    std::vector<std::string> notes; // what was taken for granted
    std::vector<std::string> credits;
    std::vector<Error> leftOut; // steps that could not be used, one line each
};

struct FloodOptions {
    std::optional<WaterKind> kind;
    std::optional<std::string> variable; // of a file with several; a column of a table
    std::optional<std::string> crs;
    Heights heights = Heights::Ellipsoidal; // of stages and beds
    double raiseMetres = 0.0;
    std::optional<UtcTime> start;      // of the first step, where the file does not say
    std::optional<double> stepSeconds; // between steps, likewise
};

// `paths`: one file, or one a step in the order of time. What each holds is known by its content.
Result<std::shared_ptr<const FloodData>> openFlood(const std::vector<std::string>& paths,
                                                   const FloodOptions& options);

// The formats of meshes, for openFlood: known by what is in the file.
bool isUnstructuredFlood(const std::string& path);
Result<std::shared_ptr<const FloodData>> openUnstructuredFlood(const std::string& path,
                                                               const FloodOptions& options);

} // namespace gnomon
