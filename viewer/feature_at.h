// The thing that tiles say stands at a place: of the surfaces above and below it, the highest whose
// feature its file has a row for.
#pragma once

#include "streaming/loader.h"

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct TileFeature {
    std::string id; // idOf() its row
    std::uint32_t feature = kNoFeature;
    std::vector<Property> properties;
    std::string tile;                         // the content's path
    double baseMetres = 0.0, topMetres = 0.0; // its lowest vertex, and there; above the ellipsoid
};

// Loads the finest tiles over the place; where those have nothing, their neighbours too, for boxes
// that are too small are published. `meshAxes` are those the tileset was given.
// None where there is none; `complete` (may be null) is false where some of the tiles could not be
// had before the deadline.
std::optional<TileFeature> featureAt(StreamedTileset& tileset, glm::dvec2 lonLat,
                                     const glm::dmat3& meshAxes,
                                     std::chrono::steady_clock::time_point deadline,
                                     bool* complete = nullptr);

} // namespace gnomon
