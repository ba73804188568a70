#include "streaming/flood/point_flood_table.h"

#include "streaming/flood/lower_case.h"
#include "streaming/terrain/gdal_quiet.h"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <limits>

namespace gnomon {

namespace {

// Gauges and marks are seen by people: a larger table is something else.
constexpr std::uintmax_t kMostBytes = 16u << 20;

std::string trimmed(std::string_view text) {
    constexpr std::string_view kSpace = " \t\r\n";
    const std::size_t from = text.find_first_not_of(kSpace);
    if (from == std::string_view::npos)
        return {};
    return std::string(text.substr(from, text.find_last_not_of(kSpace) - from + 1));
}

std::string shortened(const std::string& text) {
    constexpr std::size_t kLongest = 40;
    std::string line;
    for (const char c : text.substr(0, kLongest))
        line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    return line;
}

std::optional<double> numberIn(const std::string& cell) {
    double value = 0.0;
    const char* end = cell.data() + cell.size();
    const auto [at, wrong] = std::from_chars(cell.data(), end, value);
    if (wrong != std::errc() || at != end || !std::isfinite(value))
        return std::nullopt;
    return value;
}

// Of one line; commas within quotes do not part.
std::vector<std::string> cellsOf(const std::string& line, char separator) {
    std::vector<std::string> cells;
    std::string cell;
    bool quoted = false;
    for (const char c : line) {
        if (c == '"') {
            quoted = !quoted;
        } else if (c == separator && !quoted) {
            cells.push_back(trimmed(cell));
            cell.clear();
        } else {
            cell += c;
        }
    }
    cells.push_back(trimmed(cell));
    return cells;
}

char separatorOf(const std::string& header) {
    char best = ',';
    for (const char c : {';', '\t'})
        if (std::count(header.begin(), header.end(), c) >
            std::count(header.begin(), header.end(), best))
            best = c;
    return best;
}

std::optional<std::size_t> named(const std::vector<std::string>& columns,
                                 std::initializer_list<const char*> names) {
    for (const char* name : names)
        for (std::size_t i = 0; i < columns.size(); ++i)
            if (lower(columns[i]) == name)
                return i;
    return std::nullopt;
}

struct PlaceColumns {
    std::size_t x = 0, y = 0;
    bool degrees = false;
};

std::optional<PlaceColumns> placeColumns(const std::vector<std::string>& columns) {
    const auto x = named(columns, {"x", "easting", "east", "x_coord", "xcoord", "point_x"});
    const auto y = named(columns, {"y", "northing", "north", "y_coord", "ycoord", "point_y"});
    if (x && y)
        return PlaceColumns{*x, *y, false};
    const auto lon = named(columns, {"lon", "longitude", "long", "lng"});
    const auto lat = named(columns, {"lat", "latitude"});
    if (lon && lat)
        return PlaceColumns{*lon, *lat, true};
    return std::nullopt;
}

bool speaksOfWater(const std::string& column) {
    const std::string name = lower(column);
    for (const char* word : {"stage", "level", "wse", "wsl", "depth", "pegel", "wasserstand"})
        if (name.find(word) != std::string::npos)
            return true;
    return name == "wl" || name == "h" || name == "z";
}

std::string listed(const std::vector<std::string>& columns) {
    constexpr std::size_t kMost = 12;
    std::string names;
    for (std::size_t i = 0; i < std::min(columns.size(), kMost); ++i)
        names += (i > 0 ? ", '" : "'") + shortened(columns[i]) + "'";
    return names + (columns.size() > kMost ? ", …" : "");
}

bool startsWithStage(const std::string& column) {
    return lower(column).starts_with("stage");
}

// The one asked for by its name or a part of it; of several that of a stage; else the first that
// sounds like a level.
Result<std::size_t> valueColumn(const std::string& path, const std::vector<std::string>& columns,
                                const FloodOptions& options, std::vector<std::string>& notes) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        if (options.variable && lower(columns[i]) == lower(*options.variable))
            return i;
        const bool fits =
            options.variable ? lower(columns[i]).find(lower(*options.variable)) != std::string::npos
                             : speaksOfWater(columns[i]);
        if (fits)
            found.push_back(i);
    }
    if (found.empty())
        return Error{path, (options.variable
                                ? "has no column '" + shortened(*options.variable) + "'; it has "
                                : std::string("which of its columns is the level? "
                                              "It has ")) +
                               listed(columns)};
    std::vector<std::size_t> stages;
    for (const std::size_t i : found)
        if (startsWithStage(columns[i]))
            stages.push_back(i);
    const std::vector<std::size_t>& of = stages.empty() ? found : stages;
    if (of.size() > 1 && options.variable) {
        std::vector<std::string> names;
        for (const std::size_t i : of)
            names.push_back(columns[i]);
        return Error{path, "'" + shortened(*options.variable) + "' is part of the names of " +
                               std::to_string(of.size()) + " columns: " + listed(names)};
    }
    if (!options.variable || found.size() > 1)
        notes.push_back("of its columns '" + shortened(columns[of.front()]) + "' is shown");
    return of.front();
}

