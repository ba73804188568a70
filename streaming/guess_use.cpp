#include "streaming/guess_use.h"

#include "streaming/flood/unstructured_hdf5_check.h"
#include "streaming/flood/unstructured_netcdf_header.h"
#include "streaming/terrain/gdal_quiet.h"

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace gnomon {

namespace {

std::string lowerCase(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

// The first of `words` that `text` holds. Short ones must stand alone: "wd" in "wd_max", not in
// "crowd".
std::optional<std::string_view> wordIn(const std::string& text,
                                       std::span<const std::string_view> words) {
    constexpr std::size_t kShort = 3;
    for (const std::string_view word : words)
        for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
            const auto isLetter = [&](std::size_t i) {
                return i < text.size() && std::isalpha(static_cast<unsigned char>(text[i])) != 0;
            };
            const bool alone = !(at > 0 && isLetter(at - 1)) && !isLetter(at + word.size());
            if (alone || word.size() > kShort)
                return word;
        }
    return std::nullopt;
}

using namespace std::string_view_literals;
constexpr std::array kDepthWords = {"depth"sv, "inund"sv, "wd"sv,    "hmax"sv,
                                    "tiefe"sv, "flood"sv, "hazard"sv};
constexpr std::array kStageWords = {"stage"sv, "waterlevel"sv, "water_level"sv, "wse"sv,
                                    "wsl"sv,   "zsmax"sv,      "zs"sv,          "wasserstand"sv};
constexpr std::array kTerrainWords = {"dem"sv,  "dtm"sv,  "dsm"sv,    "dom"sv,     "dgm"sv,
                                      "dhm"sv,  "topo"sv, "elev"sv,   "terrain"sv, "height"sv,
                                      "srtm"sv, "ahn"sv,  "ground"sv, "bathy"sv};
constexpr std::array kTreeWords = {"tree"sv,  "baum"sv,    "baeume"sv, "crown"sv,
                                   "krone"sv, "species"sv, "genus"sv};
constexpr std::array kLampWords = {"lamp"sv, "light"sv, "leuchte"sv, "lumen"sv, "lantern"sv};
constexpr std::array kBarrierWords = {"barrier"sv, "wall"sv,  "dyke"sv,   "dike"sv,
                                      "levee"sv,   "deich"sv, "sandbag"sv};

std::optional<RasterGuess> byWords(const std::string& text, const char* where) {
    const auto guess = [&](RasterUse use, std::string_view word) {
        return RasterGuess{use, std::string(where) + " says \"" + std::string(word) + "\""};
    };
    if (const auto word = wordIn(text, kTerrainWords))
        return guess(RasterUse::Terrain, *word);
    if (const auto word = wordIn(text, kStageWords))
        return guess(RasterUse::Stage, *word);
    if (const auto word = wordIn(text, kDepthWords))
        return guess(RasterUse::Depth, *word);
    return std::nullopt;
}

bool isPicture(GDALDataset& data) {
    GDALRasterBand* band = data.GetRasterBand(1);
    if (band->GetColorTable() != nullptr)
        return true;
    const bool isByte = band->GetRasterDataType() == GDT_Byte;
    return isByte || (data.GetRasterCount() >= 3 && data.GetRasterCount() <= 4 &&
                      band->GetColorInterpretation() == GCI_RedBand);
}

// Depths are nowhere negative and mostly nothing; heights of a place are seldom either. Looked at
// in small windows spread over the raster: a coarse picture would unpack all of it.
bool looksLikeDepth(GDALRasterBand& band) {
    constexpr int kWindows = 6, kAcross = 64, kDown = 8;
    constexpr double kDeepest = 60.0, kDryShare = 0.2;
    const int columns = std::min(band.GetXSize(), kAcross), rows = std::min(band.GetYSize(), kDown);
    std::vector<float> values(std::size_t(columns) * std::size_t(rows));
    int given = 0;
    const double none = band.GetNoDataValue(&given);
    std::size_t dry = 0, wet = 0;
    for (int i = 0; i < kWindows * kWindows; ++i) {
        const auto start = [](int size, int window, int k) {
            return int(std::int64_t(size - window) * k / (kWindows - 1));
        };
        if (band.RasterIO(GF_Read, start(band.GetXSize(), columns, i % kWindows),
                          start(band.GetYSize(), rows, i / kWindows), columns, rows, values.data(),
                          columns, rows, GDT_Float32, 0, 0, nullptr) != CE_None)
            return false;
        for (const float v : values) {
            const bool missing = !std::isfinite(v) || (given != 0 && v == float(none));
            if (!missing && (v < 0.0f || v > kDeepest))
                return false;
            (missing || v == 0.0f ? dry : wet) += 1;
        }
    }
    return wet > 0 && double(dry) > kDryShare * double(dry + wet);
}

// Damaged NetCDF and HDF5 files can hang or crash the libraries that read them.
Failure checkForLibraries(const std::string& path) {
    std::array<char, 4> head{};
    std::ifstream(path, std::ios::binary).read(head.data(), head.size());
    const std::string_view magic(head.data(), head.size());
    if (magic.starts_with("CDF"))
        return checkClassicNetCdf(path);
    if (magic == "\x89HDF")
        return checkHdf5(path);
    return {};
}

} // namespace

Result<RasterGuess> guessRasterUse(const std::string& path) {
    if (const Failure damaged = checkForLibraries(path))
        return *damaged;
    registerGdalDrivers();
    const GdalQuiet quiet;
    constexpr std::array kDrivers = {"GTiff",
                                     "AAIGrid",
                                     "netCDF",
                                     "SRTMHGT",
                                     "USGSDEM",
                                     "DTED",
                                     "HFA",
                                     "EHdr",
                                     "PNG",
                                     "JPEG",
                                     static_cast<const char*>(nullptr)};
    const GDALDatasetUniquePtr data(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data()));
    if (!data)
        return Error{path, "cannot be read as a raster: " + quiet.reason()};
    const std::string name = lowerCase(std::filesystem::path(path).stem().string());
    if (data->GetRasterCount() == 0) {
        // A NetCDF file of several variables: of a flood model, unless its name says terrain.
        if (const auto guess = byWords(name, "its name"))
            return *guess;
        return RasterGuess{RasterUse::Depth, "it holds several variables, as flood models write"};
    }
    if (isPicture(*data))
        return RasterGuess{RasterUse::Imagery, "it is a picture"};
    if (const auto guess = byWords(name, "its name"))
        return *guess;
    GDALRasterBand* band = data->GetRasterBand(1);
    if (const auto guess = byWords(lowerCase(band->GetDescription()), "its band"))
        return *guess;
    if (const char* variable = band->GetMetadataItem("NETCDF_VARNAME"))
        if (const auto guess = byWords(lowerCase(variable), "its variable"))
            return *guess;
    if (data->GetRasterCount() > 1)
        return RasterGuess{RasterUse::Depth, "it has a band for each of several steps"};
    if (looksLikeDepth(*band))
        return RasterGuess{RasterUse::Depth, "its values are nowhere negative and often nothing"};
    return RasterGuess{RasterUse::Terrain, "nothing says that it is anything else"};
}

