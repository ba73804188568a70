// What is read from a file before a curve is laid through it: the keys of a camera path as their
// author wrote them. Between camera_path.cpp and the readers of its formats.
#pragma once

#include "geo/camera.h"
#include "geo/time.h"
#include "viewer/camera_path.h"

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

inline constexpr double kMaxPathSeconds = 1e9;
inline constexpr double kMaxPathMetres = 1e8;

struct PathKey {
    // Never earlier than the key before; at the same time as that one, the view jumps.
    double t = 0.0;
    Geodetic place;           // of the camera; with a range, of the point looked at
    bool aboveGround = false; // the height counts from the ground, not from the ellipsoid
    Orientation orientation;  // in the frame at `place`
    double rangeMetres = 0.0; // the camera is so far behind `place`
    double fovDegrees = 45.0; // vertical
    std::optional<ZonedTime> time;
    bool rests = false; // the flight comes to rest here
};

struct PathKeys {
    std::vector<PathKey> keys; // at least one
    Interpolation interpolation = Interpolation::Smooth;
    std::vector<std::string> notes; // what was taken for granted or left out
};

// `name` is the file, for messages; `aspect` is width by height.
Result<PathKeys> pathKeysFromJson(const std::string& text, const std::string& name,
                                  double defaultFovDegrees);
Result<PathKeys> pathKeysFromKml(const std::string& text, const std::string& name,
                                 double defaultFovDegrees, double aspect);

} // namespace gnomon
