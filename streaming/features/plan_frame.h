// Places seen from above in metres about a place, x to the east; for what is no larger than a few
// kilometres (off by less than a millimetre a kilometre).
#pragma once

#include "geo/ellipsoid.h"

#include <glm/vec2.hpp>

#include <cmath>

namespace gnomon {

class PlanFrame {
  public:
    explicit PlanFrame(glm::dvec2 lonLat) : origin_(lonLat) {
        // Radii of curvature along the parallel and the meridian.
        constexpr double a = kEquatorialRadiusMetres, b = kPolarRadiusMetres;
        const double s = std::sin(lonLat.y * kRadiansPerDegree);
        const double c = std::cos(lonLat.y * kRadiansPerDegree);
        const double w = std::sqrt(a * a * c * c + b * b * s * s);
        metresPerDegree_ =
            kRadiansPerDegree * glm::dvec2(a * a / w * c, a * a * b * b / (w * w * w));
    }
    glm::dvec2 plan(glm::dvec2 lonLat) const { // the short way round the Earth
        return glm::dvec2(std::remainder(lonLat.x - origin_.x, 360.0), lonLat.y - origin_.y) *
               metresPerDegree_;
    }
    glm::dvec2 plan(const glm::dvec3& p) const { return plan(glm::dvec2(p)); }
    glm::dvec2 lonLat(const glm::dvec2& p) const { return origin_ + p / metresPerDegree_; }

  private:
    glm::dvec2 origin_, metresPerDegree_;
};

} // namespace gnomon
