// What the metrics ask of points on surfaces: whether two lie on one surface, how exactly a picture
// tells where they are, and where the light is from there.
#pragma once

#include "bench/reference.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace gnomon::bench {

// Normals within 11.5° belong to one surface, so that a dome of flat faces is one.
inline constexpr double kSameSurfaceCosine = 0.98;

// How far a picture may be off a surface that it shows: rasterisers place corners at 1/256 of a
// pixel, rays in double do not; and a millimetre, the length at which meshes are welded.
inline double surfaceTolerance(const Camera& camera, double distanceMetres) {
    const double pixelRadians = 2.0 * camera.tanHalfHeight() / camera.heightPixels;
    return 1e-3 + pixelRadians * distanceMetres / 16.0;
}

inline bool samePlane(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& other,
                      double toleranceMetres) {
    return std::abs(glm::dot(normal, other - point)) <= toleranceMetres;
}

// Unit, from a stored point to the light's centre.
inline glm::dvec3 towardsLight(const Light& light, const glm::dvec3& point) {
    if (const SunDisc* sun = std::get_if<SunDisc>(&light))
        return sun->towards;
    return glm::normalize(std::get<LampPoint>(light).position - point);
}

} // namespace gnomon::bench
