#include "streaming/flood/sww.h"

#include "streaming/flood/lower_case.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace gnomon {

namespace {

// ANUGA lets nothing flow where it is shallower (its minimum_allowed_height).
constexpr float kStillMetres = 1e-3f;

class SwwFile final : public MeshFile {
  public:
    explicit SwwFile(ArrayFile file) : file_(std::move(file)) {}

    Failure open(const FloodOptions& options);
    Result<std::vector<float>> water(std::size_t step) const override;
    bool hasVelocity() const override { return momentumX_ && momentumY_; }
    Result<std::vector<glm::vec2>> velocity(std::size_t step) const override;

  private:
    // What the file has at a step, a corner or a triangle.
    struct Step {
        std::vector<float> stage, elevation;
        float depth(std::size_t i) const { return std::max(stage[i] - elevation[i], 0.0f); }
    };

    Failure chooseVariables(const FloodOptions& options);
    Failure readMesh();
    Failure readBed();
    void readTimes();
    void findCrs();
    void weld(const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& volumes);
    Result<Step> readStep(std::size_t step) const;
    Result<std::vector<float>> row(const ArrayVariable& variable, std::size_t step) const;
    Failure takeMeansWhereGroundJumps(const std::vector<double>& volumes);
    Error broken(const std::string& why) const { return {file_.path(), why}; }
    std::size_t values() const { return bed.size(); }

    ArrayFile file_;
    std::optional<ArrayVariable> stage_, elevation_, momentumX_, momentumY_;
    bool changingBed_ = false;
    bool asked_ = false; // for the corners, by name
    std::size_t triangles_ = 0, points_ = 0;
    std::vector<std::uint32_t> welded_;  // of each point of the file: the one it became
    std::vector<float> weight_;          // of each point of the file: its share of that one
    std::vector<std::uint32_t> corners_; // three a triangle, when their mean is the value
};

Failure SwwFile::chooseVariables(const FloodOptions& options) {
    const std::string wanted = options.variable.value_or("");
    if (!wanted.empty() && wanted != "stage" && wanted != "stage_c")
        return broken("has no water in '" + wanted + "': a .sww has 'stage', and newer 'stage_c'");
    asked_ = wanted == "stage";
    at = file_.find("", "stage_c") && file_.find("", "elevation_c") && !asked_ ? ValuesAt::Faces
                                                                               : ValuesAt::Points;
    const std::string suffix = at == ValuesAt::Faces ? "_c" : "";
    stage_ = file_.find("", "stage" + suffix);
    elevation_ = file_.find("", "elevation" + suffix);
    momentumX_ = file_.find("", "xmomentum" + suffix);
    momentumY_ = file_.find("", "ymomentum" + suffix);
    std::string list;
    for (const std::string& name : file_.arrays(""))
        list += (list.empty() ? "" : ", ") + name;
    if (!stage_ || !elevation_)
        return broken("has no stage and elevation; it has " + list);
    return {};
}

// Corners at the same place, to the last bit, are one point.
void SwwFile::weld(const std::vector<double>& x, const std::vector<double>& y,
                   const std::vector<double>& volumes) {
    struct Hash {
        std::size_t operator()(const std::pair<double, double>& p) const {
            return std::bit_cast<std::uint64_t>(p.first) * 0x9E3779B97F4A7C15u ^
                   std::bit_cast<std::uint64_t>(p.second) * 0xC2B2AE3D27D4EB4Fu;
        }
    };
    std::unordered_map<std::pair<double, double>, std::uint32_t, Hash> places;
    const double left = file_.number("", "xllcorner").value_or(0.0),
                 low = file_.number("", "yllcorner").value_or(0.0);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const auto [place, fresh] =
            places.try_emplace({x[i], y[i]}, std::uint32_t(mesh.points.size()));
        if (fresh)
            mesh.points.emplace_back(x[i] + left, y[i] + low);
        welded_.push_back(place->second);
    }
    weight_.assign(x.size(), 0.0f);
    for (std::size_t t = 0; t + 2 < volumes.size(); t += 3) {
        std::array<std::uint32_t, 3> corner{}, face{};
        for (int i = 0; i < 3; ++i) {
            const double index = volumes[t + std::size_t(i)];
            const bool there = index >= 0.0 && index < double(x.size());
            corner[i] = there ? std::uint32_t(index) : 0;
            face[i] = there ? welded_[corner[i]] : std::numeric_limits<std::uint32_t>::max();
        }
        mesh.addFace(face.data(), 3);
        if (std::max({face[0], face[1], face[2]}) >= mesh.points.size())
            continue;
        const glm::dvec2 a = mesh.points[face[1]] - mesh.points[face[0]],
                         b = mesh.points[face[2]] - mesh.points[face[0]];
        for (const std::uint32_t c : corner)
            weight_[c] += float(std::abs(a.x * b.y - a.y * b.x) / 6.0);
    }
    std::vector<double> sum(mesh.points.size());
    for (std::size_t i = 0; i < weight_.size(); ++i)
        sum[welded_[i]] += weight_[i];
    for (std::size_t i = 0; i < weight_.size(); ++i)
        weight_[i] = sum[welded_[i]] > 0.0 ? float(weight_[i] / sum[welded_[i]]) : 0.0f;
}

