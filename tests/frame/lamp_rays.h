// What a lamp sees, by rays in double against the triangles themselves.
#pragma once

#include "tests/frame/sun_rays.h"

#include <glm/geometric.hpp>

#include <limits>
#include <optional>
#include <vector>

namespace gnomon::test {

class LampRays {
  public:
    // One frame for both, in metres. What is nearer to the lamp than `nearMetres` casts nothing.
    LampRays(std::vector<Triangle> triangles, const glm::dvec3& lamp, double nearMetres)
        : triangles_(std::move(triangles)), lamp_(lamp), near_(nearMetres) {
        for (Triangle& t : triangles_)
            for (glm::dvec3& p : t)
                p -= lamp;
    }

    struct Hit {
        double distance = std::numeric_limits<double>::infinity();
        std::size_t triangle = 0;
    };
    // The nearest along a unit direction.
    Hit nearest(const glm::dvec3& direction) const {
        Hit hit;
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            if (const auto d = distance(triangles_[i], direction); d && *d < hit.distance)
                hit = {*d, i};
        return hit;
    }
    // Where the direction meets a triangle's plane, inside of it or not.
    double planeDistance(std::size_t triangle, const glm::dvec3& direction) const {
        const auto& [a, b, c] = triangles_[triangle];
        const glm::dvec3 n = glm::cross(b - a, c - a);
        return glm::dot(n, a) / glm::dot(n, direction);
    }
    bool visible(const glm::dvec3& point, double tolerance) const {
        const glm::dvec3 to = point - lamp_;
        const double far = glm::length(to) - tolerance;
        const glm::dvec3 v = glm::normalize(to);
        for (const Triangle& t : triangles_)
            if (const auto d = distance(t, v); d && *d < far)
                return false;
        return true;
    }
    const glm::dvec3& lamp() const { return lamp_; }

  private:
    // Möller & Trumbore, from the origin.
    std::optional<double> distance(const Triangle& t, const glm::dvec3& v) const {
        const glm::dvec3 e1 = t[1] - t[0], e2 = t[2] - t[0], p = glm::cross(v, e2);
        const double det = glm::dot(e1, p);
        if (det == 0.0)
            return std::nullopt;
        const glm::dvec3 q = glm::cross(-t[0], e1);
        const double u = glm::dot(-t[0], p) / det, w = glm::dot(v, q) / det;
        const double d = glm::dot(e2, q) / det;
        if (u < 0.0 || w < 0.0 || u + w > 1.0 || d < near_)
            return std::nullopt;
        return d;
    }

    std::vector<Triangle> triangles_;
    glm::dvec3 lamp_;
    double near_;
};

} // namespace gnomon::test
