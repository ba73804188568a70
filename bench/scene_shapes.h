// What the comparison scenes are made of. Solids are closed and wound outwards, corners exactly
// equal where faces meet; sheets have one side, their front. East, north, up in metres.
#pragma once

#include "geo/result.h"
#include "viewer/place/shape.h"

#include <functional>
#include <span>
#include <vector>

namespace gnomon::bench {

using builtin::Shape;

// Corners lie on this lattice, which floats hold exactly to 2 km: a pipe of 2 cm stays round.
inline constexpr double kSceneLatticeMetres = 1.0 / 8192.0;

Shape sceneShape();

void addBox(Shape& into, const glm::dvec3& low, const glm::dvec3& high);
// Four corners, counter-clockwise from the front.
void addSheet(Shape& into, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
              const glm::dvec3& d);
// A corrugated sheet between two edges, from a to b and from d to c, folded across a → b in `waves`
// waves of ± `depthMetres`, drawn from the front as addSheet's.
void addCorrugated(Shape& into, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                   const glm::dvec3& d, int waves, double depthMetres);
// A round bar with flat ends.
void addPipe(Shape& into, const glm::dvec3& a, const glm::dvec3& b, double radius, int sides = 12);
void addSphere(Shape& into, const glm::dvec3& centre, const glm::dvec3& radii, int rings = 32);
// A sphere with dents, as a tree's crown.
void addCrown(Shape& into, const glm::dvec3& centre, const glm::dvec3& radii, double rough);
// An I of `height` and `width`, its web and flanges `thickness` thick, along the line from a to b.
void addBeam(Shape& into, const glm::dvec3& a, const glm::dvec3& b, double width, double height,
             double thickness);
// A flat truss: two chords from a to b, `height` apart (the upper one above), with struts between.
void addTruss(Shape& into, const glm::dvec3& a, const glm::dvec3& b, double height, int panels,
              double bar);
// Two stiles and rungs, from the foot up; `side` is half its width as a vector.
void addLadder(Shape& into, const glm::dvec3& foot, const glm::dvec3& top, const glm::dvec3& side,
               int rungs);
// `top` four legs and a slab: a table on the floor at `at`, `size` (width, depth, height).
void addTable(Shape& into, const glm::dvec3& at, const glm::dvec3& size);
void addChair(Shape& into, const glm::dvec3& at, double headingRadians);

// The surface of genus two where `field` is zero, inside it being negative, within a box: one
// vertex a cell of `step` metres, moved onto the surface, and the field's own normals (after
// Gibson, "Constrained elastic surface nets", 1998). Closed where the surface does not reach the
// box.
struct Field {
    std::function<double(const glm::dvec3&)> value;
    glm::dvec3 low, high;
};
void addIsosurface(Shape& into, const Field& field, double step);

// Crossed upright quads with a picture of leaves; uvs 0…1 from the foot's left to the top's right.
void addCrossedQuads(Shape& into, const glm::dvec3& foot, double width, double height, int quads,
                     double turnRadians);
// Leaves with gaps between: PNG, RGBA.
Result<std::vector<std::byte>> leafPicture(std::uint64_t seed);

// A surface of heights over a grid of given lines, its normals smooth and upwards.
void addTerrain(Shape& into, std::span<const double> xs, std::span<const double> ys,
                const std::function<glm::dvec3(double x, double y)>& at,
                const std::function<glm::vec3(double x, double y)>& colorAt);

} // namespace gnomon::bench
