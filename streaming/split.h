// Cuts clean triangles into meshes: by material, and by a grid so that meshes can be culled and
// their floats stay small. See mesh.h for what a mesh promises.
#pragma once

#include "streaming/clean.h"

#include <optional>

namespace gnomon {

std::vector<Mesh> split(const Soup& soup, const CleanSoup& clean,
                        const Transform<Ecef, Tile>& ecefFromTile,
                        const std::optional<glm::dmat3>& meshAxes = {});

} // namespace gnomon
