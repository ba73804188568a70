// The header of NetCDF's classic formats, looked through before a library sees it: libnetcdf 4.9
// crashes on counts that lie, and reads zeros where a file ends before its arrays do.
#pragma once

#include "geo/result.h"

#include <string>

namespace gnomon {

// Nothing when the header is sound and all its arrays lie in the file.
Failure checkClassicNetCdf(const std::string& path);

} // namespace gnomon
