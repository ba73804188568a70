#include "streaming/flood/hecras.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace gnomon {

namespace {

const std::string kGeometry = "Geometry/2D Flow Areas";
const std::string kBlocks = "Results/Unsteady/Output/Output Blocks";

// How much each face's velocity, along its normal, tells of its cell's: the least-squares fit, each
// face by its length.
struct CellVelocity {
    std::vector<std::uint32_t> starts{0};
    std::vector<std::uint32_t> faces;
    std::vector<glm::vec2> weights;
};

struct Area {
    std::string name;
    std::size_t cells = 0, firstCell = 0; // of all areas'
    ArrayVariable water;
    std::optional<ArrayVariable> faceVelocity;
    CellVelocity velocity;
};

class HecRasFile final : public MeshFile {
  public:
    explicit HecRasFile(ArrayFile file) : file_(std::move(file)) {}

    Failure open(const FloodOptions& options);
    Result<std::vector<float>> water(std::size_t step) const override;
    bool hasVelocity() const override {
        return std::all_of(areas_.begin(), areas_.end(),
                           [](const Area& area) { return area.faceVelocity.has_value(); });
    }
    Result<std::vector<glm::vec2>> velocity(std::size_t step) const override;

  private:
    Failure findResults();
    Failure findUnit();
    Failure readTimes();
    Failure addArea(const std::string& name, const FloodOptions& options);
    Failure addCells(const std::string& group, std::size_t cells);
    Result<ArrayVariable> findWater(const std::string& group, const FloodOptions& options);
    Result<CellVelocity> velocityOf(const std::string& group, std::size_t cells) const;
    Result<std::vector<double>> table(const std::string& group, const std::string& name,
                                      std::size_t columns) const;
    void noteVolume();
    Result<double> tableVolume(const Area& area, const std::vector<float>& level) const;
    Error broken(const std::string& why) const { return {file_.path(), why}; }

