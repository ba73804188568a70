// Small rasters written by GDAL, and results made by functions.
#pragma once

#include "streaming/flood/flood.h"
#include "tests/streaming/mesh_flood_support.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <array>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace gnomon::test {

inline constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

inline std::filesystem::path dataFolder() {
    if (const char* given = std::getenv("GNOMON_DATA"))
        return given;
    return std::filesystem::path(GNOMON_SOURCE_DIR) / ".." / "shared" / "data";
}

#define GNOMON_NEEDS(path)                                                                         \
    if (!std::filesystem::exists(path))                                                            \
    GTEST_SKIP() << path << " is not here"

// Near Venice, north up, unless `transform` says else.
struct TiffSpec {
    int columns = 8, rows = 6;
    std::array<double, 6> transform{290000.0, 10.0, 0.0, 5050000.0, 0.0, -10.0};
    int epsg = 32633; // 0: none
    int bands = 1;
    std::function<double(int column, int row, int band)> value = [](int, int, int) { return 1.0; };
    double noData = -9999.0;
    std::string unit;
};

inline void writeTiff(const std::string& path, const TiffSpec& spec) {
    GDALAllRegister();
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const GDALDatasetUniquePtr data(
        driver->Create(path.c_str(), spec.columns, spec.rows, spec.bands, GDT_Float32, nullptr));
    ASSERT_TRUE(data);
    std::array<double, 6> transform = spec.transform;
    data->SetGeoTransform(transform.data());
    if (spec.epsg != 0) {
        OGRSpatialReference crs;
        crs.importFromEPSG(spec.epsg);
        data->SetSpatialRef(&crs);
    }
    for (int b = 1; b <= spec.bands; ++b) {
        std::vector<float> values;
        for (int row = 0; row < spec.rows; ++row)
            for (int column = 0; column < spec.columns; ++column)
                values.push_back(float(spec.value(column, row, b)));
        GDALRasterBand* band = data->GetRasterBand(b);
        band->SetNoDataValue(spec.noData);
        if (!spec.unit.empty())
            band->SetUnitType(spec.unit.c_str());
        ASSERT_EQ(band->RasterIO(GF_Write, 0, 0, spec.columns, spec.rows, values.data(),
                                 spec.columns, spec.rows, GDT_Float32, 0, 0, nullptr),
                  CE_None);
    }
}

// A grid in NetCDF as models write it.
struct GridSpec {
    int columns = 8, rows = 6, steps = 3;
    double spacing = 10.0;
    double x0 = 290000.0, y0 = 5050000.0;
    std::string stage = "zs", depth, bed = "zb"; // empty: not written
    std::string timeUnit = "hours since 2021-07-14 12:00:00";
    std::vector<double> times; // 0, 1, … when empty
    int epsg = 32633;          // -1: no attribute
    bool eachPlace = false;    // x and y of all nodes, not of rows and columns
    double bend = 0.0;         // metres by which the middle of a row lies north of its ends
    bool velocity = false;     // 1 along x, step along y
    bool eastNorth = false;    // the velocity's names say so
    std::function<double(int column, int row)> ground = [](int, int) { return 0.0; };
    std::function<double(int column, int row, int step)> level = [](int, int, int step) {
        return 1.0 + step; // NaN: dry
    };
};

