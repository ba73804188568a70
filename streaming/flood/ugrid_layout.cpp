#include "streaming/flood/ugrid_layout.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace gnomon {

namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

struct NamedRole {
    const char* name;
    UgridRole role;
};

constexpr std::array kStandardNames = std::to_array<NamedRole>({
    {"sea_surface_height", UgridRole::Stage},
    {"sea_surface_elevation", UgridRole::Stage},
    {"sea_surface_height_above_geoid", UgridRole::Stage},
    {"sea_surface_height_above_mean_sea_level", UgridRole::Stage},
    {"sea_surface_height_above_reference_ellipsoid", UgridRole::Stage},
    {"water_surface_height_above_reference_datum", UgridRole::Stage},
    {"water_surface_elevation", UgridRole::Stage},
    {"water_level", UgridRole::Stage},
    {"sea_floor_depth_below_sea_surface", UgridRole::Depth},
    {"water_depth", UgridRole::Depth},
    {"depth", UgridRole::Depth},
    {"altitude", UgridRole::Bed},
    {"bed_level", UgridRole::Bed},
    {"ground_surface_altitude", UgridRole::Bed},
    {"sea_floor_altitude", UgridRole::Bed},
    {"height_above_reference_ellipsoid", UgridRole::Bed},
    {"sea_water_x_velocity", UgridRole::VelocityX},
    {"eastward_sea_water_velocity", UgridRole::VelocityX},
    {"sea_water_y_velocity", UgridRole::VelocityY},
    {"northward_sea_water_velocity", UgridRole::VelocityY},
});

// After a prefix such as "mesh2d_" is taken off; in order, the surest first.
constexpr std::array kNames = std::to_array<NamedRole>({
    {"s1", UgridRole::Stage},
    {"zs", UgridRole::Stage},
    {"waterlevel", UgridRole::Stage},
    {"water_level", UgridRole::Stage},
    {"stage", UgridRole::Stage},
    {"wse", UgridRole::Stage},
    {"water_surface", UgridRole::Stage},
    {"eta", UgridRole::Stage},
    {"zeta", UgridRole::Stage},
    {"zsmax", UgridRole::Stage},
    {"waterdepth", UgridRole::Depth},
    {"water_depth", UgridRole::Depth},
    {"depth", UgridRole::Depth},
    {"h", UgridRole::Depth},
    {"hmax", UgridRole::Depth},
    {"flowelem_bl", UgridRole::Bed},
    {"zb", UgridRole::Bed},
    {"bed", UgridRole::Bed},
    {"bed_level", UgridRole::Bed},
    {"bedlevel", UgridRole::Bed},
    {"node_z", UgridRole::Bed},
    {"face_z", UgridRole::Bed},
    {"elevation", UgridRole::Bed},
    {"z", UgridRole::Bed},
    {"ucx", UgridRole::VelocityX},
    {"ucy", UgridRole::VelocityY},
    {"u", UgridRole::VelocityX},
    {"v", UgridRole::VelocityY},
    {"velocity_x", UgridRole::VelocityX},
    {"velocity_y", UgridRole::VelocityY},
});

// TUFLOW FV's: there H is the level.
constexpr std::array kTuflowNames = std::to_array<NamedRole>({
    {"h", UgridRole::Stage},
    {"d", UgridRole::Depth},
    {"cell_zb", UgridRole::Bed},
    {"node_zb", UgridRole::Bed},
    {"v_x", UgridRole::VelocityX},
    {"v_y", UgridRole::VelocityY},
});

template <std::size_t N>
bool findIn(const std::array<NamedRole, N>& table, const std::string& name, int firstRank,
            UgridField& field) {
    for (std::size_t i = 0; i < N; ++i)
        if (name == table[i].name) {
            field.role = table[i].role;
            field.rank = firstRank + int(i);
            return true;
        }
    return false;
}

void findRole(const UgridTopology& topology, UgridField& field) {
    const std::string name = lower(field.variable.name());
    if (topology.isTuflow) {
        findIn(kTuflowNames, name, 0, field);
        return;
    }
    const std::string standard = lower(field.variable.text("standard_name").value_or(""));
    if (findIn(kStandardNames, standard, 0, field))
        return;
    const int after = int(kStandardNames.size());
    if (findIn(kNames, name, after, field))
        return;
    // "mesh2d_s1", "Mesh2_zs": what is left of each underscore may be the mesh's name.
    for (std::size_t at = name.find('_'); at != std::string::npos; at = name.find('_', at + 1))
        if (findIn(kNames, name.substr(at + 1), after, field))
            return;
}