    ArrayFile file_;
    std::string results_; // the group of time series
    double metresPerUnit_ = 1.0;
    std::vector<Area> areas_;
};

// A matrix of numbers with at least so many columns, row by row.
Result<std::vector<double>> HecRasFile::table(const std::string& group, const std::string& name,
                                              std::size_t columns) const {
    const auto variable = file_.find(group, name);
    if (!variable)
        return broken("has no '" + group + "/" + name + "'");
    const auto& dimensions = variable->dimensions();
    const std::uint64_t wide = dimensions.size() == 2 ? dimensions[1].size : 1;
    if (dimensions.empty() || dimensions.size() > 2 || wide != columns)
        return broken("'" + group + "/" + name + "' has not " + std::to_string(columns) +
                      " columns");
    return variable->readAll();
}

Failure HecRasFile::findResults() {
    std::vector<std::string> blocks = file_.groups(kBlocks);
    // The block of all cells; others are hydrographs at places.
    std::stable_sort(blocks.begin(), blocks.end(), [](const std::string& a, const std::string& b) {
        return (a == "Base Output") > (b == "Base Output");
    });
    for (const std::string& block : blocks) {
        results_ = kBlocks + "/" + block + "/Unsteady Time Series";
        if (!file_.groups(results_ + "/2D Flow Areas").empty())
            return {};
    }
    return broken("is HEC-RAS, but has no unsteady results of 2D flow areas");
}

Failure HecRasFile::findUnit() {
    const std::string system = file_.text("", "Units System").value_or("");
    const std::string si = file_.text("Geometry", "SI Units").value_or("");
    if (system.starts_with("US") || (system.empty() && si == "False"))
        metresPerUnit_ = 0.3048;
    else if (!system.starts_with("SI") && si != "True")
        notes.push_back("does not say its units; taken for metres");
    crs = file_.text("", "Projection");
    return {};
}

Failure HecRasFile::readTimes() {
    for (const char* name : {"Time Date Stamp", "Time Date Stamp (ms)", "Time Date Stamp Milli"}) {
        const auto stamps = file_.find(results_, name);
        if (!stamps)
            continue;
        const auto texts = stamps->readTexts();
        if (!texts)
            continue;
        times.seconds.clear();
        for (const std::string& text : *texts)
            times.seconds.push_back(
                hecTime(text).value_or(std::numeric_limits<double>::quiet_NaN()));
        times.absolute = std::any_of(times.seconds.begin(), times.seconds.end(),
                                     [](double t) { return std::isfinite(t); });
        if (times.absolute) {
            times.note = "its times name no zone; taken for UTC";
            return {};
        }
    }
    const auto days = file_.find(results_, "Time");
    if (!days)
        return broken("has no times of its steps");
    Result<std::vector<double>> values = days->readAll();
    if (!values)
        return values.error();
    times = cfTimes(*values, "days", "");
    return {};
}

Result<ArrayVariable> HecRasFile::findWater(const std::string& group, const FloodOptions& options) {
    if (options.variable) {
        const auto variable = file_.find(group, *options.variable);
        const bool depth = options.variable->find("Depth") != std::string::npos;
        if (!variable) {
            std::string list;
            for (const std::string& name : file_.arrays(group))
                list += (list.empty() ? "" : ", ") + name;
            return broken("has no '" + *options.variable + "'; it has " + list);
        }
        kind = options.kind.value_or(depth ? WaterKind::Depth : WaterKind::Stage);
        return *variable;
    }
    const bool depths = options.kind == WaterKind::Depth;
    for (const char* name : {"Water Surface", "Depth", "Cell Invert Depth"}) {
        const bool depth = std::string(name) != "Water Surface";
        if (depth != depths && options.kind)
            continue;
        if (const auto variable = file_.find(group, name)) {
            kind = depth ? WaterKind::Depth : WaterKind::Stage;
            return *variable;
        }
    }
    std::string list;
    for (const std::string& name : file_.arrays(group))
        list += (list.empty() ? "" : ", ") + name;
    return broken(std::string("has no '") + (depths ? "Depth" : "Water Surface") + "' in '" +
                  group + "'; it has " + list);
}

Failure HecRasFile::addCells(const std::string& group, std::size_t cells) {
    const auto points = table(group, "FacePoints Coordinate", 2);
    if (!points)
        return points.error();
    const auto indexes = file_.find(group, "Cells FacePoint Indexes");
    if (!indexes || indexes->dimensions().size() != 2 || indexes->dimensions()[0].size != cells)
        return broken("has no 'Cells FacePoint Indexes' for the cells of '" + group + "'");
    const auto corners = indexes->readAll();
    if (!corners)
        return corners.error();
    Result<std::vector<double>> lowest = table(group, "Cells Minimum Elevation", 1);
    if (!lowest)
        return lowest.error();
    if (lowest->size() != cells)
        return broken("has not one minimum elevation a cell in '" + group + "'");
    std::vector<double> areas(cells, 0.0);
    if (auto own = table(group, "Cells Surface Area", 1); own && own->size() == cells)
        areas = std::move(*own);

    const std::size_t first = mesh.points.size(), count = points->size() / 2;
    for (std::size_t i = 0; i < count; ++i)
        mesh.points.emplace_back((*points)[2 * i], (*points)[2 * i + 1]);
    const std::size_t wide = cells == 0 ? 0 : corners->size() / cells;
    std::vector<std::uint32_t> face;
    for (std::size_t cell = 0; cell < cells; ++cell) {
        face.clear();
        for (std::size_t i = 0; i < wide; ++i) {
            const double index = (*corners)[cell * wide + i];
            if (!(index >= 0.0)) // the row is filled up with -1
                continue;
            face.push_back(index < double(count) ? std::uint32_t(first + std::size_t(index))
                                                 : std::numeric_limits<std::uint32_t>::max());
        }
        mesh.addFace(face.data(), face.size());
        bed.push_back(float((*lowest)[cell] * metresPerUnit_));
        faceArea.push_back(areas[cell]);
    }
    return {};
}

Result<CellVelocity> HecRasFile::velocityOf(const std::string& group, std::size_t cells) const {
    const auto info = table(group, "Cells Face and Orientation Info", 2);
    const auto lists = table(group, "Cells Face and Orientation Values", 2);
    const auto normals = table(group, "Faces NormalUnitVector and Length", 3);
    for (const auto* read : {&info, &lists, &normals})
        if (!*read)
            return read->error();
    if (info->size() != 2 * cells)
        return broken("'" + group + "' has not one list of faces a cell");
    CellVelocity out;
    for (std::size_t cell = 0; cell < cells; ++cell) {
        const double start = (*info)[2 * cell], count = (*info)[2 * cell + 1];
        const bool sound = start >= 0.0 && count >= 0.0 && count <= double(kMaxFaceCorners) &&
                           start + count <= double(lists->size() / 2);
        const std::size_t begin = out.faces.size();
        glm::dvec3 sum(0.0); // of l nx nx, l nx ny, l ny ny
        for (std::size_t i = 0; sound && i < std::size_t(count); ++i) {
            const double face = (*lists)[2 * (std::size_t(start) + i)];
            if (!(face >= 0.0 && face < double(normals->size() / 3)))
                continue;
            const double* n = normals->data() + 3 * std::size_t(face);
            sum += n[2] * glm::dvec3(n[0] * n[0], n[0] * n[1], n[1] * n[1]);
            out.faces.push_back(std::uint32_t(face));
        }
        const double determinant = sum.x * sum.z - sum.y * sum.y;
        for (std::size_t i = begin; i < out.faces.size(); ++i) {
            const double* n = normals->data() + 3 * std::size_t(out.faces[i]);
            const glm::dvec2 weight =
                n[2] / determinant *
                glm::dvec2(sum.z * n[0] - sum.y * n[1], sum.x * n[1] - sum.y * n[0]);
            // Faces all one way tell nothing across.
            const double trace = sum.x + sum.z;
            out.weights.push_back(determinant > 1e-6 * trace * trace ? glm::vec2(weight)
                                                                     : glm::vec2(0.0f));
        }
        out.starts.push_back(std::uint32_t(out.faces.size()));
    }
    return out;
}

Failure HecRasFile::addArea(const std::string& name, const FloodOptions& options) {
    const std::string group = kGeometry + "/" + name;
    const std::string results = results_ + "/2D Flow Areas/" + name;
    Result<ArrayVariable> water = findWater(results, options);
    if (!water)
        return water.error();
    if (water->dimensions().size() != 2)
        return broken("'" + water->name() + "' of '" + name + "' is no table of steps and cells");
    Area area;
    area.name = name;
    area.cells = std::size_t(water->dimensions()[1].size);
    area.firstCell = mesh.faces();
    area.water = std::move(*water);
    if (area.water.dimensions()[0].size < times.seconds.size())
        return broken("'" + area.water.name() + "' of '" + name + "' has " +
                      std::to_string(area.water.dimensions()[0].size) + " steps of " +
                      std::to_string(times.seconds.size()));
    if (Failure failure = addCells(group, area.cells))
        return failure;
    area.faceVelocity = file_.find(results, "Face Velocity");
    if (area.faceVelocity) {
        if (auto velocity = velocityOf(group, area.cells))
            area.velocity = std::move(*velocity);
        else
            area.faceVelocity.reset();
    }
    areas_.push_back(std::move(area));
    return {};
}

Result<double> HecRasFile::tableVolume(const Area& area, const std::vector<float>& level) const {
    const std::string group = kGeometry + "/" + area.name;
    const auto info = table(group, "Cells Volume Elevation Info", 2);
    const auto rows = table(group, "Cells Volume Elevation Values", 2);
    if (!info || !rows)
        return (info ? rows : info).error();
    if (info->size() != 2 * area.cells)
        return broken("'" + group + "' has not one table of volumes a cell");
    double sum = 0.0;
    for (std::size_t cell = 0; cell < area.cells; ++cell) {
        const double start = (*info)[2 * cell], count = (*info)[2 * cell + 1];
        if (!(start >= 0.0 && count >= 1.0 && start + count <= double(rows->size() / 2)))
            continue;
        const double* row = rows->data() + 2 * std::size_t(start);
        const std::size_t last = std::size_t(count) - 1;
        const double z = level[cell];
        std::size_t above = 0;
        while (above <= last && row[2 * above] < z)
            ++above;
        if (above == 0)
            continue;
        const double below = row[2 * (above - 1)], volume = row[2 * (above - 1) + 1];
        if (above > last) // over the highest ground: a prism
            sum += volume + (z - below) * faceArea[area.firstCell + cell];
        else
            sum += volume + (row[2 * above + 1] - volume) * (z - below) / (row[2 * above] - below);
    }
    return sum;
}

void HecRasFile::noteVolume() {
    if (kind != WaterKind::Stage)
        return;
    double tables = 0.0, cells = 0.0;
    for (const Area& area : areas_) {
        const auto level = area.water.readRow(times.seconds.size() - 1);
        const auto volume = level ? tableVolume(area, *level) : Result<double>(broken(""));
        if (!volume)
            return;
        tables += *volume;
        for (std::size_t cell = 0; cell < area.cells; ++cell) {
            const double depth = (*level)[cell] - bed[area.firstCell + cell] / metresPerUnit_;
            if (depth > 0.0)
                cells += depth * faceArea[area.firstCell + cell];
        }
    }
    const double cubic = metresPerUnit_ * metresPerUnit_ * metresPerUnit_;
    char text[256];
    std::snprintf(text, sizeof text,
                  "depths are above each cell's lowest point, so depth times area overstates the "
                  "volume: %.4g m3 at the last step, where HEC-RAS's own tables say %.4g m3",
                  cells * cubic, tables * cubic);
    notes.emplace_back(text);
}

Failure HecRasFile::open(const FloodOptions& options) {
    at = ValuesAt::Faces;
    if (Failure failure = findResults())
        return failure;
    if (Failure failure = findUnit())
        return failure;
    if (Failure failure = readTimes())
        return failure;
    if (times.seconds.empty())
        return broken("has no step of time");
    for (const std::string& name : file_.groups(results_ + "/2D Flow Areas")) {
        const std::size_t faces = mesh.faces();
        if (Failure failure = addArea(name, options))
            leftOut.push_back(
                {failure->subject, "2D flow area '" + name + "': " + failure->reason});
        if (areas_.empty() || areas_.back().firstCell + areas_.back().cells != mesh.faces()) {
            mesh.starts.resize(faces + 1); // an area that failed half-way
            mesh.corners.resize(mesh.starts.back());
            bed.resize(faces);
            faceArea.resize(faces);
        }
    }
    if (areas_.empty())
        return leftOut.empty() ? broken("has no 2D flow area") : leftOut.front();
    noteVolume();
    return {};
}

Result<std::vector<float>> HecRasFile::water(std::size_t step) const {
    std::vector<float> out;
    for (const Area& area : areas_) {
        const auto values = area.water.readRow(step);
        if (!values)
            return values.error();
        for (const float value : *values)
            out.push_back(float(value * metresPerUnit_));
    }
    return out;
}

Result<std::vector<glm::vec2>> HecRasFile::velocity(std::size_t step) const {
    std::vector<glm::vec2> out;
    for (const Area& area : areas_) {
        const auto values = area.faceVelocity->readRow(step);
        if (!values)
            return values.error();
        const CellVelocity& fit = area.velocity;
        for (std::size_t cell = 0; cell < area.cells; ++cell) {
            glm::vec2 sum(0.0f);
            for (std::size_t i = fit.starts[cell]; i < fit.starts[cell + 1]; ++i)
                if (fit.faces[i] < values->size() && std::isfinite((*values)[fit.faces[i]]))
                    sum += fit.weights[i] * (*values)[fit.faces[i]];
            out.push_back(float(metresPerUnit_) * sum);
        }
    }
    return out;
}

} // namespace

bool isHecRas(const ArrayFile& file) {
    return !file.groups(kGeometry).empty();
}

Result<std::unique_ptr<MeshFile>> readHecRas(ArrayFile file, const FloodOptions& options) {
    auto hecRas = std::make_unique<HecRasFile>(std::move(file));
    if (Failure failure = hecRas->open(options))
        return *failure;
    return std::unique_ptr<MeshFile>(std::move(hecRas));
}

} // namespace gnomon
