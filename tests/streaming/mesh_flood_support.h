// Small results on meshes, written with libnetcdf or byte by byte into a folder of the test's own.
#pragma once

#include "streaming/flood/flood.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <netcdf.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
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

// A NetCDF file, by the calls that libnetcdf has; a call that fails stops the test.
class NetCdf {
  public:
    explicit NetCdf(const std::string& path, int format = NC_64BIT_OFFSET) {
        check(nc_create(path.c_str(), NC_CLOBBER | format, &file_));
    }
    ~NetCdf() { check(nc_close(file_)); }
    NetCdf(const NetCdf&) = delete;
    NetCdf& operator=(const NetCdf&) = delete;

    void dimension(const std::string& name, std::size_t size) {
        check(nc_def_dim(file_, name.c_str(), size, &dimensions_[name]));
        sizes_[name] = size;
    }
    void variable(const std::string& name, nc_type type, const std::vector<std::string>& over) {
        std::vector<int> ids;
        for (const std::string& dimension : over)
            ids.push_back(dimensions_.at(dimension));
        check(
            nc_def_var(file_, name.c_str(), type, int(ids.size()), ids.data(), &variables_[name]));
    }
    void text(const std::string& variable, const std::string& name, const std::string& value) {
        check(nc_put_att_text(file_, id(variable), name.c_str(), value.size(), value.data()));
    }
    void number(const std::string& variable, const std::string& name, double value,
                nc_type type = NC_DOUBLE) {
        check(nc_put_att_double(file_, id(variable), name.c_str(), type, 1, &value));
    }
    void endDefinition() { check(nc_enddef(file_)); }
    void put(const std::string& variable, const std::vector<double>& values) {
        check(nc_put_var_double(file_, variables_.at(variable), values.data()));
    }

  private:
    static void check(int status) {
        if (status != NC_NOERR)
            throw std::runtime_error(nc_strerror(status));
    }
    int id(const std::string& variable) const {
        return variable.empty() ? NC_GLOBAL : variables_.at(variable);
    }

    int file_ = -1;
    std::map<std::string, int> dimensions_, variables_;
    std::map<std::string, std::size_t> sizes_;
};

constexpr double kFill = -999.0;

// Faces of up to four corners over points, in UTM 33N near Venice; values are functions of place
// and step.
struct UgridSpec {
    std::vector<glm::dvec2> points;
    std::vector<std::vector<int>> faces;
    bool onFaces = true;
    int startIndex = 0;
    bool saysStartIndex = true;
    int steps = 2;
    std::string timeUnit = "seconds since 2020-02-28 12:00:00";
    std::vector<double> times; // 0, 3600, … when empty
    std::string crsAttribute = "EPSG_code", crs = "EPSG:32633";
    std::string stage = "mesh2d_s1", depth, bed = "mesh2d_flowelem_bl"; // empty: not written
    std::string heightUnit = "m";
    std::function<double(glm::dvec2, int)> level = [](glm::dvec2, int step) { return 2.0 + step; };
    std::function<double(glm::dvec2)> ground = [](glm::dvec2) { return 0.0; };
    std::function<glm::dvec2(glm::dvec2, int)> velocity; // not written when empty
    int format = NC_64BIT_OFFSET;
};

inline glm::dvec2 middleOf(const UgridSpec& spec, std::size_t face) {
    glm::dvec2 sum(0.0);
    for (const int corner : spec.faces[face])
        sum += spec.points[std::size_t(corner) % spec.points.size()];
    return sum / double(spec.faces[face].size());
}

// `columns` by `rows` squares; every third is cut into two triangles when `mixed`.
inline UgridSpec gridSpec(int columns, int rows, double side, bool mixed) {
    UgridSpec spec;
    for (int y = 0; y <= rows; ++y)
        for (int x = 0; x <= columns; ++x)
            spec.points.emplace_back(290000.0 + side * x, 5050000.0 + side * y);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            const int a = y * (columns + 1) + x, b = a + 1, c = b + columns + 1, d = c - 1;
            if (mixed && (x + y * columns) % 3 == 0) {
                spec.faces.push_back({a, b, c});
                spec.faces.push_back({a, c, d});
            } else {
                spec.faces.push_back({a, b, c, d});
            }
        }
    return spec;
}

inline void writeValues(NetCdf& file, const UgridSpec& spec) {
    std::vector<glm::dvec2> places = spec.points;
    if (spec.onFaces) {
        places.clear();
        for (std::size_t f = 0; f < spec.faces.size(); ++f)
            places.push_back(middleOf(spec, f));
    }
    std::vector<double> ground, level, depth, u, v, time = spec.times;
    for (const glm::dvec2 place : places)
        ground.push_back(spec.ground(place));
    for (int step = 0; step < spec.steps; ++step) {
        if (spec.times.empty())
            time.push_back(3600.0 * step);
        for (const glm::dvec2 place : places) {
            const double z = spec.level(place, step);
            level.push_back(std::isnan(z) ? kFill : z);
            depth.push_back(std::isnan(z) ? kFill : std::max(z - spec.ground(place), 0.0));
            const glm::dvec2 flow = spec.velocity ? spec.velocity(place, step) : glm::dvec2(0.0);
            u.push_back(flow.x);
            v.push_back(flow.y);
        }
    }
    if (!spec.bed.empty())
        file.put(spec.bed, ground);
    if (!spec.stage.empty())
        file.put(spec.stage, level);
    if (!spec.depth.empty())
        file.put(spec.depth, depth);
    if (spec.velocity) {
        file.put("mesh2d_ucx", u);
        file.put("mesh2d_ucy", v);
    }
    if (!spec.timeUnit.empty())
        file.put("time", time);
}

