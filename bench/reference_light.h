// A light as one surface point sees it.
#pragma once

#include "bench/reference.h"

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include <cmath>
#include <limits>

namespace gnomon::bench {

struct Incoming {
    glm::dvec3 towards{0, 0, 1}; // the centre, unit
    double distanceMetres = std::numeric_limits<double>::infinity();
    double tangent = 0.0; // of the disc's angular radius; 0: a point
    bool shines = true;   // false behind a lamp that lights half of space

    bool reaches(const glm::dvec3& normal) const {
        return shines && glm::dot(normal, towards) > 0.0;
    }
};

inline Incoming incomingAt(const glm::dvec3&, const SunDisc& sun) {
    return {glm::normalize(sun.towards), std::numeric_limits<double>::infinity(),
            std::tan(0.5 * glm::radians(sun.diameterDegrees)), true};
}
inline Incoming incomingAt(const glm::dvec3& point, const LampPoint& lamp) {
    const glm::dvec3 way = lamp.position - point;
    const double distance = glm::length(way);
    const bool allRound = lamp.facing == glm::dvec3(0.0);
    return {way / std::max(distance, 1e-300), distance, 0.0,
            distance > 0.0 && (allRound || glm::dot(lamp.facing, way) < 0.0)};
}
inline Incoming incomingAt(const glm::dvec3& point, const Light& light) {
    return std::visit([&](const auto& l) { return incomingAt(point, l); }, light);
}

} // namespace gnomon::bench
