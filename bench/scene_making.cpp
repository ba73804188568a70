#include "bench/scene_making.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gnomon::bench {

namespace {

constexpr double kSunRadius = 0.5 * kSunDiameterDegrees * kRadiansPerDegree; // as a tangent, too

// Whether a ray (unit) meets a triangle farther on than `from` (Moeller & Trumbore, 1997).
bool meets(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& from,
           const glm::dvec3& ray) {
    const glm::dvec3 u = b - a, v = c - a, p = glm::cross(ray, v);
    const double determinant = glm::dot(u, p);
    if (determinant == 0.0)
        return false;
    const glm::dvec3 s = from - a, q = glm::cross(s, u);
    const double x = glm::dot(s, p) / determinant, y = glm::dot(ray, q) / determinant;
    return x >= 0.0 && y >= 0.0 && x + y <= 1.0 && glm::dot(v, q) / determinant > 0.0;
}

bool meets(const Shape& shape, const glm::dvec3& from, const glm::dvec3& ray) {
    for (std::size_t i = 0; i + 2 < shape.indices.size(); i += 3)
        if (meets(shape.positions[shape.indices[i]], shape.positions[shape.indices[i + 1]],
                  shape.positions[shape.indices[i + 2]], from, ray))
            return true;
    return false;
}

constexpr int kRimRays = 24;

// How many of the rays to the sun's rim are stopped.
int stoppedRays(const Shape& shape, const glm::dvec3& at, const glm::dvec3& sun) {
    constexpr double kLift = 1e-4; // off the surface that the probe lies on
    const glm::dvec3 side = glm::normalize(glm::cross(sun, glm::dvec3(0.3, 0.5, 0.8)));
    const glm::dvec3 up = glm::cross(side, sun);
    int stopped = 0;
    for (int i = 0; i < kRimRays; ++i) {
        const double a = 2.0 * std::numbers::pi * i / kRimRays;
        const glm::dvec3 ray =
            glm::normalize(sun + kSunRadius * (std::cos(a) * side + std::sin(a) * up));
        stopped += meets(shape, at + glm::dvec3(0, 0, kLift), ray);
    }
    return stopped;
}

bool holds(const Shape& shape, const Probe& probe, const glm::dvec3& sun) {
    constexpr double kAbove = 0.01; // by so much the surface lies below its probe's ends, not more
    for (const glm::dvec3& end : {probe.from, probe.to})
        if (!meets(shape, end + glm::dvec3(0, 0, kAbove), {0, 0, -1}))
            return false;
    const bool contact = probe.kind == Probe::Kind::Contact;
    constexpr std::array kDark = {0.02, 0.25, 0.5, 0.75, 1.0};
    constexpr std::array kLit = {-0.1, 0.0, 0.1};
    for (const double t : kDark) // of a penumbra's probe only the last stretch is wholly dark
        if (stoppedRays(shape, glm::mix(probe.from, probe.to, contact ? t : 0.9 + 0.2 * t), sun) !=
            kRimRays)
            return false;
    for (const double t : kLit)
        if (!contact && stoppedRays(shape, glm::mix(probe.from, probe.to, t), sun) != 0)
            return false;
    return true;
}

} // namespace

glm::dvec3 MadeScene::towardsSun() const {
    const double a = sun.azimuthDegrees * kRadiansPerDegree;
    const double e = sun.elevationDegrees * kRadiansPerDegree;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

glm::dvec3 MadeScene::shadowOf(const glm::dvec3& point, double height) const {
    const glm::dvec3 towards = towardsSun();
    return point - (point.z - height) / towards.z * towards;
}

void MadeScene::probeEdge(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& towardsDark,
                          double height, double leastMetres) {
    if (!(towardsSun().z > 0.0))
        return;
    const glm::dvec3 middle = 0.5 * (a + b), shadow = shadowOf(middle, height);
    const double gap = glm::length(middle - shadow);
    // Across the edge's shadow on the level, from light to dark.
    const glm::dvec3 edge = glm::normalize(shadowOf(b, height) - shadowOf(a, height));
    glm::dvec3 across(-edge.y, edge.x, 0.0);
    if (glm::dot(across, towardsDark) < 0.0)
        across = -across;
    const double width =
        gap * 2.0 * std::tan(0.5 * kSunDiameterDegrees * kRadiansPerDegree) / towardsSun().z;
    const glm::dvec3 half = 0.5 * std::max(3.0 * width, leastMetres) * across;
    probes.push_back({Probe::Kind::Penumbra, shadow - half, shadow + half, gap});
}

void MadeScene::dropSpoiltProbes() {
    const glm::dvec3 towards = towardsSun();
    std::erase_if(probes, [&](const Probe& probe) { return !holds(solids, probe, towards); });
}

} // namespace gnomon::bench
