#include "geo/bounds.h"

#include "geo/region.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {
namespace {

// Half of the extent along a unit direction.
double halfExtent(const OrientedBox& box, const glm::dvec3& direction) {
    return std::abs(glm::dot(direction, box.halfAxes[0])) +
           std::abs(glm::dot(direction, box.halfAxes[1])) +
           std::abs(glm::dot(direction, box.halfAxes[2]));
}

// The nearest point by one axis after the other, which is exact at once for orthogonal axes. For
// slanted ones the sweeps only find a good direction: what is returned is the gap between `p` and
// the box along that direction, and no gap exceeds the distance.
double distanceToBox(const OrientedBox& box, Point<Ecef> p) {
    constexpr int kSweeps = 16;
    constexpr double kSettled = 1e-12;
    const glm::dvec3 fromCentre = p.xyz - box.centre.xyz;
    glm::dvec3 rest = fromCentre;
    glm::dvec3 coordinates(0.0);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        double change = 0.0;
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3& axis = box.halfAxes[i];
            const double squared = glm::dot(axis, axis);
            if (!(squared > 0.0))
                continue;
            const double moved =
                std::clamp(coordinates[i] + glm::dot(rest, axis) / squared, -1.0, 1.0);
            rest -= (moved - coordinates[i]) * axis;
            change = std::max(change, std::abs(moved - coordinates[i]));
            coordinates[i] = moved;
        }
        if (change < kSettled)
            break;
    }
    const double length = glm::length(rest);
    if (!(length > 0.0))
        return 0.0;
    const glm::dvec3 direction = rest / length;
    return std::max(0.0, glm::dot(direction, fromCentre) - halfExtent(box, direction));
}

Containment compare(double centreDistance, double halfSize) {
    if (centreDistance < -halfSize)
        return Containment::Outside;
    return centreDistance >= halfSize ? Containment::Inside : Containment::Crosses;
}

const OrientedBox* boxOf(const BoundingVolume& volume) {
    if (const auto* region = std::get_if<Region>(&volume))
        return &region->box;
    return std::get_if<OrientedBox>(&volume);
}

// At least the most a matrix stretches any vector: the root of the largest row sum of its Gram
// matrix (Gershgorin), which is the longest column's length when the columns are orthogonal.
double largestStretch(const glm::dmat3& m) {
    const glm::dmat3 gram = glm::transpose(m) * m;
    double largest = 0.0;
    for (int i = 0; i < 3; ++i)
        largest =
            std::max(largest, std::abs(gram[i][0]) + std::abs(gram[i][1]) + std::abs(gram[i][2]));
    return std::sqrt(largest);
}

} // namespace

Containment classify(const BoundingVolume& volume, const Plane& plane) {
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return compare(plane.signedDistance(sphere->centre), sphere->radiusMetres);
    const OrientedBox& box = *boxOf(volume);
    return compare(plane.signedDistance(box.centre), halfExtent(box, plane.normal.xyz));
}

Containment classify(const BoundingVolume& volume, std::span<const Plane> planes) {
    Containment all = Containment::Inside;
    for (const Plane& plane : planes) {
        const Containment one = classify(volume, plane);
        if (one == Containment::Outside)
            return one;
        if (one == Containment::Crosses)
            all = one;
    }
    return all;
}

double distanceTo(const BoundingVolume& volume, Point<Ecef> p) {
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return std::max(0.0, length(p - sphere->centre) - sphere->radiusMetres);
    const double toBox = distanceToBox(*boxOf(volume), p);
    if (const auto* region = std::get_if<Region>(&volume))
        return std::max(toBox, distanceToRegion(*region, p));
    return toBox;
}

Sphere boundingSphere(const BoundingVolume& volume) {
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return *sphere;
    const OrientedBox& box = *boxOf(volume);
    double squared = 0.0;
    for (const Point<Ecef>& corner : corners(box)) {
        const Vector<Ecef> arm = corner - box.centre;
        squared = std::max(squared, dot(arm, arm));
    }
    return {box.centre, std::sqrt(squared)};
}

Interval extentAlong(const BoundingVolume& volume, Point<Ecef> from, Vector<Ecef> direction) {
    if (const auto* sphere = std::get_if<Sphere>(&volume)) {
        const double centre = dot(direction, sphere->centre - from);
        const double half = sphere->radiusMetres * length(direction);
        return {centre - half, centre + half};
    }
    const OrientedBox& box = *boxOf(volume);
    const double centre = dot(direction, box.centre - from);
    const double half = halfExtent(box, direction.xyz);
    Interval extent{centre - half, centre + half};
    if (const auto* region = std::get_if<Region>(&volume)) {
        // The sums of Earth-sized numbers round by some nanometres; the box has its own margin.
        const double slack = 1e-8 * length(direction);
        const double offset = glm::dot(direction.xyz, from.xyz);
        const Interval exact = regionExtent(*region, direction.xyz);
        extent.min = std::max(extent.min, exact.min - offset - slack);
        extent.max = std::min(extent.max, exact.max - offset + slack);
    }
    return extent;
}

BoundingVolume transformed(const BoundingVolume& volume,
                           const Transform<Ecef, Tile>& ecefFromTile) {
    const auto moved = [&](Point<Ecef> p) { return ecefFromTile(Point<Tile>{p.xyz}); };
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return Sphere{moved(sphere->centre),
                      sphere->radiusMetres * largestStretch(ecefFromTile.axes())};
    if (const auto* box = std::get_if<OrientedBox>(&volume))
        return OrientedBox{moved(box->centre), ecefFromTile.axes() * box->halfAxes};
    return volume;
}

OrientedBox boxAround(std::span<const Point<Ecef>> points, const glm::dmat3& axes) {
    if (points.empty())
        return {};
    // Relative to the first point, so that a small box far from the Earth's centre keeps its
    // digits.
    const Point<Ecef> first = points.front();
    glm::dvec3 low(0.0), high(0.0);
    for (const Point<Ecef>& p : points) {
        const glm::dvec3 along = glm::transpose(axes) * (p - first).xyz;
        low = glm::min(low, along);
        high = glm::max(high, along);
    }
    const glm::dvec3 half = 0.5 * (high - low);
    return {first + Vector<Ecef>{axes * (0.5 * (low + high))},
            glm::dmat3(half.x * axes[0], half.y * axes[1], half.z * axes[2])};
}

std::array<Point<Ecef>, 8> corners(const OrientedBox& box) {
    std::array<Point<Ecef>, 8> result;
    for (unsigned i = 0; i < 8; ++i)
        result[i] = box.centre + Vector<Ecef>{box.halfAxes * glm::dvec3((i & 1) ? 1.0 : -1.0,
                                                                        (i & 2) ? 1.0 : -1.0,
                                                                        (i & 4) ? 1.0 : -1.0)};
    return result;
}

} // namespace gnomon
