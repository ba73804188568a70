// All of a scene, loaded: its triangles in the anchor's frame, east, north, up in metres.
#pragma once

#include "tests/frame/sun_rays.h"
#include "viewer/scene.h"
#include "viewer/scene_placement.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace gnomon::test {

struct Loaded {
    std::vector<std::shared_ptr<const TileContent>> contents;
    std::vector<Triangle> triangles; // of all meshes
    std::vector<bool> clear;         // of one whose texture may let light through
    std::uint64_t closed = 0;
};

inline Loaded loadAll(Scene& scene) {
    Loaded out;
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.ecefFromAnchor);
    for (Layer& layer : scene.layers) {
        const auto contents = firstContents(*layer.tileset, 4096).value();
        for (const auto& content : contents) {
            out.contents.push_back(content);
            out.closed += content->facts.closedTriangles;
            for (const Mesh& mesh : content->meshes) {
                // Meshes are stored along the anchor's axes.
                const glm::dvec3 origin = anchorFromEcef(mesh.origin).xyz;
                const auto at = [&](std::size_t i) {
                    return origin + glm::dvec3(mesh.positions[mesh.indices[i]]);
                };
                const bool clear = content->materials[std::size_t(mesh.material)].alphaTest;
                // Skirts are for the eye: rays meet none.
                const std::size_t solid = mesh.indices.size() - 3 * mesh.skirtTriangles;
                for (std::size_t i = 0; i + 2 < solid; i += 3) {
                    out.triangles.push_back({at(i), at(i + 1), at(i + 2)});
                    out.clear.push_back(clear);
                }
            }
        }
    }
    return out;
}

// How far along a ray (unit) the first triangle is, or infinity.
inline double firstHit(const std::vector<Triangle>& triangles, const glm::dvec3& from,
                       const glm::dvec3& direction, double nearest = 0.0) {
    double best = 1e300;
    for (const auto& [a, b, c] : triangles) {
        const glm::dvec3 u = b - a, v = c - a, p = glm::cross(direction, v);
        const double determinant = glm::dot(u, p);
        if (determinant == 0.0)
            continue;
        const glm::dvec3 s = from - a, q = glm::cross(s, u);
        const double x = glm::dot(s, p) / determinant, y = glm::dot(direction, q) / determinant;
        const double t = glm::dot(v, q) / determinant;
        if (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > nearest && t < best)
            best = t;
    }
    return best;
}

} // namespace gnomon::test
