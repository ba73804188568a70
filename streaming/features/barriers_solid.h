// One barrier as closed solids that stand in the ground: from kBaseDepthMetres below it to the
// crest.
#pragma once

#include "streaming/features/barriers_facts.h"
#include "streaming/soup.h"

namespace gnomon {

// Hides the base where the ground bulges down between samples, and where coarser terrain lies
// lower.
inline constexpr double kBaseDepthMetres = 0.5;

// Checked as any content is (streaming/clean.h).
struct BarrierSolid {
    Point<Ecef> origin;
    std::vector<glm::dvec3> positions; // from `origin`, ECEF's axes
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint8_t> closed; // one a triangle
    BarrierMaterial material = BarrierMaterial::Wall;
};

// Long lines become several, each about kMaxMeshExtentMetres, that meet flush in the middle of a
// segment. Fails where the barrier has no extent or the ground no height.
Result<std::vector<BarrierSolid>> solidsOf(const BarrierFacts& barrier,
                                           const GroundHeights& ground);

} // namespace gnomon
