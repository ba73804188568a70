// UGRID 1.0 results in NetCDF (Delft3D FM, SFINCS quadtree, and whatever follows the conventions),
// and TUFLOW FV's own layout, which is the same under fixed names. Values on nodes or faces of the
// two-dimensional mesh.
#pragma once

#include "streaming/flood/unstructured.h"
#include "streaming/flood/unstructured_arrays.h"

namespace gnomon {

bool isUgrid(const ArrayFile& file);
Result<std::unique_ptr<MeshFile>> readUgrid(ArrayFile file, const FloodOptions& options);

} // namespace gnomon
