#include "streaming/terrain/raster_file.h"

#include "streaming/terrain/gdal_quiet.h"

#include <cpl_conv.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <mutex>
#include <span>

namespace gnomon {

namespace {

// What holds heights in one file. Left out are formats that lead on to other files or to a network
// (VRT, WMS and the like), whatever the user named.
constexpr std::array kDrivers = {
    "GTiff", "AAIGrid", "netCDF",         "SRTMHGT", "USGSDEM", "DTED",
    "HFA",   "EHdr",    "GRASSASCIIGrid", "XYZ",     "GSAG",    "GSBG",
    "GS7BG", "ENVI",    "SAGA",           "BT",      "RST",     "PCRaster",
    "ZMap",  "ISG",     "JP2OpenJPEG",    "PNG",     "GPKG",    static_cast<const char*>(nullptr)};

RasterHandle openDataset(const std::string& name) {
    return RasterHandle(
        GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data()));
}

bool allFinite(std::span<const double> values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

std::string lowerCase(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

// As one line, and no longer than a line is read.
std::string oneLine(const char* text) {
    constexpr std::size_t kLongest = 200;
    std::string line;
    for (const char* c = text; *c != 0 && line.size() < kLongest; ++c)
        line += static_cast<unsigned char>(*c) < ' ' ? ' ' : *c;
    return line;
}

// Metres in the unit a band names; none for a unit that is no length.
std::optional<double> metresPerUnit(const std::string& named) {
    const std::string unit = lowerCase(named);
    if (unit.empty() || unit == "m" || unit.starts_with("met"))
        return 1.0;
    if (unit == "us-ft" || unit.find("survey foot") != std::string::npos)
        return 1200.0 / 3937.0;
    if (unit == "ft" || unit == "foot" || unit == "feet")
        return 0.3048;
    if (unit == "cm" || unit.starts_with("centimet"))
        return 0.01;
    if (unit == "dm" || unit.starts_with("decimet"))
        return 0.1;
    if (unit == "mm" || unit.starts_with("millimet"))
        return 0.001;
    if (unit == "km" || unit.starts_with("kilomet"))
        return 1000.0;
    return std::nullopt;
}

// One variable of a file of several, as the file lists them.
struct Variable {
    std::string name, gdalName, description;
};

std::vector<Variable> variablesOf(GDALDataset& data) {
    std::vector<Variable> found;
    char** list = data.GetMetadata("SUBDATASETS");
    for (int i = 1;; ++i) {
        const std::string key = "SUBDATASET_" + std::to_string(i);
        const char* name = CSLFetchNameValue(list, (key + "_NAME").c_str());
        if (name == nullptr)
            return found;
        const char* text = CSLFetchNameValue(list, (key + "_DESC").c_str());
        const std::string gdalName = name;
        found.push_back({gdalName.substr(gdalName.find_last_of(":/") + 1), gdalName,
                         text != nullptr ? text : ""});
    }
}

bool saysGround(const Variable& variable) {
    const std::string text = lowerCase(variable.name + " " + variable.description);
    for (const char* word : {"altitude", "elevation", "bed_level", "bedlevel", "topography",
                             "bathymetry", "orography", "terrain", "dem"})
        if (text.find(word) != std::string::npos)
            return text.find("water") == std::string::npos;
    return false;
}

std::string listed(const std::vector<Variable>& variables) {
    constexpr std::size_t kMost = 12;
    std::string names;
    for (std::size_t i = 0; i < std::min(variables.size(), kMost); ++i)
        names += (i > 0 ? ", " : "") + variables[i].name;
    return oneLine((names + (variables.size() > kMost ? "…" : "")).c_str());
}

Result<std::string> pickVariable(const std::string& path, const std::vector<Variable>& variables,
                                 const RasterOptions& options, std::vector<std::string>& notes) {
    if (options.variable) {
        for (const Variable& variable : variables)
            if (variable.name == *options.variable)
                return variable.gdalName;
        return Error{path,
                     "has no variable '" + *options.variable + "'; it has " + listed(variables)};
    }
    const auto first = std::find_if(variables.begin(), variables.end(), saysGround);
    if (first == variables.end() ||
        std::find_if(first + 1, variables.end(), saysGround) != variables.end())
        return Error{path,
                     "holds several variables of which one must be named: " + listed(variables)};
    notes.push_back("of its " + std::to_string(variables.size()) + " variables '" + first->name +
                    "' was taken for the ground");
    return first->gdalName;
}

// Some NetCDF files place each pixel by itself, in variables `x` and `y` of the same size. Where
// they form a grid, that is its place.
std::optional<std::array<double, 6>> transformFromPlaces(const std::vector<Variable>& variables,
                                                         int width, int height) {
    if (width < 2 || height < 2)
        return std::nullopt;
    std::array<std::vector<double>, 2> places;
    for (int axis = 0; axis < 2; ++axis) {
        const auto it = std::find_if(variables.begin(), variables.end(), [&](const Variable& v) {
            return v.name == (axis == 0 ? "x" : "y");
        });
        const RasterHandle data = it == variables.end() ? nullptr : openDataset(it->gdalName);
        if (!data || data->GetRasterXSize() != width || data->GetRasterYSize() != height ||
            data->GetRasterCount() != 1)
            return std::nullopt;
        auto& out = places[std::size_t(axis)];
        out.resize(std::size_t(width) * std::size_t(height));
        if (data->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, width, height, out.data(), width,
                                             height, GDT_Float64, 0, 0, nullptr) != CE_None)
            return std::nullopt;
    }
    const auto place = [&](int c, int r) {
        const std::size_t i = std::size_t(r) * std::size_t(width) + std::size_t(c);
        return glm::dvec2(places[0][i], places[1][i]);
    };
    const glm::dvec2 corner = place(0, 0);
    const glm::dvec2 across = (place(width - 1, 0) - corner) / double(width - 1);
    const glm::dvec2 down = (place(0, height - 1) - corner) / double(height - 1);
    // Coordinates in float are good to half a metre at worst; pixels are many metres wide then.
    constexpr double kSlackPixels = 0.02;
    const double side = std::sqrt(std::abs(across.x * down.y - across.y * down.x));
    for (int r = 0; r < height; ++r)
        for (int c = 0; c < width; ++c) {
            const glm::dvec2 off = place(c, r) - corner - double(c) * across - double(r) * down;
            if (!(std::max(std::abs(off.x), std::abs(off.y)) <= kSlackPixels * side))
                return std::nullopt;
        }
    const glm::dvec2 outer = corner - 0.5 * across - 0.5 * down;
    return std::array{outer.x, across.x, down.x, outer.y, across.y, down.y};
}

Failure describeBand(RasterFile& file, GDALDataset& data, const RasterOptions& options) {
    file.width = data.GetRasterXSize();
    file.height = data.GetRasterYSize();
    file.bands = data.GetRasterCount();
    if (file.bands == 0)
        return Error{file.path, "holds no raster"};
    if (file.bands > 1 && !options.severalBands)
        return Error{file.path,
                     "has " + std::to_string(file.bands) +
                         " bands; heights have one (a picture goes on terrain with drape=)"};
    GDALRasterBand& band = *data.GetRasterBand(1);
    if (GDALDataTypeIsComplex(band.GetRasterDataType()))
        return Error{file.path, "holds complex numbers, not heights"};
    if (band.GetColorTable() != nullptr)
        return Error{file.path, "is a picture with a palette, not heights"};
    std::optional<double> metres = metresPerUnit(band.GetUnitType());
    if (!metres && !options.anyUnit)
        return Error{file.path, "its values are in '" + oneLine(band.GetUnitType()) +
                                    "', not in a unit of length"};
    int given = 0;
    const double none = band.GetNoDataValue(&given);
    if (given != 0)
        file.noData = none;
    file.scale = metres.value_or(1.0) * band.GetScale();
    file.offset = metres.value_or(1.0) * band.GetOffset();
    if (!std::isfinite(file.scale) || !std::isfinite(file.offset) || file.scale == 0.0)
        return Error{file.path, "its scale or offset is no number that can be used"};
    band.GetBlockSize(&file.blockSize.x, &file.blockSize.y);
    return {};
}

void findOverviews(RasterFile& file, GDALDataset& data) {
    GDALRasterBand& band = *data.GetRasterBand(1);
    for (int i = 0; i < band.GetOverviewCount(); ++i) {
        GDALRasterBand* overview = band.GetOverview(i);
        if (overview == nullptr || overview->GetXSize() < 2 || overview->GetYSize() < 2)
            continue;
        const glm::ivec2 size(overview->GetXSize(), overview->GetYSize());
        const int factor = int(std::lround(double(file.width) / size.x));
        if (factor < 2 || (!file.overviewFactors.empty() && factor <= file.overviewFactors.back()))
            continue;
        file.overviewFactors.push_back(factor);
        file.overviewIndex.push_back(i);
        file.overviewSizes.push_back(size);
    }
}

Failure findPlace(RasterFile& file, GDALDataset& data, const std::vector<Variable>& variables) {
    if (data.GetGeoTransform(file.transform.data()) != CE_None) {
        const auto grid = transformFromPlaces(variables, file.width, file.height);
        if (!grid)
            return Error{file.path,
                         "does not say where its corner lies and how wide its pixels are"};
        file.transform = *grid;
    }
    const auto& t = file.transform;
    const double across = t[1] * t[5] - t[2] * t[4];
    if (!allFinite(t) || !std::isfinite(across) || across == 0.0)
        return Error{file.path, "its pixels have no width, or its corner lies nowhere"};
    return {};
}

void findCrs(RasterFile& file, GDALDataset& data) {
    const OGRSpatialReference* reference = data.GetSpatialRef();
    if (reference == nullptr || reference->IsEmpty())
        return;
    char* text = nullptr;
    const std::array<const char*, 2> options = {"FORMAT=WKT2_2019", nullptr};
    if (reference->exportToWkt(&text, options.data()) == OGRERR_NONE && text != nullptr)
        file.crs = text;
    CPLFree(text);
    const char* authority = reference->GetAuthorityName(nullptr);
    const char* code = reference->GetAuthorityCode(nullptr);
    const char* name = reference->GetName();
    const char* zone = reference->GetAttrValue("PROJECTION") != nullptr
                           ? reference->GetAttrValue("CONVERSION")
                           : nullptr;
    file.crsName = authority != nullptr && code != nullptr ? std::string(authority) + ":" + code
                   : name != nullptr && std::string(name) != "unnamed" ? oneLine(name)
                   : zone != nullptr                                   ? oneLine(zone)
                                                                       : "unnamed";
    // Projections written down without a number often are one that has a number.
    if (authority == nullptr) {
        OGRSpatialReference known(*reference);
        if (known.AutoIdentifyEPSG() == OGRERR_NONE && known.GetAuthorityCode(nullptr) != nullptr)
            file.crsName = std::string("EPSG:") + known.GetAuthorityCode(nullptr);
    }
}

void findCredits(RasterFile& file, GDALDataset& data) {
    for (const char* key : {"TIFFTAG_COPYRIGHT", "COPYRIGHT", "ATTRIBUTION", "CREDIT",
                            "NC_GLOBAL#copyright", "NC_GLOBAL#attribution", "NC_GLOBAL#credit"})
        if (const char* text = data.GetMetadataItem(key); text != nullptr && *text != 0) {
            const std::string line = oneLine(text);
            if (std::find(file.credits.begin(), file.credits.end(), line) == file.credits.end())
                file.credits.push_back(line);
        }
}

} // namespace

void RasterClose::operator()(GDALDataset* data) const {
    GDALClose(data);
}

RasterHandle RasterFile::openAgain() const {
    const GdalQuiet quiet;
    return openDataset(name);
}

Result<OpenedRaster> openRasterFile(const std::string& path, const RasterOptions& options) {
    registerGdalDrivers();
    const GdalQuiet quiet;
    OpenedRaster opened;
    RasterFile& file = opened.file;
    file.path = file.name = path;
    opened.data = openDataset(path);
    if (!opened.data)
        return Error{path, "cannot be read as a raster: " + quiet.reason()};
    const std::vector<Variable> variables = variablesOf(*opened.data);
    if (!variables.empty() && (options.variable || opened.data->GetRasterCount() == 0)) {
        const Result<std::string> picked = pickVariable(path, variables, options, file.notes);
        if (!picked)
            return picked.error();
        file.name = *picked;
        opened.data = openDataset(file.name);
        if (!opened.data)
            return Error{path, "its variable cannot be read as a raster: " + quiet.reason()};
    }
    GDALDataset& data = *opened.data;
    if (const Failure wrong = describeBand(file, data, options))
        return *wrong;
    if (const Failure wrong = findPlace(file, data, variables))
        return *wrong;
    findOverviews(file, data);
    findCrs(file, data);
    findCredits(file, data);
    return opened;
}

} // namespace gnomon
