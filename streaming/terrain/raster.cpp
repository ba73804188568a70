#include "streaming/terrain/raster.h"

#include "streaming/terrain/gdal_quiet.h"
#include "streaming/terrain/raster_file.h"

#include <gdal_priv.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <mutex>

namespace gnomon {

namespace {

// No ground is as high or deep as this: files that name no value for "no data" hold such numbers
// (3.4e38, say).
constexpr double kLargestValue = 1e6;

struct Reading {
    std::optional<double> noData;
    double scale = 1.0, offset = 0.0;
};

// What is no number, no data, or out of the world becomes NaN.
template <class T>
void toMetres(std::span<const T> values, const Reading& reading, float* out) {
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    // A file of floats holds its no data value rounded to float (-3.4028235e38).
    const double none = reading.noData.value_or(std::numeric_limits<double>::infinity());
    const double slack =
        std::isfinite(none) ? std::abs(none) * double(std::numeric_limits<float>::epsilon()) : 0.0;
    const T low = T(std::max(none - slack, double(std::numeric_limits<T>::lowest())));
    const T high = T(std::min(none + slack, double(std::numeric_limits<T>::max())));
    const bool any = std::isfinite(none);
    const T scale = T(reading.scale), offset = T(reading.offset);
    for (std::size_t i = 0; i < values.size(); ++i) {
        const T v = values[i];
        const T metres = v * scale + offset;
        const bool missing =
            !(std::abs(metres) <= T(kLargestValue)) || (any && v >= low && v <= high);
        out[i] = missing ? kNaN : float(metres);
    }
}

bool fitsFloat(GDALDataType type) {
    return type == GDT_Byte || type == GDT_Int16 || type == GDT_UInt16 || type == GDT_Float32;
}

} // namespace

// One GDAL dataset serves one thread at a time: there are as many as threads that read at once.
struct Raster::State {
    RasterFile file;
    mutable std::mutex mutex;
    mutable std::vector<RasterHandle> idle;

    class Lease {
      public:
        explicit Lease(const State& owner) : owner_(owner) {
            {
                const std::lock_guard lock(owner.mutex);
                if (!owner.idle.empty()) {
                    data_ = std::move(owner.idle.back());
                    owner.idle.pop_back();
                }
            }
            if (!data_)
                data_ = owner.file.openAgain();
        }
        ~Lease() {
            if (data_) {
                const std::lock_guard lock(owner_.mutex);
                owner_.idle.push_back(std::move(data_));
            }
        }
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        GDALRasterBand* band(int index) const {
            return data_ ? data_->GetRasterBand(index) : nullptr;
        }

      private:
        const State& owner_;
        RasterHandle data_;
    };

