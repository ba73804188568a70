#include "streaming/curved_frame.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

double farthestOff(const CurvedFrame& frame, const Transform<Ecef, Tile>& near,
                   std::span<const Point<Ecef>> flatPoints) {
    double farthest = 0.0;
    for (const Point<Ecef>& flat : flatPoints) {
        const Result<Point<Ecef>> exact = frame.place(flat.xyz);
        if (exact) { // a corner may lie where the projection ends
            farthest = std::max(farthest, length(*exact - near(Point<Tile>{flat.xyz})));
        }
    }
    return farthest;
}

// Each half axis longer by `metres`; one without a length points where the others do not.
OrientedBox grown(OrientedBox box, double metres) {
    for (int axis = 0; axis < 3; ++axis) {
        const double half = glm::length(box.halfAxes[axis]);
        glm::dvec3 direction = box.halfAxes[axis] / half;
        if (!(half > 0.0)) {
            const glm::dvec3 across =
                glm::cross(box.halfAxes[(axis + 1) % 3], box.halfAxes[(axis + 2) % 3]);
            direction = glm::length(across) > 0.0 ? glm::normalize(across) : glm::dvec3(0.0);
        }
        box.halfAxes[axis] += metres * direction;
    }
    return box;
}

} // namespace

glm::dvec3 middleOf(const BoundingVolume& flat) {
    if (const auto* box = std::get_if<OrientedBox>(&flat)) {
        return box->centre.xyz;
    }
    const auto* sphere = std::get_if<Sphere>(&flat);
    return sphere ? sphere->centre.xyz : std::get<Region>(flat).box.centre.xyz;
}

BoundingVolume curvedVolume(const CurvedFrame& frame, const Transform<Ecef, Tile>& near,
                            const BoundingVolume& flat) {
    const BoundingVolume placed = transformed(flat, near);
    if (const auto* box = std::get_if<OrientedBox>(&flat)) {
        return grown(std::get<OrientedBox>(placed), farthestOff(frame, near, corners(*box)));
    }
    if (const auto* sphere = std::get_if<Sphere>(&flat)) {
        const double r = sphere->radiusMetres;
        const OrientedBox around{sphere->centre, glm::dmat3(r)};
        Sphere out = std::get<Sphere>(placed);
        out.radiusMetres += farthestOff(frame, near, corners(around));
        return out;
    }
    return placed;
}

} // namespace gnomon
