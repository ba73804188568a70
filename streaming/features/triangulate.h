// Polygons of buildings checked and cut into triangles: the cheap way where it provably does, GEOS
// where not.
#pragma once

#include "streaming/features/barriers_plan.h"

#include <cstdint>

namespace gnomon {

// No ring crosses itself or another, holes are inside.
bool isSound(std::span<const PlanRing> rings);

// More often than anybody could mean; mending takes time by the number of crossings.
bool crossesTooOften(std::span<const PlanRing> rings);

// Corners by the numbers of the vertices, counted over all rings; counter-clockwise. `polygon` is
// sound, its outer ring counter-clockwise. Every vertex is a corner; none are added. Empty when it
// cannot be cut.
using Corners = std::vector<std::array<std::uint32_t, 3>>;
Corners cornersOf(const PlanPolygon& polygon);

double signedArea(const PlanRing& ring);

} // namespace gnomon
