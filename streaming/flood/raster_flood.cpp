#include "streaming/flood/raster_flood.h"

#include "streaming/flood/unstructured_arrays.h"
#include "streaming/guess_use.h"
#include "streaming/terrain/raster.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>

namespace gnomon {

namespace {

constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();

// A file with more pixels is no flood result; to look through it would take hours.
constexpr double kMostPixels = 4e9;

Result<Raster> openRaster(const std::string& path, const FloodOptions& options) {
    RasterOptions asked;
    asked.severalBands = true;
    asked.variable = options.variable;
    Result<Raster> raster = Raster::open(path, asked);
    if (!raster)
        return raster;
    if (raster->width() < 2 || raster->height() < 2)
        return Error{path, "is one pixel wide: a surface needs two by two"};
    if (double(raster->width()) * double(raster->height()) > kMostPixels)
        return Error{path, "has " + std::to_string(raster->width()) + " x " +
                               std::to_string(raster->height()) + " pixels, too many to be read"};
    return raster;
}

Result<std::vector<float>> readThinned(const Raster& raster, const GridThinning& thinning,
                                       int band) {
    if (thinning.step == 1)
        return raster.read(0, 0, raster.width(), raster.height(), band);
    std::vector<float> out, line(std::size_t(raster.width()));
    out.reserve(thinning.nodes());
    for (int row = 0; row < thinning.rows; ++row) {
        if (const Failure wrong = raster.readInto(0, thinning.first + row * thinning.step,
                                                  raster.width(), 1, line, band))
            return *wrong;
        for (int column = 0; column < thinning.columns; ++column)
            out.push_back(line[std::size_t(thinning.first + column * thinning.step)]);
    }
    return out;
}

class RasterSource final : public GridSource {
  public:
    struct Step {
        std::string path;
        int band = 1;
    };
    RasterSource(std::vector<Step> steps, GridThinning thinning, FloodOptions options)
        : steps_(std::move(steps)), thinning_(thinning), options_(std::move(options)) {}

    Result<std::vector<float>> water(std::size_t source) const override {
        const std::lock_guard lock(mutex_);
        const Step& step = steps_[source];
        if (!open_ || openPath_ != step.path) {
            Result<Raster> raster = openRaster(step.path, options_);
            if (!raster)
                return raster.error();
            open_ = std::make_unique<Raster>(std::move(*raster));
            openPath_ = step.path;
        }
        const GridThinning now = GridThinning::of(open_->width(), open_->height());
        if (now.columns != thinning_.columns || now.rows != thinning_.rows ||
            step.band > open_->bands())
            return Error{step.path, "has changed since it was opened"};
        return readThinned(*open_, thinning_, step.band);
    }

