// What is under a pixel of the frame drawn last: the tile, the triangle's feature and what its file
// tells of that. The pictures of tile ids and depths name the tile and how far; its triangles, met
// by the pixel's ray, tell the rest.
#pragma once

#include "geo/camera.h"
#include "viewer/frame.h"

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct Picked {
    std::uint32_t tile = 0; // the Tile picture's id; 0 is the ground
    Point<Ecef> at;
    std::uint32_t feature = kNoFeature;
    std::string id; // of the feature; empty when its tile tells nothing of it
    std::vector<Property> properties;
};

// A pixel's facts in the Tile and Depth pictures.
struct PixelFacts {
    double x = 0.0, y = 0.0; // pixels from the left and the top; the middle of the first is 0.5
    std::uint32_t tile = 0;
    double depthMetres = 0.0; // along the view axis; infinite: sky
};

// None for the sky. Depth may be that of water: then the feature is of what lies below. A tile that
// is not among `tiles` any more, or that the ray does not meet there, gives the place alone.
std::optional<Picked> pick(const Camera& camera, const PixelFacts& pixel,
                           const std::vector<ResidentTile>& tiles, const glm::dmat3& meshAxes);

// Of the renderer's last frame, drawn with `camera`. Reads the pictures back: some milliseconds.
std::optional<Picked> pick(FrameRenderer& renderer, const Camera& camera, int x, int y);

} // namespace gnomon
