// GDAL kept from talking to the terminal: what it says is carried in our one line. For .cpp files
// only.
#pragma once

#include <cpl_error.h>

#include <string>

namespace gnomon {

// Once, however often called, from any thread.
void registerGdalDrivers();

// While it lives, GDAL says nothing on this thread; its first error is kept.
class GdalQuiet {
  public:
    GdalQuiet();
    ~GdalQuiet();
    GdalQuiet(const GdalQuiet&) = delete;
    GdalQuiet& operator=(const GdalQuiet&) = delete;

    std::string reason() const; // one line
    bool silent() const { return said_.empty(); }

  private:
    static void take(CPLErr severity, CPLErrorNum, const char* text);
    std::string said_;
};

} // namespace gnomon
