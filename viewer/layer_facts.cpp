#include "viewer/layer_facts.h"

#include <charconv>
#include <cmath>

namespace gnomon {

namespace {

template <class T>
void fill(std::optional<T>& mine, const std::optional<T>& other) {
    if (!mine)
        mine = other;
}

} // namespace

LayerFacts LayerFacts::orElse(const LayerFacts& other) const {
    LayerFacts all = *this;
    fill(all.crs, other.crs);
    fill(all.heights, other.heights);
    fill(all.placement, other.placement);
    fill(all.up, other.up);
    fill(all.raiseMetres, other.raiseMetres);
    fill(all.heightMetres, other.heightMetres);
    fill(all.widthMetres, other.widthMetres);
    fill(all.heightAttribute, other.heightAttribute);
    fill(all.from, other.from);
    fill(all.until, other.until);
    fill(all.waterKind, other.waterKind);
    fill(all.variable, other.variable);
    fill(all.start, other.start);
    fill(all.stepSeconds, other.stepSeconds);
    fill(all.dryMetres, other.dryMetres);
    fill(all.colors, other.colors);
    fill(all.most, other.most);
    fill(all.look, other.look);
    fill(all.hole, other.hole);
    fill(all.color, other.color);
    return all;
}

std::optional<double> durationSeconds(const std::string& text) {
    double number = 0.0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failed != std::errc() || !std::isfinite(number) || number <= 0.0)
        return {};
    const std::string unit(end, text.data() + text.size());
    if (unit == "s" || unit.empty())
        return number;
    if (unit == "min")
        return 60.0 * number;
    if (unit == "h")
        return 3600.0 * number;
    if (unit == "d")
        return 86400.0 * number;
    return {};
}

std::optional<WaterColors> waterColorsNamed(const std::string& text) {
    if (text == "depth")
        return WaterColors::Depth;
    if (text == "speed" || text == "velocity")
        return WaterColors::Speed;
    if (text == "natural")
        return WaterColors::Natural;
    return {};
}

std::optional<TerrainLook> terrainLookNamed(const std::string& text) {
    if (text == "plain")
        return TerrainLook::Plain;
    if (text == "ramp")
        return TerrainLook::Ramp;
    if (text == "ramp-unlit")
        return TerrainLook::RampUnlit;
    return {};
}

std::optional<WaterKind> waterKindNamed(const std::string& text) {
    if (text == "depth")
        return WaterKind::Depth;
    if (text == "stage" || text == "level")
        return WaterKind::Stage;
    return {};
}

std::optional<std::array<std::uint8_t, 3>> colorNamed(const std::string& text) {
    std::uint32_t rgb = 0;
    if (text.size() != 7 || text[0] != '#')
        return {};
    const auto [end, failed] = std::from_chars(text.data() + 1, text.data() + 7, rgb, 16);
    if (failed != std::errc() || end != text.data() + 7)
        return {};
    return std::array{std::uint8_t(rgb >> 16), std::uint8_t(rgb >> 8), std::uint8_t(rgb)};
}

} // namespace gnomon
