// Triangles with flat faces, as they go into one glTF primitive, and the solids made of them. Every
// solid is closed and wound outwards, its corners exactly equal where faces meet.
#pragma once

#include "viewer/place/plan.h"

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::builtin {

// Positions are east, north, up relative to `origin`, all on the lattice. May also be filled by
// hand, with vertices that faces share.
struct Shape {
    glm::dvec3 origin{0};
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> colors;   // linear RGBA8, R lowest
    std::vector<std::uint16_t> features; // empty, or one a vertex
    std::vector<std::uint32_t> indices;

    double latticeMetres = kLatticeMetres; // a power of two

    // What the next faces get.
    std::uint32_t color = 0xffffffffu;
    std::uint16_t feature = 0;
    bool withFeatures = false;

    void setColor(glm::vec3 srgb);
    // A flat polygon, counter-clockwise from outside, convex or a star about its first corner.
    void face(std::span<const glm::dvec3> corners, std::span<const glm::vec2> uv = {});
    void quad(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, glm::dvec3 d) {
        face(std::array{a, b, c, d});
    }
    std::uint32_t triangles() const { return std::uint32_t(indices.size() / 3); }
};

// The detail a tile shows, finest first. Each step leaves out what is smaller than the next level's
// error (tiles.h).
enum class Detail {
    Full,   // all of it
    Plain,  // no overhangs, chimneys, parapets, roof boxes, railings
    Boxes,  // buildings as boxes, roofs at half their height
    Masses, // a box a block
};

// Faces are only ever added to `into`; colours and features as set there.
void addBuilding(Shape& into, const Building& building, Detail detail);
// A box a block of buildings, those lower than `lowestMetres` left out.
void addMasses(Shape& into, const Cell& cell, double lowestMetres);
void addTower(Shape& into, const Plan& plan, Detail detail);
void addBridge(Shape& into, const Plan& plan, Detail detail);
// Open: not a solid.
void addShed(Shape& into, const Plan& plan, const Shed& shed);

// A tree 1 m high, its foot at the origin. `simple`: the crown only.
Shape treeShape(TreeKind kind, bool simple);

// Straight walls over a footprint (counter-clockwise), from z0 to z1, with floor and roof.
void addPrism(Shape& into, std::span<const glm::dvec2> footprint, double z0, double z1);
// A box of `width` (across) and `height` along the line from a to b; closed.
void addBar(Shape& into, glm::dvec3 a, glm::dvec3 b, double width, double height);

} // namespace gnomon::builtin
