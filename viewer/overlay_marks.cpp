#include "viewer/overlay_marks.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace gnomon {

namespace {

constexpr double kRounding = 1e-9; // what sums and powers of doubles may be off by, relatively

// A number with a true minus, and no minus before what is written as zero.
std::string numberText(double value, int decimals) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", decimals, std::abs(value));
    const bool zero = std::string_view(text).find_first_not_of("0.") == std::string_view::npos;
    return value < 0.0 && !zero ? "\u2212" + std::string(text) : text;
}

double decadeOf(double value) {
    return std::pow(10.0, std::floor(std::log10(value)));
}

} // namespace

double niceStepAbove(double value) {
    const double decade = decadeOf(value);
    for (const double step : {1.0, 2.0, 5.0})
        if (value <= step * decade * (1.0 + kRounding))
            return step * decade;
    return 10.0 * decade;
}

double niceStepBelow(double value) {
    const double decade = decadeOf(value);
    for (const double step : {10.0, 5.0, 2.0})
        if (value >= step * decade * (1.0 - kRounding))
            return step * decade;
    return decade;
}

std::string Ticks::label(double value) const {
    const int decimals = std::max(0, -int(std::floor(std::log10(step) + kRounding)));
    return numberText(value, std::min(decimals, 9));
}

Ticks ticksBetween(double least, double most, int mostTicks) {
    Ticks ticks;
    const double range = most - least;
    if (!(range > 0.0) || !std::isfinite(range) || range < kRounding * std::abs(most))
        return ticks;
    const auto firstOf = [&](double step) { return std::ceil(least / step - kRounding); };
    const auto countOf = [&](double step) {
        return std::floor(most / step + kRounding) - firstOf(step) + 1.0;
    };
    ticks.step = niceStepAbove(range / std::max(mostTicks, 1));
    while (countOf(ticks.step) > std::max(mostTicks, 2))
        ticks.step = niceStepAbove(1.5 * ticks.step);
    const double first = firstOf(ticks.step), count = countOf(ticks.step);
    for (double i = 0.0; i < count; ++i)
        ticks.values.push_back((first + i) * ticks.step);
    return ticks;
}

std::optional<GroundScale> groundScale(const Camera& camera, Point<Ecef> groundAtCentre) {
    const glm::dvec3 up = ellipsoidNormal(groundAtCentre).xyz;
    const glm::dvec3 f = camera.forward.xyz, r = camera.right.xyz, u = camera.up.xyz;
    const double across = camera.tanHalfWidth(), tall = camera.tanHalfHeight();
    for (const glm::dvec2 corner : {glm::dvec2(-1, -1), {1, -1}, {-1, 1}, {1, 1}})
        if (glm::dot(f + corner.x * across * r + corner.y * tall * u, up) >= 0.0)
            return {};
    const double distance = length(groundAtCentre - camera.position);
    // The ray t beside the centre (in the picture plane at distance 1) meets the level ground at
    // distance · (f + t r) · (f·up) / (f·up + t r·up); this is its derivative at t = 0.
    const double down = glm::dot(f, up);
    const glm::dvec3 step = distance * (r - f * (glm::dot(r, up) / down));
    const double perPixel = 2.0 * tall / std::max(camera.heightPixels, 1);
    const double slope =
        std::max(std::abs(glm::dot(u, up)) * tall, std::abs(glm::dot(r, up)) * across) /
        std::abs(down);
    const double metres = glm::length(step) * perPixel;
    if (!(metres > 0.0) || !std::isfinite(metres))
        return {};
    return GroundScale{metres, slope > 0.1};
}

std::optional<ScaleBar> scaleBar(double metresPerPixel, double mostPixels) {
    const double most = metresPerPixel * mostPixels;
    if (!(most > 0.0) || !std::isfinite(most))
        return {};
    const double metres = niceStepBelow(most);
    constexpr double kMetresPerKilometre = 1000.0;
    ScaleBar bar{metres / metresPerPixel, {}};
    const bool kilometres = metres >= kMetresPerKilometre * (1.0 - kRounding);
    char text[64];
    std::snprintf(text, sizeof text, "%.7g %s", kilometres ? metres / kMetresPerKilometre : metres,
                  kilometres ? "km" : "m");
    bar.label = text;
    return bar;
}

CompassAxes compassAxes(const Camera& camera) {
    constexpr double kFlattestRadians = 25.0 * kRadiansPerDegree;
    const glm::dmat3 enu = ecefFromEnu(geodeticOf(camera.position)).axes();
    const auto local = [&enu](Vector<Ecef> v) { return glm::transpose(enu) * v.xyz; };
    const glm::dvec3 forward = local(camera.forward);
    glm::dvec3 right = local(camera.right), up = local(camera.up);
    const double below = std::asin(std::clamp(-forward.z, -1.0, 1.0));
    if (below < kFlattestRadians) {
        // Tilted down about the level axis across the view. Looking straight up has none: its own
        // will do.
        const glm::dvec3 level(forward.y, -forward.x, 0.0);
        const double size = glm::length(level);
        const glm::dvec3 axis = size > 1e-9 ? level / size : glm::normalize(right);
        const double angle = below - kFlattestRadians; // clockwise seen along the axis
        const auto tilted = [&](glm::dvec3 v) {
            return std::cos(angle) * v + std::sin(angle) * glm::cross(axis, v) +
                   (1.0 - std::cos(angle)) * glm::dot(axis, v) * axis;
        };
        right = tilted(right);
        up = tilted(up);
    }
    return {{right.y, up.y}, {right.x, up.x}};
}

std::string sunText(double azimuthDegrees, double elevationDegrees) {
    // To a tenth, and a full turn is none.
    double tenths = std::fmod(std::round(azimuthDegrees * 10.0), 3600.0);
    tenths += tenths < 0.0 ? 3600.0 : 0.0;
    return "Sun: azimuth " + numberText(tenths / 10.0, 1) + "\u00B0, elevation " +
           numberText(elevationDegrees, 1) + "\u00B0";
}

} // namespace gnomon
