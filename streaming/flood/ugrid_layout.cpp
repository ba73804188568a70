#include "streaming/flood/ugrid_layout.h"

#include "streaming/flood/lower_case.h"

#include <array>
#include <sstream>

namespace gnomon {

namespace {

// After a prefix such as "mesh2d_" is taken off; in order, the surest first.
constexpr std::array kNames = std::to_array<NamedRole>({
    {"s1", WaterRole::Stage},
    {"zs", WaterRole::Stage},
    {"waterlevel", WaterRole::Stage},
    {"water_level", WaterRole::Stage},
    {"stage", WaterRole::Stage},
    {"wse", WaterRole::Stage},
    {"water_surface", WaterRole::Stage},
    {"eta", WaterRole::Stage},
    {"zeta", WaterRole::Stage},
    {"zsmax", WaterRole::Stage},
    {"waterdepth", WaterRole::Depth},
    {"water_depth", WaterRole::Depth},
    {"depth", WaterRole::Depth},
    {"h", WaterRole::Depth},
    {"hmax", WaterRole::Depth},
    {"flowelem_bl", WaterRole::Bed},
    {"zb", WaterRole::Bed},
    {"bed", WaterRole::Bed},
    {"bed_level", WaterRole::Bed},
    {"bedlevel", WaterRole::Bed},
    {"node_z", WaterRole::Bed},
    {"face_z", WaterRole::Bed},
    {"elevation", WaterRole::Bed},
    {"z", WaterRole::Bed},
    {"ucx", WaterRole::VelocityX},
    {"ucy", WaterRole::VelocityY},
    {"u", WaterRole::VelocityX},
    {"v", WaterRole::VelocityY},
    {"velocity_x", WaterRole::VelocityX},
    {"velocity_y", WaterRole::VelocityY},
});

// TUFLOW FV's: there H is the level.
constexpr std::array kTuflowNames = std::to_array<NamedRole>({
    {"h", WaterRole::Stage},
    {"d", WaterRole::Depth},
    {"cell_zb", WaterRole::Bed},
    {"node_zb", WaterRole::Bed},
    {"v_x", WaterRole::VelocityX},
    {"v_y", WaterRole::VelocityY},
});

bool findIn(std::span<const NamedRole> table, const std::string& name, int firstRank,
            UgridField& field) {
    const NamedRole* found = findName(table, name);
    if (found == nullptr)
        return false;
    field.role = found->role;
    field.rank = firstRank + int(found - table.data());
    return true;
}

void findRole(const UgridTopology& topology, UgridField& field) {
    const std::string name = lower(field.variable.name());
    if (topology.isTuflow) {
        findIn(kTuflowNames, name, 0, field);
        return;
    }
    const std::string standard = lower(field.variable.text("standard_name").value_or(""));
    if (findIn(standardNames(), standard, 0, field))
        return;
    const int after = int(standardNames().size());
    if (findIn(kNames, name, after, field))
        return;
    // "mesh2d_s1", "Mesh2_zs": what is left of each underscore may be the mesh's name.
    for (std::size_t at = name.find('_'); at != std::string::npos; at = name.find('_', at + 1))
        if (findIn(kNames, name.substr(at + 1), after, field))
            return;
}

std::optional<std::string> crsFrom(const ArrayVariable& variable) {
    for (const char* attribute : kEpsgAttributes)
        if (const auto code = epsgIn(variable, attribute); code && *code > 0)
            return "EPSG:" + std::to_string(*code);
    return systemTextIn(variable);
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
        if (field.role == WaterRole::Depth && !field.changes &&
            lower(field.variable.text("positive").value_or("")) == "down")
            field.role = WaterRole::None;
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
