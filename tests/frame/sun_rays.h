// What the sun sees, by rays in double against the triangles themselves: the truth that pictures
// are held against. All rays run towards the sun, so a grid on the light's plane finds their
// triangles.
#pragma once

#include "shadows/light_basis.h"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace gnomon::test {

using Triangle = std::array<glm::dvec3, 3>;

class SunRays {
  public:
    // Triangles and the direction to the sun in one frame, in metres.
    SunRays(const std::vector<Triangle>& triangles, const glm::dvec3& towardsSun)
        : lightFromFrame_(glm::transpose(lightAxes(towardsSun))) {
        for (const Triangle& t : triangles)
            triangles_.push_back(
                {lightFromFrame_ * t[0], lightFromFrame_ * t[1], lightFromFrame_ * t[2]});
        for (const Triangle& t : triangles_)
            for (const glm::dvec3& p : t) {
                low_ = glm::min(low_, glm::dvec2(p));
                high_ = glm::max(high_, glm::dvec2(p));
            }
        const double across = std::max({high_.x - low_.x, high_.y - low_.y, 1e-3});
        cell_ = across / kCells;
        cells_.resize(kCells * kCells);
        for (std::uint32_t i = 0; i < triangles_.size(); ++i)
            insert(i);
    }

    // Whether anything stands more than `tolerance` metres sunward of the point.
    bool shadowed(const glm::dvec3& point, double tolerance) const {
        return above(lightFromFrame_ * point, tolerance);
    }

    // The same at points all round within `radius` of it, on the plane through it that `normal` is
    // normal to.
    enum class Answer { Lit, Dark, Edge };
    Answer around(const glm::dvec3& point, const glm::dvec3& normal, double radius,
                  double tolerance) const {
        const glm::dvec3 p = lightFromFrame_ * point, n = lightFromFrame_ * normal;
        const bool dark = above(p, tolerance);
        for (int ring = 1; ring <= 3; ++ring)
            for (int i = 0; i < 12; ++i) {
                const double a = (i + 0.5 * ring) * 2.0 * 3.14159265358979 / 12.0;
                const double r = radius * ring / 3.0;
                const glm::dvec2 d(r * std::cos(a), r * std::sin(a));
                const double dz = -(n.x * d.x + n.y * d.y) / n.z;
                if (above(p + glm::dvec3(d, dz), tolerance) != dark)
                    return Answer::Edge;
            }
        return dark ? Answer::Dark : Answer::Lit;
    }

  private:
    static constexpr int kCells = 128;

    int index(double x, double low) const {
        return std::clamp(int(std::floor((x - low) / cell_)), 0, kCells - 1);
    }

    void insert(std::uint32_t i) {
        const Triangle& t = triangles_[i];
        const glm::dvec3 low = glm::min(t[0], glm::min(t[1], t[2]));
        const glm::dvec3 high = glm::max(t[0], glm::max(t[1], t[2]));
        for (int y = index(low.y, low_.y); y <= index(high.y, low_.y); ++y)
            for (int x = index(low.x, low_.x); x <= index(high.x, low_.x); ++x)
                cells_[std::size_t(y * kCells + x)].push_back(i);
    }

    bool above(const glm::dvec3& p, double tolerance) const {
        if (p.x < low_.x || p.x > high_.x || p.y < low_.y || p.y > high_.y)
            return false;
        for (const std::uint32_t i :
             cells_[std::size_t(index(p.y, low_.y) * kCells + index(p.x, low_.x))]) {
            const auto& [a, b, c] = triangles_[i];
            const auto edge = [&](const glm::dvec3& u, const glm::dvec3& v) {
                return (v.x - u.x) * (p.y - u.y) - (v.y - u.y) * (p.x - u.x);
            };
            const double wa = edge(b, c), wb = edge(c, a), wc = edge(a, b), sum = wa + wb + wc;
            const bool inside = (wa >= 0 && wb >= 0 && wc >= 0) || (wa <= 0 && wb <= 0 && wc <= 0);
            if (inside && sum != 0.0 && (wa * a.z + wb * b.z + wc * c.z) / sum > p.z + tolerance)
                return true;
        }
        return false;
    }

    glm::dmat3 lightFromFrame_;
    std::vector<Triangle> triangles_;
    glm::dvec2 low_{1e300}, high_{-1e300};
    double cell_ = 1.0;
    std::vector<std::vector<std::uint32_t>> cells_;
};

} // namespace gnomon::test
