// A camera held by the hand: it looks at a target on the anchor's level and turns about it. No
// window here; a window turns pointer motion into these calls.
#pragma once

#include "geo/camera.h"
#include "viewer/scene.h"

namespace gnomon {

class Orbit {
  public:
    // Keeps where `camera` stands and looks; the target is where its axis meets the anchor's level,
    // or a point ahead of it when it looks up.
    Orbit(const Scene& scene, const Camera& camera);

    void turn(double headingDegrees, double pitchDegrees); // about the target; pitch stays in ±89.9
    void zoom(double factor);                              // distance to the target times this
    // Moves the target with the ground below the pointer; in pixels.
    void pan(double rightPixels, double upPixels);
    void resize(int widthPixels, int heightPixels);

    Camera camera() const;

  private:
    const Scene& scene_;
    Camera lens_;            // field of view and size
    glm::dvec3 target_{0.0}; // in the anchor's frame
    double headingDegrees_ = 0.0, pitchDegrees_ = -35.0, distanceMetres_ = 1.0;
};

} // namespace gnomon
