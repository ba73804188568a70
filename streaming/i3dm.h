// Instanced models of 3D Tiles 1.0: i3dm, one glTF that stands in many places. Instances become
// triangles like any others, so what they may become together is bounded by the budget.
#pragma once

#include "streaming/gltf.h"
#include "streaming/tile_headers.h"

namespace gnomon {

// Throws BadContent.
GltfContent readI3dm(const TileParts& parts, const DecodeOptions& options, ByteBudget& budget);

} // namespace gnomon
