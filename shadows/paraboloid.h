// What a lamp sees, on maps: after Brabec, Annen & Seidel, "Shadow mapping for hemispherical and
// omnidirectional light sources", 2002; and a cube's faces to compare.
//
// A paraboloid in front of the lamp reflects its hemisphere onto a plane. The picture is that of
// the stereographic projection, u = v.xy / (1 + |v.z|) for a unit direction v: angles are kept, the
// hemisphere fills the unit disc, and a texel at the rim covers a quarter of the solid angle of one
// in the middle, no more uneven than that. A straight edge, a great circle as the lamp sees it,
// becomes an arc of a circle. So how far it strays from the chord that would be drawn in its place
// is known exactly, and triangles are cut until none strays by more than is asked for.
//
// Maps keep the distance from the lamp. Past the rim they go on for kLampGuardTexels (with 1 + v.z,
// past the horizon), so that a filter reads one map only and no seam shows.
#pragma once

#include "geo/frames.h"
#include "shadows/lamp.h"
#include "shadows/settings.h"

#include <glm/vec2.hpp>

#include <array>
#include <cstddef>
#include <vector>

namespace gnomon {

struct LampFrame; // right, up, ahead (where it faces); origin in the lamp

// The axes turn continuously with the facing but where a lamp faces the zenith. All round: ahead
// is down.
Transform<LampFrame, Ecef> lampFromEcef(const Transform<Ecef, Enu>& ecefFromAnchor,
                                        const Lamp& lamp);
bool shinesAllRound(const Lamp& lamp);

// In the plane of the map, of a unit direction; ahead only, or behind when mirrored first.
glm::dvec2 paraboloidPoint(const glm::dvec3& direction); // 1e6 at most, straight behind
glm::dvec3 paraboloidDirection(const glm::dvec2& point);
// Steradians that a unit of the plane's area covers: 4 in the middle, 1 at the rim.
double paraboloidSolidAngle(const glm::dvec2& point);

// The maps of one lamp. Paraboloid: ahead, behind. Cube: ahead, right, left, up, down, behind;
// 1/√3 of the size, so that six faces have the texels of two hemispheres.
struct LampMaps {
    LampMethod method = LampMethod::Paraboloid;
    int texels = 1024;          // across each map
    int count = 1;              // 1 or 2; 5 or 6
    double unitsAcross() const; // of the plane; the hemisphere's disc and a cube's face take 2
};
// Of the filters that read a lamp's map none reaches farther than pcf:9, 4.5 texels and the one it
// ends in; and a gather of four rounds up.
inline constexpr int kLampGuardTexels = 8;
LampMaps lampMaps(const ShadowSettings& settings, const Lamp& lamp);

struct LampTexel {
    int map = 0;
    glm::dvec2 at{0.0}; // texel centres are at halves
};
LampTexel lampTexel(const LampMaps& maps, const glm::dvec3& direction); // of any length
glm::dvec3 lampDirection(const LampMaps& maps, const LampTexel& texel); // unit
// Clip x, y and w of a place on a face of the cube.
glm::dvec3 faceClip(const LampMaps& maps, int face, const glm::dvec3& position);
// The wider side of a texel, as an angle seen from the lamp.
double texelRadians(const LampMaps& maps, const glm::dvec3& direction);

// How far the image of the edge from a to b strays from the chord, in units of the plane, exactly.
// Infinite when the edge passes behind the chord's ends. Positions are relative to the lamp.
double edgeBend(const glm::dvec3& a, const glm::dvec3& b);
// The point that halves the edge's angle: the same from both ends, to the last bit, so triangles
// that share an edge are cut alike and no crack opens.
glm::dvec3 edgeMiddle(const glm::dvec3& a, const glm::dvec3& b);
// Into how many pieces an edge is cut so that none bends by more than `limit` (> 0): halved until
// it does.
int edgeSegments(const glm::dvec3& a, const glm::dvec3& b, double limit);

using LampTriangle = std::array<glm::dvec3, 3>; // corners relative to the lamp
// The part of the triangle ahead of the lamp, in pieces whose images' edges are none of them off by
// more than `limit` when drawn straight; 0 does not cut. What lies beyond the map's guard is left
// out. Stops cutting when `out` holds `most`.
void cutTriangle(const LampTriangle& triangle, double limit, const LampMaps& maps, std::size_t most,
                 std::vector<LampTriangle>& out);

} // namespace gnomon
