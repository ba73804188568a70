// HEC-RAS 2D results (plan HDF5): all 2D flow areas of a plan as one, values of cells.
//
// HEC-RAS keeps the ground within a cell as a table of volume over level. What is shown is the
// level, and as a cell's bed its lowest point, as HEC-RAS's own depths are; so depth times area
// overstates the volume of cells that slope, and a note says by how much.
#pragma once

#include "streaming/flood/unstructured.h"
#include "streaming/flood/unstructured_arrays.h"

namespace gnomon {

bool isHecRas(const ArrayFile& file);
Result<std::unique_ptr<MeshFile>> readHecRas(ArrayFile file, const FloodOptions& options);

} // namespace gnomon
