// Where water ends between wet nodes and dry ones: what is shown of a triangle that has both.
//
// Along the way from a wet node to a dry one the surface runs on level from the wet node. It ends
//   - where it meets the straight line between the two beds, when the dry bed is above it: on a
//     slope the shore is that of the slope;
//   - in the middle, where the cells of a model meet, when the dry bed is below it or not known:
//     then something else than the ground keeps the water off;
// with a passage from one to the other while the dry bed is less below the level than a fifth of
// the depth, so that a shore does not jump as water rises. It comes no nearer to a dry node than a
// twentieth of the way.
//
// Models count whole cells as wet. In valleys no wider than a few cells the rule above shows less
// water than the model has; so no shore is nearer to a wet node than a share `nearest` of the way,
// nor farther than `farthest`, both chosen at each moment as weak as will do for the area shown to
// be that of the wet cells within half a percent. Likewise depth: under a straight line from a wet
// node to the shore there is too little where the model's cells end in a bank; so the depth just
// within the shore is a share of that at the node, again as small as will do for the volume: first
// where the shore is no slope's, then everywhere. Where that too is not enough (ponds of one cell)
// less is shown.
#pragma once

#include "streaming/flood/water_surface_nodes.h"

#include <glm/vec3.hpp>

#include <array>

namespace gnomon {

struct ShoreRule {
    static constexpr double kNearest = 0.01; // triangles keep some width
    static constexpr double kFoot = 0.98;    // of the way to the shore: where a bank begins

    double nearest = kNearest, farthest = 1.0;
    double bankElsewhere = 0.0, bankOnSlopes = 0.0;

    bool hasBanks() const { return bankElsewhere > 0.0 || bankOnSlopes > 0.0; }
};

// From a wet node to a dry one.
struct ShoreEdge {
    double share = 0.5; // of the way to where water ends, the rule's limits left out
    bool isSlope = false;
};
// `bedAbove`: the dry bed's height above the wet node's level; NaN: not known.
ShoreEdge shoreEdge(double depth, double bedAbove);

struct PlacedShore {
    double share = 0.5, bank = 0.0;
};
PlacedShore placed(const ShoreEdge& edge, const ShoreRule& rule);

// A corner of what is shown: a node (`wet` == `dry`), or a place on the way from one to the other.
struct WaterCorner {
    std::uint32_t wet = 0, dry = 0;
    bool isFoot = false;
    double share = 0.0, depth = 0.0;
    glm::dvec3 weights{0.0}; // of the triangle's corners

    bool isNode() const { return wet == dry; }
};
using WaterPiece = std::array<WaterCorner, 3>;

struct WaterPieces {
    std::array<WaterPiece, 4> pieces;
    int count = 0;
};

// The parts of its triangle's area and the depths at its corners as one number each.
double areaShare(const WaterPiece& piece);
inline double meanDepth(const WaterPiece& piece) {
    return (piece[0].depth + piece[1].depth + piece[2].depth) / 3.0;
}

// Depths and beds of all nodes; those deeper than `dryMetres` are wet.
class WetTriangles {
  public:
    WetTriangles(const std::vector<float>& depths, const std::vector<float>& beds, double dryMetres)
        : depths_(depths), beds_(beds), dry_(float(dryMetres)) {}

    bool isWet(std::uint32_t node) const { return depths_[node] > dry_; }
    int wetCorners(const NodeTriangle& t) const {
        return int(isWet(t[0])) + int(isWet(t[1])) + int(isWet(t[2]));
    }
    double depth(std::uint32_t node) const { return depths_[node]; }
    double level(std::uint32_t node) const { return double(beds_[node]) + depths_[node]; }
    // A film that counts as dry is as good as bed.
    ShoreEdge edge(std::uint32_t wet, std::uint32_t dry) const {
        return shoreEdge(depths_[wet], level(dry) - level(wet));
    }
    WaterPieces piecesOf(const NodeTriangle& triangle, const ShoreRule& rule) const;

  private:
    const std::vector<float>& depths_;
    const std::vector<float>& beds_;
    float dry_;
};

// Triangles with wet and dry corners, and the square metres of each.
struct ShoreTriangle {
    NodeTriangle nodes{};
    double area = 0.0;
};
struct WaterSums {
    double area = 0.0, volume = 0.0;
};
// The rule by which these triangles show what is `missing`: what there is by nodes and their cells
// (`whole`), less what triangles that are wet all over show.
ShoreRule fitShore(const WetTriangles& wet, const std::vector<ShoreTriangle>& shore,
                   const WaterSums& missing, const WaterSums& whole);
WaterSums shownOf(const WetTriangles& wet, const std::vector<ShoreTriangle>& shore,
                  const ShoreRule& rule);

} // namespace gnomon
