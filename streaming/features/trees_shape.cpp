#include "streaming/features/trees_shape.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <utility>

namespace gnomon {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr unsigned kBroadVariants = 6, kNeedleVariants = 4;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

// In [0, 1), the same everywhere (SplitMix64's finaliser).
double noise(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    std::uint64_t z = a * 0x9e3779b97f4a7c15ull + b * 0xc2b2ae3d27d4eb4full + c + 1;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// A closed solid as its corners, which its faces share.
struct Solid {
    std::vector<glm::dvec3> positions;
    std::vector<Triangle> triangles;
};

glm::dvec3 faceNormal(const Solid& solid, const Triangle& t) {
    const glm::dvec3& a = solid.positions[t[0]];
    return glm::normalize(glm::cross(solid.positions[t[1]] - a, solid.positions[t[2]] - a));
}

// One vertex for all corners at the same place with the same normal.
std::uint32_t vertexOf(TreeShape& shape, std::size_t from, const glm::dvec3& position,
                       const glm::dvec3& normal) {
    for (std::size_t i = from; i < shape.positions.size(); ++i)
        if (shape.positions[i] == position && shape.normals[i] == normal)
            return std::uint32_t(i);
    shape.positions.push_back(position);
    shape.normals.push_back(normal);
    return std::uint32_t(shape.positions.size() - 1);
}

// `round`: how much the light falls as on a ball about `middle`, 0 facets to 1.
void addSolid(TreeShape& shape, const Solid& solid, bool trunk, double round, double middle) {
    const std::size_t from = shape.positions.size();
    for (const Triangle& t : solid.triangles) {
        const glm::dvec3 face = faceNormal(solid, t);
        Triangle out;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3& p = solid.positions[t[i]];
            const glm::dvec3 away = glm::normalize(p - glm::dvec3(0, 0, middle));
            const glm::dvec3 normal =
                round < 1.0 ? glm::normalize(glm::mix(face, away, round)) : away;
            out[i] = vertexOf(shape, from, p, normal);
        }
        shape.triangles.push_back(out);
    }
    const double low =
        std::ranges::min(solid.positions, {}, [](const glm::dvec3& p) { return p.z; }).z;
    for (std::size_t i = from; i < shape.positions.size(); ++i) {
        shape.isTrunk.push_back(trunk);
        shape.shade.push_back(trunk ? 1.0
                                    : 0.82 + 0.24 * (shape.positions[i].z - low) / (1.0 - low));
    }
    shape.solidEnds.push_back(std::uint32_t(shape.triangles.size()));
}

struct Ring {
    double radius, z;
};

// Rings of `sides` corners about the z axis, flat below and above, pointed where a radius is 0.
// `ragged`: every second corner lies this much further in.
Solid turned(std::span<const Ring> rings, unsigned sides, double ragged, double turn) {
    Solid solid;
    std::vector<std::uint32_t> start;
    for (const Ring& ring : rings) {
        start.push_back(std::uint32_t(solid.positions.size()));
        for (unsigned i = 0; i < (ring.radius > 0.0 ? sides : 1); ++i) {
            const double angle = kTwoPi * (i + turn) / sides;
            const double r = ring.radius * (i % 2 ? 1.0 - ragged : 1.0);
            solid.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), ring.z);
        }
    }
    const auto at = [&](std::size_t ring, unsigned i) {
        return start[ring] + (rings[ring].radius > 0.0 ? i % sides : 0);
    };
    const std::size_t top = rings.size() - 1;
    for (unsigned i = 1; i + 1 < sides; ++i) {
        if (rings[0].radius > 0.0)
            solid.triangles.push_back({at(0, 0), at(0, i + 1), at(0, i)});
        if (rings[top].radius > 0.0)
            solid.triangles.push_back({at(top, 0), at(top, i), at(top, i + 1)});
    }
    for (std::size_t k = 0; k < top; ++k)
        for (unsigned i = 0; i < sides; ++i) {
            if (rings[k].radius > 0.0)
                solid.triangles.push_back({at(k, i), at(k, i + 1), at(k + 1, i + 1)});
            if (rings[k + 1].radius > 0.0)
                solid.triangles.push_back({at(k, i), at(k + 1, i + 1), at(k + 1, i)});
        }
    return solid;
}