inline void writeUgrid(const std::string& path, const UgridSpec& spec) {
    NetCdf file(path, spec.format);
    file.dimension("time", std::size_t(spec.steps));
    file.dimension("mesh2d_nNodes", spec.points.size());
    file.dimension("mesh2d_nFaces", spec.faces.size());
    file.dimension("mesh2d_nMax", 4);
    const std::string place = spec.onFaces ? "mesh2d_nFaces" : "mesh2d_nNodes";
    file.variable("mesh2d", NC_INT, {});
    file.text("mesh2d", "cf_role", "mesh_topology");
    file.number("mesh2d", "topology_dimension", 2, NC_INT);
    file.text("mesh2d", "node_coordinates", "mesh2d_node_x mesh2d_node_y");
    file.text("mesh2d", "face_node_connectivity", "mesh2d_face_nodes");
    file.variable("mesh2d_node_x", NC_DOUBLE, {"mesh2d_nNodes"});
    file.variable("mesh2d_node_y", NC_DOUBLE, {"mesh2d_nNodes"});
    file.variable("mesh2d_face_nodes", NC_INT, {"mesh2d_nFaces", "mesh2d_nMax"});
    file.number("mesh2d_face_nodes", "_FillValue", kFill, NC_INT);
    if (spec.saysStartIndex)
        file.number("mesh2d_face_nodes", "start_index", spec.startIndex, NC_INT);
    if (!spec.timeUnit.empty()) {
        file.variable("time", NC_DOUBLE, {"time"});
        file.text("time", "units", spec.timeUnit);
    }
    const auto field = [&](const std::string& name, const std::vector<std::string>& over) {
        if (name.empty())
            return;
        file.variable(name, NC_FLOAT, over);
        file.number(name, "_FillValue", kFill, NC_FLOAT);
        file.text(name, "units", spec.heightUnit);
    };
    field(spec.bed, {place});
    field(spec.stage, {"time", place});
    field(spec.depth, {"time", place});
    if (spec.velocity) {
        field("mesh2d_ucx", {"time", place});
        field("mesh2d_ucy", {"time", place});
    }
    if (!spec.crsAttribute.empty()) {
        file.variable("projected_coordinate_system", NC_INT, {});
        file.text("projected_coordinate_system", spec.crsAttribute, spec.crs);
    }
    file.endDefinition();
    std::vector<double> x, y, corners;
    for (const glm::dvec2 point : spec.points) {
        x.push_back(point.x);
        y.push_back(point.y);
    }
    for (const std::vector<int>& face : spec.faces)
        for (std::size_t i = 0; i < 4; ++i)
            corners.push_back(i < face.size() ? face[i] + spec.startIndex : kFill);
    file.put("mesh2d_node_x", x);
    file.put("mesh2d_node_y", y);
    file.put("mesh2d_face_nodes", corners);
    writeValues(file, spec);
}

// What a reader finds when it adds up.
struct MeshSums {
    double cellArea = 0, triangleArea = 0, volume = 0, wetArea = 0, maxDepth = 0, lowest = 1e9,
           highest = -1e9;
    std::size_t wet = 0, rim = 0;
};

// Square metres by a sphere of the local radius: another way than the reader's.
inline double sphereArea(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
    constexpr double kRadians = 3.14159265358979323846 / 180.0, kA = 6378137.0,
                     kE2 = 0.0066943799901;
    const double s = std::sin(a.y * kRadians), w = std::sqrt(1.0 - kE2 * s * s);
    const double east = kA / w * std::cos(a.y * kRadians) * kRadians,
                 north = kA * (1.0 - kE2) / (w * w * w) * kRadians;
    return 0.5 * east * north * ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
}

inline MeshSums sumsOf(const FloodData& data, std::size_t step) {
    const FloodGeometry& geometry = data.geometry();
    MeshSums sums;
    for (const auto& t : geometry.triangles) {
        const double area =
            sphereArea(geometry.lonLat[t[0]], geometry.lonLat[t[1]], geometry.lonLat[t[2]]);
        EXPECT_GT(area, 0.0) << "a triangle is clockwise";
        sums.triangleArea += area;
    }
    const Result<std::vector<float>> values = data.values(step);
    if (!values) {
        ADD_FAILURE() << values.error().message();
        return sums;
    }
    EXPECT_EQ(values->size(), geometry.lonLat.size());
    for (std::size_t i = 0; i < values->size(); ++i) {
        sums.cellArea += geometry.cellArea[i];
        sums.rim += geometry.cellArea[i] == 0.0f;
        const double value = (*values)[i];
        if (!std::isfinite(value))
            continue;
        const double depth = data.kind() == WaterKind::Depth || geometry.bed.empty()
                                 ? value
                                 : value - geometry.bed[i];
        ++sums.wet;
        sums.lowest = std::min(sums.lowest, value);
        sums.highest = std::max(sums.highest, value);
        sums.maxDepth = std::max(sums.maxDepth, depth);
        sums.volume += depth * geometry.cellArea[i];
        sums.wetArea += depth > 0.01 ? double(geometry.cellArea[i]) : 0.0;
    }
    return sums;
}

inline std::string meshData(const std::string& name) {
    const char* given = std::getenv("GNOMON_DATA");
    const std::string folder = given != nullptr ? given : GNOMON_SOURCE_DIR "/../shared/data";
    return folder + "/flood-meshes/" + name;
}

} // namespace gnomon
