// Which variables of a NetCDF file of grids are the water, the bed, the velocity, the coordinates
// and the time. Files name them as they like: standard names (CF conventions) tell most, else the
// names that models in use write, else what their long names speak of.
#pragma once

#include "streaming/flood/flood.h"
#include "streaming/flood/unstructured_arrays.h"
#include "streaming/flood/water_variables.h"

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct GridVariable {
    ArrayVariable variable;
    WaterRole role = WaterRole::None;
    int rank = 0; // smaller is surer
    bool isMaximum = false;
    bool isEastNorth = false;          // of a velocity: not along the grid's own axes
    std::size_t rows = 0, columns = 0; // its last two dimensions
    std::uint64_t steps = 1;           // its first, where it is one of time
    std::string because;               // what told the role

    bool hasTime() const { return variable.dimensions().size() > 2; }
    bool over(const GridVariable& other) const; // the same rows and columns
};

// All arrays of numbers over two dimensions, and perhaps time; in the file's order.
std::vector<GridVariable> findGridVariables(const ArrayFile& file);

// The role of the water's variable that the user names, or the best; with the bed and velocity that
// go with it.
struct GridFields {
    GridVariable water;
    WaterKind kind = WaterKind::Stage;
    std::optional<GridVariable> bed, velocityX, velocityY;
};
Result<GridFields> chooseGridFields(const ArrayFile& file, const FloodOptions& options,
                                    std::vector<std::string>& notes);

// Where the rows and columns are: two arrays of all nodes, or one a dimension.
struct GridCoordinates {
    std::vector<double> x, y;
    bool each = false;          // a pair for each node
    bool xRunsAlongRows = true; // x has one a column, y one a row; else the other way round
    bool degrees = false;       // longitude and latitude
};
Result<GridCoordinates> findGridCoordinates(const ArrayFile& file, const GridVariable& water);

// "EPSG:28992" or well-known text; none where the file does not say or says zero.
std::optional<std::string> findGridCrs(const ArrayFile& file, const GridVariable& water);
// The file has a place for a number of a system, with nothing in it.
bool saysCrsZero(const ArrayFile& file);

// The moments of its steps; empty when it has none.
struct GridTimes {
    std::vector<double> seconds;
    bool absolute = false;
};
Result<GridTimes> findGridTimes(const ArrayFile& file, const GridVariable& water,
                                std::vector<std::string>& notes);

} // namespace gnomon
