// What goes into a lamp's maps: the triangles within its reach, in the lamp's frame, cut for the
// maps and laid out for shaders/lamp_depth.*.
#pragma once

#include "render/gpu_tile.h"
#include "shadows/paraboloid.h"
#include "streaming/mesh.h"

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace gnomon {

// A mesh that may stand between a lamp and what it lights: as it was decoded, and as it is drawn.
struct LampCaster {
    std::shared_ptr<const TileContent> content;
    std::uint32_t mesh = 0; // into content->meshes
    const render::GpuTile* tile = nullptr;

    const Mesh& geometry() const { return content->meshes[mesh]; }
    bool alphaTests() const;
};

// Of these, the ones whose box the lamp reaches.
std::vector<LampCaster> castersOf(const Lamp& lamp, std::span<const LampCaster> casters);

// One map's triangles. A texel asks the triangle's own plane for its distance, so that what is
// stored is the distance at the texel's centre, however the triangle was cut.
struct LampMapTriangles {
    std::vector<glm::vec3> corners; // clip x, y and w; three a triangle
    // Four a triangle, of the whole one it was cut from. xyz: n / (n·p) of its plane, whose product
    // with a unit direction is one over the distance; w: its farthest corner's distance. Then, of
    // each edge, the inward unit normal of its plane through the lamp. Alpha-tested ones have two
    // more: u and v of a place in the lamp's frame.
    std::vector<glm::vec4> planes;
    std::uint32_t opaque = 0; // triangles, first
    struct AlphaRange {
        std::uint32_t first = 0, count = 0; // triangles
        std::size_t caster = 0;             // index into those given
    };
    std::vector<AlphaRange> alpha;
};

struct LampGeometry {
    std::vector<LampMapTriangles> maps;
    std::uint64_t sourceTriangles = 0;
};
// `bendTexels`: ShadowSettings::lampEdgeTexels; cubes bend nothing.
LampGeometry lampGeometry(const Transform<LampFrame, Ecef>& lampFromEcef, const Lamp& lamp,
                          const LampMaps& maps, const glm::dmat3& meshAxes, double bendTexels,
                          std::span<const LampCaster> casters);

} // namespace gnomon
