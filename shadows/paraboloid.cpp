#include "shadows/paraboloid.h"

#include "shadows/light_basis.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

// Halving 180° so often leaves 0.04": less than a texel of any map.
constexpr int kMostHalvings = 24;
// Straight behind is infinitely far out; floats end earlier.
constexpr double kFarthestUnits = 1e6;

double squared(double x) {
    return x * x;
}

} // namespace

bool shinesAllRound(const Lamp& lamp) {
    return lamp.facing.xyz == glm::dvec3(0.0);
}

Transform<LampFrame, Ecef> lampFromEcef(const Transform<Ecef, Enu>& ecefFromAnchor,
                                        const Lamp& lamp) {
    const glm::dmat3 enuFromEcef = glm::transpose(ecefFromAnchor.axes());
    const glm::dvec3 facing =
        shinesAllRound(lamp) ? glm::dvec3(0, 0, -1) : glm::normalize(enuFromEcef * lamp.facing.xyz);
    // lightAxes has its one singular direction in the nadir, where most lamps face: so turned over.
    glm::dmat3 axes = lightAxes(-facing);
    axes[1] = -axes[1];
    axes[2] = -axes[2];
    const glm::dmat3 rotation = glm::transpose(axes) * enuFromEcef;
    glm::dmat4 m(rotation);
    m[3] = glm::dvec4(-(rotation * lamp.position.xyz), 1.0);
    return {m};
}

glm::dvec2 paraboloidPoint(const glm::dvec3& v) {
    // Behind, 1 + z loses its digits; x² + y² = (1 + z)(1 - z) has them.
    const double across2 = squared(v.x) + squared(v.y);
    const double onePlusZ = v.z > -0.5 ? 1.0 + v.z : across2 / (1.0 - v.z);
    const glm::dvec2 p = glm::dvec2(v.x, v.y) / onePlusZ;
    const double r = glm::length(p);
    if (r <= kFarthestUnits)
        return p;
    return std::isfinite(r) ? p * (kFarthestUnits / r) : glm::dvec2(kFarthestUnits, 0.0);
}

glm::dvec3 paraboloidDirection(const glm::dvec2& p) {
    const double r2 = squared(p.x) + squared(p.y);
    return glm::dvec3(2.0 * p.x, 2.0 * p.y, 1.0 - r2) / (1.0 + r2);
}

double paraboloidSolidAngle(const glm::dvec2& p) {
    return 4.0 / squared(1.0 + squared(p.x) + squared(p.y));
}

double LampMaps::unitsAcross() const {
    return 2.0 / (1.0 - 2.0 * kLampGuardTexels / texels);
}

LampMaps lampMaps(const ShadowSettings& settings, const Lamp& lamp) {
    // Half the sun's map across: what a lamp lights is smaller than a cascade.
    const int hemisphere = std::max(settings.mapSize / 2, 64);
    const bool round = shinesAllRound(lamp);
    if (settings.lamps == LampMethod::Cube)
        return {LampMethod::Cube, int(std::lround(hemisphere / std::sqrt(3.0))), round ? 6 : 5};
    return {settings.lamps, hemisphere, round ? 2 : 1};
}

namespace {

// The cube's faces: across, up and out of each, as axes 0…2 of the lamp's frame.
struct Face {
    int across, up, out;
    double sign;
};
constexpr Face kFaces[] = {{0, 1, 2, 1}, {1, 2, 0, 1},  {1, 2, 0, -1},
                           {2, 0, 1, 1}, {2, 0, 1, -1}, {0, 1, 2, -1}};

int faceOf(const glm::dvec3& v) {
    const glm::dvec3 a = glm::abs(v);
    if (a.z >= a.x && a.z >= a.y)
        return v.z >= 0.0 ? 0 : 5;
    if (a.x >= a.y)
        return v.x >= 0.0 ? 1 : 2;
    return v.y >= 0.0 ? 3 : 4;
}

} // namespace

LampTexel lampTexel(const LampMaps& maps, const glm::dvec3& direction) {
    LampTexel texel;
    glm::dvec2 units(0.0);
    if (maps.method == LampMethod::Cube) {
        texel.map = faceOf(direction);
        const Face& face = kFaces[texel.map];
        units =
            glm::dvec2(direction[face.across], direction[face.up]) / std::abs(direction[face.out]);
    } else {
        const glm::dvec3 v = glm::normalize(direction);
        texel.map = v.z >= 0.0 ? 0 : 1;
        units = paraboloidPoint({v.x, v.y, std::abs(v.z)});
    }
    texel.at = (units / maps.unitsAcross() + 0.5) * double(maps.texels);
    return texel;
}

glm::dvec3 lampDirection(const LampMaps& maps, const LampTexel& texel) {
    const glm::dvec2 units = (texel.at / double(maps.texels) - 0.5) * maps.unitsAcross();
    if (maps.method == LampMethod::Cube) {
        const Face& face = kFaces[texel.map];
        glm::dvec3 v(0.0);
        v[face.across] = units.x;
        v[face.up] = units.y;
        v[face.out] = face.sign;
        return glm::normalize(v);
    }
    glm::dvec3 v = paraboloidDirection(units);
    if (texel.map == 1)
        v.z = -v.z;
    return v;
}

