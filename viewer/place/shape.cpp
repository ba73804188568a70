#include "viewer/place/shape.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon::builtin {
namespace {

// glTF's vertex colours are linear.
std::uint32_t linear8(float srgb) {
    const double s = std::clamp(double(srgb), 0.0, 1.0);
    const double l = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    return std::uint32_t(l * 255.0 + 0.5);
}

} // namespace

void Shape::setColor(glm::vec3 c) {
    color = linear8(c.r) | linear8(c.g) << 8 | linear8(c.b) << 16 | 0xff000000u;
}

void Shape::face(std::span<const glm::dvec3> corners, std::span<const glm::vec2> uv) {
    const auto first = std::uint32_t(positions.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
        // Snapped in the place's frame, so that tiles agree.
        const glm::dvec3 p = glm::round(corners[i] / latticeMetres) * latticeMetres;
        positions.push_back(p - origin);
        uvs.push_back(uv.empty() ? glm::vec2(0.0f) : uv[i]);
        colors.push_back(color);
        if (withFeatures)
            features.push_back(feature);
    }
    // Newell's normal: also right where three corners are in line.
    glm::dvec3 n{0};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = positions[first + i];
        const glm::dvec3 b = positions[first + (i + 1) % corners.size()];
        n += glm::cross(a, b);
    }
    n = glm::normalize(n);
    normals.resize(positions.size(), glm::vec3(n));
    for (std::uint32_t i = 2; i < corners.size(); ++i)
        indices.insert(indices.end(), {first, first + i - 1, first + i});
}

void addPrism(Shape& into, std::span<const glm::dvec2> footprint, double z0, double z1) {
    std::vector<glm::dvec3> top, bottom;
    for (std::size_t i = 0; i < footprint.size(); ++i) {
        const glm::dvec2 a = footprint[i], b = footprint[(i + 1) % footprint.size()];
        top.emplace_back(a, z1);
        bottom.emplace_back(footprint[footprint.size() - 1 - i], z0);
        into.quad({a, z0}, {b, z0}, {b, z1}, {a, z1});
    }
    into.face(top);
    into.face(bottom);
}

void addBar(Shape& into, glm::dvec3 a, glm::dvec3 b, double width, double height) {
    const glm::dvec3 along = glm::normalize(b - a);
    const glm::dvec3 side = std::abs(along.z) > 0.99
                                ? glm::dvec3(1, 0, 0)
                                : glm::normalize(glm::cross(along, glm::dvec3(0, 0, 1)));
    const glm::dvec3 s = side * (width / 2), u = glm::cross(side, along) * (height / 2);
    // Seen along the bar: right is s, up is u.
    const glm::dvec3 p[4] = {a - s - u, a + s - u, a + s + u, a - s + u};
    const glm::dvec3 q[4] = {b - s - u, b + s - u, b + s + u, b - s + u};
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        into.quad(p[j], p[i], q[i], q[j]);
    }
    into.quad(p[0], p[1], p[2], p[3]);
    into.quad(q[3], q[2], q[1], q[0]);
}

void addShed(Shape& into, const Plan& plan, const Shed& shed) {
    const double c = std::cos(shed.headingRadians), s = std::sin(shed.headingRadians);
    const double x = shed.size.x / 2, y = shed.size.y / 2;
    double low = 1e9;
    for (const double sx : {-x, x})
        for (const double sy : {-y, y})
            low =
                std::min(low, plan.ground(shed.at + glm::dvec2(c * sx - s * sy, s * sx + c * sy)));
    const auto at = [&](double lx, double ly, double z) {
        return glm::dvec3(shed.at + glm::dvec2(c * lx - s * ly, s * lx + c * ly), z);
    };
    const double z0 = low - 0.2, z1 = low + shed.size.z, z2 = z1 + 0.25;
    into.setColor({0.72f, 0.75f, 0.74f});
    into.quad(at(x, y, z0), at(-x, y, z0), at(-x, y, z1), at(x, y, z1)); // back, seen from outside
    into.quad(at(-x, y, z0), at(-x, -y, z0), at(-x, -y, z2), at(-x, y, z1));
    into.quad(at(x, -y, z0), at(x, y, z0), at(x, y, z1), at(x, -y, z2));
    into.setColor({0.42f, 0.46f, 0.44f});
    into.quad(at(-x, -y - 0.3, z2 + 0.05), at(x, -y - 0.3, z2 + 0.05), at(x, y, z1), at(-x, y, z1));
}

