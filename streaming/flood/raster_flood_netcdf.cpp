#include "streaming/flood/raster_flood.h"
#include "streaming/flood/raster_flood_layout.h"
#include "streaming/flood/unstructured_hdf5_check.h"
#include "streaming/flood/unstructured_netcdf_header.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace gnomon {

namespace {

// Read at once: no more than any file may hold.
constexpr std::size_t kValuesAtOnce = 1'000'000;

// The whole of one step, or of a variable without steps.
Result<std::vector<float>> readStep(const GridVariable& field, std::uint64_t step,
                                    const GridThinning& thinning) {
    std::vector<std::uint64_t> start(field.variable.dimensions().size(), 0);
    std::vector<std::size_t> count(start.size(), 1);
    if (field.hasTime())
        start[0] = step;
    std::uint64_t& row = start[start.size() - 2];
    count.back() = field.columns;
    std::vector<float> out;
    out.reserve(thinning.nodes());
    // Rows in between are passed by where they are many.
    const std::size_t rowsAtOnce =
        std::size_t(thinning.step) * std::size_t(thinning.step) > 64
            ? 1
            : std::clamp<std::size_t>(kValuesAtOnce / field.columns, 1, field.rows);
    std::size_t haveFrom = 0, haveTo = 0;
    std::vector<float> have;
    for (int r = 0; r < thinning.rows; ++r) {
        const std::size_t wanted = std::size_t(thinning.first + r * thinning.step);
        if (wanted >= haveTo) {
            row = wanted;
            count[count.size() - 2] = std::min(rowsAtOnce, field.rows - wanted);
            auto read = field.variable.readBlock(start, count);
            if (!read)
                return read;
            have = std::move(*read);
            haveFrom = wanted;
            haveTo = wanted + count[count.size() - 2];
        }
        const float* line = have.data() + (wanted - haveFrom) * field.columns;
        for (int c = 0; c < thinning.columns; ++c)
            out.push_back(line[thinning.first + c * thinning.step]);
    }
    return out;
}

// One of perhaps several files.
struct CfGrid {
    std::string path;
    GridFields fields;
};

class CfSource final : public GridSource {
  public:
    struct Step {
        std::size_t grid = 0;
        std::uint64_t step = 0;
    };
    CfSource(std::vector<CfGrid> grids, std::vector<Step> steps, GridThinning thinning)
        : grids_(std::move(grids)), steps_(std::move(steps)), thinning_(thinning) {}

    Result<std::vector<float>> water(std::size_t source) const override {
        const Step& step = steps_[source];
        return readStep(grids_[step.grid].fields.water, step.step, thinning_);
    }
    bool hasVelocity() const override {
        return std::all_of(grids_.begin(), grids_.end(), [](const CfGrid& g) {
            return g.fields.velocityX && g.fields.velocityY;
        });
    }
    bool velocityIsEastNorth() const override {
        return grids_.front().fields.velocityX->isEastNorth;
    }
    Result<std::vector<glm::vec2>> velocity(std::size_t source) const override {
        const Step& step = steps_[source];
        const GridFields& fields = grids_[step.grid].fields;
        const auto x = readStep(*fields.velocityX, step.step, thinning_);
        const auto y = readStep(*fields.velocityY, step.step, thinning_);
        if (!x || !y)
            return (x ? y : x).error();
        std::vector<glm::vec2> out(x->size());
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = {(*x)[i], (*y)[i]};
        return out;
    }