glm::dvec3 faceClip(const LampMaps& maps, int face, const glm::dvec3& p) {
    const Face& f = kFaces[face];
    const double scale = 2.0 / maps.unitsAcross();
    return {p[f.across] * scale, p[f.up] * scale, p[f.out] * f.sign};
}

double texelRadians(const LampMaps& maps, const glm::dvec3& direction) {
    const double units = maps.unitsAcross() / maps.texels;
    const glm::dvec3 v = glm::normalize(direction);
    if (maps.method == LampMethod::Cube) // 1 / sqrt(1 + r²) around the face, less along r
        return units * std::abs(v[kFaces[faceOf(v)].out]);
    return units * (1.0 + std::abs(v.z)); // 2 / (1 + r²), all ways
}

double edgeBend(const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 va = glm::normalize(a), vb = glm::normalize(b), across = glm::cross(va, vb);
    const double sine = glm::length(across);
    if (sine < 1e-12)
        return 0.0; // seen end on, or through the lamp itself
    const glm::dvec2 pa = paraboloidPoint(va), pb = paraboloidPoint(vb);
    const glm::dvec2 middle = paraboloidPoint(glm::normalize(va + vb));
    // The great circle's image has the radius 1 / |z| of its plane's unit normal.
    const double z = std::abs(across.z) / sine, chord2 = glm::dot(pb - pa, pb - pa);
    const double root = std::sqrt(std::max(1.0 - squared(z) * chord2 / 4.0, 0.0));
    // On the smaller arc the chord's ends are seen at more than a right angle; NaN is behind too.
    if (glm::dot(pa - middle, pb - middle) <= 0.0)
        return chord2 / 4.0 * z / (1.0 + root);
    return z > 0.0 ? (1.0 + root) / z : std::numeric_limits<double>::infinity();
}

glm::dvec3 edgeMiddle(const glm::dvec3& a, const glm::dvec3& b) {
    // The bisector meets the far side in the ratio of the other two.
    const double la = glm::length(a), lb = glm::length(b);
    return (a * lb + b * la) / (la + lb);
}

namespace {

bool bends(const glm::dvec3& a, const glm::dvec3& b, double limit) {
    return !(edgeBend(a, b) <= limit);
}

int segments(const glm::dvec3& a, const glm::dvec3& b, double limit, int halvings) {
    if (halvings == 0 || !bends(a, b, limit))
        return 1;
    const glm::dvec3 m = edgeMiddle(a, b);
    return segments(a, m, limit, halvings - 1) + segments(m, b, limit, halvings - 1);
}

// Cuts one triangle; recursive, by its edges alone.
struct Cutter {
    double limit, lowest;
    std::size_t most;
    std::vector<LampTriangle>& out;

    void cut(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, int halvings) const {
        if (beyond(a) && beyond(b) && beyond(c))
            return;
        const bool may = limit > 0.0 && halvings > 0 && out.size() < most;
        const bool ab = may && bends(a, b, limit), bc = may && bends(b, c, limit),
                   ca = may && bends(c, a, limit);
        // Turned so that the last edge is not cut unless all are, and of two the first two.
        if (ca && !(ab && bc))
            return ab ? some(c, a, b, true, halvings)
                      : (bc ? some(b, c, a, true, halvings) : some(c, a, b, false, halvings));
        if (bc && !ab)
            return some(b, c, a, false, halvings);
        if (!ab)
            return out.push_back({a, b, c});
        if (!ca)
            return some(a, b, c, bc, halvings);
        const glm::dvec3 p = edgeMiddle(a, b), q = edgeMiddle(b, c), r = edgeMiddle(c, a);
        cut(a, p, r, halvings - 1);
        cut(p, b, q, halvings - 1);
        cut(r, q, c, halvings - 1);
        cut(p, q, r, halvings - 1);
    }

  private:
    // All corners lower than this: so is everything between them, since a great circle between two
    // points below the horizon runs no higher than they.
    bool beyond(const glm::dvec3& p) const { return p.z < lowest * glm::length(p); }

    // Cuts ab, and bc when `both`.
    void some(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, bool both,
              int halvings) const {
        const glm::dvec3 p = edgeMiddle(a, b);
        cut(a, p, c, halvings - 1);
        if (!both)
            return cut(p, b, c, halvings - 1);
        const glm::dvec3 q = edgeMiddle(b, c);
        cut(p, b, q, halvings - 1);
        cut(p, q, c, halvings - 1);
    }
};

} // namespace

int edgeSegments(const glm::dvec3& a, const glm::dvec3& b, double limit) {
    return segments(a, b, limit, kMostHalvings);
}

void cutTriangle(const LampTriangle& t, double limit, const LampMaps& maps, std::size_t most,
                 std::vector<LampTriangle>& out) {
    const double rim2 = squared(0.5 * maps.unitsAcross());
    const double lowest = (1.0 - rim2) / (1.0 + rim2);
    Cutter{limit, lowest, most, out}.cut(t[0], t[1], t[2], kMostHalvings);
}

} // namespace gnomon
