// Points to solids. A point of a cloud has no size, so it could be neither seen through a lens nor
// hold back light, and a renderer that draws dots needs a path of its own for it. Here each becomes
// a small closed tetrahedron lying flat on the surface that the points around it sample: it is
// drawn, casts and receives like any other mesh.
//
// Size. On a surface with one point in each square of side s, the k-th nearest neighbour of a point
// is at about d = s √((k − 1) / π) (unbiased for points strewn at random), so s = d √(π / (k − 1)),
// here with k = 8. Eight points or fewer are no surface; of those s is the distance of the nearest,
// so that they just touch. The base is an equilateral triangle whose corners are R = √2 s away from
// the point: its inscribed circle, of R / 2 = s / √2, reaches the corners of the point's square, so
// that a grid is covered whichever way the triangles are turned (measured: grids and jittered grids
// 100 %, points strewn at random 97 %). A point without company, a bird or a stray echo, must not
// become a sail: s is at most kMostSpacings times the median of the cloud. The height is R / 8,
// which keeps the three upper faces within 14° of the surface; the point is the centre of mass.
//
// Normals are the file's or else those of the plane through a point and its neighbours. A plane has
// no outer side, so such a solid is lit alike from both.
#pragma once

#include "streaming/soup.h"

#include <optional>

namespace gnomon {

inline constexpr double kMostSpacings = 4.0;
// The spacing where there is none to be had: a single point, or all in one place. A hand's breadth.
inline constexpr double kLoneSpacingMetres = 0.1;

// One entry a point in each; `normals`, `colors` and `features` are empty when there are none.
struct PointCloud {
    std::vector<glm::dvec3> positions; // the tile's frame, metres
    std::vector<glm::vec3> normals;    // the tile's frame; zero where there is none
    std::vector<std::uint32_t> colors, features;
    std::uint32_t material = 0;

    std::size_t size() const { return positions.size(); }
    // Of these points only, which are in their order.
    void keep(const std::vector<std::uint32_t>& points);
};

struct PointSolids {
    std::vector<Mesh> meshes;
    std::uint64_t triangles = 0; // all of them closed
    std::uint64_t invalid = 0;   // points without a finite place
    std::uint64_t leftOut = 0;   // points for which there was no memory, spread evenly
};

// The clouds of one content, whose points are each other's neighbours: writers part them by colour
// or kind.
PointSolids solidsOf(std::vector<PointCloud> clouds, const Transform<Ecef, Tile>& ecefFromTile,
                     const std::optional<glm::dmat3>& meshAxes, ByteBudget& budget);

// The spacing s about each point, as above but without the bounds.
std::vector<double> spacingsOf(const std::vector<glm::dvec3>& points);

} // namespace gnomon
