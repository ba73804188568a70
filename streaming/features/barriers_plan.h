// Barriers seen from above: what a line of some width or an area covers, and how that is cut into
// triangles. In metres, x to the east; nothing here knows heights.
#pragma once

#include <glm/vec2.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gnomon {

using PlanRing = std::vector<glm::dvec2>; // not closed: the first point is not repeated
// Points of polygons lie on a grid: no two are so near that they would be welded
// (streaming/clean.h).
inline constexpr double kPlanGridMetres = 0.005;
struct PlanPolygon {
    std::vector<PlanRing> rings; // the outer one first, then holes
};

// What lies within half the width of a line: flat at its ends, mitred at its bends (cut off where
// the tip would reach further than kMitreLimit half widths). One that crosses itself is one
// polygon; one whose last point is its first is closed.
inline constexpr double kMitreLimit = 5.0;
std::vector<PlanPolygon> stripAlong(std::span<const glm::dvec2> line, double widthMetres);

// The same area in polygons that do not cross themselves; empty when it has none.
std::vector<PlanPolygon> validAreas(std::span<const PlanRing> rings);

struct PlanMesh {
    std::vector<glm::dvec2> points;
    std::vector<std::array<std::uint32_t, 3>> triangles; // counter-clockwise
};
// Over the polygon's points alone, none in between left out (constrained Delaunay triangles).
std::optional<PlanMesh> triangulated(const PlanPolygon& polygon);

} // namespace gnomon
