// Pictures to paint with, written by GDAL into a folder of the test's own, and tiles to paint on.
#pragma once

#include "streaming/terrain/drape.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace gnomon {

class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "gnomon-XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

struct PictureSpec {
    int width = 256, height = 256, bands = 3;
    GDALDataType type = GDT_Byte;
    std::array<double, 6> place{356000, 1, 0, 5700000, 0, -1}; // EPSG:25832 near Cologne
    std::string crs = "EPSG:25832";                            // empty: none
    std::function<double(int band, double column, double row)> value;
    std::string driver = "GTiff";
    std::vector<std::string> creation;
    std::function<void(GDALDataset&)> finish; // before it is closed
};

inline OGRSpatialReference crsOf(const std::string& text) {
    OGRSpatialReference crs;
    crs.SetFromUserInput(text.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return crs;
}

inline void writePicture(const std::string& path, const PictureSpec& spec) {
    GDALAllRegister();
    std::vector<const char*> creation;
    for (const std::string& option : spec.creation)
        creation.push_back(option.c_str());
    creation.push_back(nullptr);
    // Drivers that can only copy go through memory.
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(spec.driver.c_str());
    ASSERT_NE(driver, nullptr);
    const bool direct = driver->GetMetadataItem(GDAL_DCAP_CREATE) != nullptr;
    GDALDriver* first = direct ? driver : GetGDALDriverManager()->GetDriverByName("MEM");
    std::unique_ptr<GDALDataset> data(
        first->Create(direct ? path.c_str() : "", spec.width, spec.height, spec.bands, spec.type,
                      direct ? const_cast<char**>(creation.data()) : nullptr));
    ASSERT_NE(data, nullptr);
    auto place = spec.place;
    if (direct || spec.driver == "GTiff")
        data->SetGeoTransform(place.data());
    if (!spec.crs.empty() && direct) {
        const OGRSpatialReference crs = crsOf(spec.crs);
        data->SetSpatialRef(&crs);
    }
    std::vector<double> values(std::size_t(spec.width) * std::size_t(spec.height));
    for (int b = 1; b <= spec.bands; ++b) {
        for (int row = 0; row < spec.height; ++row)
            for (int column = 0; column < spec.width; ++column)
                values[std::size_t(row) * std::size_t(spec.width) + std::size_t(column)] =
                    spec.value(b, column + 0.5, row + 0.5);
        ASSERT_EQ(data->GetRasterBand(b)->RasterIO(GF_Write, 0, 0, spec.width, spec.height,
                                                   values.data(), spec.width, spec.height,
                                                   GDT_Float64, 0, 0, nullptr),
                  CE_None);
    }
    if (spec.finish)
        spec.finish(*data);
    if (!direct) {
        const std::unique_ptr<GDALDataset> copy(
            driver->CreateCopy(path.c_str(), data.get(), FALSE, const_cast<char**>(creation.data()),
                               nullptr, nullptr));
        ASSERT_NE(copy, nullptr);
    }
}

// A tile to paint on, regular in longitude and latitude.
struct PaintedTile {
    int across = 128, down = 128;
    double west = 0, south = 0, east = 0, north = 0;
    std::vector<std::uint8_t> rgba;

    PaintedTile(std::array<double, 4> extent, int acrossTexels, int downTexels)
        : across(acrossTexels), down(downTexels), west(extent[0]), south(extent[1]),
          east(extent[2]), north(extent[3]), rgba(std::size_t(4 * acrossTexels * downTexels), 0) {}

    glm::dvec2 place(int i, int j) const {
        return {west + (east - west) * (i + 0.5) / across,
                north + (south - north) * (j + 0.5) / down};
    }
    std::vector<glm::dvec2> places() const {
        std::vector<glm::dvec2> out;
        for (int j = 0; j < down; ++j)
            for (int i = 0; i < across; ++i)
                out.push_back(place(i, j));
        return out;
    }
    Failure paintWith(const Drape& drape) { return drape.paint(places(), across, rgba); }
    const std::uint8_t* texel(int i, int j) const {
        return &rgba[std::size_t(4 * (j * across + i))];
    }
};

} // namespace gnomon
