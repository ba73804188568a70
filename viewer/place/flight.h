// The camera's way: from far over the city, across the bridge, down between the houses to the
// tower.
#pragma once

#include "geo/ellipsoid.h"
#include "viewer/place/plan.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace gnomon::builtin {

struct FlightKey {
    double seconds = 0;
    glm::dvec3 position{0}; // east, north, up in the place's frame
    glm::dvec3 target{0};   // what it looks at
};

inline constexpr double kFlightFovDegrees = 45.0;

std::vector<FlightKey> flight(const Plan& plan);

// As a camera path file, the place's frame at `at`. Roll is written too: far out, the place's up is
// not quite the local one.
nlohmann::json flightJson(const std::vector<FlightKey>& keys, const Geodetic& at);
// A summer afternoon there: 16 h by the sun, UTC.
std::string afternoon(const Geodetic& at);
// When the flood begins to rise that day, and when the barrier stands.
std::string floodBegins(const Geodetic& at);
std::string barrierAppears(const Geodetic& at);

} // namespace gnomon::builtin