  private:
    std::vector<CfGrid> grids_;
    std::vector<Step> steps_;
    GridThinning thinning_;
};

// Positions in single precision are off by up to half a metre in northing; where they are those of
// an even grid, that is taken.
struct EvenGrid {
    glm::dvec2 corner, across, down;
};
std::optional<EvenGrid> evenGrid(const GridCoordinates& at, std::size_t columns, std::size_t rows) {
    const auto place = [&](std::size_t c, std::size_t r) {
        const std::size_t i = r * columns + c;
        if (at.each)
            return glm::dvec2(at.x[i], at.y[i]);
        return at.xRunsAlongRows ? glm::dvec2(at.x[c], at.y[r]) : glm::dvec2(at.x[r], at.y[c]);
    };
    const EvenGrid grid{place(0, 0), (place(columns - 1, 0) - place(0, 0)) / double(columns - 1),
                        (place(0, rows - 1) - place(0, 0)) / double(rows - 1)};
    const double area = std::abs(grid.across.x * grid.down.y - grid.across.y * grid.down.x);
    if (!(area > 0.0))
        return std::nullopt;
    constexpr double kSlackCells = 0.02;
    const double slack = kSlackCells * std::sqrt(area);
    for (std::size_t r = 0; r < rows; ++r)
        for (std::size_t c = 0; c < columns; ++c) {
            const glm::dvec2 off =
                place(c, r) - grid.corner - double(c) * grid.across - double(r) * grid.down;
            if (!(std::max(std::abs(off.x), std::abs(off.y)) <= slack))
                return std::nullopt;
        }
    return grid;
}

Result<std::string> crsOf(const ArrayFile& file, const GridFields& fields, bool degrees,
                          const FloodOptions& options) {
    if (const auto own = findGridCrs(file, fields.water))
        return *own;
    if (options.crs)
        return *options.crs;
    if (degrees)
        return std::string("EPSG:4326");
    return Error{file.path(),
                 std::string(saysCrsZero(file) ? "names EPSG:0, which is no system of coordinates"
                                               : "does not say which coordinates it uses") +
                     ": give its coordinate reference system with --crs EPSG:n"};
}

// "" for WKT, whose name says it; that of a system by number is the number.
std::string nameOf(const std::string& crs) {
    const std::size_t quote = crs.find('"');
    if (crs.find('[') == std::string::npos || quote == std::string::npos)
        return crs;
    return crs.substr(quote + 1, crs.find('"', quote + 1) - quote - 1);
}

Failure placeNodes(const ArrayFile& file, const GridFields& fields, const GridThinning& thinning,
                   const FloodOptions& options, GridFlood& flood) {
    const Result<GridCoordinates> at = findGridCoordinates(file, fields.water);
    if (!at)
        return at.error();
    const Result<std::string> crs = crsOf(file, fields, at->degrees, options);
    if (!crs)
        return crs.error();
    flood.crs = nameOf(*crs);
    const std::size_t columns = fields.water.columns;
    const auto even = evenGrid(*at, columns, fields.water.rows);
    const auto position = [&](int column, int row) {
        const auto c = std::size_t(thinning.first + column * thinning.step);
        const auto r = std::size_t(thinning.first + row * thinning.step);
        if (even)
            return even->corner + double(c) * even->across + double(r) * even->down;
        if (at->each)
            return glm::dvec2(at->x[r * columns + c], at->y[r * columns + c]);
        return at->xRunsAlongRows ? glm::dvec2(at->x[c], at->y[r]) : glm::dvec2(at->x[r], at->y[c]);
    };
    Result<GridPlaces> places = placeGrid(file.path(), thinning.columns, thinning.rows, position,
                                          even.has_value(), *crs, options);
    if (!places)
        return places.error();
    flood.place(std::move(*places), thinning);
    return {};
}

struct FileSteps {
    std::vector<CfSource::Step> steps;
    std::vector<std::string> names;
    std::vector<double> seconds;
    bool known = true, absolute = true; // the times
};

Failure addSteps(const ArrayFile& file, const GridFields& fields, std::size_t grid,
                 FloodData& saying, FileSteps& out) {
    const Result<GridTimes> times = findGridTimes(file, fields.water, saying.notes);
    if (!times)
        return times.error();
    const std::string stem = std::filesystem::path(file.path()).stem().string();
    out.known = out.known && times->seconds.size() == fields.water.steps;
    out.absolute = out.absolute && times->absolute;
    for (std::uint64_t step = 0; step < fields.water.steps; ++step) {
        out.steps.push_back({grid, step});
        out.names.push_back(fields.water.steps == 1 ? stem
                                                    : stem + " step " + std::to_string(step + 1));
        out.seconds.push_back(step < times->seconds.size() ? times->seconds[std::size_t(step)]
                                                           : 0.0);
    }
    return {};
}

void addCredits(const ArrayFile& file, FloodData& flood) {
    for (const char* name : {"copyright", "attribution", "credit"})
        if (const auto text = file.text("", name); text && !text->empty())
            flood.credits.push_back(text->substr(0, text->find('\n')).substr(0, 200));
}

} // namespace

