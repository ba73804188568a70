#include "streaming/flood/ugrid.h"

#include "streaming/flood/ugrid_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

class UgridFile final : public MeshFile {
  public:
    explicit UgridFile(ArrayFile file) : file_(std::move(file)) {}

    Failure open(const FloodOptions& options);
    Result<std::vector<float>> water(std::size_t step) const override;
    bool hasVelocity() const override { return u_ && v_; }
    Result<std::vector<glm::vec2>> velocity(std::size_t step) const override;

  private:
    Failure readMesh();
    Failure chooseWater(const FloodOptions& options);
    Failure readTimes();
    Failure readBed();
    Failure bedFromDepth();
    void meanOfCorners(const std::vector<float>& atNodes);
    void findVelocity();
    std::string list() const;
    const UgridField* best(WaterRole role, bool atWater = false) const;
    Result<std::vector<float>> metres(const ArrayVariable& variable, std::size_t step) const;
    Error broken(const std::string& why) const { return {file_.path(), why}; }

    ArrayFile file_;
    UgridTopology topology_;
    ArrayDimension nodes_, faces_;
    std::vector<UgridField> fields_;
    UgridField water_;
    std::optional<ArrayVariable> u_, v_;
};

std::string UgridFile::list() const {
    std::string names;
    for (const UgridField& field : fields_)
        names += (names.empty() ? "" : ", ") + field.variable.name();
    return names.empty() ? "no values on nodes or faces" : names;
}

// The surest field of a role; with `atWater` one that has its values where the water has.
const UgridField* UgridFile::best(WaterRole role, bool atWater) const {
    const UgridField* found = nullptr;
    for (const UgridField& field : fields_)
        if (field.role == role && (!atWater || field.at == water_.at)) {
            // What changes with time before what does not (a maximum), then by how sure it is.
            const bool better = found == nullptr || (field.changes && !found->changes) ||
                                (field.changes == found->changes && field.rank < found->rank);
            if (better)
                found = &field;
        }
    return found;
}

Failure UgridFile::readMesh() {
    const auto found = findUgridTopology(file_);
    if (!found) {
        std::string names;
        for (const std::string& name : file_.arrays(""))
            names += (names.empty() ? "" : ", ") + name;
        return broken(
            "has no mesh that is known (UGRID's mesh_topology, ANUGA's volumes, HEC-RAS's "
            "2D flow areas); it has " +
            (names.empty() ? "nothing" : names));
    }
    topology_ = *found;
    const auto x = file_.find("", topology_.x), y = file_.find("", topology_.y),
               corners = file_.find("", topology_.faceNodes);
    if (x->dimensions().size() != 1 || y->dimensions().size() != 1 ||
        corners->dimensions().size() != 2)
        return broken("its mesh '" + topology_.faceNodes + "' has not the two dimensions of UGRID");
    const auto xs = x->readAll(), ys = y->readAll(), table = corners->readAll();
    for (const auto* read : {&xs, &ys, &table})
        if (!*read)
            return read->error();
    if (xs->size() != ys->size())
        return broken("has " + std::to_string(xs->size()) + " x and " + std::to_string(ys->size()) +
                      " y of nodes");
    nodes_ = x->dimensions()[0];

    // Faces are rows; columns when the file names the second dimension as the faces'.
    const bool turned = !topology_.faceDimension.empty() &&
                        corners->dimensions()[1].name == topology_.faceDimension;
    faces_ = corners->dimensions()[turned ? 1 : 0];
    const std::size_t wide = std::size_t(corners->dimensions()[turned ? 0 : 1].size),
                      count = std::size_t(faces_.size);
    double first = corners->number("start_index").value_or(topology_.isTuflow ? 1.0 : 0.0);
    double highest = -1.0;
    for (const double corner : *table)
        if (corner > highest)
            highest = corner;
    if (first == 0.0 && highest == double(xs->size())) {
        first = 1.0;
        notes.push_back("its faces count nodes from 1, whatever it says");
    }
    for (std::size_t i = 0; i < xs->size(); ++i)
        mesh.points.emplace_back((*xs)[i], (*ys)[i]);
    std::vector<std::uint32_t> face;
    for (std::size_t f = 0; f < count; ++f) {
        face.clear();
        for (std::size_t i = 0; i < wide; ++i) {
            const double corner =
                (turned ? (*table)[i * count + f] : (*table)[f * wide + i]) - first;
            if (!(corner >= 0.0)) // the row is filled up
                continue;
            face.push_back(corner < double(xs->size()) ? std::uint32_t(corner)
                                                       : std::numeric_limits<std::uint32_t>::max());
        }
        mesh.addFace(face.data(), face.size());
    }
    return {};
}

