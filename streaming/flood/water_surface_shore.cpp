#include "streaming/flood/water_surface_shore.h"

#include <cmath>

namespace gnomon {

namespace {

// Of the water's depth: a dry bed that is farther below the level is kept dry by something else
// than itself.
constexpr double kFlat = 0.2;

// Of the way to a dry node: so near water comes to it.
constexpr double kMostShare = 0.95;

// Shown and counted differ by no more.
constexpr double kSlack = 0.005;

WaterCorner nodeCorner(const NodeTriangle& t, int i, double depth) {
    WaterCorner corner;
    corner.wet = corner.dry = t[std::size_t(i)];
    corner.depth = depth;
    corner.weights[i] = 1.0;
    return corner;
}

struct EdgeCorners {
    WaterCorner foot, shore;
};

EdgeCorners edgeCorners(const NodeTriangle& t, int wet, int dry, double depth,
                        const PlacedShore& at) {
    EdgeCorners out;
    out.shore.wet = t[std::size_t(wet)];
    out.shore.dry = t[std::size_t(dry)];
    out.shore.share = at.share;
    out.shore.weights[wet] = 1.0 - at.share;
    out.shore.weights[dry] = at.share;
    out.foot = out.shore;
    out.foot.isFoot = true;
    out.foot.share = ShoreRule::kFoot * at.share;
    out.foot.depth = depth * (1.0 - (1.0 - at.bank) * ShoreRule::kFoot);
    out.foot.weights[wet] = 1.0 - out.foot.share;
    out.foot.weights[dry] = out.foot.share;
    return out;
}

// How far the shore is along the two ways of a triangle that has them, before any limits.
struct ShoreShares {
    double first = 0.5, second = 0.5, area = 0.0;
    bool oneIsWet = true;