Failure SwwFile::readMesh() {
    const auto x = file_.find("", "x"), y = file_.find("", "y"),
               volumes = file_.find("", "volumes");
    if (volumes->dimensions().size() != 2 || volumes->dimensions()[1].size != 3)
        return broken("its 'volumes' are no triangles");
    const auto xs = x->readAll(), ys = y->readAll(), corners = volumes->readAll();
    for (const auto* read : {&xs, &ys, &corners})
        if (!*read)
            return read->error();
    if (xs->size() != ys->size())
        return broken("has " + std::to_string(xs->size()) + " x and " + std::to_string(ys->size()) +
                      " y");
    points_ = xs->size();
    triangles_ = corners->size() / 3;
    weld(*xs, *ys, *corners);
    const std::size_t expected = at == ValuesAt::Faces ? triangles_ : points_;
    for (const auto* variable : {&stage_, &elevation_, &momentumX_, &momentumY_})
        if (*variable && ((*variable)->dimensions().empty() ||
                          (*variable)->dimensions().back().size != expected))
            return broken("'" + (*variable)->name() + "' has not " + std::to_string(expected) +
                          " values a step");
    if (stage_->dimensions().size() != 2)
        return broken("'stage' does not change with time");
    if (at == ValuesAt::Points && !asked_)
        if (Failure failure = takeMeansWhereGroundJumps(*corners))
            return failure;
    if (at == ValuesAt::Faces) {
        welded_ = {};
        weight_ = {};
    }
    return {};
}

// Without the means of triangles, but with ground that jumps between them: then a corner's values
// are extrapolated, and the mean of a triangle's three is the mean that ANUGA computed.
Failure SwwFile::takeMeansWhereGroundJumps(const std::vector<double>& volumes) {
    const Result<std::vector<float>> ground = elevation_->readRow(0);
    if (!ground)
        return ground.error();
    std::vector<float> first(mesh.points.size(), std::numeric_limits<float>::quiet_NaN());
    bool jumps = false;
    for (std::size_t i = 0; i < ground->size(); ++i) {
        float& here = first[welded_[i]];
        jumps |= std::abs((*ground)[i] - here) > kStillMetres;
        here = (*ground)[i];
    }
    if (!jumps)
        return {};
    at = ValuesAt::Faces;
    for (const double corner : volumes) {
        if (!(corner >= 0.0 && corner < double(points_)))
            return broken("its 'volumes' name points that do not exist");
        corners_.push_back(std::uint32_t(corner));
    }
    return {};
}

Result<std::vector<float>> SwwFile::row(const ArrayVariable& variable, std::size_t step) const {
    Result<std::vector<float>> values = variable.readRow(step);
    if (!values || corners_.empty())
        return values;
    std::vector<float> means(triangles_);
    for (std::size_t t = 0; t < triangles_; ++t) {
        double sum = 0.0;
        for (std::size_t i = 3 * t; i < 3 * t + 3; ++i)
            sum += (*values)[corners_[i]];
        means[t] = float(sum / 3.0);
    }
    return means;
}

Result<SwwFile::Step> SwwFile::readStep(std::size_t step) const {
    Result<std::vector<float>> stage = row(*stage_, step);
    if (!stage)
        return stage.error();
    Result<std::vector<float>> elevation = row(*elevation_, step);
    if (!elevation)
        return elevation.error();
    return Step{std::move(*stage), std::move(*elevation)};
}

// The bed of the first step; and whether it changes, by the middle and the last.
Failure SwwFile::readBed() {
    const Result<std::vector<float>> first = row(*elevation_, 0);
    if (!first)
        return first.error();
    if (elevation_->dimensions().size() == 2) {
        const std::uint64_t steps = elevation_->dimensions()[0].size;
        if (steps < times.seconds.size())
            return broken("has fewer steps of elevation than of stage");
        for (const std::uint64_t step : {steps / 2, steps - 1}) {
            const auto later = row(*elevation_, step);
            if (!later)
                return later.error();
            for (std::size_t i = 0; i < first->size(); ++i)
                changingBed_ |= std::abs((*later)[i] - (*first)[i]) > kStillMetres;
        }
    }
    if (welded_.empty()) {
        bed = *first;
    } else {
        bed.assign(mesh.points.size(), 0.0f);
        for (std::size_t i = 0; i < first->size(); ++i)
            bed[welded_[i]] += weight_[i] * (*first)[i];
    }
    if (changingBed_) {
        notes.push_back("its ground changes with time: depths are above the ground of their step, "
                        "shown on that of the first");
        kind = WaterKind::Depth;
    }
    return {};
}

