// From a soup to triangles one can trust: finite, with an area, each there once, wound outward
// where they bound a solid.
//
// Vertices are welded for finding out what hangs together, never moved, and no triangle that has an
// area is lost by it. Two vertices are one when
// they lie within kWeldMetres of each other: each joins the nearest earlier vertex that stands for
// a group, looked up in all grid cells in reach, so neither cell borders nor rounding part
// neighbours, and no group grows wider than twice that. Models smaller than 10 m weld at 1/10000 of
// their size.
#pragma once

#include "streaming/soup.h"

namespace gnomon {

inline constexpr double kWeldMetres = 1e-3;
// Further away than the moon: no vertex of a tile, whatever its bits say.
inline constexpr double kFarthestMetres = 1e9;

struct CleanSoup {
    Point<Ecef> origin;
    std::vector<glm::dvec3> local; // a position a soup vertex, metres from `origin`, ECEF's axes
    std::vector<Soup::Triangle> triangles; // in the soup's order; closed ones wound outward
    std::vector<std::uint8_t> closed;      // one a triangle

    std::uint64_t duplicates = 0, degenerate = 0, invalid = 0, closedTriangles = 0;
    std::uint32_t components = 0, closedComponents = 0;
    glm::dvec3 areaVector{0.0}; // in the tile's frame, by the windings kept
};

CleanSoup clean(const Soup& soup, const Transform<Ecef, Tile>& ecefFromTile);

// What a content made of these triangles has to say of them.
ContentFacts factsOf(const CleanSoup& cleaned);

} // namespace gnomon
