// A flight of the camera through keyframes. Positions are interpolated in ECEF relative to the
// first keyframe, orientations as quaternions in ECEF, so that neither poles nor the antimeridian
// are special and a path moved rigidly gives the same flight.
//
// "smooth" is a cubic Hermite curve through the keyframes with tangents of the parabola through
// three neighbours (C1, also where keyframes are unevenly spaced in time); orientations are the
// Hermite quaternion curve of Kim, Kim and Shin, "A general construction scheme for unit quaternion
// curves with simple high order derivatives", 1995. Field of view, range and time never overshoot
// (Fritsch and Butland, "A method for constructing local monotone piecewise cubic interpolants",
// 1984).
//
// Between two views that look at something (KML's LookAt) it is that point and the range to it that
// are interpolated, so that a flight around a building is round.
#pragma once

#include "geo/camera.h"
#include "geo/result.h"
#include "geo/time.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

enum class Interpolation { Smooth, Linear };

struct PathKeys; // viewer/camera_keys.h

class CameraPath {
  public:
    // JSON as docs/ describes it, or the first gx:Tour of a KML file; `name` is the file, for
    // messages. Keyframes without a field of view get `defaultFovDegrees`; KML gives its own from
    // side to side, for which `aspect` (width by height) is needed.
    static Result<CameraPath> parse(const std::string& text, const std::string& name,
                                    double defaultFovDegrees, double aspect = 16.0 / 9.0);
    static Result<CameraPath> load(const std::string& file, double defaultFovDegrees,
                                   double aspect = 16.0 / 9.0);

    // KML may give heights above the ground. Until they are told, it is the ellipsoid.
    bool needsGround() const;
    using GroundHeight = std::function<double(double longitudeDegrees, double latitudeDegrees)>;
    CameraPath onGround(const GroundHeight& metresAboveEllipsoid) const;
    // What was taken for granted in reading it, or left out.
    const std::vector<std::string>& notes() const;

    struct Sample {
        Camera camera; // width and height in pixels are left for the caller
        std::optional<UtcTime> time;
    };
    // Before the first keyframe the first, after the last the last.
    Sample sample(double seconds) const;

    double startSeconds() const;
    double endSeconds() const;
    std::optional<std::string> timeZone() const; // the first that a keyframe's time names
    std::size_t size() const;                    // keyframes
    Interpolation interpolation() const;

  private:
    struct State;
    explicit CameraPath(std::shared_ptr<const State> state);
    std::shared_ptr<const State> state_;
};

} // namespace gnomon