    Error unreadable(const GdalQuiet& quiet) const {
        return Error{file.path, "cannot be read: " + quiet.reason()};
    }
    Failure read(GDALRasterBand* band, int column, int row, int columns, int rows,
                 float* out) const;
};

Raster::Raster(std::unique_ptr<State> state) : state_(std::move(state)) {}
Raster::Raster(Raster&&) noexcept = default;
Raster& Raster::operator=(Raster&&) noexcept = default;
Raster::~Raster() {
    const GdalQuiet quiet; // closing may complain
    state_.reset();
}

Result<Raster> Raster::open(const std::string& path, const RasterOptions& options) {
    Result<OpenedRaster> opened = openRasterFile(path, options);
    if (!opened)
        return opened.error();
    auto state = std::make_unique<State>();
    state->file = std::move(opened->file);
    state->idle.push_back(std::move(opened->data));
    return Raster(std::move(state));
}

int Raster::width() const {
    return state_->file.width;
}

int Raster::height() const {
    return state_->file.height;
}

int Raster::bands() const {
    return state_->file.bands;
}

glm::dvec2 Raster::at(double column, double row) const {
    const auto& t = state_->file.transform;
    return {t[0] + column * t[1] + row * t[2], t[3] + column * t[4] + row * t[5]};
}

glm::dvec2 Raster::pixelOf(glm::dvec2 position) const {
    const auto& t = state_->file.transform;
    const double across = t[1] * t[5] - t[2] * t[4];
    const double x = position.x - t[0], y = position.y - t[3];
    return {(x * t[5] - y * t[2]) / across, (y * t[1] - x * t[4]) / across};
}

bool Raster::rowsRunSouth() const {
    const auto& t = state_->file.transform;
    return t[1] * t[5] - t[2] * t[4] < 0.0;
}

const std::optional<std::string>& Raster::crs() const {
    return state_->file.crs;
}

std::string Raster::crsName() const {
    return state_->file.crsName;
}

const std::vector<std::string>& Raster::credits() const {
    return state_->file.credits;
}

const std::vector<std::string>& Raster::notes() const {
    return state_->file.notes;
}

std::vector<int> Raster::overviewFactors() const {
    return state_->file.overviewFactors;
}

glm::ivec2 Raster::blockSize() const {
    return state_->file.blockSize;
}

glm::ivec2 Raster::overviewSize(int factor) const {
    for (std::size_t i = 0; i < state_->file.overviewFactors.size(); ++i)
        if (state_->file.overviewFactors[i] == factor)
            return state_->file.overviewSizes[i];
    return {0, 0};
}

Failure Raster::State::read(GDALRasterBand* band, int column, int row, int columns, int rows,
                            float* out) const {
    const GdalQuiet quiet;
    if (band == nullptr)
        return Error{file.path, "can no longer be opened"};
    const Reading reading{file.noData, file.scale, file.offset};
    const std::size_t count = std::size_t(columns) * std::size_t(rows);
    const auto io = [&](void* to, GDALDataType type) {
        return band->RasterIO(GF_Read, column, row, columns, rows, to, columns, rows, type, 0, 0,
                              nullptr) == CE_None;
    };
    if (fitsFloat(band->GetRasterDataType())) {
        if (!io(out, GDT_Float32))
            return unreadable(quiet);
        toMetres<float>(std::span<const float>(out, count), reading, out);
        return {};
    }
    std::vector<double> values(count); // a float may not hold the file's numbers
    if (!io(values.data(), GDT_Float64))
        return unreadable(quiet);
    toMetres<double>(values, reading, out);
    return {};
}

Failure Raster::readInto(int column, int row, int columns, int rows, std::span<float> out,
                         int band) const {
    assert(column >= 0 && row >= 0 && columns > 0 && rows > 0 && columns <= width() - column &&
           rows <= height() - row);
    assert(out.size() >= std::size_t(columns) * std::size_t(rows));
    const State::Lease lease(*state_);
    return state_->read(lease.band(band), column, row, columns, rows, out.data());
}

Result<std::vector<float>> Raster::read(int column, int row, int columns, int rows,
                                        int band) const {
    std::vector<float> out(std::size_t(columns) * std::size_t(rows));
    if (const Failure wrong = readInto(column, row, columns, rows, out, band))
        return *wrong;
    return out;
}

Failure Raster::sampleInto(int column, int row, int step, int columns, int rows,
                           std::span<float> out) const {
    if (step == 1)
        return readInto(column, row, columns, rows, out);
    const int across = (columns - 1) * step + 1;
    std::vector<float> line(static_cast<std::size_t>(across));
    const State::Lease lease(*state_);
    for (int j = 0; j < rows; ++j) {
        if (const Failure wrong =
                state_->read(lease.band(1), column, row + j * step, across, 1, line.data()))
            return wrong;
        for (int i = 0; i < columns; ++i)
            out[std::size_t(j) * std::size_t(columns) + std::size_t(i)] =
                line[std::size_t(i) * std::size_t(step)];
    }
    return {};
}

Result<std::vector<float>> Raster::readOverview(int factor, int column, int row, int columns,
                                                int rows) const {
    const auto& factors = state_->file.overviewFactors;
    const auto it = std::find(factors.begin(), factors.end(), factor);
    assert(it != factors.end());
    const State::Lease lease(*state_);
    GDALRasterBand* band = lease.band(1);
    if (band != nullptr)
        band = band->GetOverview(state_->file.overviewIndex[std::size_t(it - factors.begin())]);
    std::vector<float> out(std::size_t(columns) * std::size_t(rows));
    if (const Failure wrong = state_->read(band, column, row, columns, rows, out.data()))
        return *wrong;
    return out;
}

} // namespace gnomon
