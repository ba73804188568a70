// Buildings as closed solids. A solid's faces are listed with the very same corner values, so that
// they weld exactly; parts that stand in one another (chimneys, roofs with overhang) overlap and
// share no face.
#include "viewer/place/shape.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace gnomon::builtin {
namespace {

using Corners = std::vector<glm::dvec2>;

glm::dvec2 rotated(const Building& b, glm::dvec2 p) {
    const double c = std::cos(b.headingRadians), s = std::sin(b.headingRadians);
    return b.centre + glm::dvec2(c * p.x - s * p.y, s * p.x + c * p.y);
}

// A wall from a to b with whole windows: u counts bays, v storeys from the eaves down; the picture
// holds four of each.
void addWall(Shape& into, const Building& b, glm::dvec2 from, glm::dvec2 to, double z0, double z1) {
    const double bay = b.facade == Facade::Offices ? 3.4 : 2.9;
    const auto bays = float(std::max(1.0, std::round(glm::distance(from, to) / bay)) / 4);
    const auto storeys = float((z1 - z0) / b.storeyMetres / 4);
    into.face(std::array{glm::dvec3(from, z0), glm::dvec3(to, z0), glm::dvec3(to, z1),
                         glm::dvec3(from, z1)},
              std::array{glm::vec2(0, storeys), glm::vec2(bays, storeys), glm::vec2(bays, 0),
                         glm::vec2(0, 0)});
}

// Whole storeys of windows down from z1; what is left at the foot is a plinth, all around at one
// height, so that no edge of one wall ends within an edge of the next.
void addWalls(Shape& into, const Building& b, const Corners& foot, double z0, double z1) {
    const double storeys = std::max(1.0, std::floor((z1 - b.groundMetres - 0.2) / b.storeyMetres));
    const double plinth = z1 - storeys * b.storeyMetres;
    const bool split = plinth > z0 + 0.3;
    for (std::size_t i = 0; i < foot.size(); ++i) {
        const glm::dvec2 from = foot[i], to = foot[(i + 1) % foot.size()];
        into.setColor(b.wallColor);
        addWall(into, b, from, to, split ? plinth : z0, z1);
        if (!split)
            continue;
        into.setColor(b.wallColor * 0.78f);
        into.quad({from, z0}, {to, z0}, {to, plinth}, {from, plinth});
    }
    into.setColor(b.wallColor);
}

// From afar: windows to the ground.
void addPlainWalls(Shape& into, const Building& b, const Corners& foot, double z0, double z1) {
    into.setColor(b.wallColor);
    for (std::size_t i = 0; i < foot.size(); ++i)
        addWall(into, b, foot[i], foot[(i + 1) % foot.size()], z0, z1);
}

// Fans about the corner from which a whole L is seen: the one opposite the notch (index 0 or, when
// mirrored, the last).
void addFlat(Shape& into, const Building& b, const Corners& foot, double z, bool up) {
    std::vector<glm::dvec3> corners;
    const bool mirrored = b.notch.x > 0 && b.notchCorner.x * b.notchCorner.y < 0;
    const std::size_t n = foot.size(), start = mirrored ? n - 1 : 0;
    for (std::size_t i = 0; i < n; ++i)
        corners.emplace_back(foot[(start + (up ? i : n - i)) % n], z);
    into.face(corners);
}

void addFloor(Shape& into, const Building& b, const Corners& foot) {
    into.setColor(b.wallColor);
    addFlat(into, b, foot, b.baseMetres, false);
}

void addBox(Shape& into, const Building& b, double top, bool plinth) {
    const Corners foot = b.footprint();
    addFloor(into, b, foot);
    if (plinth)
        addWalls(into, b, foot, b.baseMetres, top);
    else
        addPlainWalls(into, b, foot, b.baseMetres, top);
    into.setColor(b.roofColor);
    addFlat(into, b, foot, top, true);
}

// A flat roof behind a parapet 0.8 m high and 0.3 m thick.
void addParapetBuilding(Shape& into, const Building& b) {
    const Corners outer = b.footprint(), inner = b.footprint(-0.3);
    const double deck = b.eavesMetres, top = deck + 0.8;
    addFloor(into, b, outer);
    addWalls(into, b, outer, b.baseMetres, top);
    into.setColor(b.wallColor * 0.92f);
    for (std::size_t i = 0; i < outer.size(); ++i) {
        const std::size_t j = (i + 1) % outer.size();
        into.quad({outer[i], top}, {outer[j], top}, {inner[j], top}, {inner[i], top});
        into.quad({inner[i], top}, {inner[j], top}, {inner[j], deck}, {inner[i], deck});
    }
    into.setColor(b.roofColor);
    addFlat(into, b, inner, deck, true);
    if (b.roofBox) {
        const glm::dvec2 at =
            b.notch.x > 0 ? -glm::dvec2(b.notchCorner) * (b.half - 3.4) : 0.2 * b.half;
        into.setColor(b.roofColor * 0.9f);
        Corners box;
        for (const glm::dvec2 c : {glm::dvec2(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
            box.push_back(rotated(b, at + c * glm::dvec2(1.7, 1.4)));
        addPrism(into, box, deck - 0.3, deck + 2.3);
    }
}

// The four corners turned so that the ridge runs from the middle of [3][0] to the middle of [1][2].
Corners alongRidge(const Building& b, double growAcross, double growAlong) {
    const glm::dvec2 grow =
        b.ridgeAlongX ? glm::dvec2(growAlong, growAcross) : glm::dvec2(growAcross, growAlong);
    const glm::dvec2 h = b.half + grow;
    Corners c{rotated(b, {-h.x, -h.y}), rotated(b, {h.x, -h.y}), rotated(b, {h.x, h.y}),
              rotated(b, {-h.x, h.y})};
    if (!b.ridgeAlongX)
        std::rotate(c.begin(), c.begin() + 1, c.end());
    return c;
}

void addGableBody(Shape& into, const Building& b, double eaves, double ridge) {
    const Corners c = alongRidge(b, 0, 0);
    const glm::dvec2 r0 = (c[0] + c[3]) / 2.0, r1 = (c[1] + c[2]) / 2.0;
    into.setColor(b.wallColor);
    into.face(std::array{glm::dvec3(c[3], b.baseMetres), glm::dvec3(c[2], b.baseMetres),
                         glm::dvec3(c[1], b.baseMetres), glm::dvec3(c[0], b.baseMetres)});
    addWalls(into, b, c, b.baseMetres, eaves);
    into.face(std::array{glm::dvec3(c[1], eaves), glm::dvec3(c[2], eaves), glm::dvec3(r1, ridge)});
    into.face(std::array{glm::dvec3(c[3], eaves), glm::dvec3(c[0], eaves), glm::dvec3(r0, ridge)});
    into.setColor(b.roofColor);
    into.quad({c[0], eaves}, {c[1], eaves}, {r1, ridge}, {r0, ridge});
    into.quad({c[2], eaves}, {c[3], eaves}, {r0, ridge}, {r1, ridge});
}

// The roof's own slab, reaching over the walls: a chevron of 0.25 m drawn along the ridge.
void addGableSlab(Shape& into, const Building& b) {
    const Corners c = alongRidge(b, b.overhangMetres, b.gableOverhangMetres);
    const double run = b.ridgeAlongX ? b.half.y : b.half.x;
    const double low = b.eavesMetres - b.overhangMetres * b.roofMetres / run;
    const double ridge = b.eavesMetres + b.roofMetres, thick = 0.25;
    const glm::dvec2 r0 = (c[0] + c[3]) / 2.0, r1 = (c[1] + c[2]) / 2.0;
    // Across the ridge, counter-clockwise seen from its far end (r1).
    const glm::dvec3 n[6] = {{c[0], low - thick}, {r0, ridge - thick}, {c[3], low - thick},
                             {c[3], low},         {r0, ridge},         {c[0], low}};
    const glm::dvec3 f[6] = {{c[1], low - thick}, {r1, ridge - thick}, {c[2], low - thick},
                             {c[2], low},         {r1, ridge},         {c[1], low}};
    into.setColor(b.roofColor);
    for (int i = 0; i < 6; ++i) {
        const int j = (i + 1) % 6;
        into.quad(n[i], n[j], f[j], f[i]);
    }
    into.quad(n[0], n[5], n[4], n[1]);
    into.quad(n[1], n[4], n[3], n[2]);
    into.quad(f[0], f[1], f[4], f[5]);
    into.quad(f[1], f[2], f[3], f[4]);
}

// Corners first, then the two ends of the ridge.
void addHip(Shape& into, const Corners& c, double z, double ridge) {
    const double across = glm::distance(c[0], c[3]), along = glm::distance(c[0], c[1]);
    const double t = std::min(0.46, 0.5 * across / along);
    const glm::dvec2 a = (c[0] + c[3]) / 2.0, e = (c[1] + c[2]) / 2.0;
    const glm::dvec2 r0 = glm::mix(a, e, t), r1 = glm::mix(e, a, t);
    into.quad({c[0], z}, {c[1], z}, {r1, ridge}, {r0, ridge});
    into.quad({c[2], z}, {c[3], z}, {r0, ridge}, {r1, ridge});
    into.face(std::array{glm::dvec3(c[1], z), glm::dvec3(c[2], z), glm::dvec3(r1, ridge)});
    into.face(std::array{glm::dvec3(c[3], z), glm::dvec3(c[0], z), glm::dvec3(r0, ridge)});
}

void addHipBuilding(Shape& into, const Building& b, bool overhang) {
    const double ridge = b.topMetres();
    const Corners c = alongRidge(b, 0, 0);
    if (!overhang) {
        into.setColor(b.wallColor);
        into.face(std::array{glm::dvec3(c[3], b.baseMetres), glm::dvec3(c[2], b.baseMetres),
                             glm::dvec3(c[1], b.baseMetres), glm::dvec3(c[0], b.baseMetres)});
        addWalls(into, b, c, b.baseMetres, b.eavesMetres);
        into.setColor(b.roofColor);
        addHip(into, c, b.eavesMetres, ridge);
        return;
    }
    addBox(into, b, b.eavesMetres, true);
    const Corners o = alongRidge(b, b.overhangMetres, b.overhangMetres);
    const double low = b.eavesMetres - 0.15, fascia = b.eavesMetres + 0.1;
    into.setColor(b.roofColor);
    into.quad({o[3], low}, {o[2], low}, {o[1], low}, {o[0], low});
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t j = (i + 1) % 4;
        into.quad({o[i], low}, {o[j], low}, {o[j], fascia}, {o[i], fascia});
    }
    addHip(into, o, fascia, ridge);
}

// One slope, high along [2][3].
void addShedRoofBuilding(Shape& into, const Building& b) {
    const Corners c = alongRidge(b, 0, 0);
    const double z0 = b.baseMetres, low = b.eavesMetres, high = b.topMetres();
    into.setColor(b.wallColor);
    into.quad({c[3], z0}, {c[2], z0}, {c[1], z0}, {c[0], z0});
    addWalls(into, b, c, z0, low);
    into.face(std::array{glm::dvec3(c[1], low), glm::dvec3(c[2], low), glm::dvec3(c[2], high)});
    into.face(std::array{glm::dvec3(c[3], low), glm::dvec3(c[0], low), glm::dvec3(c[3], high)});
    into.quad({c[2], low}, {c[3], low}, {c[3], high}, {c[2], high});
    into.setColor(b.roofColor);
    into.quad({c[0], low}, {c[1], low}, {c[2], high}, {c[3], high});
}

void addChimney(Shape& into, const Building& b) {
    const Corners c = alongRidge(b, 0, 0);
    const glm::dvec2 r0 = (c[0] + c[3]) / 2.0, r1 = (c[1] + c[2]) / 2.0;
    const glm::dvec2 ridge = glm::normalize(r1 - r0), across{-ridge.y, ridge.x};
    const glm::dvec2 at = glm::mix(r0, r1, 0.62) + across * 0.8;
    into.setColor({0.58f, 0.40f, 0.34f});
    addPrism(into,
             Corners{at - 0.35 * ridge - 0.35 * across, at + 0.35 * ridge - 0.35 * across,
                     at + 0.35 * ridge + 0.35 * across, at - 0.35 * ridge + 0.35 * across},
             b.eavesMetres - 0.5, b.topMetres() + 0.7);
}

} // namespace

void addBuilding(Shape& into, const Building& b, Detail detail) {
    const bool full = detail == Detail::Full;
    if (detail == Detail::Boxes)
        return addBox(into, b, b.eavesMetres + b.roofMetres / 2, false);
    switch (b.roof) {
    case Roof::Flat:
        if (full)
            addParapetBuilding(into, b);
        else
            addBox(into, b, b.eavesMetres + 0.4, true);
        break;
    case Roof::Gable:
        if (full && b.overhangMetres > 0) {
            // The body's roof lies in the middle of the slab's thickness.
            addGableBody(into, b, b.eavesMetres - 0.125, b.topMetres() - 0.125);
            addGableSlab(into, b);
        } else {
            addGableBody(into, b, b.eavesMetres, b.topMetres());
        }
        break;
    case Roof::Hip:
        addHipBuilding(into, b, full && b.overhangMetres > 0);
        break;
    case Roof::Shed:
        addShedRoofBuilding(into, b);
        break;
    }
    if (full && b.chimney)
        addChimney(into, b);
}

void addMasses(Shape& into, const Cell& cell, double lowestMetres) {
    for (const Block& block : cell.blocks) {
        Rect r{1e9, 1e9, -1e9, -1e9};
        double area = 0, volume = 0, base = 1e9;
        Building mass;
        for (const Building& b : cell.buildings) {
            if (!block.rect.contains(b.centre))
                continue;
            for (const glm::dvec2 p : b.footprint()) {
                r.west = std::min(r.west, p.x), r.east = std::max(r.east, p.x);
                r.south = std::min(r.south, p.y), r.north = std::max(r.north, p.y);
            }
            const double a = b.half.x * b.half.y;
            area += a;
            volume += a * (b.eavesMetres + b.roofMetres / 2);
            base = std::min(base, b.baseMetres);
            mass.wallColor = b.wallColor;
            mass.roofColor = b.roofColor;
            mass.facade = b.facade;
        }
        if (area == 0 || volume / area - base - 1.5 < lowestMetres)
            continue;
        mass.centre = r.centre();
        mass.half = {r.width() / 2, r.height() / 2};
        mass.baseMetres = base;
        addBox(into, mass, volume / area, false);
    }
}

} // namespace gnomon::builtin