namespace {

// libnetcdf and libhdf5 crash, or read for minutes, on files that are damaged.
Result<ArrayFile> openSound(const std::string& path) {
    const bool isHdf5 = ArrayFile::formatOf(path) == ArrayFile::Format::Hdf5;
    if (const Failure wrong = isHdf5 ? checkHdf5(path) : checkClassicNetCdf(path))
        return *wrong;
    return ArrayFile::open(path, ArrayFile::Format::NetCdf);
}

// Opens the first and those others that fit it.
Result<std::vector<CfGrid>> openGrids(const std::vector<std::string>& paths,
                                      const FloodOptions& options, GridFlood& flood,
                                      FileSteps& steps) {
    std::vector<CfGrid> grids;
    GridThinning thinning;
    for (const std::string& path : paths) {
        const Result<ArrayFile> file = openSound(path);
        Failure wrong;
        std::vector<std::string> notes;
        Result<GridFields> fields = file ? chooseGridFields(*file, options, notes) : file.error();
        if (!fields) {
            wrong = fields.error();
        } else if (grids.empty()) {
            thinning = GridThinning::of(int(fields->water.columns), int(fields->water.rows));
            wrong = thinning.fits(int(fields->water.columns), int(fields->water.rows))
                        ? placeNodes(*file, *fields, thinning, options, flood)
                        : Error{path, "is too long and narrow to be shown"};
        } else if (fields->water.rows != grids.front().fields.water.rows ||
                   fields->water.columns != grids.front().fields.water.columns ||
                   fields->kind != grids.front().fields.kind) {
            wrong = Error{path, "is of another size or kind than the steps before it"};
        }
        if (!wrong)
            wrong = addSteps(*file, *fields, grids.size(), flood, steps);
        if (wrong) {
            if (paths.size() == 1)
                return *wrong;
            wrong->reason += "; its steps are left out";
            flood.leftOut.push_back(*wrong);
            continue;
        }
        if (grids.empty()) {
            flood.notes.insert(flood.notes.begin(), notes.begin(), notes.end());
            addCredits(*file, flood);
        }
        grids.push_back({path, std::move(*fields)});
    }
    if (grids.empty())
        return Error{paths.front(), "none of these " + std::to_string(paths.size()) +
                                        " files can be used: " + flood.leftOut.front().message()};
    return grids;
}

} // namespace

Result<std::shared_ptr<const FloodData>> openGridNetCdf(const std::vector<std::string>& paths,
                                                        const FloodOptions& options) {
    auto flood = std::make_shared<GridFlood>();
    FileSteps told;
    Result<std::vector<CfGrid>> grids = openGrids(paths, options, *flood, told);
    if (!grids)
        return grids.error();
    flood->path = paths.front();
    const GridFields& fields = grids->front().fields;
    const int width = int(fields.water.columns), height = int(fields.water.rows);
    const GridThinning thinning = GridThinning::of(width, height);
    if (const std::string note = thinning.note(width, height); !note.empty())
        flood->notes.push_back(note);
    if (fields.bed) {
        Result<std::vector<float>> bed = readStep(*fields.bed, 0, thinning);
        if (!bed)
            return bed.error();
        flood->setBed(std::move(*bed));
    }
    FloodSteps steps = told.known && told.steps.size() > 0
                           ? stepsByTime(told.seconds, told.absolute, told.names, options, *flood)
                           : stepsByName(told.names, options, *flood);
    if (steps.seconds.empty())
        return Error{paths.front(), "has no step of time"};
    const WaterKind kind = fields.kind;
    auto source = std::make_unique<CfSource>(std::move(*grids), std::move(told.steps), thinning);
    flood->setSteps(std::move(steps), std::move(source), kind);
    return std::shared_ptr<const FloodData>(std::move(flood));
}

} // namespace gnomon
