#include "bench/scene_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gnomon::bench {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// Two unit vectors that make a right-handed frame with `along`; the second is as far up as can be.
struct Across {
    glm::dvec3 side, up;
};
Across across(const glm::dvec3& along) {
    const glm::dvec3 side = std::abs(along.z) > 0.99
                                ? glm::dvec3(1, 0, 0)
                                : glm::normalize(glm::cross(along, glm::dvec3(0, 0, 1)));
    return {side, glm::cross(side, along)};
}

double onLattice(double metres, double lattice) {
    return std::round(metres / lattice) * lattice;
}

// Vertices with normals of their own, that several faces share.
class Smooth {
  public:
    explicit Smooth(Shape& into) : into_(into) {}
    std::uint32_t vertex(const glm::dvec3& p, const glm::dvec3& normal) {
        const double step = into_.latticeMetres;
        into_.positions.emplace_back(onLattice(p.x, step), onLattice(p.y, step),
                                     onLattice(p.z, step));
        into_.normals.emplace_back(glm::normalize(normal));
        into_.uvs.emplace_back(0.0f);
        into_.colors.push_back(into_.color);
        return std::uint32_t(into_.positions.size() - 1);
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        into_.indices.insert(into_.indices.end(), {a, b, c});
    }

  private:
    Shape& into_;
};

} // namespace

Shape sceneShape() {
    Shape shape;
    shape.latticeMetres = kSceneLatticeMetres;
    return shape;
}

void addBox(Shape& into, const glm::dvec3& low, const glm::dvec3& high) {
    const std::array footprint = {glm::dvec2(low.x, low.y), glm::dvec2(high.x, low.y),
                                  glm::dvec2(high.x, high.y), glm::dvec2(low.x, high.y)};
    builtin::addPrism(into, footprint, low.z, high.z);
}

void addSheet(Shape& into, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
              const glm::dvec3& d) {
    into.quad(a, b, c, d);
}

void addCorrugated(Shape& into, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c,
                   const glm::dvec3& d, int waves, double depthMetres) {
    const glm::dvec3 front = glm::normalize(glm::cross(b - a, d - a));
    const int folds = 2 * waves;
    const auto at = [&](const glm::dvec3& from, const glm::dvec3& to, int i) {
        return glm::mix(from, to, double(i) / folds) + (i % 2 ? -1.0 : 1.0) * depthMetres * front;
    };
    for (int i = 0; i < folds; ++i)
        into.quad(at(a, b, i), at(a, b, i + 1), at(d, c, i + 1), at(d, c, i));
}

void addPipe(Shape& into, const glm::dvec3& a, const glm::dvec3& b, double radius, int sides) {
    const auto [side, up] = across(glm::normalize(b - a));
    Smooth smooth(into);
    std::vector<glm::dvec3> ends[2];
    std::vector<std::uint32_t> ring[2];
    for (int i = 0; i < sides; ++i) {
        const double angle = kTurn * i / sides;
        const glm::dvec3 out = std::cos(angle) * side + std::sin(angle) * up;
        for (int end = 0; end < 2; ++end) {
            const glm::dvec3 p = (end ? b : a) + radius * out;
            ends[end].push_back(p);
            ring[end].push_back(smooth.vertex(p, out));
        }
    }
    // side × up points against the line, so a ring runs clockwise seen from b.
    for (int i = 0; i < sides; ++i) {
        const auto j = std::size_t((i + 1) % sides), k = std::size_t(i);
        smooth.triangle(ring[0][j], ring[0][k], ring[1][k]);
        smooth.triangle(ring[0][j], ring[1][k], ring[1][j]);
    }
    into.face(ends[0]);
    std::reverse(ends[1].begin(), ends[1].end());
    into.face(ends[1]);
}

