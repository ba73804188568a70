// A pinhole camera in ECEF. Right, up and forward are unit ECEF vectors.
#pragma once

#include "geo/ellipsoid.h"
#include "geo/frames.h"

#include <algorithm>

namespace gnomon {

struct Camera {
    Point<Ecef> position;
    Vector<Ecef> right{{1, 0, 0}};
    Vector<Ecef> up{{0, 1, 0}};
    Vector<Ecef> forward{{0, 0, -1}};
    double verticalFovRadians = 45.0 * kRadiansPerDegree;
    int widthPixels = 1280;
    int heightPixels = 720;

    // A window of no size counts as one pixel, so that nothing divides by zero.
    double aspect() const { return double(std::max(widthPixels, 1)) / std::max(heightPixels, 1); }
    // Half extents of the picture plane at distance 1. Angles are cut to 1e-6 rad from 0 and 180°.
    double tanHalfHeight() const;
    double tanHalfWidth() const { return tanHalfHeight() * aspect(); }
};

// Degrees in the ENU frame at the camera: heading clockwise from north, pitch above the horizon,
// roll clockwise as seen from behind.
struct Orientation {
    double headingDegrees = 0.0;
    double pitchDegrees = 0.0;
    double rollDegrees = 0.0;
};

// Sets position and axes; field of view and size are left as they are.
void place(Camera& camera, const Geodetic& position, const Orientation& orientation);
Orientation orientationOf(const Camera& camera);

// Rotation only: Eye axes (right, up, backward) as rows applied to camera-relative ECEF.
glm::dmat3 eyeFromEcefRotation(const Camera& camera);

// Reversed-Z with the far plane at infinity and clip depth 0…1: depth = near / distance, so 1 at
// the near plane and 0 at infinity (Upchurch & Desbrun, "Tightening the precision of perspective
// rendering", 2012). Column-major, for Eye coordinates.
glm::dmat4 reversedInfiniteProjection(const Camera& camera, double nearMetres);

} // namespace gnomon
