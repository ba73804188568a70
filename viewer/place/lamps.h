// The place's street lamps: hung over the middle of the street that the flight follows, from beyond
// the bridge to the tower's square, and four lanterns around the tower.
#pragma once

#include "geo/ellipsoid.h"
#include "viewer/place/plan.h"

#include <nlohmann/json.hpp>

#include <vector>

namespace gnomon::builtin {

struct StreetLamp {
    glm::dvec3 foot{0}; // on the ground or the bridge's deck
    double heightMetres = 0;
    bool allRound = false;
};
std::vector<StreetLamp> streetLamps(const Plan& plan);

// As GeoJSON (viewer/lamps_file.h), the place's frame at `at`.
nlohmann::json lampsJson(const std::vector<StreetLamp>& lamps, const Geodetic& at);

} // namespace gnomon::builtin
