#include "streaming/raycast.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace gnomon {

namespace {

// Möller & Trumbore, "Fast, minimum storage ray/triangle intersection" (1997). The triangle is
// relative to the ray's start.
std::optional<double> meet(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                           const glm::dvec3& direction) {
    constexpr double kEdge = 1e-9;
    const glm::dvec3 ab = b - a, ac = c - a;
    const glm::dvec3 p = glm::cross(direction, ac);
    const double determinant = glm::dot(ab, p);
    if (determinant == 0.0) {
        return {};
    }
    const double u = -glm::dot(a, p) / determinant;
    const glm::dvec3 q = glm::cross(-a, ab);
    const double v = glm::dot(direction, q) / determinant;
    const double metres = glm::dot(ac, q) / determinant;
    const bool inside = u >= -kEdge && v >= -kEdge && u + v <= 1.0 + kEdge;
    return inside && metres >= 0.0 && std::isfinite(metres) ? std::optional(metres) : std::nullopt;
}

// What two of the corners say; a vertex shared with a neighbour may carry its feature.
std::uint32_t featureOf(const Mesh& mesh, const std::uint32_t* corner) {
    if (mesh.features.empty()) {
        return kNoFeature;
    }
    const std::uint32_t b = mesh.features[corner[1]], c = mesh.features[corner[2]];
    return b == c ? b : mesh.features[corner[0]];
}

} // namespace

std::vector<RayHit> castRay(const TileContent& content, const glm::dmat3& meshAxes,
                            Point<Ecef> from, Vector<Ecef> direction) {
    std::vector<RayHit> hits;
    const glm::dmat3 storedFromEcef = glm::transpose(meshAxes);
    const glm::dvec3 along = storedFromEcef * direction.xyz;
    for (std::uint32_t m = 0; m < content.meshes.size(); ++m) {
        const Mesh& mesh = content.meshes[m];
        const glm::dvec3 start = storedFromEcef * (from - mesh.origin).xyz;
        const double past = glm::length(glm::cross(start, along));
        if (past > mesh.radiusMetres * (1.0 + 1e-9) + 1e-6) {
            continue;
        }
        const auto corner = [&](std::size_t i) {
            return glm::dvec3(mesh.positions[mesh.indices[i]]) - start;
        };
        for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
            const std::size_t i = std::size_t(t) * 3;
            if (const auto metres = meet(corner(i), corner(i + 1), corner(i + 2), along)) {
                hits.push_back({*metres, m, t, featureOf(mesh, &mesh.indices[i])});
            }
        }
    }
    std::stable_sort(hits.begin(), hits.end(),
                     [](const RayHit& a, const RayHit& b) { return a.metres < b.metres; });
    return hits;
}

} // namespace gnomon