Solid icosahedron() {
    const double g = std::numbers::phi;
    Solid solid;
    solid.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                       {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (glm::dvec3& p : solid.positions)
        p = glm::normalize(p);
    solid.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                       {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                       {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                       {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    return solid;
}

// Each triangle in four; the new corners lie between their neighbours' distances from the middle,
// a little rough. The old corners stay the first.
Solid refined(const Solid& coarse, unsigned variant) {
    Solid fine{coarse.positions, {}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, fresh] =
            middles.emplace(std::minmax(a, b), std::uint32_t(fine.positions.size()));
        if (fresh) {
            const glm::dvec3 &p = fine.positions[a], &q = fine.positions[b];
            const double out = (glm::length(p) + glm::length(q)) / 2.0;
            const double rough = 0.92 + 0.22 * noise(variant, 3, at->second);
            fine.positions.push_back(out * rough * glm::normalize(p + q));
        }
        return at->second;
    };
    for (const Triangle& t : coarse.triangles) {
        const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]),
                            ca = middle(t[2], t[0]);
        fine.triangles.insert(fine.triangles.end(),
                              {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    return fine;
}

// An icosahedron turned and lumpy by `variant`.
Solid lumpyBall(unsigned variant) {
    Solid ball = icosahedron();
    const double turn = kTwoPi * noise(variant, 0, 1), tilt = 0.5 + noise(variant, 0, 2);
    for (std::size_t i = 0; i < ball.positions.size(); ++i) {
        glm::dvec3& p = ball.positions[i];
        p = {p.x, p.y * std::cos(tilt) - p.z * std::sin(tilt),
             p.y * std::sin(tilt) + p.z * std::cos(tilt)};
        p = {p.x * std::cos(turn) - p.y * std::sin(turn),
             p.x * std::sin(turn) + p.y * std::cos(turn), p.z};
        p *= 0.80 + 0.40 * noise(variant, 1, i);
    }
    return ball;
}

constexpr double kBroadFoot = 0.20;   // the lowest point of a broad-leaved crown
constexpr double kBroadMiddle = 0.55; // where it is widest

// The lumpy ball as high and as wide as a crown is. The coarse one has the fine one's first
// corners, moved outward by `swell` to hold as much.
Solid broadCrown(unsigned variant, bool fine, double swell) {
    const Solid ball = lumpyBall(variant);
    const Solid detailed = refined(ball, variant);
    double low = 0.0, high = 0.0, wide = 0.0;
    for (const glm::dvec3& p : detailed.positions) {
        low = std::min(low, p.z);
        high = std::max(high, p.z);
        wide = std::max(wide, std::hypot(p.x, p.y));
    }
    Solid out = fine ? detailed : ball;
    for (glm::dvec3& p : out.positions) {
        p *= swell;
        // Fuller above than a ball: shoulders, not an egg.
        const double z = p.z > 0.0 ? kBroadMiddle + std::pow(p.z / high, 0.8) * (1.0 - kBroadMiddle)
                                   : kBroadMiddle + p.z / low * (kBroadFoot - kBroadMiddle);
        p = {p.x / wide, p.y / wide, z};
    }
    return out;
}

// Of the crown's radius; a young tree's and an old one's trunk are both near it.
constexpr double kTrunkRadius = 0.07;

Solid trunk(double topZ) {
    return turned(std::array{Ring{kTrunkRadius, -kTreeRootDepth}, Ring{0.75 * kTrunkRadius, topZ}},
                  5, 0.0, 0.0);
}
Solid spike(double topZ) {
    return turned(std::array{Ring{1.2 * kTrunkRadius, -kTreeRootDepth}, Ring{0.0, topZ}}, 3, 0.0,
                  0.0);
}
// Pointed above and below, where it reaches the ground: no trunk is seen at that distance.
Solid spindle(double radius, double z) {
    return turned(std::array{Ring{0.0, -kTreeRootDepth}, Ring{radius, z}, Ring{0.0, 1.0}}, 4, 0.0,
                  0.5);
}

// Makes up for what chords cut off a ball.
constexpr double kSwell = 1.1;

TreeShape broadShape(unsigned variant, TreeDetail detail) {
    TreeShape shape;
    switch (detail) {
    case TreeDetail::Near:
        addSolid(shape, broadCrown(variant, true, 1.0), false, 0.45, kBroadMiddle);
        addSolid(shape, trunk(kBroadMiddle), true, 0.0, 0.0);
        break;
    case TreeDetail::Far:
        addSolid(shape, broadCrown(variant, false, kSwell), false, 1.0, kBroadMiddle);
        addSolid(shape, spike(kBroadMiddle), true, 0.0, 0.0);
        break;
    case TreeDetail::Farthest:
        addSolid(shape, spindle(1.1, kBroadMiddle), false, 1.0, kBroadMiddle);
        break;
    }
    return shape;
}

struct Tier {
    double radius, low, high;
};

TreeShape needleShape(unsigned variant, TreeDetail detail) {
    TreeShape shape;
    const auto tiers = [&](std::span<const Tier> all, unsigned sides, double ragged, double round) {
        for (std::size_t i = 0; i < all.size(); ++i) {
            const double wide = i == 0 ? 1.0 : 0.92 + 0.16 * noise(variant, 2, i);
            const std::array rings{Ring{all[i].radius * wide, all[i].low}, Ring{0.0, all[i].high}};
            addSolid(shape, turned(rings, sides, ragged, 0.37 * double(i + variant)), false, round,
                     all[i].low);
        }
    };
    switch (detail) {
    case TreeDetail::Near:
        tiers(std::array{Tier{1.0, 0.12, 0.56}, Tier{0.80, 0.32, 0.74}, Tier{0.58, 0.53, 0.88},
                         Tier{0.36, 0.72, 1.0}},
              9, 0.12, 0.4);
        addSolid(shape, trunk(0.2), true, 0.0, 0.0);
        break;
    case TreeDetail::Far:
        tiers(std::array{Tier{1.0, 0.12, 0.72}, Tier{0.68, 0.46, 1.0}}, 5, 0.0, 1.0);
        addSolid(shape, spike(0.3), true, 0.0, 0.0);
        break;
    case TreeDetail::Farthest:
        addSolid(shape, spindle(1.05, 0.16), false, 1.0, 0.16);
        break;
    }
    return shape;
}

glm::dvec3 nearestOn(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                     const glm::dvec3& c) {
    // Ericson, "Real-Time Collision Detection", 2005, 5.1.5.
    const glm::dvec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp),
                 d4 = glm::dot(ac, bp), d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d1 <= 0.0 && d2 <= 0.0)
        return a;
    if (d3 >= 0.0 && d4 <= d3)
        return b;
    if (d6 >= 0.0 && d5 <= d6)
        return c;
    const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
        return a + d1 / (d1 - d3) * ab;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
        return a + d2 / (d2 - d6) * ac;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
        return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    return a + vb / (va + vb + vc) * ab + vc / (va + vb + vc) * ac;
}

// Does the solid of these triangles wind around `p`? (van Oosterom & Strackee, "The solid angle of
// a plane triangle", 1983.)
bool isInside(const TreeShape& shape, std::span<const Triangle> solid, const glm::dvec3& p) {
    double angle = 0.0;
    for (const Triangle& t : solid) {
        const glm::dvec3 a = shape.positions[t[0]] - p, b = shape.positions[t[1]] - p,
                         c = shape.positions[t[2]] - p;
        const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
        angle += 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                                  la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la +
                                      glm::dot(c, a) * lb);
    }
    return angle > kTwoPi; // half of all directions
}

// The triangles of each of its solids; those of one share no vertices with those of another.
std::vector<std::span<const Triangle>> solidsOf(const TreeShape& shape) {
    std::vector<std::span<const Triangle>> solids;
    std::size_t first = 0;
    for (const std::uint32_t end : shape.solidEnds) {
        solids.push_back(std::span(shape.triangles).subspan(first, end - first));
        first = end;
    }
    return solids;
}

// A point is hidden in a solid only where it lies in the box around it.
struct Box {
    glm::dvec3 low{std::numeric_limits<double>::infinity()}, high{-low};

    Box(const TreeShape& shape, std::span<const Triangle> solid) {
        for (const Triangle& t : solid)
            for (const std::uint32_t v : t) {
                low = glm::min(low, shape.positions[v]);
                high = glm::max(high, shape.positions[v]);
            }
    }
    bool holds(const glm::dvec3& p) const {
        return glm::all(glm::greaterThan(p, low)) && glm::all(glm::lessThan(p, high));
    }
};

constexpr double kSampleSpacing = 0.07; // of the height, of the crown's radius
// What may be missed between samples: on random points 1 % at this spacing.
constexpr double kBetweenSamples = 1.02;

// Evenly over the triangle, corners and edges too.
template <class Visit>
void eachSample(const TreeShape& shape, const Triangle& t, const Visit& visit) {
    const glm::dvec3 &a = shape.positions[t[0]], &b = shape.positions[t[1]],
                     &c = shape.positions[t[2]];
    const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    const int steps = std::max(2, int(std::ceil(longest / kSampleSpacing)));
    for (int i = 0; i <= steps; ++i)
        for (int k = 0; k + i <= steps; ++k)
            visit(a + (b - a) * (double(i) / steps) + (c - a) * (double(k) / steps));
}

// Points of the surface that lie inside no other of its solids.
std::vector<glm::dvec3> seenPoints(const TreeShape& shape) {
    const std::vector<std::span<const Triangle>> solids = solidsOf(shape);
    std::vector<Box> boxes;
    for (const auto& solid : solids)
        boxes.emplace_back(shape, solid);
    std::vector<glm::dvec3> points;
    for (std::size_t own = 0; own < solids.size(); ++own)
        for (const Triangle& t : solids[own])
            eachSample(shape, t, [&](const glm::dvec3& p) {
                for (std::size_t other = 0; other < solids.size(); ++other)
                    if (other != own && boxes[other].holds(p) && isInside(shape, solids[other], p))
                        return;
                points.push_back(p);
            });
    return points;
}

// Squared distance across and in height; what makes a distance at any size of tree.
using Parts = std::pair<double, double>;

// From each point to the surface's nearest, where a crown's radius is `aspect` of the height.
void addDistances(const std::vector<glm::dvec3>& points, const TreeShape& to, double aspect,
                  std::vector<Parts>& out) {
    const glm::dvec3 scale(aspect, aspect, 1.0);
    for (const glm::dvec3& point : points) {
        glm::dvec3 best(std::numeric_limits<double>::infinity());
        double squared = best.x;
        for (const Triangle& t : to.triangles) {
            const glm::dvec3 off =
                nearestOn(scale * point, scale * to.positions[t[0]], scale * to.positions[t[1]],
                          scale * to.positions[t[2]]) -
                scale * point;
            if (glm::dot(off, off) < squared) {
                squared = glm::dot(off, off);
                best = off / scale;
            }
        }
        out.emplace_back(best.x * best.x + best.y * best.y, best.z * best.z);
    }
}

// Only those that are largest for some size of tree.
std::vector<Parts> largest(std::vector<Parts> all) {
    std::sort(all.rbegin(), all.rend());
    std::vector<Parts> front;
    for (const Parts& parts : all)
        if (front.empty() || parts.second > front.back().second)
            front.push_back(parts);
    return front;
}

// Points that are nearest on a tree of one aspect are near on one of another: each of these gives a
// bound for every tree, the truest where the aspect fits.
constexpr std::array kAspects{0.12, 0.22, 0.4};
using Deviation = std::array<std::vector<Parts>, kAspects.size()>;

Deviation deviationOf(const TreeShape& fine, const std::vector<glm::dvec3>& finePoints,
                      const TreeShape& coarse) {
    Deviation deviation;
    const std::vector<glm::dvec3> coarsePoints = seenPoints(coarse);
    for (std::size_t i = 0; i < kAspects.size(); ++i) {
        std::vector<Parts> parts;
        addDistances(finePoints, coarse, kAspects[i], parts);
        addDistances(coarsePoints, fine, kAspects[i], parts);
        deviation[i] = largest(std::move(parts));
    }
    return deviation;
}

struct Variant {
    std::array<TreeShape, 3> shapes; // by detail
    Deviation far, farthest;
};

std::vector<Variant> variantsOf(TreeForm form) {
    std::vector<Variant> variants(treeVariants(form));
    for (unsigned v = 0; v < variants.size(); ++v) {
        std::array<TreeShape, 3>& shapes = variants[v].shapes;
        for (std::size_t d = 0; d < shapes.size(); ++d)
            shapes[d] = form == TreeForm::Broad ? broadShape(v, TreeDetail(d))
                                                : needleShape(v, TreeDetail(d));
        const std::vector<glm::dvec3> points = seenPoints(shapes[0]);
        variants[v].far = deviationOf(shapes[0], points, shapes[1]);
        variants[v].farthest = deviationOf(shapes[0], points, shapes[2]);
    }
    return variants;
}

const Variant& variantOf(TreeForm form, unsigned variant) {
    static const std::vector<Variant> broad = variantsOf(TreeForm::Broad),
                                      needle = variantsOf(TreeForm::Needle);
    return (form == TreeForm::Broad ? broad : needle)[variant];
}

} // namespace

unsigned treeVariants(TreeForm form) {
    return form == TreeForm::Broad ? kBroadVariants : kNeedleVariants;
}

const TreeShape& treeShape(TreeForm form, unsigned variant, TreeDetail detail) {
    return variantOf(form, variant).shapes[std::size_t(detail)];
}

double treeDeviationMetres(TreeForm form, unsigned variant, TreeDetail detail, double heightMetres,
                           double crownRadiusMetres) {
    if (detail == TreeDetail::Near)
        return 0.0;
    const Variant& shapes = variantOf(form, variant);
    double least = std::numeric_limits<double>::infinity();
    for (const auto& bound : detail == TreeDetail::Far ? shapes.far : shapes.farthest) {
        double squared = 0.0;
        for (const auto& [across, up] : bound)
            squared = std::max(squared, crownRadiusMetres * crownRadiusMetres * across +
                                            heightMetres * heightMetres * up);
        least = std::min(least, squared);
    }
    return kBetweenSamples * std::sqrt(least);
}

double usualCrownRadius(TreeForm form) {
    return form == TreeForm::Broad ? 0.34 : 0.22;
}

} // namespace gnomon
