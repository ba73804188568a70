// Normals through a transform of positions that may stretch and mirror.
#pragma once

#include <glm/glm.hpp>

#include <cmath>

namespace gnomon {

// The inverse transpose of `axes` but for its scale, which needs no inverse: so it is there for
// axes in one plane, too.
inline glm::dmat3 normalAxesOf(const glm::dmat3& axes) {
    const double sign = glm::determinant(axes) < 0.0 ? -1.0 : 1.0;
    return sign * glm::dmat3(glm::cross(axes[1], axes[2]), glm::cross(axes[2], axes[0]),
                             glm::cross(axes[0], axes[1]));
}

// Of unit length; zero where there is no direction.
inline glm::vec3 turnedNormal(const glm::dmat3& normalAxes, const glm::vec3& normal) {
    const glm::dvec3 turned = normalAxes * glm::dvec3(normal);
    const double length = glm::length(turned);
    return length > 0.0 && std::isfinite(length) ? glm::vec3(turned / length) : glm::vec3(0.0f);
}

} // namespace gnomon