    double shown(double nearest, double farthest) const {
        const double a = std::clamp(first, nearest, farthest);
        const double b = std::clamp(second, nearest, farthest);
        return area * (oneIsWet ? a * b : 1.0 - (1.0 - a) * (1.0 - b));
    }
};

// The corner that is alone in being wet, or dry.
int loneCorner(const WetTriangles& wet, const NodeTriangle& t, bool isWet) {
    for (int i = 0; i < 3; ++i)
        if (wet.isWet(t[std::size_t(i)]) == isWet)
            return i;
    return 0;
}

// Where `shown` is `wanted` between the two, by halving; it rises or falls all the way.
template <class Shown>
double solve(double low, double high, double wanted, const Shown& shown) {
    const bool rises = shown(high) > shown(low);
    for (int i = 0; i < 24; ++i) {
        const double middle = 0.5 * (low + high);
        ((shown(middle) < wanted) == rises ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

void fitArea(const WetTriangles& wet, const std::vector<ShoreTriangle>& shore, double wanted,
             double slack, ShoreRule& rule) {
    std::vector<ShoreShares> shares;
    shares.reserve(shore.size());
    for (const ShoreTriangle& s : shore) {
        const bool oneIsWet = wet.wetCorners(s.nodes) == 1;
        const int lone = loneCorner(wet, s.nodes, oneIsWet);
        const std::uint32_t at = s.nodes[std::size_t(lone)];
        const std::uint32_t next = s.nodes[std::size_t((lone + 1) % 3)];
        const std::uint32_t last = s.nodes[std::size_t((lone + 2) % 3)];
        const auto share = [&](std::uint32_t other) {
            return (oneIsWet ? wet.edge(at, other) : wet.edge(other, at)).share;
        };
        shares.push_back({share(next), share(last), s.area, oneIsWet});
    }
    const auto shown = [&](double nearest, double farthest) {
        double sum = 0.0;
        for (const ShoreShares& s : shares)
            sum += s.shown(nearest, farthest);
        return sum;
    };
    const double natural = shown(rule.nearest, rule.farthest);
    constexpr double kLimit = 0.9; // the other end of the way stays free
    if (natural < wanted - slack)
        rule.nearest = solve(rule.nearest, kLimit, wanted - slack,
                             [&](double x) { return shown(x, rule.farthest); });
    else if (natural > wanted + slack)
        rule.farthest = solve(1.0 - kLimit, rule.farthest, wanted + slack,
                              [&](double x) { return shown(rule.nearest, x); });
}

void fitVolume(const WetTriangles& wet, const std::vector<ShoreTriangle>& shore, double wanted,
               ShoreRule& rule) {
    // It grows evenly with either share.
    double shown = shownOf(wet, shore, rule).volume;
    for (double ShoreRule::*bank : {&ShoreRule::bankElsewhere, &ShoreRule::bankOnSlopes}) {
        if (!(wanted > shown))
            return;
        rule.*bank = 1.0;
        const double full = shownOf(wet, shore, rule).volume;
        if (full > wanted) {
            rule.*bank = (wanted - shown) / (full - shown);
            return;
        }
        shown = full;
    }
}

} // namespace

ShoreEdge shoreEdge(double depth, double bedAbove) {
    const double rise = bedAbove / depth;
    if (!(rise > -kFlat)) // NaN too
        return {0.5, false};
    if (rise >= 0.0)
        return {std::min(1.0 / (1.0 + rise), kMostShare), true};
    const double passage = 1.0 + rise / kFlat;
    return {0.5 + passage * (kMostShare - 0.5), passage > 0.5};
}

PlacedShore placed(const ShoreEdge& edge, const ShoreRule& rule) {
    const double share = std::clamp(edge.share, rule.nearest, rule.farthest);
    const bool slope = edge.isSlope && (share == edge.share || share <= ShoreRule::kNearest);
    return {share, slope ? rule.bankOnSlopes : rule.bankElsewhere};
}

double areaShare(const WaterPiece& piece) {
    return std::abs(
        glm::determinant(glm::dmat3(piece[0].weights, piece[1].weights, piece[2].weights)));
}

WaterPieces WetTriangles::piecesOf(const NodeTriangle& t, const ShoreRule& rule) const {
    WaterPieces out;
    const auto add = [&](const WaterCorner& a, const WaterCorner& b, const WaterCorner& c) {
        out.pieces[std::size_t(out.count++)] = {a, b, c};
    };
    const int wetCount = wetCorners(t);
    const auto node = [&](int i) { return nodeCorner(t, i, depths_[t[std::size_t(i)]]); };
    if (wetCount == 3)
        add(node(0), node(1), node(2));
    if (wetCount != 1 && wetCount != 2)
        return out;
    const int lone = loneCorner(*this, t, wetCount == 1);
    const int next = (lone + 1) % 3, last = (lone + 2) % 3;
    const auto towards = [&](int from, int to) {
        const std::uint32_t a = t[std::size_t(from)], b = t[std::size_t(to)];
        return edgeCorners(t, from, to, depths_[a], placed(edge(a, b), rule));
    };
    const bool banks = rule.hasBanks();
    if (wetCount == 1) {
        const EdgeCorners p = towards(lone, next), q = towards(lone, last);
        if (!banks) {
            add(node(lone), p.shore, q.shore);
            return out;
        }
        add(node(lone), p.foot, q.foot);
        add(p.foot, p.shore, q.shore);
        add(p.foot, q.shore, q.foot);
        return out;
    }
    // next, last are wet, in this order about the triangle.
    const EdgeCorners p = towards(next, lone), q = towards(last, lone);
    const WaterCorner& pIn = banks ? p.foot : p.shore;
    const WaterCorner& qIn = banks ? q.foot : q.shore;
    add(node(next), node(last), qIn);
    add(node(next), qIn, pIn);
    if (banks) {
        add(pIn, qIn, q.shore);
        add(pIn, q.shore, p.shore);
    }
    return out;
}

WaterSums shownOf(const WetTriangles& wet, const std::vector<ShoreTriangle>& shore,
                  const ShoreRule& rule) {
    WaterSums sums;
    for (const ShoreTriangle& s : shore) {
        const WaterPieces parts = wet.piecesOf(s.nodes, rule);
        for (int i = 0; i < parts.count; ++i) {
            const WaterPiece& piece = parts.pieces[std::size_t(i)];
            const double area = s.area * areaShare(piece);
            sums.area += area;
            sums.volume += area * meanDepth(piece);
        }
    }
    return sums;
}

ShoreRule fitShore(const WetTriangles& wet, const std::vector<ShoreTriangle>& shore,
                   const WaterSums& missing, const WaterSums& whole) {
    ShoreRule rule;
    if (shore.empty())
        return rule;
    fitArea(wet, shore, missing.area, kSlack * whole.area, rule);
    fitVolume(wet, shore, missing.volume - kSlack * whole.volume, rule);
    return rule;
}

} // namespace gnomon
