// What mesh.h promises of a decoded tile. Some of it decodeContent checks itself (check_content.h);
// here it is checked again, in other words, with what would be too slow for that.
#pragma once

#include "tests/fuzz/table_promises.h"

#include "streaming/content.h"

namespace gnomon::fuzz {

inline void checkVertices(const Mesh& mesh) {
    const std::size_t n = mesh.positions.size();
    demand(mesh.normals.size() == n, "a normal a vertex");
    demand(mesh.uvs.empty() || mesh.uvs.size() == n, "no uvs or one a vertex");
    demand(mesh.colors.empty() || mesh.colors.size() == n, "no colours or one a vertex");
    demand(mesh.features.empty() || mesh.features.size() == n, "no features or one a vertex");
    // Floats are rounded to: half a unit in the last place, of the largest.
    const double slack = 1e-6 * mesh.radiusMetres + 1e-6 * length(mesh.box.centre - mesh.origin) +
                         1e-9 * glm::length(mesh.origin.xyz) + 1e-6;
    for (const glm::vec3& position : mesh.positions) {
        const glm::dvec3 p(position);
        demand(isFinite(p), "positions are finite");
        demand(glm::length(p) <= mesh.radiusMetres + slack, "the radius holds the vertices");
        const glm::dvec3 fromCentre = mesh.origin.xyz + p - mesh.box.centre.xyz;
        for (int axis = 0; axis < 3; ++axis) {
            const glm::dvec3 half = mesh.box.halfAxes[axis];
            const double reach = glm::length(half);
            const double along = reach > 0 ? std::abs(glm::dot(fromCentre, half)) / reach : 0.0;
            demand(along <= reach + slack, "the box holds the vertices");
        }
    }
    for (const glm::vec2& uv : mesh.uvs)
        demand(std::isfinite(uv.x) && std::isfinite(uv.y), "uvs are finite");
}

inline void checkMesh(const Mesh& mesh, const TileContent& content) {
    demand(isFinite(mesh.origin.xyz) && isFinite(mesh.box), "a mesh's place is finite");
    demand(std::isfinite(mesh.radiusMetres) && mesh.radiusMetres >= 0, "a radius is a length");
    demand(mesh.material >= 0 && std::size_t(mesh.material) < content.materials.size(),
           "a mesh's material is there");
    checkVertices(mesh);
    demand(mesh.indices.size() % 3 == 0, "whole triangles");
    for (const std::uint32_t index : mesh.indices)
        demand(index < mesh.positions.size(), "an index names a vertex");
    demand(mesh.faceNormals.size() == mesh.triangles(), "a normal a face");
    demand(std::uint64_t(mesh.closedTriangles) + mesh.skirtTriangles <= mesh.triangles(),
           "closed triangles and skirts are triangles");
    // Features behind the last row are told apart, and have no properties.
}

inline void checkContent(const TileContent& content) {
    std::uint64_t triangles = 0, closed = 0;
    for (const Mesh& mesh : content.meshes) {
        checkMesh(mesh, content);
        triangles += mesh.triangles();
        closed += mesh.closedTriangles;
    }
    const ContentFacts& facts = content.facts;
    demand(facts.triangles == triangles && facts.closedTriangles == closed, "facts count meshes");
    demand(facts.closedComponents <= facts.components, "closed components are components");
    demand(!facts.format.empty(), "what was read has a format");
    for (const Material& material : content.materials) {
        demand(material.image >= -1 && material.image < std::ptrdiff_t(content.images.size()),
               "a material's image is there");
        demand(std::isfinite(material.alphaCutoff), "a cutoff is finite");
    }
    for (const Image& image : content.images)
        demand(image.width >= 1 && image.height >= 1 && image.width <= 8192 &&
                   image.height <= 8192 &&
                   image.rgba.size() == std::size_t(image.width) * std::size_t(image.height) * 4,
               "an image has its pixels");
    for (const std::string& warning : facts.warnings)
        demandReadable(warning);
    if (content.features)
        checkTable(*content.features);
}

// A tile as the loader decodes it, with a file beside it for whatever it refers to.
inline void fuzzContent(Span bytes, Span beside, UpAxis up) {
    DecodeOptions options;
    options.gltfUpAxis = up;
    options.ecefFromTile.matrix[3] = glm::dvec4(4.0e6, 5.0e5, 4.9e6, 1.0);
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        const auto path = resolveUri("a/b/tile.glb", uri);
        if (!path)
            return path.error();
        return Bytes(beside.begin(), beside.end());
    };
    const auto content = decodeContent(bytes, "tile", options);
    if (!content) {
        demandReadable(content.error());
        return;
    }
    checkContent(*content);
    // The same bytes, the same tile; of small ones, so as not to try half as many.
    constexpr std::size_t kSmall = 2048;
    if (bytes.size() > kSmall)
        return;
    const auto again = decodeContent(bytes, "tile", options);
    demand(again && again->bytes() == content->bytes() &&
               again->facts.triangles == content->facts.triangles,
           "decoding is deterministic");
}

} // namespace gnomon::fuzz
