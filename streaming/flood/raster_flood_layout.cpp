#include "streaming/flood/raster_flood_layout.h"

#include "streaming/flood/lower_case.h"
#include "streaming/flood/unstructured_time.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

namespace gnomon {

namespace {

// Those that maps have besides.
constexpr std::array kMapStandardNames = std::to_array<NamedRole>({
    {"flood_water_thickness", WaterRole::Depth},
    {"surface_altitude", WaterRole::Bed},
});

// As models write them; the surest first.
constexpr std::array kNames = std::to_array<NamedRole>({
    {"zs", WaterRole::Stage},      {"zsmax", WaterRole::Stage}, {"s1", WaterRole::Stage},
    {"stage", WaterRole::Stage},   {"wse", WaterRole::Stage},   {"wsl", WaterRole::Stage},
    {"eta", WaterRole::Stage},     {"zeta", WaterRole::Stage},  {"h", WaterRole::Depth},
    {"hmax", WaterRole::Depth},    {"d", WaterRole::Depth},     {"zb", WaterRole::Bed},
    {"dem", WaterRole::Bed},       {"dtm", WaterRole::Bed},     {"z", WaterRole::Bed},
    {"u", WaterRole::VelocityX},   {"v", WaterRole::VelocityY}, {"ucx", WaterRole::VelocityX},
    {"ucy", WaterRole::VelocityY},
});

// What long and short names speak of, with '_' for ' '.
constexpr std::array kWords = std::to_array<NamedRole>({
    {"water_level", WaterRole::Stage},
    {"waterlevel", WaterRole::Stage},
    {"water_surface", WaterRole::Stage},
    {"surface_elevation", WaterRole::Stage},
    {"sea_surface_height", WaterRole::Stage},
    {"water_depth", WaterRole::Depth},
    {"waterdepth", WaterRole::Depth},
    {"flood_depth", WaterRole::Depth},
    {"inundation", WaterRole::Depth},
    {"bed_level", WaterRole::Bed},
    {"bedlevel", WaterRole::Bed},
    {"bed_elevation", WaterRole::Bed},
    {"topography", WaterRole::Bed},
    {"bathymetry", WaterRole::Bed},
    {"elevation", WaterRole::Bed},
    {"stage", WaterRole::Stage},
    {"depth", WaterRole::Depth},
});

// Depths of something else.
constexpr std::array kOtherWords = {"infiltr", "rain", "precip", "snow", "cumul",
                                    "hazard",  "wave", "soil",   "time", "duration"};

bool isLength(const std::string& unit) {
    const std::string u = lower(unit);
    return u.empty() || u == "m" || u.starts_with("met");
}

std::string shortened(const std::string& text) {
    constexpr std::size_t kLongest = 60;
    std::string line;
    for (const char c : text.substr(0, kLongest))
        line += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    return line;
}

void findRole(GridVariable& field) {
    const std::string name = lower(field.variable.name());
    const std::string standard = lower(field.variable.text("standard_name").value_or(""));
    std::string words = name + " " + lower(field.variable.text("long_name").value_or(""));
    std::replace(words.begin(), words.end(), ' ', '_');
    field.isMaximum =
        (standard + words).find("max") != std::string::npos ||
        lower(field.variable.text("cell_methods").value_or("")).find("max") != std::string::npos;
    const NamedRole* known = findName(standardNames(), standard);
    if (known == nullptr)
        known = findName(kMapStandardNames, standard);
    if (known != nullptr) {
        field.role = known->role;
        field.rank = 0;
        field.because = "standard name " + standard;
        field.isEastNorth = standard.starts_with("eastward") || standard.starts_with("northward");
        return;
    }
    if (std::any_of(kOtherWords.begin(), kOtherWords.end(),
                    [&](const char* w) { return words.find(w) != std::string::npos; }))
        return;
    if (const NamedRole* usual = findName(kNames, name)) {
        field.role = usual->role;
        field.rank = 1;
        field.because = "its name";
        return;
    }
    for (const NamedRole& word : kWords)
        if (words.find(word.name) != std::string::npos) {
            field.role = word.role;
            field.rank = 2;
            field.because = "\"" + std::string(word.name) + "\" in its names";
            return;
        }
}

enum class Axis { X, Y, None };

struct AxisOf {
    Axis axis = Axis::None;
    bool degrees = false;
};

AxisOf axisOf(const ArrayVariable& variable) {
    const std::string standard = lower(variable.text("standard_name").value_or(""));
    const std::string unit = lower(variable.unit());
    const std::string name = lower(variable.name());
    const std::string axis = lower(variable.text("axis").value_or(""));
    const auto isOne = [](const std::string& text, std::initializer_list<const char*> of) {
        return std::any_of(of.begin(), of.end(), [&](const char* w) { return text == w; });
    };
    const bool degrees =
        unit.starts_with("degree") || standard == "longitude" || standard == "latitude";
    if (standard == "longitude" || standard == "projection_x_coordinate" ||
        unit.starts_with("degrees_e") || unit.starts_with("degree_e"))
        return {Axis::X, degrees};
    if (standard == "latitude" || standard == "projection_y_coordinate" ||
        unit.starts_with("degrees_n") || unit.starts_with("degree_n"))
        return {Axis::Y, degrees};
    if (axis == "x" || isOne(name, {"x", "lon", "longitude", "easting", "xc", "x_coordinate"}))
        return {Axis::X, degrees || name.starts_with("lon")};
    if (axis == "y" || isOne(name, {"y", "lat", "latitude", "northing", "yc", "y_coordinate"}))
        return {Axis::Y, degrees || name.starts_with("lat")};
    return {};
}

// No result has more; a file that claims it means to fill the memory.
constexpr std::uint64_t kMostCells = 1u << 28, kMostSteps = 100'000;

std::string listed(const std::vector<GridVariable>& variables) {
    constexpr std::size_t kMost = 12;
    std::string names;
    for (std::size_t i = 0; i < std::min(variables.size(), kMost); ++i)
        names += (i > 0 ? ", " : "") + variables[i].variable.name();
    return shortened(names + (variables.size() > kMost ? "…" : ""));
}

// Is there any water at the first, middle or last step? Maxima that a model never wrote are zeros.
bool holdsWater(const GridVariable& field) {
    for (const std::uint64_t step : {std::uint64_t(0), field.steps / 2, field.steps - 1}) {
        std::vector<std::uint64_t> start(field.variable.dimensions().size(), 0);
        if (field.hasTime())
            start[0] = step;
        std::vector<std::size_t> count(start.size(), 1);
        // In pieces that are never too many for the file.
        const std::size_t rowsAtOnce = std::max<std::size_t>(1'000'000 / field.columns, 1);
        for (std::size_t row = 0; row < field.rows; row += rowsAtOnce) {
            start[start.size() - 2] = row;
            count[count.size() - 2] = std::min(rowsAtOnce, field.rows - row);
            count[count.size() - 1] = field.columns;
            const auto values = field.variable.readBlock(start, count);
            if (!values)
                return true; // reading it for good tells what is wrong
            for (const float v : *values)
                if (std::isfinite(v) && (field.role == WaterRole::Depth ? v > 0.0f : v != 0.0f))
                    return true;
        }
    }
    return false;
}

const char* word(WaterKind kind) {
    return kind == WaterKind::Depth ? "depth" : "level";
}

} // namespace

bool GridVariable::over(const GridVariable& other) const {
    const auto& a = variable.dimensions();
    const auto& b = other.variable.dimensions();
    return a[a.size() - 1].name == b[b.size() - 1].name &&
           a[a.size() - 2].name == b[b.size() - 2].name && rows == other.rows &&
           columns == other.columns;
}

std::vector<GridVariable> findGridVariables(const ArrayFile& file) {
    std::vector<GridVariable> found;
    for (const std::string& name : file.arrays("")) {
        const auto variable = file.find("", name);
        if (!variable || variable->dimensions().size() < 2 || variable->dimensions().size() > 4)
            continue;
        const auto& dimensions = variable->dimensions();
        GridVariable field;
        field.variable = *variable;
        const std::uint64_t rows = dimensions[dimensions.size() - 2].size;
        const std::uint64_t columns = dimensions[dimensions.size() - 1].size;
        if (rows < 2 || columns < 2 || rows > kMostCells / columns)
            continue;
        field.rows = std::size_t(rows);
        field.columns = std::size_t(columns);
        if (field.hasTime())
            field.steps = dimensions[0].size;
        // Layers, ensembles and the like: only where there is one.
        if (field.steps == 0 || field.steps > kMostSteps ||
            (dimensions.size() == 4 && dimensions[1].size != 1))
            continue;
        if (axisOf(*variable).axis != Axis::None)
            continue;
        findRole(field);
        found.push_back(std::move(field));
    }
    return found;
}

namespace {

Result<GridVariable> chooseWater(const ArrayFile& file, const std::vector<GridVariable>& variables,
                                 const FloodOptions& options, std::vector<std::string>& notes) {
    if (options.variable) {
        for (const bool anyCase : {false, true})
            for (const GridVariable& v : variables)
                if (v.variable.name() == *options.variable ||
                    (anyCase && lower(v.variable.name()) == lower(*options.variable)))
                    return v;
        return Error{file.path(), "has no variable '" + *options.variable +
                                      "' over a grid; it has " + listed(variables)};
    }
    std::vector<const GridVariable*> waters;
    for (const GridVariable& v : variables)
        if ((v.role == WaterRole::Stage || v.role == WaterRole::Depth) &&
            isLength(v.variable.unit()))
            waters.push_back(&v);
    const auto order = [&](const GridVariable* v) {
        const bool asked =
            !options.kind || (v->role == WaterRole::Depth) == (*options.kind == WaterKind::Depth);
        return std::tuple(!asked, v->steps == 1, v->isMaximum, v->rank,
                          v->role == WaterRole::Depth);
    };
    std::stable_sort(waters.begin(), waters.end(),
                     [&](const auto* a, const auto* b) { return order(a) < order(b); });
    for (const GridVariable* v : waters) {
        if (!holdsWater(*v)) {
            notes.push_back("its variable '" + v->variable.name() + "' holds no water");
            continue;
        }
        notes.push_back("of its variables '" + shortened(v->variable.name()) + "' is shown, as " +
                        (v->role == WaterRole::Depth ? "depth" : "level") + " (" + v->because +
                        ")");
        return *v;
    }
    // A file of one variable, whatever it is called.
    if (waters.empty() && variables.size() == 1)
        return variables.front();
    if (!waters.empty())
        return Error{file.path(), "holds no water: " + notes.back()};
    return Error{file.path(),
                 variables.empty()
                     ? "holds no numbers over a grid"
                     : "which of its variables is the water? Name one: " + listed(variables)};
}

} // namespace

Result<GridFields> chooseGridFields(const ArrayFile& file, const FloodOptions& options,
                                    std::vector<std::string>& notes) {
    const std::vector<GridVariable> variables = findGridVariables(file);
    Result<GridVariable> water = chooseWater(file, variables, options, notes);
    if (!water)
        return water.error();
    GridFields fields{std::move(*water), WaterKind::Stage, {}, {}, {}};
    const WaterRole role = fields.water.role;
    if (role == WaterRole::Stage || role == WaterRole::Depth) {
        fields.kind = role == WaterRole::Depth ? WaterKind::Depth : WaterKind::Stage;
        if (options.kind && *options.kind != fields.kind)
            notes.push_back("'" + fields.water.variable.name() + "' is no " + word(*options.kind) +
                            " but a " + word(fields.kind) + " (" + fields.water.because +
                            "), and shown so");
    } else if (options.kind) {
        fields.kind = *options.kind;
    } else {
        return Error{file.path(),
                     "is its variable '" + fields.water.variable.name() +
                         "' depth or level? Say depth=FILE or stage=FILE",
                     ErrorKind::Usage};
    }
    for (const GridVariable& v : variables) {
        if (!v.over(fields.water))
            continue;
        const auto better = [&](std::optional<GridVariable>& slot) {
            if (!slot || v.rank < slot->rank)
                slot = v;
        };
        if (v.role == WaterRole::Bed && v.steps == 1 && isLength(v.variable.unit()))
            better(fields.bed);
        else if (v.role == WaterRole::VelocityX && v.steps == fields.water.steps)
            better(fields.velocityX);
        else if (v.role == WaterRole::VelocityY && v.steps == fields.water.steps)
            better(fields.velocityY);
    }
    if (fields.bed)
        notes.push_back("its bed is '" + fields.bed->variable.name() + "' (" + fields.bed->because +
                        ")");
    return fields;
}

namespace {

// Of all nodes: arrays over the same two dimensions.
std::optional<GridCoordinates> coordinatesOfEach(const ArrayFile& file, const GridVariable& water) {
    const auto& over = water.variable.dimensions();
    std::optional<ArrayVariable> x, y;
    bool degrees = false;
    for (const std::string& name : file.arrays("")) {
        const auto variable = file.find("", name);
        if (!variable || variable->dimensions().size() != 2 ||
            variable->dimensions()[0].name != over[over.size() - 2].name ||
            variable->dimensions()[1].name != over[over.size() - 1].name)
            continue;
        const AxisOf axis = axisOf(*variable);
        // A projected pair is the file's own; longitudes beside it are made from it.
        if (axis.axis == Axis::X && (!x || (degrees && !axis.degrees))) {
            x = variable;
            degrees = axis.degrees;
        }
        if (axis.axis == Axis::Y && (!y || (axisOf(*y).degrees && !axis.degrees)))
            y = variable;
    }
    if (!x || !y || axisOf(*x).degrees != axisOf(*y).degrees)
        return std::nullopt;
    auto xs = x->readAll(), ys = y->readAll();
    if (!xs || !ys)
        return std::nullopt;
    return GridCoordinates{std::move(*xs), std::move(*ys), true, true, degrees};
}

std::optional<std::pair<std::vector<double>, AxisOf>> alongDimension(const ArrayFile& file,
                                                                     const std::string& dimension) {
    std::optional<ArrayVariable> best;
    for (const std::string& name : file.arrays("")) {
        const auto variable = file.find("", name);
        if (!variable || variable->dimensions().size() != 1 ||
            variable->dimensions()[0].name != dimension)
            continue;
        // The variable of the dimension's own name is the coordinate, whatever else lies along it.
        if (name == dimension || (!best && axisOf(*variable).axis != Axis::None))
            best = variable;
        if (name == dimension)
            break;
    }
    if (!best)
        return std::nullopt;
    auto values = best->readAll();
    if (!values)
        return std::nullopt;
    return std::pair(std::move(*values), axisOf(*best));
}

} // namespace

Result<GridCoordinates> findGridCoordinates(const ArrayFile& file, const GridVariable& water) {
    const auto& over = water.variable.dimensions();
    auto down = alongDimension(file, over[over.size() - 2].name);
    auto across = alongDimension(file, over[over.size() - 1].name);
    const bool fit =
        down && across && down->first.size() == water.rows && across->first.size() == water.columns;
    // Numbers along a dimension may be mere counts.
    const bool known = fit && down->second.axis != Axis::None && across->second.axis != Axis::None;
    if (!known)
        if (auto each = coordinatesOfEach(file, water);
            each && each->x.size() == water.rows * water.columns &&
            each->y.size() == each->x.size())
            return std::move(*each);
    if (fit) {
        const bool turned = down->second.axis == Axis::X && across->second.axis != Axis::X;
        GridCoordinates out;
        out.xRunsAlongRows = !turned;
        out.degrees = down->second.degrees && across->second.degrees;
        out.x = std::move(turned ? down->first : across->first);
        out.y = std::move(turned ? across->first : down->first);
        return out;
    }
    return Error{file.path(),
                 "does not say where the rows and columns of '" + water.variable.name() + "' lie"};
}

namespace {

// 0: it has an attribute for it, and there is no system in it.
std::optional<long> firstEpsgIn(const ArrayVariable& variable) {
    for (const char* attribute : kEpsgAttributes)
        if (const auto code = epsgIn(variable, attribute))
            return code;
    return std::nullopt;
}

} // namespace

std::optional<std::string> findGridCrs(const ArrayFile& file, const GridVariable& water) {
    if (const std::string text = water.variable.wellKnownText(); !text.empty())
        return text;
    for (const std::string& name : file.arrays("")) {
        const auto variable = file.find("", name);
        if (!variable)
            continue;
        if (const auto code = firstEpsgIn(*variable); code && *code > 0)
            return "EPSG:" + std::to_string(*code);
        if (auto text = systemTextIn(*variable))
            return text;
    }
    for (const char* attribute : kEpsgAttributes)
        if (const auto code = file.number("", attribute); code && *code > 0 && *code < 1e6)
            return "EPSG:" + std::to_string(long(*code));
    return std::nullopt;
}

bool saysCrsZero(const ArrayFile& file) {
    for (const char* attribute : kEpsgAttributes)
        if (const auto code = file.number("", attribute); code && *code == 0)
            return true;
    for (const std::string& name : file.arrays(""))
        if (const auto variable = file.find("", name))
            if (const auto code = firstEpsgIn(*variable); code && *code == 0)
                return true;
    return false;
}

Result<GridTimes> findGridTimes(const ArrayFile& file, const GridVariable& water,
                                std::vector<std::string>& notes) {
    GridTimes times;
    if (!water.hasTime())
        return times;
    const ArrayDimension& dimension = water.variable.dimensions().front();
    std::optional<ArrayVariable> time;
    for (const std::string& name : file.arrays("")) {
        const auto variable = file.find("", name);
        if (!variable || variable->dimensions().size() != 1 ||
            variable->dimensions()[0].name != dimension.name)
            continue;
        const bool says = lower(variable->unit()).find(" since ") != std::string::npos ||
                          lower(variable->text("standard_name").value_or("")) == "time";
        if (says || (name == dimension.name && !time))
            time = variable;
        if (says)
            break;
    }
    if (!time)
        return times;
    const auto values = time->readAll();
    if (!values)
        return values.error();
    StepTimes told = cfTimes(*values, time->unit(), time->text("calendar").value_or(""));
    if (!told.note.empty())
        notes.push_back(told.note);
    times.seconds = std::move(told.seconds);
    times.absolute = told.absolute;
    return times;
}

} // namespace gnomon
