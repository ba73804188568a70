#include "streaming/terrain/raster.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cmath>
#include <limits>
#include <mutex>
#include <span>

namespace gnomon {

namespace {

// What holds heights in one file. Left out are formats that lead on to other files or to a network
// (VRT, WMS and the like), whatever the user named.
constexpr std::array kDrivers = {"GTiff",   "AAIGrid", "netCDF",
                                 "SRTMHGT", "USGSDEM", "DTED",
                                 "HFA",     "EHdr",    static_cast<const char*>(nullptr)};

// While it lives, GDAL says nothing on this thread; its first error is kept.
class Quiet {
  public:
    Quiet() { CPLPushErrorHandlerEx(&Quiet::take, &said_); }
    ~Quiet() { CPLPopErrorHandler(); }
    Quiet(const Quiet&) = delete;
    Quiet& operator=(const Quiet&) = delete;

    std::string reason() const {
        constexpr std::size_t kLongest = 300;
        std::string line;
        for (const char c : said_.substr(0, kLongest))
            line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
        return line.empty() ? "GDAL gives no reason" : line;
    }

  private:
    static void take(CPLErr severity, CPLErrorNum, const char* text) {
        auto& said = *static_cast<std::string*>(CPLGetErrorHandlerUserData());
        if (severity >= CE_Failure && said.empty() && text != nullptr)
            said = text;
    }
    std::string said_;
};

void registerDrivers() {
    static std::once_flag once;
    std::call_once(once, [] { GDALAllRegister(); });
}

bool allFinite(std::span<const double> values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

// Metres in the unit a band names; none for a unit that is no length.
std::optional<double> metresPerUnit(std::string unit) {
    std::transform(unit.begin(), unit.end(), unit.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    if (unit.empty() || unit == "m" || unit.starts_with("met"))
        return 1.0;
    if (unit == "us-ft" || unit.find("survey foot") != std::string::npos)
        return 1200.0 / 3937.0;
    if (unit == "ft" || unit == "foot" || unit == "feet")
        return 0.3048;
    if (unit == "cm")
        return 0.01;
    return std::nullopt;
}

} // namespace

struct Raster::State {
    std::string path;
    std::unique_ptr<GDALDataset> data;
    GDALRasterBand* band = nullptr;
    std::array<double, 6> transform{};
    std::optional<std::string> crs;
    std::string crsName;
    std::optional<double> noData;
    double scale = 1.0, offset = 0.0;

    Failure describe();
    Failure findPlace();
};

Raster::Raster(std::unique_ptr<State> state) : state_(std::move(state)) {}
Raster::Raster(Raster&&) noexcept = default;
Raster& Raster::operator=(Raster&&) noexcept = default;
Raster::~Raster() {
    const Quiet quiet; // closing may complain
    state_.reset();
}

Failure Raster::State::describe() {
    const int bands = data->GetRasterCount();
    if (bands == 0)
        return Error{path, "holds no raster, or several variables of which one must be picked, "
                           "which cannot be done yet"};
    if (bands > 1)
        return Error{path, "has " + std::to_string(bands) +
                               " bands; heights have one (pictures cannot be opened yet)"};
    band = data->GetRasterBand(1);
    if (GDALDataTypeIsComplex(band->GetRasterDataType()))
        return Error{path, "holds complex numbers, not heights"};
    if (band->GetColorTable() != nullptr)
        return Error{path, "is a picture with a palette, not heights"};
    const std::optional<double> metres = metresPerUnit(band->GetUnitType());
    if (!metres)
        return Error{path, std::string("its values are in '") + band->GetUnitType() +
                               "', not in a unit of length"};
    int given = 0;
    const double none = band->GetNoDataValue(&given);
    if (given != 0)
        noData = none;
    scale = *metres * band->GetScale();
    offset = *metres * band->GetOffset();
    if (!std::isfinite(scale) || !std::isfinite(offset) || scale == 0.0)
        return Error{path, "its scale or offset is no number that can be used"};
    return findPlace();
}

Failure Raster::State::findPlace() {
    if (data->GetGeoTransform(transform.data()) != CE_None)
        return Error{path, "does not say where its corner lies and how wide its pixels are"};
    const double across = transform[1] * transform[5] - transform[2] * transform[4];
    if (!allFinite(transform) || !std::isfinite(across) || across == 0.0)
        return Error{path, "its pixels have no width, or its corner lies nowhere"};
    const OGRSpatialReference* reference = data->GetSpatialRef();
    if (reference == nullptr || reference->IsEmpty())
        return {};
    char* text = nullptr;
    const std::array<const char*, 2> options = {"FORMAT=WKT2_2019", nullptr};
    if (reference->exportToWkt(&text, options.data()) == OGRERR_NONE && text != nullptr)
        crs = text;
    CPLFree(text);
    const char* authority = reference->GetAuthorityName(nullptr);
    const char* code = reference->GetAuthorityCode(nullptr);
    const char* name = reference->GetName();
    crsName = authority != nullptr && code != nullptr ? std::string(authority) + ":" + code
              : name != nullptr                       ? name
                                                      : "";
    return {};
}

Result<Raster> Raster::open(const std::string& path) {
    registerDrivers();
    Quiet quiet;
    auto state = std::make_unique<State>();
    state->path = path;
    state->data.reset(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data()));
    if (!state->data)
        return Error{path, "cannot be read as a raster: " + quiet.reason()};
    if (Failure wrong = state->describe())
        return *wrong;
    return Raster(std::move(state));
}

int Raster::width() const {
    return state_->data->GetRasterXSize();
}

int Raster::height() const {
    return state_->data->GetRasterYSize();
}

glm::dvec2 Raster::at(double column, double row) const {
    const auto& t = state_->transform;
    return {t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]};
}

const std::optional<std::string>& Raster::crs() const {
    return state_->crs;
}

std::string Raster::crsName() const {
    return state_->crsName;
}

Result<std::vector<float>> Raster::read(int column, int row, int columns, int rows) const {
    assert(column >= 0 && row >= 0 && columns > 0 && rows > 0 && columns <= width() - column &&
           rows <= height() - row);
    Quiet quiet;
    // In double, as the file's value for no data is; a float may not hold it.
    std::vector<double> values(std::size_t(columns) * std::size_t(rows));
    if (state_->band->RasterIO(GF_Read, column, row, columns, rows, values.data(), columns, rows,
                               GDT_Float64, 0, 0, nullptr) != CE_None)
        return Error{state_->path, "cannot be read: " + quiet.reason()};
    // A file of floats holds its no data value rounded to float (-3.4028235e38).
    const double none = state_->noData.value_or(0.0);
    const double slack = std::abs(none) * double(std::numeric_limits<float>::epsilon());
    std::vector<float> out;
    out.reserve(values.size());
    for (const double v : values) {
        const bool missing = !std::isfinite(v) || (state_->noData && std::abs(v - none) <= slack);
        out.push_back(missing ? std::numeric_limits<float>::quiet_NaN()
                              : float(v * state_->scale + state_->offset));
    }
    return out;
}

} // namespace gnomon
