// What a raster file says of itself. For raster.cpp only: it knows GDAL.
#pragma once

#include "streaming/terrain/raster.h"

#include <array>

class GDALDataset;

namespace gnomon {

struct RasterClose {
    void operator()(GDALDataset* data) const;
};
using RasterHandle = std::unique_ptr<GDALDataset, RasterClose>;

struct RasterFile {
    std::string path; // as the user wrote it
    std::string name; // as GDAL opens it: one variable of a file of several
    int width = 0, height = 0, bands = 0;
    std::array<double, 6> transform{};
    std::optional<std::string> crs;
    std::string crsName;
    std::optional<double> noData;
    double scale = 1.0, offset = 0.0;
    glm::ivec2 blockSize{1, 1};
    std::vector<int> overviewFactors, overviewIndex;
    std::vector<glm::ivec2> overviewSizes;
    std::vector<std::string> credits, notes;

    RasterHandle openAgain() const; // null when it has gone
};

struct OpenedRaster {
    RasterFile file;
    RasterHandle data;
};
Result<OpenedRaster> openRasterFile(const std::string& path, const RasterOptions& options);

} // namespace gnomon