  private:
    std::vector<Step> steps_;
    GridThinning thinning_;
    FloodOptions options_;
    mutable std::mutex mutex_;
    mutable std::unique_ptr<Raster> open_; // one at a time: there may be thousands of steps
    mutable std::string openPath_;
};

bool liesAlike(const Raster& a, const Raster& b) {
    const double pixel = glm::length(a.at(1, 0) - a.at(0, 0));
    const double slack = 0.01 * pixel;
    return glm::length(a.at(0, 0) - b.at(0, 0)) < slack &&
           glm::length(a.at(a.width(), a.height()) - b.at(b.width(), b.height())) < slack;
}

std::string size(const Raster& raster) {
    return std::to_string(raster.width()) + " x " + std::to_string(raster.height());
}

// The first that can be used, and of the others those that fit it.
struct RasterFiles {
    std::optional<Raster> first;
    std::vector<RasterSource::Step> steps;
    std::vector<std::string> names; // of the steps, for their times
};

Result<RasterFiles> openFiles(const std::vector<std::string>& paths, const FloodOptions& options,
                              FloodData& saying) {
    RasterFiles files;
    for (const std::string& path : paths) {
        Result<Raster> raster = openRaster(path, options);
        Failure wrong;
        if (!raster)
            wrong = raster.error();
        else if (paths.size() > 1 && raster->bands() > 1)
            wrong = Error{path, "has " + std::to_string(raster->bands()) +
                                    " bands, and of several files each is one step"};
        else if (files.first && (raster->width() != files.first->width() ||
                                 raster->height() != files.first->height()))
            wrong = Error{path, "has " + size(*raster) + " pixels, the steps before it " +
                                    size(*files.first)};
        else if (files.first &&
                 (raster->crsName() != files.first->crsName() || !liesAlike(*files.first, *raster)))
            wrong = Error{path, "does not lie where the steps before it do"};
        if (wrong) {
            if (paths.size() == 1)
                return *wrong;
            wrong->reason += "; this step is left out";
            saying.leftOut.push_back(*wrong);
            continue;
        }
        const std::string stem = std::filesystem::path(path).stem().string();
        for (int band = 1; band <= raster->bands(); ++band) {
            files.steps.push_back({path, band});
            files.names.push_back(raster->bands() == 1 ? stem : "band " + std::to_string(band));
        }
        if (!files.first)
            files.first = std::move(*raster);
    }
    if (!files.first)
        return Error{paths.front(), "none of these " + std::to_string(paths.size()) +
                                        " files can be used: " + saying.leftOut.front().message()};
    return files;
}

Result<WaterKind> chooseKind(const std::string& path, const FloodOptions& options,
                             const GridSource& source, FloodData& saying) {
    if (options.kind)
        return *options.kind;
    if (const Result<RasterGuess> guess = guessRasterUse(path);
        guess && (guess->use == RasterUse::Depth || guess->use == RasterUse::Stage)) {
        const bool depth = guess->use == RasterUse::Depth;
        saying.notes.push_back(std::string("taken for ") + (depth ? "depths" : "levels") +
                               " of water: " + guess->because);
        return depth ? WaterKind::Depth : WaterKind::Stage;
    }
    const Result<std::vector<float>> values = source.water(0);
    if (!values)
        return values.error();
    const WaterKind kind = guessWaterKind(*values);
    saying.notes.push_back(kind == WaterKind::Depth
                               ? "taken for depths of water: no value is below 0 or over 60"
                               : "taken for levels of water: its values are no depths");
    return kind;
}

// A NetCDF file of the 64-bit kind is HDF5 inside; other HDF5 files are not for us.
bool isNetCdf(const std::string& path) {
    const auto format = ArrayFile::formatOf(path);
    return format.has_value();
}

} // namespace

Result<std::vector<glm::vec2>> GridSource::velocity(std::size_t) const {
    return std::vector<glm::vec2>();
}

void GridFlood::place(GridPlaces places, const GridThinning& thinning) {
    geometry_.lonLat = std::move(places.lonLat);
    geometry_.cellArea = std::move(places.cellArea);
    geometry_.columns = thinning.columns;
    geometry_.rows = thinning.rows;
    lift_ = std::move(places.lift);
    eastOfX_ = std::move(places.eastOfX);
}

void GridFlood::setBed(std::vector<float> bed) {
    for (std::size_t i = 0; i < bed.size(); ++i)
        bed[i] = std::abs(bed[i]) <= kMostWaterMetres ? bed[i] + lift_[i] : kNoData;
    geometry_.bed = std::move(bed);
}

void GridFlood::setSteps(FloodSteps steps, std::unique_ptr<const GridSource> source,
                         WaterKind kind) {
    steps_ = std::move(steps);
    source_ = std::move(source);
    kind_ = kind;
    if (!source_->hasVelocity())
        eastOfX_ = {};
    else if (source_->velocityIsEastNorth())
        eastOfX_.assign(eastOfX_.size(), 0.0f);
}

Result<std::vector<float>> GridFlood::values(std::size_t step) const {
    if (step >= steps_.source.size())
        return Error{"", "there is no step " + std::to_string(step)};
    Result<std::vector<float>> read = source_->water(steps_.source[step]);
    if (!read)
        return read;
    std::vector<float>& values = *read;
    values.resize(geometry_.lonLat.size(), kNoData);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!(std::abs(values[i]) <= kMostWaterMetres))
            values[i] = kNoData;
        else if (kind_ == WaterKind::Stage)
            values[i] += lift_[i];
        else if (values[i] <= 0.0f)
            values[i] = kNoData;
    }
    return read;
}