std::optional<std::string> crsFrom(const ArrayVariable& variable) {
    for (const char* name : {"EPSG_code", "epsg_code", "EPSG", "epsg"}) {
        std::string code;
        if (const auto number = variable.number(name))
            code = std::to_string(std::int64_t(std::clamp(*number, 0.0, 1e9)));
        else if (const auto text = variable.text(name))
            code = *text;
        const std::string digits = code.substr(code.find_last_of(": ") + 1); // npos + 1 is 0
        const long value = std::strtol(digits.c_str(), nullptr, 10);
        if (value > 0)
            return "EPSG:" + std::to_string(value);
    }
    for (const char* name : {"crs_wkt", "spatial_ref", "wkt"})
        if (const auto text = variable.text(name); text && text->find('[') != std::string::npos)
            return text;
    return std::nullopt;
}

} // namespace

std::optional<UgridTopology> findUgridTopology(const ArrayFile& file) {
    if (file.find("", "cell_node") && file.find("", "node_X") && file.find("", "node_Y"))
        return UgridTopology{"node_X", "node_Y", "cell_node", "", true};
    for (const std::string& name : file.arrays("")) {
        const auto variable = file.find("", name);
        if (!variable)
            continue;
        const auto faces = variable->text("face_node_connectivity");
        const auto nodes = variable->text("node_coordinates");
        if (!faces || !nodes)
            continue;
        UgridTopology topology;
        std::istringstream(*nodes) >> topology.x >> topology.y;
        topology.faceNodes = *faces;
        topology.faceDimension = variable->text("face_dimension").value_or("");
        if (file.find("", topology.x) && file.find("", topology.y) &&
            file.find("", topology.faceNodes))
            return topology;
    }
    return std::nullopt;
}

std::vector<UgridField> findUgridFields(const ArrayFile& file, const UgridTopology& topology,
                                        const ArrayDimension& nodes, const ArrayDimension& faces) {
    std::vector<UgridField> fields;
    for (const std::string& name : file.arrays("")) {
        if (name == topology.x || name == topology.y || name == topology.faceNodes)
            continue;
        auto variable = file.find("", name);
        if (!variable || variable->dimensions().empty() || variable->dimensions().size() > 2)
            continue;
        const std::string& last = variable->dimensions().back().name;
        if (last != nodes.name && last != faces.name)
            continue;
        UgridField field{std::move(*variable)};
        field.at = last == faces.name ? ValuesAt::Faces : ValuesAt::Points;
        field.changes = field.variable.dimensions().size() == 2;
        findRole(topology, field);
        // A depth below a datum that never changes is a bed, not water; it is not guessed at.
        if (field.role == UgridRole::Depth && !field.changes &&
            lower(field.variable.text("positive").value_or("")) == "down")
            field.role = UgridRole::None;
        fields.push_back(std::move(field));
    }
    return fields;
}

std::optional<std::string> findUgridCrs(const ArrayFile& file, const UgridTopology& topology,
                                        const ArrayVariable& data) {
    std::vector<std::string> names;
    if (const auto mapping = data.text("grid_mapping"))
        names.push_back(*mapping);
    for (const std::string& name : file.arrays(""))
        names.push_back(name);
    for (const std::string& name : names) {
        const auto variable = file.find("", name);
        // A variable that is only there for its attributes.
        if (!variable || variable->dimensions().size() > 1 ||
            (variable->dimensions().size() == 1 && variable->dimensions()[0].size > 1))
            continue;
        if (auto crs = crsFrom(*variable))
            return crs;
    }
    if (std::string text = data.wellKnownText(); !text.empty())
        return text;
    const auto x = file.find("", topology.x);
    const bool degrees = x && (x->unit().starts_with("degree") ||
                               x->text("standard_name").value_or("") == "longitude");
    const auto spherical = file.find("", "node_X") ? file.text("", "spherical") : std::nullopt;
    if (degrees || lower(spherical.value_or("")) == "true")
        return "EPSG:4326";
    return std::nullopt;
}

std::optional<double> metresIn(const std::string& unit) {
    const std::string name = lower(unit);
    if (name.empty() || name == "m" || name.starts_with("met") || name == "1" || name == "-")
        return 1.0;
    if (name == "us-ft" || name.find("survey") != std::string::npos)
        return 1200.0 / 3937.0;
    if (name == "ft" || name == "foot" || name == "feet")
        return 0.3048;
    if (name == "cm")
        return 0.01;
    if (name == "mm")
        return 0.001;
    return std::nullopt;
}

} // namespace gnomon
