// TELEMAC-2D results: Selafin (Serafin), single or double precision. Read here and not through
// GDAL's driver, which knows no double precision and gives each value by itself as a feature; the
// format is a row of Fortran records whose lengths must all agree with the four counts in it.
#pragma once

#include "streaming/flood/unstructured.h"

namespace gnomon {

bool isSelafin(const std::string& path);
Result<std::unique_ptr<MeshFile>> readSelafin(const std::string& path, const FloodOptions& options);

} // namespace gnomon
