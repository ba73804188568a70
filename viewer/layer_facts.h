// What a user says of a layer because its own files do not: on the command line of all that lack
// the fact, in a scene file of one layer.
#pragma once

#include "geo/crs.h"
#include "geo/ellipsoid.h"
#include "geo/result.h"
#include "geo/time.h"
#include "streaming/flood/flood.h"
#include "streaming/terrain/terrain.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>

namespace gnomon {

// Puts what has a frame of its own on the Earth: origin, and the heading its y axis points to.
struct Placement {
    Geodetic origin;
    double headingDegrees = 0.0;
};

enum class ModelUp { Auto, Y, Z }; // Auto: from the geometry's own area vector, else Z

// How water looks.
enum class WaterColors { Depth, Speed, Natural };

struct LayerFacts {
    // Where it stands.
    std::optional<std::string> crs;
    std::optional<Heights> heights;
    std::optional<Placement> placement;
    std::optional<ModelUp> up;
    std::optional<double> raiseMetres;
    // Buildings, trees, barriers.
    std::optional<double> heightMetres, widthMetres;
    std::optional<std::string> heightAttribute;
    std::optional<UtcTime> from, until;
    // Water.
    std::optional<WaterKind> waterKind;
    std::optional<std::string> variable; // also of terrain in a file of several
    std::optional<UtcTime> start;
    std::optional<double> stepSeconds;
    std::optional<double> dryMetres;
    std::optional<WaterColors> colors;
    std::optional<double> most; // metres or m/s of the last colour
    // Terrain, and what is painted on it.
    std::optional<TerrainLook> look;
    // A file of areas where other ground is shown (that of a tileset): terrain leaves them out, and
    // still tells their heights.
    std::optional<std::string> hole;
    std::optional<std::array<std::uint8_t, 3>> color; // sRGB

    // These, and what they leave open from `other`.
    LayerFacts orElse(const LayerFacts& other) const;
};

// As people write them; nullopt for anything else.
std::optional<double> durationSeconds(const std::string& text);       // 300s, 15min, 1h, 1d
std::optional<WaterColors> waterColorsNamed(const std::string& text); // depth, speed, natural
std::optional<TerrainLook> terrainLookNamed(const std::string& text); // plain, ramp, ramp-unlit
std::optional<WaterKind> waterKindNamed(const std::string& text);     // depth, stage
std::optional<std::array<std::uint8_t, 3>> colorNamed(const std::string& text); // #rrggbb

} // namespace gnomon