std::optional<std::string> readText(const std::string& path) {
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(path, failed);
    if (failed || bytes > kMostBytes)
        return std::nullopt;
    std::ifstream file(path, std::ios::binary);
    std::string text(std::size_t(bytes), '\0');
    file.read(text.data(), std::streamsize(bytes));
    if (file.gcount() != std::streamsize(bytes))
        return std::nullopt;
    if (text.starts_with("\xef\xbb\xbf"))
        text.erase(0, 3);
    return text;
}

std::string takeLine(const std::string& text, std::size_t& at) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at);
    at = end + 1;
    return line;
}

bool isCsv(const std::string& path) {
    const std::string ending = lower(std::filesystem::path(path).extension().string());
    return ending == ".csv" || ending == ".txt" || ending == ".tsv";
}

bool isFeatures(const std::string& path) {
    const std::string ending = lower(std::filesystem::path(path).extension().string());
    return ending == ".geojson" || ending == ".json" || ending == ".shp" || ending == ".gpkg";
}

void sayLeftOut(std::size_t rows, LevelTable& table) {
    if (rows > 0)
        table.notes.push_back(std::to_string(rows) + (rows == 1 ? " row has" : " rows have") +
                              " no place or no number in '" + shortened(table.column) +
                              "' and stay out");
}

Result<LevelTable> readCsv(const std::string& path, const FloodOptions& options) {
    const auto text = readText(path);
    if (!text)
        return Error{path, "cannot be read as a table of points"};
    std::size_t at = 0;
    const std::string header = takeLine(*text, at);
    const char separator = separatorOf(header);
    const std::vector<std::string> columns = cellsOf(header, separator);
    const auto place = placeColumns(columns);
    if (!place)
        return Error{path, "its first line names no columns for the place (x and y, or lon and "
                           "lat): it has " +
                               listed(columns)};
    LevelTable table;
    const Result<std::size_t> value = valueColumn(path, columns, options, table.notes);
    if (!value)
        return value.error();
    table.column = columns[*value];
    if (place->degrees)
        table.crs = "EPSG:4326";
    const auto id = named(columns, {"id", "name", "point", "gauge", "station"});
    std::size_t leftOut = 0, row = 0;
    while (at < text->size()) {
        const std::string line = takeLine(*text, at);
        if (trimmed(line).empty())
            continue;
        ++row;
        const std::vector<std::string> cells = cellsOf(line, separator);
        const auto cell = [&](std::size_t i) {
            return i < cells.size() ? numberIn(cells[i]) : std::nullopt;
        };
        const auto x = cell(place->x), y = cell(place->y), v = cell(*value);
        if (!x || !y || !v) {
            ++leftOut;
            continue;
        }
        const bool hasName = id && *id < cells.size() && !cells[*id].empty();
        table.points.push_back(
            {{*x, *y}, *v, hasName ? shortened(cells[*id]) : std::to_string(row)});
    }
    sayLeftOut(leftOut, table);
    return table;
}

