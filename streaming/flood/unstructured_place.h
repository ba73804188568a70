// A mesh's nodes brought from the coordinates of their file onto the Earth.
#pragma once

#include "streaming/flood/flood.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon {

struct PlacedNodes {
    std::vector<glm::dvec2> lonLat; // degrees
    std::vector<float> liftMetres;  // to a height as the file has it: the geoid's and the user's
    std::vector<float> eastOfX;     // radians, counter-clockwise, from east to the file's x axis
};

Result<PlacedNodes> placeNodes(const std::string& path, std::span<const glm::dvec2> positions,
                               const std::string& crs, const FloodOptions& options);

// Square metres on the ellipsoid, whatever the projection stretches; negative when clockwise.
double areaOnEarth(const std::array<glm::dvec2, 3>& lonLat);

} // namespace gnomon
