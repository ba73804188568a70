// A flat plan about a place: the ellipsoid seen straight from above (orthographic projection, EPSG
// method 9840), so it is the same at a pole and on the antimeridian as anywhere.
#pragma once

#include "geo/ellipsoid.h"

#include <glm/vec2.hpp>

namespace gnomon {

class PlanFrame {
  public:
    // About the surface below `lonLat`, in degrees; x to the east there.
    explicit PlanFrame(glm::dvec2 lonLat);

    // Metres. Shrinks by a millimetre in a piece of a kilometre that lies 10 km off.
    glm::dvec2 plan(glm::dvec2 lonLat) const;
    glm::dvec2 plan(const glm::dvec3& place) const { return plan(glm::dvec2(place)); }
    // The way back, for places up to some 1000 km off. Longitudes go on beyond 180 degrees where
    // that is nearer to the middle's.
    glm::dvec2 lonLat(glm::dvec2 plan) const;

  private:
    double longitude_;
    Transform<Ecef, Enu> ecefFromPlan_;
    Transform<Enu, Ecef> planFromEcef_;
};

} // namespace gnomon