void SwwFile::readTimes() {
    const std::uint64_t steps = stage_->dimensions()[0].size;
    std::vector<double> values;
    if (const auto time = file_.find("", "time"); time && time->dimensions().size() == 1)
        if (Result<std::vector<double>> read = time->readAll())
            values = std::move(*read);
    values.resize(std::size_t(std::min<std::uint64_t>(steps, values.size())));
    const double start = file_.number("", "starttime").value_or(0.0);
    // Seconds since 1970 when it is a date at all; runs without one start at 0 or a little later.
    constexpr double kYear1975 = 157766400.0;
    times.absolute = start > kYear1975;
    times.seconds = std::move(values);
    for (double& second : times.seconds)
        second += times.absolute ? start : 0.0;
}

void SwwFile::findCrs() {
    if (const auto epsg = file_.number("", "epsg"); epsg && *epsg > 0.0) {
        crs = "EPSG:" + std::to_string(std::int64_t(*epsg));
        return;
    }
    const double zone = file_.number("", "zone").value_or(-1.0);
    if (!(zone >= 1.0 && zone <= 60.0))
        return;
    const std::string datum = lower(file_.text("", "datum").value_or("wgs84"));
    const std::string hemisphere = file_.text("", "hemisphere").value_or("");
    const bool south =
        hemisphere == "southern" ||
        (hemisphere.empty() && file_.number("", "false_northing").value_or(0.0) > 0.0);
    int code = (south ? 32700 : 32600) + int(zone);
    if (datum == "gda94" && zone >= 48.0 && zone <= 58.0)
        code = 28300 + int(zone);
    crs = "EPSG:" + std::to_string(code);
    notes.push_back("its UTM zone " + std::to_string(int(zone)) + (south ? " south" : " north") +
                    " is taken for " + *crs);
}

Failure SwwFile::open(const FloodOptions& options) {
    if (Failure failure = chooseVariables(options))
        return failure;
    if (Failure failure = readMesh())
        return failure;
    readTimes();
    if (times.seconds.empty())
        return broken("has no times");
    if (Failure failure = readBed())
        return failure;
    if (options.kind)
        kind = *options.kind;
    findCrs();
    return {};
}

Result<std::vector<float>> SwwFile::water(std::size_t step) const {
    const Result<Step> read = readStep(step);
    if (!read)
        return read.error();
    if (welded_.empty() && kind == WaterKind::Stage)
        return read->stage;
    std::vector<float> out(values(), 0.0f);
    for (std::size_t i = 0; i < read->stage.size(); ++i) {
        const std::size_t to = welded_.empty() ? i : welded_[i];
        out[to] += (welded_.empty() ? 1.0f : weight_[i]) * read->depth(i);
    }
    if (kind == WaterKind::Stage)
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = out[i] > 0.0f ? bed[i] + out[i] : std::numeric_limits<float>::quiet_NaN();
    return out;
}

Result<std::vector<glm::vec2>> SwwFile::velocity(std::size_t step) const {
    const Result<Step> read = readStep(step);
    if (!read)
        return read.error();
    const auto x = row(*momentumX_, step), y = row(*momentumY_, step);
    if (!x || !y)
        return (x ? y : x).error();
    std::vector<glm::vec2> out(values());
    std::vector<float> depth(values());
    for (std::size_t i = 0; i < read->stage.size(); ++i) {
        const std::size_t to = welded_.empty() ? i : welded_[i];
        const float weight = welded_.empty() ? 1.0f : weight_[i];
        out[to] += weight * glm::vec2((*x)[i], (*y)[i]);
        depth[to] += weight * read->depth(i);
    }
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = depth[i] > kStillMetres ? out[i] / depth[i] : glm::vec2(0.0f);
    return out;
}

} // namespace

bool isSww(const ArrayFile& file) {
    for (const char* name : {"x", "y", "volumes", "stage"})
        if (!file.find("", name))
            return false;
    return true;
}

Result<std::unique_ptr<MeshFile>> readSww(ArrayFile file, const FloodOptions& options) {
    auto sww = std::make_unique<SwwFile>(std::move(file));
    if (Failure failure = sww->open(options))
        return *failure;
    return std::unique_ptr<MeshFile>(std::move(sww));
}

} // namespace gnomon
