// The exact geometry of a region of longitudes, latitudes and heights, for bounds.cpp.
//
// A region is a solid of revolution cut by two half planes through the Earth's axis, and its
// section lies between two normals of the ellipsoid and two curves of equal height. So all
// questions fall apart into one about longitude and one in the meridian plane (r, z), both with
// closed answers.
#pragma once

#include "geo/bounds.h"

namespace gnomon {

// Distance to the region itself, without its box. Exact wherever the nearest point is on the top or
// on an edge of it, never more than the true distance elsewhere.
double distanceToRegion(const Region& region, Point<Ecef> p);
// The exact range of dot(direction, q) over the region.
Interval regionExtent(const Region& region, const glm::dvec3& direction);
// A box around the region in the tangent frame of its middle or, where that is smaller, along the
// Earth's axis.
OrientedBox boxAroundRegion(const Region& region);

} // namespace gnomon
