// ANUGA's results (.sww, NetCDF).
//
// ANUGA computes means of triangles and extrapolates them to the corners, which triangles need not
// share: there even the ground may jump, and change from step to step. Where the file has the means
// (stage_c, elevation_c) they are taken, as values of faces; where it has not and the ground jumps,
// the mean of a triangle's corners, which is the same. Else (or when the variable 'stage' is asked
// for by name) corners at one place are welded into one point with the mean bed and the mean depth
// of its corners, dry ones counting as none, each by the area it stands for: so the volume is the
// file's own.
#pragma once

#include "streaming/flood/unstructured.h"
#include "streaming/flood/unstructured_arrays.h"

namespace gnomon {

bool isSww(const ArrayFile& file);
Result<std::unique_ptr<MeshFile>> readSww(ArrayFile file, const FloodOptions& options);

} // namespace gnomon