namespace {

// Rings of `sides` corners about the z axis, closed below and above; radii may be 0 at the top.
struct Ring {
    double radius, z;
};

void addTurned(Shape& into, std::span<const Ring> rings, int sides, double wobble = 0) {
    const auto at = [&](const Ring& r, int i) {
        const double a = 2 * std::numbers::pi * (i % sides + 0.5) / sides;
        const double rough = 1 + wobble * std::sin(5.0 * (i % sides) + 9 * r.z);
        return glm::dvec3(r.radius * rough * std::cos(a), r.radius * rough * std::sin(a), r.z);
    };
    std::vector<glm::dvec3> bottom, top;
    for (int i = 0; i < sides; ++i) {
        bottom.push_back(at(rings.front(), sides - 1 - i));
        top.push_back(at(rings.back(), i));
    }
    if (rings.front().radius > 0)
        into.face(bottom);
    if (rings.back().radius > 0)
        into.face(top);
    for (std::size_t k = 0; k + 1 < rings.size(); ++k)
        for (int i = 0; i < sides; ++i) {
            const glm::dvec3 a = at(rings[k], i), b = at(rings[k], i + 1);
            const glm::dvec3 c = at(rings[k + 1], i + 1), d = at(rings[k + 1], i);
            if (rings[k].radius == 0)
                into.face(std::array{a, c, d});
            else if (rings[k + 1].radius == 0)
                into.face(std::array{a, b, c});
            else { // not flat when rough
                into.face(std::array{a, b, c});
                into.face(std::array{a, c, d});
            }
        }
}

// Softer light on crowns: as if they were round about `middle`.
void roundNormals(Shape& shape, std::size_t from, glm::dvec3 middle, double amount) {
    for (std::size_t i = from; i < shape.positions.size(); ++i) {
        const glm::dvec3 away = glm::normalize(shape.positions[i] - middle);
        shape.normals[i] =
            glm::normalize(glm::mix(shape.normals[i], glm::vec3(away), float(amount)));
    }
}

} // namespace

Shape treeShape(TreeKind kind, bool simple) {
    Shape shape;
    const auto crown = [&](std::initializer_list<Ring> rings, int sides, double wobble, double z) {
        const std::size_t from = shape.positions.size();
        addTurned(shape, std::vector<Ring>(rings), sides, wobble);
        roundNormals(shape, from, {0, 0, z}, 0.6);
    };
    if (!simple) {
        shape.setColor({0.40f, 0.31f, 0.24f});
        addTurned(shape, std::array{Ring{0.030, -0.06}, Ring{0.022, 0.4}}, 5);
    }
    switch (kind) {
    case TreeKind::Broad:
        shape.setColor({0.36f, 0.50f, 0.24f});
        if (simple)
            crown({{0, 0.2}, {0.33, 0.55}, {0, 1.0}}, 5, 0, 0.6);
        else
            crown({{0.10, 0.24}, {0.29, 0.36}, {0.34, 0.60}, {0.24, 0.86}, {0, 1.0}}, 7, 0.10,
                  0.55);
        break;
    case TreeKind::Poplar:
        shape.setColor({0.40f, 0.53f, 0.26f});
        if (simple)
            crown({{0, 0.08}, {0.14, 0.4}, {0, 1.0}}, 5, 0, 0.5);
        else
            crown({{0.05, 0.12}, {0.14, 0.3}, {0.13, 0.65}, {0, 1.0}}, 7, 0.10, 0.5);
        break;
    case TreeKind::Conifer:
        shape.setColor({0.22f, 0.38f, 0.25f});
        if (simple) {
            crown({{0.20, 0.14}, {0, 1.0}}, 5, 0, 0.3);
        } else {
            crown({{0.22, 0.14}, {0, 0.62}}, 7, 0.08, 0.2);
            crown({{0.16, 0.44}, {0, 1.0}}, 7, 0.08, 0.5);
        }
        break;
    }
    return shape;
}

