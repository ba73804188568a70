// HDF5 files tried out before they are opened here. libhdf5 1.10 corrupts its memory on files whose
// index is damaged (one bit is enough), and no check from outside can tell; so a child process
// walks the file first, and what happens to it happens there.
#pragma once

#include "geo/result.h"

#include <string>

namespace gnomon {

// Nothing when all groups, arrays and attributes could be listed.
Failure checkHdf5(const std::string& path);

} // namespace gnomon
