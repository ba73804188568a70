#include "streaming/flood/unstructured.h"

#include "streaming/flood/hecras.h"
#include "streaming/flood/selafin.h"
#include "streaming/flood/sww.h"
#include "streaming/flood/ugrid.h"
#include "streaming/flood/unstructured_arrays.h"
#include "streaming/flood/unstructured_hdf5_check.h"
#include "streaming/flood/unstructured_netcdf_header.h"
#include "streaming/flood/unstructured_place.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();

class MeshFlood final : public FloodData {
  public:
    static Result<std::shared_ptr<const FloodData>>
    make(const std::string& path, std::unique_ptr<MeshFile> file, const FloodOptions& options);

    const FloodGeometry& geometry() const override { return geometry_; }
    WaterKind kind() const override { return file_->kind; }
    const std::vector<double>& stepSeconds() const override { return seconds_; }
    bool stepsAreAbsolute() const override { return absolute_; }
    Result<std::vector<float>> values(std::size_t step) const override;
    bool hasVelocity() const override { return file_->hasVelocity(); }
    Result<std::vector<glm::vec2>> velocities(std::size_t step) const override;

  private:
    Failure place(const FloodOptions& options);
    void measure();
    void setBed();
    Failure chooseSteps(const FloodOptions& options);
    Failure checkStep(std::size_t step) const;
    bool isWet(float value, std::size_t node) const;
    void meanAtRim(std::vector<float>& values) const;

    std::unique_ptr<MeshFile> file_;
    FloodGeometry geometry_;
    NodeMesh nodes_;
    std::vector<float> lift_, eastOfX_;
    std::vector<double> seconds_;
    std::vector<std::size_t> fileStep_;
    bool absolute_ = false;
};

Failure MeshFlood::place(const FloodOptions& options) {
    const std::optional<std::string> named = options.crs ? options.crs : file_->crs;
    if (!named || named->empty())
        return Error{path, "does not say which coordinates it uses: give its coordinate reference "
                           "system with --crs EPSG:n"};
    crs = *named;
    Result<PlacedNodes> placed = placeNodes(path, nodes_.positions, crs, options);
    if (!placed)
        return placed.error();
    geometry_.lonLat = std::move(placed->lonLat);
    lift_ = std::move(placed->liftMetres);
    eastOfX_ = std::move(placed->eastOfX);
    return {};
}

void MeshFlood::measure() {
    // Areas on the Earth; a face's by how much its projection stretches there.
    std::vector<double> onEarth(nodes_.positions.size()), inFile(nodes_.positions.size());
    for (const auto& t : nodes_.triangles) {
        const double area =
            areaOnEarth({geometry_.lonLat[t[0]], geometry_.lonLat[t[1]], geometry_.lonLat[t[2]]});
        if (!(area > 0.0))
            continue;
        geometry_.triangles.push_back(t);
        const glm::dvec2 a = nodes_.positions[t[1]] - nodes_.positions[t[0]],
                         b = nodes_.positions[t[2]] - nodes_.positions[t[0]];
        for (const std::uint32_t node : t) {
            onEarth[node] += area / 3.0;
            inFile[node] += 0.5 * (a.x * b.y - a.y * b.x) / 3.0;
        }
    }
    geometry_.cellArea.assign(nodes_.positions.size(), 0.0f);
    for (std::size_t i = 0; i < nodes_.source.size(); ++i) {
        double area = onEarth[i];
        if (file_->at == ValuesAt::Faces && inFile[i] > 0.0) {
            const double own = file_->faceArea.empty() ? 0.0 : file_->faceArea[nodes_.source[i]];
            area *= (own > 0.0 ? own : nodes_.faceArea[i]) / inFile[i];
        }
        geometry_.cellArea[i] = float(area);
    }
}

// A rim node's value is the mean of those around it that have one.
void MeshFlood::meanAtRim(std::vector<float>& values) const {
    const std::size_t first = nodes_.source.size();
    for (std::size_t rim = 0; rim + 1 < nodes_.meanStarts.size(); ++rim) {
        double sum = 0.0;
        int count = 0;
        for (std::size_t i = nodes_.meanStarts[rim]; i < nodes_.meanStarts[rim + 1]; ++i)
            if (std::isfinite(values[nodes_.meanOf[i]])) {
                sum += values[nodes_.meanOf[i]];
                ++count;
            }
        values[first + rim] = count > 0 ? float(sum / count) : kNoData;
    }
}