GDALDatasetUniquePtr openFeatures(const std::string& path) {
    registerGdalDrivers();
    constexpr std::array kDrivers = {"GeoJSON", "ESRI Shapefile", "GPKG",
                                     static_cast<const char*>(nullptr)};
    return GDALDatasetUniquePtr(
        GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, kDrivers.data()));
}

std::string wellKnownText(const OGRSpatialReference* reference) {
    char* text = nullptr;
    constexpr const char* kOptions[] = {"FORMAT=WKT2_2019", nullptr};
    std::string out;
    if (reference != nullptr && reference->exportToWkt(&text, kOptions) == OGRERR_NONE &&
        text != nullptr)
        out = text;
    CPLFree(text);
    return out;
}

// The last of the columns is the points' own height.
constexpr const char* kOwnHeight = "the points' own height";

Result<LevelTable> readFeatures(const std::string& path, const FloodOptions& options) {
    const GdalQuiet quiet;
    const GDALDatasetUniquePtr data = openFeatures(path);
    OGRLayer* layer = data && data->GetLayerCount() > 0 ? data->GetLayer(0) : nullptr;
    if (layer == nullptr)
        return Error{path, "cannot be read as points: " + quiet.reason()};
    std::vector<std::string> columns;
    const OGRFeatureDefn* fields = layer->GetLayerDefn();
    for (int i = 0; i < fields->GetFieldCount(); ++i)
        columns.emplace_back(fields->GetFieldDefn(i)->GetNameRef());
    LevelTable table;
    Result<std::size_t> value = valueColumn(path, columns, options, table.notes);
    const bool own = !value && !options.variable && OGR_GT_HasZ(layer->GetGeomType()) != 0;
    if (!value && !own)
        return value.error();
    table.column = own ? kOwnHeight : columns[*value];
    if (const std::string crs = wellKnownText(layer->GetSpatialRef()); !crs.empty())
        table.crs = crs;
    const auto id = named(columns, {"id", "name", "point", "gauge", "station"});
    std::size_t leftOut = 0;
    layer->ResetReading();
    while (const OGRFeatureUniquePtr feature{layer->GetNextFeature()}) {
        const OGRGeometry* geometry = feature->GetGeometryRef();
        const bool isPoint = geometry != nullptr &&
                             wkbFlatten(geometry->getGeometryType()) == wkbPoint &&
                             !geometry->IsEmpty();
        const bool set = own || feature->IsFieldSetAndNotNull(int(*value));
        if (!isPoint || !set) {
            ++leftOut;
            continue;
        }
        const OGRPoint* point = geometry->toPoint();
        const double v = own ? point->getZ() : feature->GetFieldAsDouble(int(*value));
        if (!std::isfinite(v) || !std::isfinite(point->getX()) || !std::isfinite(point->getY())) {
            ++leftOut;
            continue;
        }
        const std::string name = id ? trimmed(feature->GetFieldAsString(int(*id))) : "";
        table.points.push_back(
            {{point->getX(), point->getY()},
             v,
             name.empty() ? std::to_string(table.points.size() + leftOut + 1) : shortened(name)});
    }
    sayLeftOut(leftOut, table);
    return table;
}

} // namespace

bool looksLikeLevelTable(const std::string& path) {
    if (isCsv(path)) {
        const auto text = readText(path);
        std::size_t at = 0;
        if (!text)
            return false;
        const std::string header = takeLine(*text, at);
        return placeColumns(cellsOf(header, separatorOf(header))).has_value();
    }
    if (!isFeatures(path))
        return false;
    const GdalQuiet quiet;
    const GDALDatasetUniquePtr data = openFeatures(path);
    return data && data->GetLayerCount() > 0;
}

Result<LevelTable> readLevelTable(const std::string& path, const FloodOptions& options) {
    Result<LevelTable> table = isCsv(path) ? readCsv(path, options) : readFeatures(path, options);
    if (table && table->points.empty())
        return Error{path, "holds no point with a number in '" + shortened(table->column) + "'"};
    return table;
}

} // namespace gnomon
