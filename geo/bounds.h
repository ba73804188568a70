// Bounding volumes of 3D Tiles and what selection asks of them. Every answer is conservative: a
// distance never exceeds the true one, a volume is never called outside when part of it is inside.
#pragma once

#include "geo/ellipsoid.h"
#include "geo/frames.h"

#include <glm/vec2.hpp>

#include <array>
#include <optional>
#include <span>
#include <variant>

namespace gnomon {

// Points p with dot(normal, p - point) >= 0 are inside. Kept as a point and a unit normal, since a
// plane's offset from the Earth's centre would cost half a micrometre.
struct Plane {
    Vector<Ecef> normal;
    Point<Ecef> point;

    double signedDistance(Point<Ecef> p) const { return dot(normal, p - point); }
};

struct Sphere {
    Point<Ecef> centre;
    double radiusMetres = 0.0;
};

// centre ± each half axis (columns; need not be orthogonal, may be zero).
struct OrientedBox {
    Point<Ecef> centre;
    glm::dmat3 halfAxes{0.0};
};

// Degrees on WGS 84, heights above the ellipsoid. west > east crosses the antimeridian. Made by
// makeRegion only: what follows the heights is derived from them there, once, since selection asks
// for distances thousands of times a frame.
struct Region {
    double westDegrees = 0, southDegrees = 0, eastDegrees = 0, northDegrees = 0;
    double minHeightMetres = 0, maxHeightMetres = 0;
    OrientedBox box;           // contains the region
    bool overHalfTurn = false; // more than 180 degrees of longitude
    // Cosine and sine of the four sides' longitude or latitude.
    glm::dvec2 west{1, 0}, south{1, 0}, east{1, 0}, north{1, 0};
    // Distance from the axis and z of the ellipsoid at the southern and northern side.
    glm::dvec2 southFoot{kEquatorialRadiusMetres, 0}, northFoot{kEquatorialRadiusMetres, 0};
};

using BoundingVolume = std::variant<OrientedBox, Sphere, Region>;

// Degrees and metres, all finite (asserted). Latitudes are cut to ±90, heights below -6300 km
// (where normals of the ellipsoid begin to cross) to that, and a pair in the wrong order is
// swapped.
Region makeRegion(double westDegrees, double southDegrees, double eastDegrees, double northDegrees,
                  double minHeightMetres, double maxHeightMetres);

enum class Containment { Outside, Crosses, Inside };

Containment classify(const BoundingVolume& volume, const Plane& plane);
// Outside as soon as one plane says so.
Containment classify(const BoundingVolume& volume, std::span<const Plane> planes);
// 0 inside. For a region: the larger of the geodetic bound and the box's.
double distanceTo(const BoundingVolume& volume, Point<Ecef> p);
Sphere boundingSphere(const BoundingVolume& volume);
// The smallest and largest of dot(direction, q - from) over the volume.
struct Interval {
    double min = 0.0, max = 0.0;
};
Interval extentAlong(const BoundingVolume& volume, Point<Ecef> from, Vector<Ecef> direction);
// A region stays where it is: 3D Tiles gives it in world coordinates. A sphere grows by the largest
// column's length, and by what a shear adds.
BoundingVolume transformed(const BoundingVolume& volume, const Transform<Ecef, Tile>& ecefFromTile);
// The smallest box around `points` whose faces are normal to `axes` (orthonormal columns).
OrientedBox boxAround(std::span<const Point<Ecef>> points, const glm::dmat3& axes);
std::array<Point<Ecef>, 8> corners(const OrientedBox& box);

// Longitude, latitude and height range; nullopt where the volume is not near the Earth's surface
// (all of it deeper than 20 km or higher than 2000 km), as in a tileset with a frame of its own.
std::optional<Region> geographicExtent(const BoundingVolume& volume);

} // namespace gnomon