Failure UgridFile::chooseWater(const FloodOptions& options) {
    fields_ = findUgridFields(file_, topology_, nodes_, faces_);
    const UgridField* chosen = nullptr;
    if (options.variable) {
        for (const UgridField& field : fields_)
            if (field.variable.name() == *options.variable)
                chosen = &field;
        if (chosen == nullptr)
            return broken("has no variable '" + *options.variable +
                          "' on its nodes or faces; it "
                          "has " +
                          list());
        const bool known = chosen->role == WaterRole::Stage || chosen->role == WaterRole::Depth;
        if (!options.kind && !known)
            return broken("'" + *options.variable +
                          "' may be a depth or a level: say which (depth= or stage=)");
        kind = options.kind.value_or(chosen->role == WaterRole::Depth ? WaterKind::Depth
                                                                      : WaterKind::Stage);
    } else {
        const UgridField* stage = best(WaterRole::Stage);
        const UgridField* depth = best(WaterRole::Depth);
        chosen = stage != nullptr ? stage : depth;
        if (options.kind)
            chosen = *options.kind == WaterKind::Depth ? depth : stage;
        else if (depth != nullptr && stage != nullptr && depth->changes && !stage->changes)
            chosen = depth;
        if (chosen == nullptr)
            return broken(std::string("has no water ") +
                          (!options.kind                       ? "level or depth"
                           : *options.kind == WaterKind::Depth ? "depth"
                                                               : "level") +
                          " that is known by its name: choose with variable; it has " + list());
        kind = chosen->role == WaterRole::Depth ? WaterKind::Depth : WaterKind::Stage;
    }
    water_ = *chosen;
    at = water_.at;
    if (!metresIn(water_.variable.unit()))
        return broken("'" + water_.variable.name() + "' is in '" +
                      water_.variable.unit().substr(0, 40) + "', which is no length");
    return {};
}

Failure UgridFile::readTimes() {
    if (!water_.changes) {
        times.seconds = {0.0};
        return {};
    }
    const ArrayDimension& steps = water_.variable.dimensions()[0];
    std::optional<ArrayVariable> time = file_.find("", steps.name);
    if (topology_.isTuflow && !time)
        time = file_.find("", "ResTime");
    for (const std::string& name : file_.arrays("")) {
        if (time)
            break;
        auto candidate = file_.find("", name);
        if (candidate && candidate->dimensions().size() == 1 &&
            candidate->dimensions()[0].name == steps.name &&
            (candidate->unit().find(" since ") != std::string::npos ||
             candidate->text("standard_name").value_or("") == "time"))
            time = std::move(candidate);
    }
    std::vector<double> values;
    if (time && time->dimensions().size() == 1 && time->dimensions()[0].size == steps.size) {
        Result<std::vector<double>> read = time->readAll();
        if (!read)
            return read.error();
        values = std::move(*read);
        times = cfTimes(values, time->unit(), time->text("calendar").value_or(""));
        return {};
    }
    constexpr std::uint64_t kMostSteps = 1'000'000;
    if (steps.size > kMostSteps)
        return broken("claims " + std::to_string(steps.size) + " steps");
    times.seconds.assign(std::size_t(steps.size), 0.0); // none is known: see MeshFlood
    return {};
}

Result<std::vector<float>> UgridFile::metres(const ArrayVariable& variable,
                                             std::size_t step) const {
    Result<std::vector<float>> values = variable.readRow(step);
    const double factor = metresIn(variable.unit()).value_or(1.0);
    if (values && factor != 1.0)
        for (float& value : *values)
            value = float(value * factor);
    return values;
}

