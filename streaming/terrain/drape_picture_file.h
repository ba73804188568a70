// A picture's file as GDAL tells of it: where it lies, what its bands mean, and windows of it
// averaged over blocks of pixels. For drape_picture*.cpp only, since it shows GDAL.
#pragma once

#include "streaming/terrain/drape.h"

#include <gdal_priv.h>
#include <glm/vec4.hpp>
#include <ogr_spatialref.h>

namespace gnomon {

// Blocks of `across` times `down` pixels of one of the file's own smaller copies, or of itself.
struct PictureLevel {
    int overview = -1; // of the file, -1: itself
    int across = 1, down = 1;
    int columns = 0, rows = 0;              // of blocks, the last ones perhaps cut
    double columnPixels = 1, rowPixels = 1; // of the file itself, a block
};

struct BlockWindow {
    int column = 0, row = 0, columns = 0, rows = 0;
};

struct PictureFile {
    std::string path;
    int width = 0, height = 0;
    std::array<double, 6> place{}, pixelFromPlace{};
    OGRSpatialReference crs;
    double turn = 0.0; // the system's full circle where x is a longitude, else 0

    std::vector<int> colorBands; // one (grey or palette) or three
    int alphaBand = 0;           // 0: none
    bool hasMask = false;        // a mask of the whole file beside its bands
    bool sixteenBits = false;
    std::vector<std::optional<double>> noData; // a colour band
    std::vector<glm::vec4> palette;            // 0…255, empty: none
    std::vector<float> shown;                  // 0…255 by raw value
    std::vector<int> overviewWidths, overviewHeights;

    // Reads all of the above; says in `notes` what it took for granted.
    static Result<PictureFile> describe(GDALDataset& data, const std::string& path,
                                        const DrapeOptions& options,
                                        std::vector<std::string>& notes);

    // Fitting for places `acrossPixels` and `downPixels` apart.
    PictureLevel level(double acrossPixels, double downPixels) const;
    // Red, green, blue (0…255, times alpha) and alpha (0…1), block by block.
    Result<std::vector<glm::vec4>> read(GDALDataset& data, const PictureLevel& level,
                                        const BlockWindow& window) const;
};

// Null where it cannot be opened; `GdalQuiet` has the reason.
std::unique_ptr<GDALDataset> openPictureData(const std::string& path);

} // namespace gnomon
