// Rasters made up for tests, where their pixels are by GDAL's own reckoning, and the triangles of
// terrain's tiles taken apart.
#pragma once

#include "geo/ellipsoid.h"
#include "streaming/content_maker.h"
#include "streaming/terrain/terrain.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace gnomon::test {

inline constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

struct Heights2d {
    int width = 0, height = 0;
    std::vector<float> values; // NaN: none

    Heights2d(int w, int h, const std::function<double(int, int)>& at) : width(w), height(h) {
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x)
                values.push_back(float(at(x, y)));
    }
    float at(int x, int y) const {
        return values[std::size_t(y) * std::size_t(width) + std::size_t(x)];
    }
};

// Hills with steps and noise on them: what levels of detail lose.
inline Heights2d roughHills(int w, int h, unsigned seed = 1) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> noise(-0.3, 0.3);
    return {w, h, [&](int x, int y) {
                const double house = (x / 17 + y / 13) % 5 == 0 ? 8.0 : 0.0;
                return 120.0 + 15.0 * std::sin(0.031 * x) * std::cos(0.023 * y) + house +
                       noise(random);
            }};
}

struct RasterLook {
    int epsg = 25832;   // 0: none
    std::string proj{}; // in place of epsg
    std::array<double, 6> transform{356000, 1, 0, 5700000, 0, -1};
    std::string unit{};
    double scale = 1.0, offset = 0.0;
    std::string copyright{};
    bool tiled = false, overviews = false;
    GDALDataType type = GDT_Float32;
    int bands = 1;
};

// In GDAL's own memory; the name to open it by. NaN is written as -9999, the file's "no data".
inline std::string writeRaster(const std::string& name, const Heights2d& heights,
                               const RasterLook& look = {}) {
    GDALAllRegister();
    const std::string path = "/vsimem/" + name + ".tif";
    char** options = look.tiled ? CSLSetNameValue(nullptr, "TILED", "YES") : nullptr;
    auto* data = GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        path.c_str(), heights.width, heights.height, look.bands, look.type, options);
    CSLDestroy(options);
    auto transform = look.transform;
    data->SetGeoTransform(transform.data());
    if (look.epsg != 0 || !look.proj.empty()) {
        OGRSpatialReference reference;
        if (look.proj.empty())
            reference.importFromEPSG(look.epsg);
        else
            reference.importFromProj4(look.proj.c_str());
        data->SetSpatialRef(&reference);
    }
    if (!look.copyright.empty())
        data->SetMetadataItem("TIFFTAG_COPYRIGHT", look.copyright.c_str());
    std::vector<float> values = heights.values;
    std::replace_if(
        values.begin(), values.end(), [](float v) { return std::isnan(v); }, -9999.0f);
    for (int b = 1; b <= look.bands; ++b) {
        GDALRasterBand* band = data->GetRasterBand(b);
        band->SetNoDataValue(-9999.0);
        if (!look.unit.empty())
            band->SetUnitType(look.unit.c_str());
        if (look.scale != 1.0 || look.offset != 0.0) {
            band->SetScale(look.scale);
            band->SetOffset(look.offset);
        }
        EXPECT_EQ(band->RasterIO(GF_Write, 0, 0, heights.width, heights.height, values.data(),
                                 heights.width, heights.height, GDT_Float32, 0, 0, nullptr),
                  CE_None);
    }
    if (look.overviews) {
        const std::array factors{2, 4, 8, 16};
        EXPECT_EQ(data->BuildOverviews("AVERAGE", int(factors.size()), factors.data(), 0, nullptr,
                                       nullptr, nullptr),
                  CE_None);
    }
    GDALClose(data);
    return path;
}