namespace {

void addRound(Shape& into, const glm::dvec3& centre, const glm::dvec3& radii, int rings,
              const std::function<double(const glm::dvec3&)>& scale) {
    Smooth smooth(into);
    const int sectors = 2 * rings;
    const auto add = [&](const glm::dvec3& out) {
        return smooth.vertex(centre + scale(out) * out * radii, out / radii);
    };
    const std::uint32_t top = add({0, 0, 1}), bottom = add({0, 0, -1});
    std::vector<std::uint32_t> grid;
    for (int r = 1; r < rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const double polar = std::numbers::pi * r / rings, angle = kTurn * s / sectors;
            grid.push_back(add({std::sin(polar) * std::cos(angle),
                                std::sin(polar) * std::sin(angle), std::cos(polar)}));
        }
    const auto at = [&](int r, int s) {
        return grid[std::size_t((r - 1) * sectors + s % sectors)];
    };
    for (int s = 0; s < sectors; ++s) {
        smooth.triangle(top, at(1, s), at(1, s + 1));
        smooth.triangle(bottom, at(rings - 1, s + 1), at(rings - 1, s));
        for (int r = 1; r + 1 < rings; ++r) {
            smooth.triangle(at(r, s), at(r + 1, s), at(r + 1, s + 1));
            smooth.triangle(at(r, s), at(r + 1, s + 1), at(r, s + 1));
        }
    }
}

} // namespace

void addSphere(Shape& into, const glm::dvec3& centre, const glm::dvec3& radii, int rings) {
    addRound(into, centre, radii, rings, [](const glm::dvec3&) { return 1.0; });
}

void addCrown(Shape& into, const glm::dvec3& centre, const glm::dvec3& radii, double rough) {
    const double phase = centre.x + 1.7 * centre.y;
    addRound(into, centre, radii, 20, [&](const glm::dvec3& p) {
        return 1.0 + rough * (std::sin(7 * p.x + phase) * std::sin(6 * p.y - phase) +
                              0.6 * std::sin(11 * p.z + 5 * p.x + phase));
    });
}

void addBeam(Shape& into, const glm::dvec3& a, const glm::dvec3& b, double width, double height,
             double thickness) {
    const auto [side, up] = across(glm::normalize(b - a));
    const double w = width / 2, h = height / 2, t = thickness / 2, inner = h - thickness;
    // The I's outline, counter-clockwise seen from a (right is side, up is up).
    const std::array<glm::dvec2, 12> outline = {{{-w, -h},
                                                 {w, -h},
                                                 {w, -inner},
                                                 {t, -inner},
                                                 {t, inner},
                                                 {w, inner},
                                                 {w, h},
                                                 {-w, h},
                                                 {-w, inner},
                                                 {-t, inner},
                                                 {-t, -inner},
                                                 {-w, -inner}}};
    const auto at = [&](const glm::dvec3& end, std::size_t i) {
        const glm::dvec2 p = outline[i % outline.size()];
        return end + p.x * side + p.y * up;
    };
    for (std::size_t i = 0; i < outline.size(); ++i)
        into.quad(at(a, i + 1), at(a, i), at(b, i), at(b, i + 1));
    // Both ends in the same three convex pieces: flange, web, flange.
    const std::vector<std::vector<std::size_t>> pieces = {
        {0, 1, 2, 3, 10, 11}, {3, 4, 9, 10}, {6, 7, 8, 9, 4, 5}};
    for (const auto& piece : pieces) {
        std::vector<glm::dvec3> front, back;
        for (std::size_t i = 0; i < piece.size(); ++i) {
            front.push_back(at(a, piece[i]));
            back.push_back(at(b, piece[piece.size() - 1 - i]));
        }
        into.face(front);
        into.face(back);
    }
}

void addTruss(Shape& into, const glm::dvec3& a, const glm::dvec3& b, double height, int panels,
              double bar) {
    const auto at = [&](int i, double up) {
        return glm::mix(a, b, double(i) / panels) + glm::dvec3(0, 0, up);
    };
    builtin::addBar(into, at(0, 0), at(panels, 0), bar, bar);
    builtin::addBar(into, at(0, height), at(panels, height), bar, bar);
    const double thin = 0.7 * bar;
    for (int i = 0; i <= panels; ++i)
        builtin::addBar(into, at(i, 0), at(i, height), thin, thin);
    for (int i = 0; i < panels; ++i) {
        const bool rising = i < panels / 2;
        builtin::addBar(into, at(i, rising ? height : 0), at(i + 1, rising ? 0 : height), thin,
                        thin);
    }
}

