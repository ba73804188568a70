// Tiles of every format there is, made of one piece of city, so that the formats can be compared.
#pragma once

#include "streaming/source.h"

#include <string>
#include <vector>

namespace gnomon::bench {

struct MadeFiles {
    std::string format; // as a row of the table is called
    std::vector<Bytes> files;
};

// Leaf tiles of the built-in place, their houses only: as plain and Draco glb, as b3dm around each,
// with EXT_meshopt_compression; the same vertices as points; trees as instances; and all of it in
// composites. Without pictures, which would hide the rest.
Result<std::vector<MadeFiles>> makeTiles(std::size_t tiles);

// A grid of 256 squares a side over a tile of level 12: 131,072 triangles. Wants to be called
// "12/X/Y.terrain".
struct MadeTerrain {
    std::string path; // its place in a pyramid
    Bytes bytes;
};
MadeTerrain makeTerrainTile();

} // namespace gnomon::bench
