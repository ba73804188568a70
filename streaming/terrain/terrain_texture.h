// What a tile of terrain is painted with. Private to terrain*.cpp.
#pragma once

#include "streaming/terrain/terrain_patch.h"

namespace gnomon {

// Colours by height, low to high along u.
Image rampImage();
// Where `share` (0…1) of an axis of `texels` texels is read: the first texel's centre to the
// last's, so that tiles side by side read the same there.
float texelShare(double share, int texels);
// The drapes over a tile, over its own colour where they leave something out. Texel centres lie on
// the tile's sides.
Result<Image> paintTile(const TerrainScene& scene, const TileName& name, const TerrainPatch& patch,
                        glm::ivec2 texels);

} // namespace gnomon