void UgridFile::meanOfCorners(const std::vector<float>& atNodes) {
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
        double sum = 0.0;
        const std::size_t begin = mesh.starts[f], end = mesh.starts[f + 1];
        for (std::size_t i = begin; i < end; ++i)
            sum += mesh.corners[i] < atNodes.size() ? double(atNodes[mesh.corners[i]])
                                                    : std::numeric_limits<double>::quiet_NaN();
        bed.push_back(float(sum / double(end - begin))); // NaN for a face without corners
    }
}

// Where the file has both level and depth, the bed is between them; as many steps are read as it
// takes until all places were wet once.
Failure UgridFile::bedFromDepth() {
    const UgridField* stage = best(WaterRole::Stage, true);
    const UgridField* depth = best(WaterRole::Depth, true);
    if (stage == nullptr || depth == nullptr || stage->changes != depth->changes)
        return {};
    constexpr std::size_t kMostSteps = 16;
    for (std::size_t step = 0; step < std::min(kMostSteps, times.seconds.size()); ++step) {
        const auto level = metres(stage->variable, step), water = metres(depth->variable, step);
        if (!level || !water)
            return (level ? water : level).error();
        bed.resize(level->size(), std::numeric_limits<float>::quiet_NaN());
        bool complete = true;
        for (std::size_t i = 0; i < bed.size() && i < water->size(); ++i) {
            if (!std::isfinite(bed[i]))
                bed[i] = (*level)[i] - (*water)[i];
            complete = complete && std::isfinite(bed[i]);
        }
        if (complete)
            return {};
    }
    bed.clear(); // beds with holes would hide water: the scene's ground serves
    return {};
}

Failure UgridFile::readBed() {
    const UgridField* here = best(WaterRole::Bed, true);
    const UgridField* anywhere = best(WaterRole::Bed);
    const UgridField* from = here != nullptr ? here : anywhere;
    const bool fromNodes = here == nullptr && from != nullptr && at == ValuesAt::Faces;
    if (from == nullptr || (here == nullptr && !fromNodes))
        return bedFromDepth();
    Result<std::vector<float>> values = metres(from->variable, 0);
    if (!values)
        return values.error();
    if (from->variable.text("positive").value_or("") == "down")
        for (float& value : *values)
            value = -value;
    if (fromNodes)
        meanOfCorners(*values);
    else
        bed = std::move(*values);
    if (std::none_of(bed.begin(), bed.end(), [](float z) { return std::isfinite(z); }))
        bed.clear();
    if (from->changes)
        notes.push_back("its bed '" + from->variable.name() + "' is that of the first step");
    return {};
}

void UgridFile::findVelocity() {
    const UgridField* u = best(WaterRole::VelocityX, true);
    const UgridField* v = best(WaterRole::VelocityY, true);
    const auto fits = [&](const UgridField* field) {
        return field != nullptr && field->changes == water_.changes &&
               field->variable.dimensions().front().size ==
                   water_.variable.dimensions().front().size;
    };
    if (!fits(u) || !fits(v))
        return;
    u_ = u->variable;
    v_ = v->variable;
}

Failure UgridFile::open(const FloodOptions& options) {
    if (Failure failure = readMesh())
        return failure;
    if (Failure failure = chooseWater(options))
        return failure;
    if (Failure failure = readTimes())
        return failure;
    if (Failure failure = readBed())
        return failure;
    findVelocity();
    crs = findUgridCrs(file_, topology_, water_.variable);
    return {};
}

Result<std::vector<float>> UgridFile::water(std::size_t step) const {
    return metres(water_.variable, step);
}

Result<std::vector<glm::vec2>> UgridFile::velocity(std::size_t step) const {
    const auto u = u_->readRow(step), v = v_->readRow(step);
    if (!u || !v)
        return (u ? v : u).error();
    std::vector<glm::vec2> out(std::min(u->size(), v->size()));
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = {(*u)[i], (*v)[i]};
    return out;
}

} // namespace

bool isUgrid(const ArrayFile& file) {
    return findUgridTopology(file).has_value();
}

Result<std::unique_ptr<MeshFile>> readUgrid(ArrayFile file, const FloodOptions& options) {
    auto ugrid = std::make_unique<UgridFile>(std::move(file));
    if (Failure failure = ugrid->open(options))
        return *failure;
    return std::unique_ptr<MeshFile>(std::move(ugrid));
}

} // namespace gnomon