// Longitude, latitude of positions in a system, by GDAL's own transformation, and back.
class GdalPlaces {
  public:
    explicit GdalPlaces(const RasterLook& look) : look_(look) {
        OGRSpatialReference from, to;
        if (look.proj.empty())
            from.importFromEPSG(look.epsg);
        else
            from.importFromProj4(look.proj.c_str());
        to.importFromEPSG(4326);
        from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
        forward_.reset(OGRCreateCoordinateTransformation(&from, &to));
        back_.reset(OGRCreateCoordinateTransformation(&to, &from));
    }
    // Whole numbers are pixels' centres.
    glm::dvec2 lonLat(double column, double row) const {
        const auto& t = look_.transform;
        double x = t[0] + (column + 0.5) * t[1] + (row + 0.5) * t[2];
        double y = t[3] + (column + 0.5) * t[4] + (row + 0.5) * t[5];
        EXPECT_TRUE(forward_->Transform(1, &x, &y));
        return {x, y};
    }
    glm::dvec2 pixel(glm::dvec2 lonLat) const {
        double x = lonLat.x, y = lonLat.y;
        EXPECT_TRUE(back_->Transform(1, &x, &y));
        const auto& t = look_.transform;
        const double across = t[1] * t[5] - t[2] * t[4];
        x -= t[0], y -= t[3];
        return {(x * t[5] - y * t[2]) / across - 0.5, (y * t[1] - x * t[4]) / across - 0.5};
    }
    Point<Ecef> ecef(double column, double row, double height) const {
        const glm::dvec2 p = lonLat(column, row);
        return ecefOf({p.x, p.y, height});
    }

  private:
    RasterLook look_;
    std::unique_ptr<OGRCoordinateTransformation> forward_, back_;
};

inline std::shared_ptr<const Terrain> openTerrain(const std::string& path,
                                                  const TerrainOptions& options = {}) {
    auto terrain = Terrain::open(path, options);
    EXPECT_TRUE(terrain) << (terrain ? "" : terrain.error().message());
    return terrain ? *terrain : nullptr;
}

inline std::string whyNot(const std::string& path, const TerrainOptions& options = {}) {
    const auto terrain = Terrain::open(path, options);
    EXPECT_FALSE(terrain);
    return terrain ? "" : terrain.error().message();
}

// "level/x/y".
struct TileId {
    int level = 0, x = 0, y = 0;
    bool operator==(const TileId&) const = default;
    auto operator<=>(const TileId&) const = default;
};
inline TileId idOf(const std::string& path) {
    TileId id;
    EXPECT_EQ(std::sscanf(path.c_str(), "%d/%d/%d", &id.level, &id.x, &id.y), 3) << path;
    return id;
}

// All tiles, also those told only when asked for.
inline std::vector<MadeTile> allTiles(const MadeTileset& made) {
    std::vector<MadeTile> out;
    for (const MadeTile& tile : made.tiles) {
        if (tile.content != ContentKind::ExternalTileset) {
            out.push_back(tile);
            continue;
        }
        const auto below = made.maker->below(tile.path);
        EXPECT_TRUE(below) << (below ? "" : below.error().message());
        if (below)
            for (const MadeTile& more : allTiles({*below, made.maker}))
                if (more.content == ContentKind::Mesh)
                    out.push_back(more);
    }
    return out;
}

inline TileContent contentOf(const MadeTileset& made, const std::string& path,
                             const DecodeOptions& options = {}) {
    auto content = made.maker->make(path, options);
    EXPECT_TRUE(content) << (content ? "" : content.error().message());
    return content ? std::move(*content) : TileContent{};
}

inline Point<Ecef> vertexOf(const Mesh& mesh, std::uint32_t v,
                            const glm::dmat3& axes = glm::dmat3(1.0)) {
    return {mesh.origin.xyz + axes * glm::dvec3(mesh.positions[v])};
}

// What casts: no skirts.
struct Triangles {
    std::vector<std::array<glm::dvec3, 3>> all;

    void add(const TileContent& content, const glm::dmat3& axes = glm::dmat3(1.0)) {
        for (const Mesh& mesh : content.meshes)
            for (std::uint32_t i = 0; i < mesh.castingTriangles(); ++i) {
                std::array<glm::dvec3, 3> t;
                for (std::size_t k = 0; k < 3; ++k)
                    t[k] = vertexOf(mesh, mesh.indices[3 * std::size_t(i) + k], axes).xyz;
                all.push_back(t);
            }
    }
};

inline std::filesystem::path dataFolder() {
    const char* given = std::getenv("GNOMON_DATA");
    return given != nullptr ? std::filesystem::path(given)
                            : std::filesystem::path(GNOMON_SOURCE_DIR) / "../shared/data";
}

} // namespace gnomon::test
