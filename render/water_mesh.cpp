#include "render/water_mesh.h"

#include "shaders/interface.h"
#include "streaming/mesh.h"

#include <epoxy/gl.h>

#include <cstddef>

namespace gnomon::render {

namespace {

// Of a triangle that is a line or a point: up, along the scene's axes.
glm::dvec3 unitOrUp(const glm::dvec3& v) {
    const double size = glm::length(v);
    return size > 0.0 ? v / size : glm::dvec3(0, 0, 1);
}

struct Normals {
    std::vector<OctNormal> faces, vertices;
};

// A vertex has the mean of its faces, by their areas: water is smooth.
void addNormals(const WaterMesh& mesh, Normals& normals) {
    std::vector<glm::dvec3> sums(mesh.vertices.size(), glm::dvec3(0.0));
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        const std::uint32_t* corner = &mesh.indices[i];
        const glm::dvec3 a(mesh.vertices[corner[0]].position);
        const glm::dvec3 across = glm::cross(glm::dvec3(mesh.vertices[corner[1]].position) - a,
                                             glm::dvec3(mesh.vertices[corner[2]].position) - a);
        normals.faces.push_back(encodeOct(unitOrUp(across)));
        for (int k = 0; k < 3; ++k)
            sums[corner[k]] += across;
    }
    for (const glm::dvec3& sum : sums)
        normals.vertices.push_back(encodeOct(unitOrUp(sum)));
}

template <class T>
Buffer upload(const std::vector<T>& values, std::size_t& bytes) {
    bytes += values.size() * sizeof(T);
    return makeBuffer(values.size() * sizeof(T), values.data());
}

void attribute(unsigned vao, unsigned index, unsigned binding, int size, unsigned type,
               bool normalized, std::size_t offset) {
    glEnableVertexArrayAttrib(vao, index);
    glVertexArrayAttribFormat(vao, index, size, type, normalized ? GL_TRUE : GL_FALSE,
                              unsigned(offset));
    glVertexArrayAttribBinding(vao, index, binding);
}

} // namespace

GpuWater::GpuWater(std::span<const WaterMesh> meshes) {
    std::vector<WaterVertex> surface;
    std::vector<std::uint32_t> indices;
    Normals normals;
    for (const WaterMesh& mesh : meshes) {
        meshes_.push_back({mesh.origin, mesh.box, std::uint32_t(indices.size()),
                           std::uint32_t(mesh.indices.size()), std::int32_t(surface.size())});
        surface.insert(surface.end(), mesh.vertices.begin(), mesh.vertices.end());
        indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
        addNormals(mesh, normals);
    }
    surface_ = upload(surface, bytes_);
    normals_ = upload(normals.vertices, bytes_);
    indices_ = upload(indices, bytes_);
    faceNormalBuffer_ = upload(normals.faces, bytes_);

    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
    glTextureBuffer(id, GL_RG16I, faceNormalBuffer_.id());
    faceNormals_ = Texture(id);

    glCreateVertexArrays(1, &id);
    vertices_ = VertexArray(id);
    glVertexArrayVertexBuffer(id, 0, surface_.id(), 0, sizeof(WaterVertex));
    glVertexArrayVertexBuffer(id, 1, normals_.id(), 0, sizeof(OctNormal));
    glVertexArrayElementBuffer(id, indices_.id());
    attribute(id, ATTRIB_POSITION, 0, 3, GL_FLOAT, false, offsetof(WaterVertex, position));
    attribute(id, ATTRIB_WATER_DEPTH, 0, 1, GL_FLOAT, false, offsetof(WaterVertex, depth));
    attribute(id, ATTRIB_VELOCITY, 0, 2, GL_FLOAT, false, offsetof(WaterVertex, velocity));
    attribute(id, ATTRIB_NORMAL, 1, 2, GL_SHORT, true, 0);
}

} // namespace gnomon::render
