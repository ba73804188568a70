#include "render/gpu_tile.h"

#include "shaders/interface.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <bit>

namespace gnomon::render {

namespace {

struct Attributes {
    OctNormal normal;
    glm::vec2 uv;
    std::uint32_t color;
};
static_assert(sizeof(Attributes) == 16);

template <class T>
Buffer upload(const std::vector<T>& data, std::size_t& bytes) {
    const std::size_t size = data.size() * sizeof(T);
    bytes += size;
    return makeBuffer(size, data.data());
}

int glWrap(Wrap wrap) {
    switch (wrap) {
    case Wrap::Repeat:
        return GL_REPEAT;
    case Wrap::MirroredRepeat:
        return GL_MIRRORED_REPEAT;
    case Wrap::ClampToEdge:
        return GL_CLAMP_TO_EDGE;
    }
    return GL_REPEAT;
}

// Halves an image by box filter until it fits.
Image fitted(const Image& image, int limit) {
    Image out = image;
    while (out.width > limit || out.height > limit) {
        Image half;
        half.width = std::max(1, out.width / 2);
        half.height = std::max(1, out.height / 2);
        half.rgba.resize(std::size_t(half.width) * std::size_t(half.height) * 4);
        for (int y = 0; y < half.height; ++y)
            for (int x = 0; x < half.width; ++x)
                for (int c = 0; c < 4; ++c) {
                    int sum = 0;
                    for (int k = 0; k < 4; ++k) {
                        const int sx = std::min(2 * x + k % 2, out.width - 1);
                        const int sy = std::min(2 * y + k / 2, out.height - 1);
                        sum +=
                            out.rgba[(std::size_t(sy) * std::size_t(out.width) + std::size_t(sx)) *
                                         4 +
                                     std::size_t(c)];
                    }
                    half.rgba[(std::size_t(y) * std::size_t(half.width) + std::size_t(x)) * 4 +
                              std::size_t(c)] = std::uint8_t((sum + 2) / 4);
                }
        out = std::move(half);
    }
    return out;
}

Texture makeTexture(const Image& image, const Material& look) {
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &id);
    const int levels = int(std::bit_width(unsigned(std::max(image.width, image.height))));
    glTextureStorage2D(id, levels, GL_SRGB8_ALPHA8, image.width, image.height);
    glTextureSubImage2D(id, 0, 0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE,
                        image.rgba.data());
    glGenerateTextureMipmap(id);
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER,
                        look.nearestFilter ? GL_NEAREST_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, look.nearestFilter ? GL_NEAREST : GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, glWrap(look.wrapS));
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, glWrap(look.wrapT));
    return Texture(id);
}

void attribute(unsigned vao, unsigned index, unsigned binding, int size, unsigned type,
               bool normalized, unsigned offset) {
    glEnableVertexArrayAttrib(vao, index);
    glVertexArrayAttribFormat(vao, index, size, type, normalized ? GL_TRUE : GL_FALSE, offset);
    glVertexArrayAttribBinding(vao, index, binding);
}

} // namespace

GpuTile::GpuTile(const TileContent& content, std::vector<std::string>& warnings) {
    uploadGeometry(content);
    uploadTextures(content, warnings);
}

void GpuTile::uploadGeometry(const TileContent& content) {
    std::vector<glm::vec3> positions;
    std::vector<Attributes> attributes;
    std::vector<std::uint32_t> indices;
    std::vector<OctNormal> faceNormals;
    for (const Mesh& mesh : content.meshes) {
        GpuMesh out;
        out.origin = mesh.origin;
        out.box = mesh.box;
        out.firstIndex = std::uint32_t(indices.size());
        out.closedIndices = mesh.closedTriangles * 3;
        out.openIndices = mesh.castingTriangles() * 3 - out.closedIndices;
        out.skirtIndices = mesh.skirtTriangles * 3;
        out.baseVertex = std::int32_t(positions.size());
        out.material = std::uint32_t(mesh.material);
        meshes_.push_back(out);
        positions.insert(positions.end(), mesh.positions.begin(), mesh.positions.end());
        for (std::size_t i = 0; i < mesh.positions.size(); ++i)
            attributes.push_back({mesh.normals[i], mesh.uvs.empty() ? glm::vec2(0.0f) : mesh.uvs[i],
                                  mesh.colors.empty() ? 0xffffffffu : mesh.colors[i]});
        indices.insert(indices.end(), mesh.indices.begin(), mesh.indices.end());
        faceNormals.insert(faceNormals.end(), mesh.faceNormals.begin(), mesh.faceNormals.end());
    }
    positions_ = upload(positions, bytes_);
    attributes_ = upload(attributes, bytes_);
    indices_ = upload(indices, bytes_);
    faceNormalBuffer_ = upload(faceNormals, bytes_);

    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
    // Buffer textures know no signed normalised format; the shader divides.
    glTextureBuffer(id, GL_RG16I, faceNormalBuffer_.id());
    faceNormals_ = Texture(id);

    unsigned vaos[2];
    glCreateVertexArrays(2, vaos);
    for (const unsigned vao : vaos) {
        glVertexArrayVertexBuffer(vao, 0, positions_.id(), 0, sizeof(glm::vec3));
        glVertexArrayElementBuffer(vao, indices_.id());
        attribute(vao, ATTRIB_POSITION, 0, 3, GL_FLOAT, false, 0);
    }
    glVertexArrayVertexBuffer(vaos[0], 1, attributes_.id(), 0, sizeof(Attributes));
    attribute(vaos[0], ATTRIB_NORMAL, 1, 2, GL_SHORT, true, offsetof(Attributes, normal));
    attribute(vaos[0], ATTRIB_UV, 1, 2, GL_FLOAT, false, offsetof(Attributes, uv));
    attribute(vaos[0], ATTRIB_COLOR, 1, 4, GL_UNSIGNED_BYTE, true, offsetof(Attributes, color));
    vertices_ = VertexArray(vaos[0]);
    positionsOnly_ = VertexArray(vaos[1]);
}

void GpuTile::uploadTextures(const TileContent& content, std::vector<std::string>& warnings) {
    int limit = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    for (const Material& look : content.materials) {
        GpuMaterial material{look, -1};
        if (look.image >= 0) {
            const Image& image = content.images[std::size_t(look.image)];
            const bool tooLarge = image.width > limit || image.height > limit;
            const Image fit = tooLarge ? fitted(image, limit) : Image{};
            if (tooLarge)
                warnings.push_back("texture of " + std::to_string(image.width) + " x " +
                                   std::to_string(image.height) + " scaled down to " +
                                   std::to_string(fit.width) + " x " + std::to_string(fit.height));
            material.texture = int(textures_.size());
            textures_.push_back(makeTexture(tooLarge ? fit : image, look));
            const Image& used = tooLarge ? fit : image;
            bytes_ += used.rgba.size() + used.rgba.size() / 3; // with its mipmaps
        }
        materials_.push_back(material);
    }
}

void GpuTile::bindTextures(const GpuMaterial& material) const {
    if (material.texture >= 0)
        bindTexture(TEX_BASE_COLOR, textures_[std::size_t(material.texture)]);
}

} // namespace gnomon::render
