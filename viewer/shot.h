// From options to what a frame is asked for: which camera, which sun, at which moment. Shared by
// the commands that make pictures.
#pragma once

#include "viewer/camera_path.h"
#include "viewer/options.h"

namespace gnomon {

// Mid-afternoon in summer: for a scene of which nothing is known.
inline constexpr SunAngles kDefaultSun{225.0, 40.0};

struct Shot {
    Camera camera;
    SunPosition sun;
    std::optional<UtcTime> time; // of what stands and flows, and of the sun unless --sun said
    std::optional<std::string> timeZone; // to tell it by; as in ZonedTime
};

// The camera and the sun over time. Reads the camera path, if one is asked for.
class Shots {
  public:
    static Result<Shots> create(const PictureOptions& options);

    // At `seconds` after the start. A keyframe's time wins over --time, that over the scene file's.
    // --sun wins over what any time says of the sun; without either it is the scene's or the
    // default. The zone of --time wins over those of the keyframes.
    Shot at(double seconds, const Scene& scene) const;
    bool usesDefaultSun(const Scene& scene) const;
    bool moves() const { return path_.has_value(); }
    double lengthSeconds() const; // 0 when the camera stands still

  private:
    explicit Shots(const PictureOptions& options) : options_(options) {}
    Camera cameraFor(const Scene& scene) const;
    const CameraPath& pathIn(const Scene& scene) const;

    PictureOptions options_;
    std::optional<CameraPath> path_;
    mutable std::optional<CameraPath> pathOnGround_; // of the first scene it was asked for
};

// The inputs, or the built-in scene asked for by name.
Result<Scene> openAsked(const PictureOptions& options);

// What the scene file says of the ground, unless the command line did.
FrameOptions frameOptionsFor(const PictureOptions& options, const Scene& scene);

} // namespace gnomon