void addLadder(Shape& into, const glm::dvec3& foot, const glm::dvec3& top, const glm::dvec3& side,
               int rungs) {
    addPipe(into, foot - side, top - side, 0.022, 8);
    addPipe(into, foot + side, top + side, 0.022, 8);
    for (int i = 1; i <= rungs; ++i) {
        const glm::dvec3 at = glm::mix(foot, top, i / (rungs + 1.0));
        addPipe(into, at - side, at + side, 0.014, 8);
    }
}

void addTable(Shape& into, const glm::dvec3& at, const glm::dvec3& size) {
    const glm::dvec3 half(size.x / 2, size.y / 2, 0);
    const double slab = 0.04, leg = 0.06, inset = 0.05;
    addBox(into, at - half + glm::dvec3(0, 0, size.z - slab), at + half + glm::dvec3(0, 0, size.z));
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0}) {
            const glm::dvec3 foot =
                at + glm::dvec3(x * (half.x - inset - leg / 2), y * (half.y - inset - leg / 2), 0);
            addBox(into, foot - glm::dvec3(leg / 2, leg / 2, 0),
                   foot + glm::dvec3(leg / 2, leg / 2, size.z - slab));
        }
}

void addChair(Shape& into, const glm::dvec3& at, double headingRadians) {
    const double c = std::cos(headingRadians), s = std::sin(headingRadians);
    const auto local = [&](double x, double y, double z) {
        return at + glm::dvec3(c * x - s * y, s * x + c * y, z);
    };
    const double half = 0.20;
    builtin::addBar(into, local(-half, 0, 0.44), local(half, 0, 0.44), 2 * half, 0.03);
    for (const double x : {-0.18, 0.18}) {
        addPipe(into, local(x, -0.18, 0), local(x, -0.18, 0.43), 0.015, 8);
        addPipe(into, local(x, 0.18, 0), local(x, 0.18, 0.92), 0.015, 8);
    }
    for (const double z : {0.62, 0.74, 0.86})
        builtin::addBar(into, local(-0.18, 0.18, z), local(0.18, 0.18, z), 0.015, 0.06);
}

void addCrossedQuads(Shape& into, const glm::dvec3& foot, double width, double height, int quads,
                     double turnRadians) {
    constexpr std::array kCorners = {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0),
                                     glm::vec2(0, 0)};
    for (int i = 0; i < quads; ++i) {
        const double angle = turnRadians + std::numbers::pi * i / quads;
        const glm::dvec3 half = 0.5 * width * glm::dvec3(std::cos(angle), std::sin(angle), 0);
        const glm::dvec3 up(0, 0, height);
        into.face(std::array{foot - half, foot + half, foot + half + up, foot - half + up},
                  kCorners);
    }
}

void addTerrain(Shape& into, std::span<const double> xs, std::span<const double> ys,
                const std::function<glm::dvec3(double x, double y)>& at,
                const std::function<glm::vec3(double x, double y)>& colorAt) {
    Smooth smooth(into);
    const auto columns = std::uint32_t(xs.size()), rows = std::uint32_t(ys.size());
    const auto first = std::uint32_t(into.positions.size());
    for (const double y : ys)
        for (const double x : xs) {
            into.setColor(colorAt(x, y));
            // The slope over a metre and a half either way, about as fine as any grid here.
            constexpr double kReach = 1.5;
            const glm::dvec3 east = at(x + kReach, y) - at(x - kReach, y);
            const glm::dvec3 north = at(x, y + kReach) - at(x, y - kReach);
            smooth.vertex(at(x, y), glm::cross(east, north));
        }
    for (std::uint32_t r = 0; r + 1 < rows; ++r)
        for (std::uint32_t c = 0; c + 1 < columns; ++c) {
            const std::uint32_t a = first + r * columns + c, d = a + columns;
            smooth.triangle(a, a + 1, d + 1);
            smooth.triangle(a, d + 1, d);
        }
}

} // namespace gnomon::bench