Result<FeatureGuess> guessFeatureUse(const std::string& path) {
    const std::string name = lowerCase(std::filesystem::path(path).stem().string());
    const auto said = [](std::string_view word, const char* where) {
        return std::string(where) + " says \"" + std::string(word) + "\"";
    };
    if (const auto word = wordIn(name, kTreeWords))
        return FeatureGuess{FeatureUse::Trees, said(*word, "its name")};
    if (const auto word = wordIn(name, kLampWords))
        return FeatureGuess{FeatureUse::Lamps, said(*word, "its name")};
    if (const auto word = wordIn(name, kBarrierWords))
        return FeatureGuess{FeatureUse::Barriers, said(*word, "its name")};
    registerGdalDrivers();
    const GdalQuiet quiet;
    constexpr std::array kDrivers = {"GeoJSON",    "GeoJSONSeq",
                                     "GPKG",       "ESRI Shapefile",
                                     "FlatGeobuf", static_cast<const char*>(nullptr)};
    const GDALDatasetUniquePtr data(
        GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, kDrivers.data()));
    OGRLayer* layer = data && data->GetLayerCount() > 0 ? data->GetLayer(0) : nullptr;
    if (layer == nullptr)
        return Error{path, "cannot be read as features: " + quiet.reason()};
    const OGRFeatureUniquePtr first(layer->GetNextFeature());
    const OGRGeometry* geometry = first ? first->GetGeometryRef() : nullptr;
    if (geometry == nullptr)
        return Error{path, "holds no feature with a shape"};
    const int dimension = geometry->getDimension();
    if (dimension == 2)
        return FeatureGuess{FeatureUse::Buildings, "it holds areas"};
    if (dimension == 1)
        return FeatureGuess{FeatureUse::Barriers, "it holds lines"};
    const OGRFeatureDefn& fields = *layer->GetLayerDefn();
    for (int i = 0; i < fields.GetFieldCount(); ++i) {
        const std::string field = lowerCase(fields.GetFieldDefn(i)->GetNameRef());
        if (const auto word = wordIn(field, kTreeWords))
            return FeatureGuess{FeatureUse::Trees, said(*word, "a column")};
        if (const auto word = wordIn(field, kLampWords); word || field == "power")
            return FeatureGuess{FeatureUse::Lamps, said(word.value_or("power"), "a column")};
    }
    return Error{path, "holds points, of which nothing tells what they are; say trees=, lamps= or "
                       "stage= before its name"};
}

} // namespace gnomon
