#include "geo/plan_frame.h"

#include <cmath>

namespace gnomon {

PlanFrame::PlanFrame(glm::dvec2 lonLat)
    : longitude_(lonLat.x), ecefFromPlan_(ecefFromEnu({lonLat.x, lonLat.y, 0.0})),
      planFromEcef_(rigidInverse(ecefFromPlan_)) {}

glm::dvec2 PlanFrame::plan(glm::dvec2 lonLat) const {
    return glm::dvec2(planFromEcef_(ecefOf({lonLat.x, lonLat.y, 0.0})).xyz);
}

glm::dvec2 PlanFrame::lonLat(glm::dvec2 plan) const {
    // Down to the surface; each round leaves a share of the height that is the slope squared.
    double below = glm::dot(plan, plan) / (2.0 * kEquatorialRadiusMetres);
    Geodetic place;
    constexpr int kRounds = 3;
    for (int i = 0; i < kRounds; ++i) {
        place = geodeticOf(ecefFromPlan_(Point<Enu>{{plan, -below}}));
        below += place.heightMetres;
    }
    return {longitude_ + std::remainder(place.longitudeDegrees - longitude_, 360.0),
            place.latitudeDegrees};
}

} // namespace gnomon
