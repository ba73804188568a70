// What a camera path promises to those who fly along it.
#pragma once

#include "tests/fuzz/fuzz.h"

#include "viewer/camera_path.h"

namespace gnomon::fuzz {

inline void checkUnit(const Vector<Ecef>& v) {
    demand(isFinite(v.xyz) && std::abs(length(v) - 1.0) < 1e-9, "a camera's axes are unit vectors");
}

inline void checkSample(const CameraPath::Sample& sample) {
    const Camera& camera = sample.camera;
    demand(isFinite(camera.position.xyz), "a camera is somewhere");
    checkUnit(camera.right);
    checkUnit(camera.up);
    checkUnit(camera.forward);
    demand(std::abs(dot(camera.right, camera.up)) < 1e-9 &&
               std::abs(dot(camera.right, camera.forward)) < 1e-9 &&
               std::abs(dot(camera.up, camera.forward)) < 1e-9,
           "a camera's axes are perpendicular");
    demand(camera.verticalFovRadians > 0 && camera.verticalFovRadians < 3.2,
           "a field of view is an angle");
    demand(!sample.time || std::isfinite(sample.time->seconds), "a moment is a number");
}

inline void checkPath(const CameraPath& path) {
    demand(path.size() >= 1, "a path has keyframes");
    const double start = path.startSeconds(), end = path.endSeconds();
    demand(std::isfinite(start) && std::isfinite(end) && start <= end, "time goes on");
    constexpr int kSamples = 24;
    for (int i = -1; i <= kSamples + 1; ++i)
        checkSample(path.sample(start + (end - start) * i / kSamples));
    checkSample(path.sample(start - 1e12));
    checkSample(path.sample(end + 1e12));
}

} // namespace gnomon::fuzz
