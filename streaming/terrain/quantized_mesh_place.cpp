#include "streaming/terrain/quantized_mesh_pyramid.h"

#include "geo/ellipsoid.h"

#include <charconv>
#include <cmath>

namespace gnomon {

namespace {

constexpr unsigned kDeepestSought = 26; // half a metre across

bool isFinite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// How far the tile's vertices, put in this place, are from the middle of its bounding sphere, as a
// share of the sphere's radius: about 1 in its own place.
double reachIn(const QuantizedTile& tile, const QuantizedPlace& place, bool webMercator) {
    const std::array<double, 4> extent = extentOf(place, webMercator);
    constexpr std::size_t kLooks = 2000;
    const std::size_t step = std::max<std::size_t>(1, tile.u.size() / kLooks);
    double farthest = 0.0;
    for (std::size_t i = 0; i < tile.u.size(); i += step) {
        const glm::dvec2 at = lonLatOf({tile.u[i], tile.v[i]}, extent);
        const Point<Ecef> p = ecefOf({at.x, at.y, tile.heightMetres(tile.height[i])});
        farthest = std::max(farthest, glm::length(p.xyz - tile.header.sphereCentre));
    }
    return farthest / tile.header.sphereRadiusMetres;
}

// The tile of a level whose extent holds a place.
QuantizedPlace around(glm::dvec2 lonLat, unsigned level, bool webMercator) {
    const auto index = [](double share, std::uint64_t count) {
        return std::uint32_t(std::clamp(share * double(count), 0.0, double(count) - 1.0));
    };
    double row = (lonLat.y + 90.0) / 180.0;
    if (webMercator)
        row = 0.5 + std::asinh(std::tan(lonLat.y * kRadiansPerDegree)) / (2.0 * std::numbers::pi);
    return {level, index((lonLat.x + 180.0) / 360.0, columnsOf(level, webMercator)),
            index(row, rowsOf(level))};
}

std::optional<std::uint32_t> number(const std::string& text) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(value)
                                                                    : std::nullopt;
}

// "z/x/y.terrain" at the end of a path, "z_x_y.terrain" as its name.
std::optional<QuantizedPlace> namedBy(std::string path) {
    if (const std::size_t dot = path.rfind('.'); dot != std::string::npos)
        path.resize(dot);
    std::vector<std::string> parts(1);
    for (const char c : path)
        if (c == '/' || c == '_')
            parts.emplace_back();
        else
            parts.back() += c;
    if (parts.size() < 3)
        return {};
    const auto z = number(parts[parts.size() - 3]), x = number(parts[parts.size() - 2]);
    const auto y = number(parts.back());
    if (!z || !x || !y || *z > kDeepestLevel || *x >= columnsOf(*z, false) || *y >= rowsOf(*z))
        return {};
    return QuantizedPlace{*z, *x, *y};
}

} // namespace

std::optional<FoundPlace> placeOf(const QuantizedTile& tile, const std::string& path) {
    // Spheres are made loosely, but not twice as large as they need be: that would fit the next
    // level.
    constexpr double kLoosest = 1.3, kRounding = 1.01;
    const QuantizedHeader& header = tile.header;
    const bool sphere = isFinite(header.sphereCentre) && std::isfinite(header.sphereRadiusMetres) &&
                        header.sphereRadiusMetres > 0.0 && !tile.u.empty();
    const auto fits = [&](double reach) { return reach <= kRounding && reach >= 1.0 / kLoosest; };
    if (const auto named = namedBy(path)) {
        for (const bool webMercator : {false, true}) {
            if (webMercator && named->x >= columnsOf(named->level, true))
                continue;
            QuantizedPlace turned = *named;
            turned.y = std::uint32_t(rowsOf(named->level) - 1 - named->y);
            for (const QuantizedPlace& place : {*named, turned})
                if (!sphere || fits(reachIn(tile, place, webMercator)))
                    return FoundPlace{place, webMercator, true};
        }
    }
    if (!sphere)
        return {};
    const bool centred = isFinite(header.centre) && glm::length(header.centre) > 1e6;
    const Result<Geodetic> middle =
        geodeticFromEcef(Point<Ecef>{centred ? header.centre : header.sphereCentre});
    if (!middle)
        return {};
    const glm::dvec2 lonLat(middle->longitudeDegrees, middle->latitudeDegrees);
    std::optional<FoundPlace> best;
    double least = std::log(kLoosest);
    for (const bool webMercator : {false, true})
        for (unsigned level = 0; level <= kDeepestSought; ++level) {
            const QuantizedPlace place = around(lonLat, level, webMercator);
            const double reach = reachIn(tile, place, webMercator);
            // Near the equator a tile of one tree is one of the other: then the usual one.
            constexpr double kClearly = 0.02;
            const double off = std::abs(std::log(reach)) + (webMercator ? kClearly : 0.0);
            if (fits(reach) && off < least) {
                least = off;
                best = FoundPlace{place, webMercator, false};
            }
        }
    return best;
}

} // namespace gnomon
