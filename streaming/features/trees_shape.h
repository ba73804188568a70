// What a tree looks like: a crown on a trunk, at three levels of detail, and how far the simpler
// ones are from the finest. Every part is a closed solid, wound outward.
#pragma once

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace gnomon {

enum class TreeForm : std::uint8_t { Broad, Needle };
// Triangles of a broad-leaved and a needle-leaved tree: 96 and 80; 24 and 20; 8.
enum class TreeDetail : std::uint8_t { Near, Far, Farthest };

// A tree 1 m high whose crown is 1 m in radius, its foot at the origin, z up. The trunk goes on
// below the foot, so that it stands on slopes.
struct TreeShape {
    std::vector<glm::dvec3> positions, normals; // one a vertex
    std::vector<std::uint8_t> isTrunk;          // one a vertex
    std::vector<double> shade;                  // one a vertex: crowns are darker below
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint32_t> solidEnds; // how many triangles there are up to the end of each
};

// Trees of one form differ a little.
unsigned treeVariants(TreeForm form);
const TreeShape& treeShape(TreeForm form, unsigned variant, TreeDetail detail);

// The largest distance, either way, between what shows of a tree of this size in `detail` and what
// shows of it in the finest (Hausdorff's), from samples all over both.
double treeDeviationMetres(TreeForm form, unsigned variant, TreeDetail detail, double heightMetres,
                           double crownRadiusMetres);

// Of a usual tree, for what a file does not say: crown radius by height.
double usualCrownRadius(TreeForm form);

// How far the trunk reaches below the foot, of the height.
inline constexpr double kTreeRootDepth = 0.06;

} // namespace gnomon