void MeshFlood::setBed() {
    if (file_->bed.empty())
        return;
    geometry_.bed.assign(nodes_.positions.size(), kNoData);
    for (std::size_t i = 0; i < nodes_.source.size(); ++i)
        geometry_.bed[i] = file_->bed[nodes_.source[i]];
    meanAtRim(geometry_.bed);
    for (std::size_t i = 0; i < geometry_.bed.size(); ++i)
        geometry_.bed[i] += lift_[i];
}

Failure MeshFlood::chooseSteps(const FloodOptions& options) {
    std::vector<double> times = file_->times.seconds;
    absolute_ = file_->times.absolute;
    if (!file_->times.note.empty())
        notes.push_back(file_->times.note);
    // A reader that finds no times gives zeros.
    if (times.size() > 1 &&
        std::all_of(times.begin(), times.end(), [](double t) { return t == 0; })) {
        if (!options.stepSeconds)
            notes.push_back("has no times: an hour is taken between its steps");
        for (std::size_t i = 0; i < times.size(); ++i)
            times[i] = double(i) * options.stepSeconds.value_or(3600.0);
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
        // Four-digit years, either way.
        constexpr double kFurthest = 3e11;
        if (!(std::abs(times[i]) < kFurthest)) {
            leftOut.push_back({path, "step " + std::to_string(i + 1) + " has no time; left out"});
        } else if (!seconds_.empty() && times[i] <= seconds_.back()) {
            leftOut.push_back({path, "step " + std::to_string(i + 1) +
                                         " is not after the one before it; left out"});
        } else {
            seconds_.push_back(times[i]);
            fileStep_.push_back(i);
        }
    }
    if (seconds_.empty())
        return Error{path, "has no step of time"};
    if (options.start) {
        if (absolute_ && std::abs(seconds_.front() - options.start->seconds) > 0.5)
            notes.push_back("its first step, " + formatUtc({seconds_.front()}) +
                            ", is put at the start that was given");
        const double shift = options.start->seconds - seconds_.front();
        for (double& second : seconds_)
            second += shift;
        absolute_ = true;
    }
    return {};
}

Result<std::shared_ptr<const FloodData>> MeshFlood::make(const std::string& path,
                                                         std::unique_ptr<MeshFile> file,
                                                         const FloodOptions& options) {
    auto flood = std::make_shared<MeshFlood>();
    flood->path = path;
    flood->file_ = std::move(file);
    MeshFile& from = *flood->file_;
    flood->notes = std::move(from.notes);
    flood->leftOut = std::move(from.leftOut);

    const std::size_t faces = from.mesh.faces();
    flood->nodes_ = nodesOf(std::move(from.mesh), from.at);
    NodeMesh& nodes = flood->nodes_;
    if (nodes.triangles.empty())
        return Error{path, "has no usable face among its " + std::to_string(faces)};
    if (nodes.unusableFaces != 0)
        flood->notes.push_back(std::to_string(nodes.unusableFaces) + " of its " +
                               std::to_string(faces) + " faces have no area and are left out");
    if (Failure failure = flood->place(options))
        return *failure;
    flood->measure();
    if (flood->geometry_.triangles.empty())
        return Error{path, "has no face with an area in " + flood->crs.substr(0, 60)};
    flood->setBed();
    if (Failure failure = flood->chooseSteps(options))
        return *failure;
    nodes.positions = {};
    nodes.triangles = {};
    return std::shared_ptr<const FloodData>(std::move(flood));
}

Failure MeshFlood::checkStep(std::size_t step) const {
    if (step < fileStep_.size())
        return {};
    return Error{path, "has no step " + std::to_string(step)};
}

bool MeshFlood::isWet(float value, std::size_t node) const {
    if (!std::isfinite(value))
        return false;
    if (file_->kind == WaterKind::Depth)
        return value > 0.0f;
    return file_->bed.empty() || value > file_->bed[nodes_.source[node]]; // false for a NaN bed
}

