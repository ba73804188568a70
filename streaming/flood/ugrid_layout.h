// Which arrays of a UGRID file are the mesh, the water, the bed, the velocity and the time. Files
// name them as they like; standard names are followed where they are given, else the names that
// models in use write.
#pragma once

#include "streaming/flood/flood.h"
#include "streaming/flood/unstructured_arrays.h"
#include "streaming/flood/unstructured_topology.h"
#include "streaming/flood/water_variables.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gnomon {

struct UgridTopology {
    std::string x, y, faceNodes; // names of arrays
    std::string faceDimension;   // where the file says it
    bool isTuflow = false;
};

std::optional<UgridTopology> findUgridTopology(const ArrayFile& file);

struct UgridField {
    ArrayVariable variable;
    WaterRole role = WaterRole::None;
    int rank = 0; // smaller is surer
    ValuesAt at = ValuesAt::Faces;
    bool changes = false; // with time
};

// All arrays of numbers that have a value a node or face.
std::vector<UgridField> findUgridFields(const ArrayFile& file, const UgridTopology& topology,
                                        const ArrayDimension& nodes, const ArrayDimension& faces);

// "EPSG:28992" or well-known text; none where the file does not say or says zero.
std::optional<std::string> findUgridCrs(const ArrayFile& file, const UgridTopology& topology,
                                        const ArrayVariable& data);

// Metres in the unit of a height; none for a unit that is no length.
std::optional<double> metresIn(const std::string& unit);

} // namespace gnomon
