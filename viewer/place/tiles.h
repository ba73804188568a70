// One tile of the place as glb bytes, at any level of the quadtree.
//
// Geometric error. A leaf shows everything. One level up (error 4 m) chimneys, parapets, overhangs
// and railings are left out, all under 1 m, and trees become five-sided: up to 4 m off. Two up (8
// m) every second tree is gone, three up (16 m) all trees, as tall as 16 m, and roofs are flat at
// half their height; four up (32 m) a block's houses are one box, its courtyard filled: some 30 m
// off. Further up only blocks taller than a quarter of the error are left. The terrain's grid
// doubles each level; its hills are far gentler than these errors. So the error is 4 m · 2^(levels
// up - 1).
#pragma once

#include "geo/result.h"
#include "viewer/place/picture.h"
#include "viewer/place/plan.h"
#include "viewer/place/shape.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gnomon::builtin {

struct TileId {
    int level = 0, x = 0, y = 0; // x eastwards, y northwards, from the south-western corner
};

double geometricErrorMetres(const Plan& plan, int level);
Rect tileRect(const Plan& plan, TileId id);
// First and last + 1 cell indices.
struct CellRange {
    int west = 0, south = 0, east = 0, north = 0;
};
CellRange cellsOf(const Plan& plan, TileId id);
// Country that no finer tile would show better stays a leaf.
bool subdivided(const Plan& plan, TileId id);

// A grid of 32 x 32 squares whose outermost ring has the finest grid's corners along the tile's
// edge, so that neighbours meet without cracks whatever their levels. u, v span the tile; normals
// smooth.
Shape terrainShape(const Plan& plan, const Rect& tile);

// The solids and the open sheds of a tile.
struct TileShapes {
    Shape houses, offices, sheds; // houses: also the tower and the bridge
    std::vector<Tree> trees;
    std::vector<std::uint32_t> ids; // of the buildings, by feature
    std::vector<float> heights;     // their metres above the ground
    std::size_t buildings = 0, shedCount = 0;
};
TileShapes tileShapes(const Plan& plan, TileId id);

struct TileBytes {
    std::vector<std::byte> glb;
    std::uint64_t triangles = 0; // instances counted
    std::size_t buildings = 0, trees = 0, sheds = 0;
};

// What all tiles share, made once.
struct SharedPictures {
    std::vector<std::byte> houses, offices; // PNG
};
Result<SharedPictures> makeSharedPictures(std::uint64_t seed);

Result<TileBytes> makeTile(const Plan& plan, TileId id, const Pixels& ground,
                           const SharedPictures& pictures);

} // namespace gnomon::builtin