void addTower(Shape& into, const Plan& plan, Detail detail) {
    Shape tower;
    const double g = plan.ground(Plan::centre());
    const glm::vec3 stone{0.86f, 0.80f, 0.70f}, copper{0.45f, 0.62f, 0.55f};
    const auto turned = [&](glm::vec3 color, std::initializer_list<Ring> rings, int sides = 8) {
        tower.setColor(color);
        addTurned(tower, std::vector<Ring>(rings), sides);
    };
    turned(stone, {{10.5, -3}, {10.5, 6}, {9.0, 7}, {7.2, 74}, {9.6, 78}, {9.6, 79.5}, {0, 79.5}});
    turned(stone * 0.97f, {{5.6, 79}, {5.4, 94}, {6.4, 95}, {6.4, 96}, {0, 96}});
    turned(copper, {{6.0, 95.8}, {4.4, 101}, {1.6, 108}, {0.5, 113}, {0, 120}});
    if (detail == Detail::Full) {
        // The gallery's railing: bars of 6 cm, an octagon 80 m up.
        tower.setColor({0.30f, 0.31f, 0.33f});
        const auto at = [](double i, double z) {
            const double a = 2 * std::numbers::pi * (i + 0.5) / 8;
            return glm::dvec3(9.4 * std::cos(a), 9.4 * std::sin(a), z);
        };
        for (int i = 0; i < 8; ++i) {
            addBar(tower, at(i, 80.7), at(i + 1, 80.7), 0.06, 0.06);
            for (int k = 0; k < 6; ++k)
                addBar(tower, glm::mix(at(i, 79.4), at(i + 1, 79.4), k / 6.0),
                       glm::mix(at(i, 80.72), at(i + 1, 80.72), k / 6.0), 0.06, 0.06);
        }
    }
    // Copied over to its place: the lattice is kept, for `g` is put on it first.
    const glm::dvec3 shift = glm::dvec3(Plan::centre(), onLattice(g)) - into.origin;
    const auto first = std::uint32_t(into.positions.size());
    for (std::size_t i = 0; i < tower.positions.size(); ++i) {
        into.positions.push_back(tower.positions[i] + shift);
        into.normals.push_back(tower.normals[i]);
        into.uvs.push_back({0, 0});
        into.colors.push_back(tower.colors[i]);
        if (into.withFeatures)
            into.features.push_back(into.feature);
    }
    for (const std::uint32_t i : tower.indices)
        into.indices.push_back(first + i);
}

void addBridge(Shape& into, const Plan& plan, Detail detail) {
    const double x = Plan::axisX(), y = plan.bridgeY(), half = plan.deckHalfLength();
    const double z = plan.deckMetres() + 0.06, width = 5.2, high = 5.6;
    const auto rect = [](double w, double s, double e, double n) {
        return std::array{glm::dvec2(w, s), glm::dvec2(e, s), glm::dvec2(e, n), glm::dvec2(w, n)};
    };
    into.setColor({0.52f, 0.52f, 0.53f});
    addPrism(into, rect(x - width, y - half, x + width, y + half), z - 0.8, z);
    into.setColor({0.70f, 0.68f, 0.64f});
    for (const double side : {-0.6, 0.6}) {
        const double py = y + side * plan.riverHalfWidth();
        addPrism(into, rect(x - 4, py - 1.2, x + 4, py + 1.2), -3, z - 0.7);
    }
    into.setColor({0.38f, 0.50f, 0.48f});
    const int panels = 2 * int(half / 4.4);
    const double step = 2 * half / panels;
    const bool full = detail == Detail::Full;
    for (const double sx : {x - width + 0.25, x + width - 0.25}) {
        const auto at = [&](int i, double up) {
            return glm::dvec3(sx, y - half + i * step, z + up);
        };
        addBar(into, at(0, 0.15), at(panels, 0.15), 0.15, 0.3);
        addBar(into, at(1, high), at(panels - 1, high), 0.15, 0.25);
        for (int i = 1; i < panels; ++i)
            addBar(into, at(i, 0), at(i, high), 0.12, 0.12);
        for (int i = 0; i < panels; ++i) { // diagonals rise towards the middle
            const bool rising = i < panels / 2;
            addBar(into, at(i, rising ? 0.1 : high), at(i + 1, rising ? high : 0.1), 0.10, 0.10);
        }
        if (!full)
            continue;
        addBar(into, at(0, 1.1), at(panels, 1.1), 0.05, 0.05);
        for (int i = 0; i < 4 * panels; ++i)
            if (i % 4) {
                const glm::dvec3 foot = glm::mix(at(0, 0), at(panels, 0), i / (4.0 * panels));
                addBar(into, foot, foot + glm::dvec3(0, 0, 1.1), 0.05, 0.05);
            }
    }
    for (int i = 1; i < panels && full; ++i) {
        const double by = y - half + i * step;
        addBar(into, {x - width + 0.2, by, z + high}, {x + width - 0.2, by, z + high}, 0.08, 0.12);
    }
}

} // namespace gnomon::builtin
