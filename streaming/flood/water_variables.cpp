#include "streaming/flood/water_variables.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace gnomon {

namespace {

constexpr std::array kStandardNames = std::to_array<NamedRole>({
    {"sea_surface_height", WaterRole::Stage},
    {"sea_surface_elevation", WaterRole::Stage},
    {"sea_surface_height_above_geoid", WaterRole::Stage},
    {"sea_surface_height_above_mean_sea_level", WaterRole::Stage},
    {"sea_surface_height_above_reference_ellipsoid", WaterRole::Stage},
    {"water_surface_height_above_reference_datum", WaterRole::Stage},
    {"water_surface_elevation", WaterRole::Stage},
    {"water_level", WaterRole::Stage},
    {"sea_floor_depth_below_sea_surface", WaterRole::Depth},
    {"water_depth", WaterRole::Depth},
    {"depth", WaterRole::Depth},
    {"altitude", WaterRole::Bed},
    {"bed_level", WaterRole::Bed},
    {"ground_surface_altitude", WaterRole::Bed},
    {"sea_floor_altitude", WaterRole::Bed},
    {"height_above_reference_ellipsoid", WaterRole::Bed},
    {"sea_water_x_velocity", WaterRole::VelocityX},
    {"eastward_sea_water_velocity", WaterRole::VelocityX},
    {"sea_water_y_velocity", WaterRole::VelocityY},
    {"northward_sea_water_velocity", WaterRole::VelocityY},
});

} // namespace

std::span<const NamedRole> standardNames() {
    return kStandardNames;
}

const NamedRole* findName(std::span<const NamedRole> names, std::string_view name) {
    const auto found = std::find_if(names.begin(), names.end(),
                                    [&](const NamedRole& named) { return name == named.name; });
    return found != names.end() ? &*found : nullptr;
}

std::optional<long> epsgIn(const ArrayVariable& variable, const char* attribute) {
    std::string code;
    if (const auto number = variable.number(attribute))
        code = std::to_string(std::int64_t(std::clamp(*number, 0.0, 1e9)));
    else if (const auto text = variable.text(attribute))
        code = *text;
    else
        return std::nullopt;
    const std::string digits = code.substr(code.find_last_of(": ") + 1); // npos + 1 is 0
    return std::max(std::strtol(digits.c_str(), nullptr, 10), 0l);
}

std::optional<std::string> systemTextIn(const ArrayVariable& variable) {
    for (const char* attribute : {"crs_wkt", "spatial_ref", "wkt"})
        if (auto text = variable.text(attribute); text && text->find('[') != std::string::npos)
            return text;
    return std::nullopt;
}

} // namespace gnomon
