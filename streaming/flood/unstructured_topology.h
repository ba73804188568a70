// Meshes of polygons as flood models have them, made into the nodes and triangles of FloodGeometry.
//
// Values at points: the points are the nodes, the polygons are cut into triangles.
//
// Values of faces (finite volumes): the nodes are the faces' centroids, where a face's mean is the
// value of a surface that is linear over it; they are triangulated among themselves, around each
// point that faces share (the dual mesh). That leaves the outer half of the outermost faces bare,
// so the points of the rim are nodes too; they carry the mean of the faces around them and stand
// for no area. So the surface runs through the model's own values, covers what the faces cover, and
// depth times area summed over the nodes is the model's own sum.
#pragma once

#include <glm/vec2.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace gnomon {

struct PolygonMesh {
    std::vector<glm::dvec2> points; // in the coordinates of the file
    std::vector<std::uint32_t> corners;
    std::vector<std::uint32_t> starts{0}; // where each face's corners begin, and the end

    std::size_t faces() const { return starts.size() - 1; }
    void addFace(const std::uint32_t* first, std::size_t count);
};

enum class ValuesAt { Points, Faces };

struct NodeMesh {
    std::vector<glm::dvec2> positions;
    std::vector<std::array<std::uint32_t, 3>> triangles; // counter-clockwise
    // Of the first nodes: the point or face of the file that each has its value from.
    std::vector<std::uint32_t> source;
    // The nodes after them are the rim's: the nodes each is the mean of, from meanStarts[i] on.
    std::vector<std::uint32_t> meanStarts{0};
    std::vector<std::uint32_t> meanOf;
    std::vector<double> faceArea;  // of the first nodes, in the file's units; of faces only
    std::size_t unusableFaces = 0; // fewer than three corners, no area, corners that do not exist
    std::size_t emptySlots = 0;    // rows that name fewer than three corners: padding, not a fault
};

// A face of more corners than this is no cell of a flood model.
constexpr std::size_t kMaxFaceCorners = 32;

NodeMesh nodesOf(PolygonMesh mesh, ValuesAt at);

} // namespace gnomon
