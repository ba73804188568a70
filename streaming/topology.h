// Which triangles bound a solid. Shadow maps may cull the front faces of what is closed, so an open
// surface must never be taken for a closed one; the other way round costs only quality.
#pragma once

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon {

struct Topology {
    std::vector<std::uint8_t> closed; // one a triangle
    std::vector<std::uint8_t> flip;   // turn it round so that it faces outward; closed ones only
    std::uint32_t components = 0, closedComponents = 0;
};

// `triangles` index `positions` and have three different corners each. Triangles of different
// `group` (0 or 1) are not connected. A component is what hangs together by edges. It is closed
// when, once wound consistently over the edges that two triangles share, every directed edge is
// matched by its opposite, and what it encloses is thicker than `thickness` in the mean. A part of
// a component that is closed by itself (a house with a fence leaning on its edge) counts as closed.
Topology analyse(std::span<const std::array<std::uint32_t, 3>> triangles,
                 std::span<const std::uint8_t> group, std::span<const glm::dvec3> positions,
                 double thickness);

} // namespace gnomon
