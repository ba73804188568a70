// Decoded geometry, ready for the GPU: what every format ends as.
//
// A tile's triangles are cut into meshes of one material and about kMaxMeshExtentMetres across
// (more where triangles are large or few), each with an ECEF origin of its own in double and float
// positions relative to it, so that no float ever holds a large coordinate (NUMERICS: r <= 838 d)
// and whole meshes can be culled, also per cascade. Transforms, up-axis and node matrices are
// already applied; positions and normals are along the axes of DecodeOptions::meshAxes.
#pragma once

#include "geo/bounds.h"
#include "geo/frames.h"
#include "streaming/feature_table.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace gnomon {

inline constexpr double kMaxMeshExtentMetres = 256.0;
inline constexpr std::uint32_t kNoFeature = 0xffffffffu;

// A unit vector in two signed normalised 16-bit numbers (octahedral; Cigolle et al., "A survey of
// efficient representations for independent unit vectors", 2014); error below 5e-5 rad.
struct OctNormal {
    std::int16_t x = 0, y = 0;
};
OctNormal encodeOct(const glm::dvec3& unit);
glm::dvec3 decodeOct(OctNormal n);

// 8-bit RGBA as in the file: sRGB for colour, rows top to bottom as glTF has them.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};

enum class Wrap { Repeat, MirroredRepeat, ClampToEdge };

struct Material {
    glm::vec4 baseColor{1.0f}; // linear, as glTF has it
    int image = -1;            // index into TileContent::images
    Wrap wrapS = Wrap::Repeat, wrapT = Wrap::Repeat;
    bool nearestFilter = false;
    bool unlit = false;     // colour is final; still casts and receives shadow
    bool alphaTest = false; // alphaMode MASK (BLEND is drawn as MASK at 0.5)
    float alphaCutoff = 0.5f;
};

struct Mesh {
    Point<Ecef> origin;
    OrientedBox box;         // of the vertices, in ECEF
    double radiusMetres = 0; // of the vertices about `origin`
    int material = 0;

    // One entry a vertex. `uvs`, `colors` and `features` are empty when the file has none.
    std::vector<glm::vec3> positions;
    std::vector<OctNormal> normals; // for shading; the face's own where the file has none
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> colors; // RGBA8, linear, R in the lowest byte
    std::vector<std::uint32_t> features;

    // Triangles of closed components first (outward wound), then those of open ones, then skirts,
    // which hide from the eye where tiles of different detail do not meet: they cast no shadow, in
    // maps as in the rays that maps are held against.
    std::vector<std::uint32_t> indices;
    std::uint32_t closedTriangles = 0;
    std::uint32_t skirtTriangles = 0;
    std::vector<OctNormal> faceNormals; // one a triangle, geometric

    std::uint32_t triangles() const { return std::uint32_t(indices.size() / 3); }
    std::uint32_t castingTriangles() const { return triangles() - skirtTriangles; } // the first
    std::size_t bytes() const;
};

// What was found in a tile while decoding it, for `info` and the reports.
struct ContentFacts {
    // "b3dm", "i3dm", "pnts", "cmpt", "glb", "gltf", "quantized-mesh"; of what is made here
    // "terrain", "buildings", "trees", "barriers".
    std::string format;
    std::uint64_t triangles = 0;
    std::uint64_t duplicates = 0; // triangles dropped because they were there already
    std::uint64_t degenerate = 0; // zero-area triangles, dropped
    std::uint64_t invalid = 0;    // triangles dropped for NaN or infinite positions
    std::uint64_t closedTriangles = 0;
    std::uint32_t components = 0, closedComponents = 0; // welded at 1 mm
    std::vector<std::string> extensions;
    std::string copyright;
    std::vector<std::string> warnings;
    // Sum over the triangles of area times normal, in the tile's frame: for terrain it points up.
    glm::dvec3 areaVector{0.0};
};

struct TileContent {
    std::vector<Mesh> meshes;
    std::vector<Material> materials;
    std::vector<Image> images;
    std::shared_ptr<const FeatureTable> features; // of Mesh::features; null when the file has none
    ContentFacts facts;

    std::size_t bytes() const;
};

} // namespace gnomon
