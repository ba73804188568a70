// Where a ray meets a tile's triangles: to find what is under a point of a map or of a picture.
#pragma once

#include "streaming/mesh.h"

#include <vector>

namespace gnomon {

struct RayHit {
    double metres = 0.0; // from the ray's start
    std::uint32_t mesh = 0, triangle = 0;
    std::uint32_t feature = kNoFeature; // the triangle's row in TileContent::features
};

// All of them, the nearest first; from either side. `meshAxes` as in DecodeOptions; `direction` is
// a unit vector. Points on an edge count, to 1e-9 of the triangle.
std::vector<RayHit> castRay(const TileContent& content, const glm::dmat3& meshAxes,
                            Point<Ecef> from, Vector<Ecef> direction);

} // namespace gnomon
