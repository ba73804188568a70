// Point clouds of 3D Tiles 1.0: pnts, plain, quantised or compressed with Draco.
#pragma once

#include "streaming/gltf.h"
#include "streaming/tile_headers.h"

namespace gnomon {

// As a content without triangles whose one material its one cloud has. Throws BadContent.
GltfContent readPnts(const TileParts& parts, ByteBudget& budget);

} // namespace gnomon