inline void writeGrid(const std::string& path, const GridSpec& spec) {
    NetCdf file(path);
    file.dimension("time", std::size_t(spec.steps));
    file.dimension("n", std::size_t(spec.rows));
    file.dimension("m", std::size_t(spec.columns));
    const std::vector<std::string> each{"n", "m"}, over{"time", "n", "m"};
    file.variable("x", NC_DOUBLE, spec.eachPlace ? each : std::vector<std::string>{"m"});
    file.variable("y", NC_DOUBLE, spec.eachPlace ? each : std::vector<std::string>{"n"});
    file.text("x", "standard_name", "projection_x_coordinate");
    file.text("y", "standard_name", "projection_y_coordinate");
    file.variable("time", NC_DOUBLE, {"time"});
    file.text("time", "units", spec.timeUnit);
    if (spec.epsg >= 0) {
        file.variable("crs", NC_INT, {});
        file.number("crs", "epsg", spec.epsg, NC_INT);
    }
    const auto field = [&](const std::string& name, const std::string& standard,
                           const std::vector<std::string>& dimensions) {
        if (name.empty())
            return;
        file.variable(name, NC_FLOAT, dimensions);
        file.text(name, "standard_name", standard);
        file.text(name, "units", "m");
        file.number(name, "_FillValue", -99999.0, NC_FLOAT);
    };
    field(spec.stage, "sea_surface_height_above_mean_sea_level", over);
    field(spec.depth, "depth", over);
    field(spec.bed, "altitude", each);
    if (spec.velocity) {
        field("u", spec.eastNorth ? "eastward_sea_water_velocity" : "sea_water_x_velocity", over);
        field("v", spec.eastNorth ? "northward_sea_water_velocity" : "sea_water_y_velocity", over);
    }
    file.endDefinition();

    std::vector<double> x, y, time = spec.times, bed, stage, depth, u, v;
    for (int step = 0; step < spec.steps && spec.times.empty(); ++step)
        time.push_back(step);
    for (int row = 0; row < spec.rows; ++row)
        for (int column = 0; column < spec.columns; ++column) {
            if (spec.eachPlace || row == 0)
                x.push_back(spec.x0 + spec.spacing * column);
            if (spec.eachPlace || column == 0)
                y.push_back(spec.y0 + spec.spacing * row +
                            spec.bend * std::sin(3.14159265 * column / (spec.columns - 1)));
            bed.push_back(spec.ground(column, row));
        }
    for (int step = 0; step < spec.steps; ++step)
        for (int row = 0; row < spec.rows; ++row)
            for (int column = 0; column < spec.columns; ++column) {
                const double z = spec.level(column, row, step);
                stage.push_back(std::isnan(z) ? -99999.0 : z);
                depth.push_back(std::isnan(z) ? -99999.0 : z - spec.ground(column, row));
                u.push_back(1.0);
                v.push_back(step);
            }
    file.put("x", x);
    file.put("y", y);
    file.put("time", time);
    if (!spec.stage.empty())
        file.put(spec.stage, stage);
    if (!spec.depth.empty())
        file.put(spec.depth, depth);
    if (!spec.bed.empty())
        file.put(spec.bed, bed);
    if (spec.velocity) {
        file.put("u", u);
        file.put("v", v);
    }
}

// A level grid of degrees about a place, some `spacing` metres apart; bed and water by functions of
// metres east and north of its first node.
class MadeFlood : public FloodData {
  public:
    struct Spec {
        int columns = 40, rows = 40;
        double spacing = 10.0;
        double lon = 12.0, lat = 45.0;
        bool southUp = true; // rows run north; else south
        std::function<double(double x, double y)> bed = [](double, double) { return 0.0; };
        // Depth or, with `stage`, level; NaN: none.
        std::function<double(double x, double y, int step)> water = [](double, double, int) {
            return 1.0;
        };
        bool stage = false, hasBed = true, velocity = false;
        std::vector<double> seconds{0.0};
    };
    explicit MadeFlood(const Spec& spec) : spec_(spec) {
        geometry_.columns = spec.columns;
        geometry_.rows = spec.rows;
        // On WGS 84.
        const double radians = 3.14159265358979 / 180.0, e2 = 0.00669437999014;
        const double w2 = 1.0 - e2 * std::pow(std::sin(spec.lat * radians), 2);
        metresPerDegree_ = 6378137.0 * radians / std::sqrt(w2) *
                           glm::dvec2(std::cos(spec.lat * radians), (1.0 - e2) / w2);
        for (int row = 0; row < spec.rows; ++row)
            for (int column = 0; column < spec.columns; ++column) {
                const glm::dvec2 p = place(column, row);
                geometry_.lonLat.push_back(lonLat(p.x, p.y));
                if (spec.hasBed)
                    geometry_.bed.push_back(float(spec.bed(p.x, p.y)));
                geometry_.cellArea.push_back(float(spec.spacing * spec.spacing));
            }
    }
    glm::dvec2 place(int column, int row) const {
        return spec_.spacing * glm::dvec2(column, spec_.southUp ? row : -row);
    }
    glm::dvec2 lonLat(double x, double y) const {
        return glm::dvec2(spec_.lon, spec_.lat) + glm::dvec2(x, y) / metresPerDegree_;
    }
    const FloodGeometry& geometry() const override { return geometry_; }
    WaterKind kind() const override { return spec_.stage ? WaterKind::Stage : WaterKind::Depth; }
    const std::vector<double>& stepSeconds() const override { return spec_.seconds; }
    bool stepsAreAbsolute() const override { return false; }
    Result<std::vector<float>> values(std::size_t step) const override {
        ++reads;
        if (step == failing)
            return Error{"flood", "step cannot be read"};
        std::vector<float> out;
        for (int row = 0; row < spec_.rows; ++row)
            for (int column = 0; column < spec_.columns; ++column) {
                const glm::dvec2 p = place(column, row);
                out.push_back(float(spec_.water(p.x, p.y, int(step))));
            }
        return out;
    }
    bool hasVelocity() const override { return spec_.velocity; }
    Result<std::vector<glm::vec2>> velocities(std::size_t step) const override {
        return std::vector<glm::vec2>(geometry_.lonLat.size(), glm::vec2(1.0f, float(step)));
    }

    mutable int reads = 0;
    std::size_t failing = 1000;

  private:
    Spec spec_;
    glm::dvec2 metresPerDegree_{1.0};
    FloodGeometry geometry_;
};

} // namespace gnomon::test