Result<std::vector<float>> MeshFlood::values(std::size_t step) const {
    if (Failure failure = checkStep(step))
        return *failure;
    Result<std::vector<float>> water = file_->water(fileStep_[step]);
    if (!water)
        return water;
    std::vector<float> out(geometry_.lonLat.size(), kNoData);
    const bool depths = file_->kind == WaterKind::Depth;
    for (std::size_t i = 0; i < nodes_.source.size(); ++i) {
        const float value = (*water)[nodes_.source[i]];
        if (isWet(value, i))
            out[i] = value;
    }
    meanAtRim(out);
    if (depths)
        return out;
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] += lift_[i];
        if (i >= nodes_.source.size() && !geometry_.bed.empty() && !(out[i] > geometry_.bed[i]))
            out[i] = kNoData;
    }
    return out;
}

Result<std::vector<glm::vec2>> MeshFlood::velocities(std::size_t step) const {
    if (Failure failure = checkStep(step))
        return *failure;
    const auto read = file_->velocity(fileStep_[step]);
    if (!read)
        return read;
    std::vector<float> east(geometry_.lonLat.size()), north(east.size());
    for (std::size_t i = 0; i < nodes_.source.size(); ++i) {
        const glm::vec2 v = (*read)[nodes_.source[i]];
        const float c = std::cos(eastOfX_[i]), s = std::sin(eastOfX_[i]);
        east[i] = c * v.x - s * v.y;
        north[i] = s * v.x + c * v.y;
    }
    meanAtRim(east);
    meanAtRim(north);
    std::vector<glm::vec2> out(east.size());
    for (std::size_t i = 0; i < out.size(); ++i)
        if (std::isfinite(east[i]) && std::isfinite(north[i]))
            out[i] = {east[i], north[i]};
    return out;
}

} // namespace

Result<std::vector<glm::vec2>> MeshFile::velocity(std::size_t) const {
    return std::vector<glm::vec2>();
}

Result<std::shared_ptr<const FloodData>>
floodFrom(const std::string& path, std::unique_ptr<MeshFile> file, const FloodOptions& options) {
    return MeshFlood::make(path, std::move(file), options);
}

namespace {

// NetCDF of today is HDF5 inside; HEC-RAS is HDF5 and nothing else.
Result<ArrayFile> openArrays(const std::string& path) {
    const auto format = ArrayFile::formatOf(path);
    if (!format)
        return Error{path, "is no mesh result that is known: UGRID, ANUGA .sww, HEC-RAS HDF5, "
                           "TELEMAC Selafin"};
    if (*format == ArrayFile::Format::Hdf5) {
        if (Failure failure = checkHdf5(path))
            return *failure;
        // GDAL's two drivers share such files out by their names' endings.
        Result<ArrayFile> hdf = ArrayFile::open(path, ArrayFile::Format::Hdf5);
        if (hdf && isHecRas(*hdf))
            return hdf;
        Result<ArrayFile> netCdf = ArrayFile::open(path, ArrayFile::Format::NetCdf);
        return netCdf || !hdf ? std::move(netCdf) : std::move(hdf);
    }
    if (Failure failure = checkClassicNetCdf(path))
        return *failure;
    return ArrayFile::open(path, *format);
}

Result<std::unique_ptr<MeshFile>> readMesh(const std::string& path, const FloodOptions& options) {
    if (isSelafin(path))
        return readSelafin(path, options);
    Result<ArrayFile> file = openArrays(path);
    if (!file)
        return file.error();
    if (isHecRas(*file))
        return readHecRas(std::move(*file), options);
    if (isSww(*file))
        return readSww(std::move(*file), options);
    return readUgrid(std::move(*file), options);
}

} // namespace

bool isUnstructuredFlood(const std::string& path) {
    if (isSelafin(path))
        return true;
    if (!ArrayFile::formatOf(path))
        return false;
    const Result<ArrayFile> file = openArrays(path);
    if (!file) // our own words say better what is wrong with these
        return path.ends_with(".sww") || path.ends_with(".hdf");
    return isHecRas(*file) || isSww(*file) || isUgrid(*file);
}

Result<std::shared_ptr<const FloodData>> openUnstructuredFlood(const std::string& path,
                                                               const FloodOptions& options) {
    Result<std::unique_ptr<MeshFile>> file = readMesh(path, options);
    if (!file)
        return file.error();
    return floodFrom(path, std::move(*file), options);
}

} // namespace gnomon
