// Which of a scene's lamps are lit in a frame, what may stand before them, and their light.
#pragma once

#include "geo/camera.h"
#include "geo/sun.h"
#include "geo/view.h"
#include "shadows/lamp.h"
#include "shadows/lamp_pass.h"
#include "viewer/scene.h"

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace gnomon {

// Street lamps' civil rule: on when the sun's centre is below the horizon; they have come up to
// full a degree later, so that a flight through the evening does not jump. 0…1.
double lampShare(double sunElevationDegrees);

// The lamps whose light reaches into the camera's view, those that give most to where the eye is
// first; as many as may be lit at once (kMaxLampHemispheres).
std::vector<std::size_t> liveLamps(std::span<const Lamp> lamps, const Camera& camera);

// What stands within a lamp's reach, in the picture or not, wanted in the detail that the camera
// has there.
View lampView(const Lamp& lamp, const View& camera);

// The lamps of a frame, step by step as viewer/frame.cpp takes them.
class LampLights {
  public:
    explicit LampLights(const Scene& scene) : scene_(scene) {}

    void choose(const Camera& camera, const SunPosition& sun, const ShadowSettings& shadows);
    void addViews(std::vector<View>& views) const; // after the camera's, which is the first
    // `casters`: all that may stand before them. `surfaceCamera`: that `seen` was drawn with.
    void draw(const render::VisibilityPass& seen, const Camera& surfaceCamera,
              std::span<const LampCaster> casters);

    std::size_t live() const { return live_.size(); }
    const render::Texture* light() const { return live_.empty() ? nullptr : &pass_.light(); }
    std::size_t bytes() const { return live_.empty() ? 0 : pass_.bytes(); }
    int mapsDrawn() const { return live_.empty() ? 0 : pass_.mapsDrawn(); }
    // One lamp's own shadow, of the frame drawn last; none when it was not lit.
    std::optional<LampPicture> shadowOf(const render::VisibilityPass& seen, std::size_t lamp);

  private:
    LampPassInput input() const;

    const Scene& scene_;
    LampPass pass_;
    std::vector<std::size_t> live_;
    double exposure_ = 1.0;
    ShadowSettings shadows_;
    Camera surfaceCamera_;
};

} // namespace gnomon