Result<std::vector<glm::vec2>> GridFlood::velocities(std::size_t step) const {
    if (!hasVelocity() || step >= steps_.source.size())
        return std::vector<glm::vec2>();
    Result<std::vector<glm::vec2>> read = source_->velocity(steps_.source[step]);
    if (!read)
        return read;
    read->resize(geometry_.lonLat.size());
    for (std::size_t i = 0; i < read->size(); ++i) {
        const glm::vec2 v = (*read)[i];
        const float c = std::cos(eastOfX_[i]), s = std::sin(eastOfX_[i]);
        const bool known = std::isfinite(v.x) && std::isfinite(v.y);
        (*read)[i] = known ? glm::vec2(c * v.x - s * v.y, s * v.x + c * v.y) : glm::vec2(0.0f);
    }
    return read;
}

WaterKind guessWaterKind(const std::vector<float>& values) {
    // No flood is deeper on land; and a depth is never below 0 by more than a solver's slip.
    constexpr float kDeepest = 60.0f, kSlip = 1.0f;
    for (const float value : values)
        if (std::abs(value) <= kMostWaterMetres && (value < -kSlip || value > kDeepest))
            return WaterKind::Stage;
    return WaterKind::Depth;
}

Result<std::shared_ptr<const FloodData>> openRasterFlood(const std::vector<std::string>& paths,
                                                         const FloodOptions& options) {
    if (std::all_of(paths.begin(), paths.end(), isNetCdf))
        return openGridNetCdf(paths, options);
    auto flood = std::make_shared<GridFlood>();
    Result<RasterFiles> files = openFiles(paths, options, *flood);
    if (!files)
        return files.error();
    const Raster& first = *files->first;
    const std::string& path = files->steps.front().path;
    const std::optional<std::string> crs = first.crs() ? first.crs() : options.crs;
    if (!crs)
        return Error{path, "does not say which coordinates it uses: give its coordinate reference "
                           "system with --crs EPSG:n"};
    flood->path = path;
    flood->crs = first.crs() ? first.crsName() : *options.crs;
    flood->credits = first.credits();
    flood->notes = first.notes();

    const GridThinning thinning = GridThinning::of(first.width(), first.height());
    if (!thinning.fits(first.width(), first.height()))
        return Error{path, "is too long and narrow to be shown: " + size(first) + " pixels"};
    const auto position = [&](int column, int row) {
        return first.at(thinning.first + column * thinning.step + 0.5,
                        thinning.first + row * thinning.step + 0.5);
    };
    Result<GridPlaces> places =
        placeGrid(path, thinning.columns, thinning.rows, position, true, *crs, options);
    if (!places)
        return places.error();
    if (const std::string note = thinning.note(first.width(), first.height()); !note.empty())
        flood->notes.push_back(note);
    flood->place(std::move(*places), thinning);

    FloodSteps steps = stepsByName(files->names, options, *flood);
    if (steps.seconds.empty())
        return Error{path, "has no step of time"};
    auto source = std::make_unique<RasterSource>(std::move(files->steps), thinning, options);
    const Result<WaterKind> kind = chooseKind(path, options, *source, *flood);
    if (!kind)
        return kind.error();
    flood->setSteps(std::move(steps), std::move(source), *kind);
    return std::shared_ptr<const FloodData>(std::move(flood));
}

} // namespace gnomon
