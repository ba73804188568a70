#include "render/gpu_tile_upload.h"

#include "shaders/interface.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace gnomon::render {

namespace {

struct Attributes {
    OctNormal normal;
    glm::vec2 uv;
    std::uint32_t color;
};
static_assert(sizeof(Attributes) == 16);

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

void attribute(unsigned vao, unsigned index, unsigned binding, int size, unsigned type,
               bool normalized, unsigned offset) {
    glEnableVertexArrayAttrib(vao, index);
    glVertexArrayAttribFormat(vao, index, size, type, normalized ? GL_TRUE : GL_FALSE, offset);
    glVertexArrayAttribBinding(vao, index, binding);
}

// With its mipmaps.
std::size_t textureBytes(const Image& image) {
    return image.rgba.size() + image.rgba.size() / 3;
}

// Of all meshes, what stands in each of the buffers.
struct Sizes {
    std::size_t positions = 0, attributes = 0, indices = 0, faceNormals = 0;
    std::size_t sum() const { return positions + attributes + indices + faceNormals; }
};
Sizes sizesOf(const TileContent& content) {
    Sizes sizes;
    for (const Mesh& mesh : content.meshes) {
        sizes.positions += mesh.positions.size() * sizeof(glm::vec3);
        sizes.attributes += mesh.positions.size() * sizeof(Attributes);
        sizes.indices += mesh.indices.size() * sizeof(std::uint32_t);
        sizes.faceNormals += mesh.faceNormals.size() * sizeof(OctNormal);
    }
    return sizes;
}

// A part of one mesh's data behind what is in the buffer already. Returns how many bytes.
template <class T>
std::size_t append(const Buffer& buffer, std::size_t at, const T* data, std::size_t count) {
    if (count > 0)
        glNamedBufferSubData(buffer.id(), GLintptr(at), GLsizeiptr(count * sizeof(T)), data);
    return count * sizeof(T);
}

std::vector<Attributes> attributesOf(const Mesh& mesh, std::size_t first, std::size_t count) {
    std::vector<Attributes> attributes;
    attributes.reserve(count);
    for (std::size_t i = first; i < first + count; ++i)
        attributes.push_back({mesh.normals[i], mesh.uvs.empty() ? glm::vec2(0.0f) : mesh.uvs[i],
                              mesh.colors.empty() ? 0xffffffffu : mesh.colors[i]});
    return attributes;
}

} // namespace

std::size_t GpuTileUpload::bytesOf(const TileContent& content) {
    std::size_t bytes = sizesOf(content).sum();
    for (const Material& look : content.materials)
        if (look.image >= 0)
            bytes += textureBytes(content.images[std::size_t(look.image)]);
    return bytes;
}

GpuTileUpload::GpuTileUpload(std::shared_ptr<const TileContent> content)
    : content_(std::move(content)) {}

bool GpuTileUpload::step(std::size_t bytes) {
    if (!std::exchange(allocated_, true))
        allocate();
    std::size_t done = 0;
    while (done < bytes && mesh_ < content_->meshes.size())
        done += uploadMesh(bytes - done);
    while (done < bytes && material_ < content_->materials.size())
        done += uploadTexture(bytes - done);
    return mesh_ == content_->meshes.size() && material_ == content_->materials.size();
}

GpuTile GpuTileUpload::take(std::vector<std::string>& warnings) {
    warnings.insert(warnings.end(), warnings_.begin(), warnings_.end());
    return std::move(tile_);
}

void GpuTileUpload::allocate() {
    const Sizes sizes = sizesOf(*content_);
    tile_.bytes_ = sizes.sum();
    tile_.positions_ = makeDynamicBuffer(std::max<std::size_t>(sizes.positions, 16));
    tile_.attributes_ = makeDynamicBuffer(std::max<std::size_t>(sizes.attributes, 16));
    tile_.indices_ = makeDynamicBuffer(std::max<std::size_t>(sizes.indices, 16));
    tile_.faceNormalBuffer_ = makeDynamicBuffer(std::max<std::size_t>(sizes.faceNormals, 16));

    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
    // Buffer textures know no signed normalised format; the shader divides.
    glTextureBuffer(id, GL_RG16I, tile_.faceNormalBuffer_.id());
    tile_.faceNormals_ = Texture(id);

    unsigned vaos[2];
    glCreateVertexArrays(2, vaos);
    for (const unsigned vao : vaos) {
        glVertexArrayVertexBuffer(vao, 0, tile_.positions_.id(), 0, sizeof(glm::vec3));
        glVertexArrayElementBuffer(vao, tile_.indices_.id());
        attribute(vao, ATTRIB_POSITION, 0, 3, GL_FLOAT, false, 0);
    }
    glVertexArrayVertexBuffer(vaos[0], 1, tile_.attributes_.id(), 0, sizeof(Attributes));
    attribute(vaos[0], ATTRIB_NORMAL, 1, 2, GL_SHORT, true, offsetof(Attributes, normal));
    attribute(vaos[0], ATTRIB_UV, 1, 2, GL_FLOAT, false, offsetof(Attributes, uv));
    attribute(vaos[0], ATTRIB_COLOR, 1, 4, GL_UNSIGNED_BYTE, true, offsetof(Attributes, color));
    tile_.vertices_ = VertexArray(vaos[0]);
    tile_.positionsOnly_ = VertexArray(vaos[1]);
}

// A part of one stream of the present mesh, or its end.
std::size_t GpuTileUpload::uploadMesh(std::size_t bytes) {
    const Mesh& mesh = content_->meshes[mesh_];
    const auto stream = Stream(stream_);
    if (stream == Stream::Positions && element_ == 0) {
        GpuMesh out;
        out.origin = mesh.origin;
        out.box = mesh.box;
        out.firstIndex = std::uint32_t(uploaded_[int(Stream::Indices)] / sizeof(std::uint32_t));
        out.closedIndices = mesh.closedTriangles * 3;
        out.openIndices = mesh.castingTriangles() * 3 - out.closedIndices;
        out.skirtIndices = mesh.skirtTriangles * 3;
        out.baseVertex = std::int32_t(uploaded_[int(Stream::Positions)] / sizeof(glm::vec3));
        out.material = std::uint32_t(mesh.material);
        tile_.meshes_.push_back(out);
    }
    const auto part = [&](std::size_t all, std::size_t elementBytes) {
        return std::min(all - element_, std::max<std::size_t>(bytes / elementBytes, 1));
    };
    const std::size_t at = uploaded_[stream_];
    std::size_t count = 0, all = 0, done = 0;
    switch (stream) {
    case Stream::Positions:
        count = part(all = mesh.positions.size(), sizeof(glm::vec3));
        done = append(tile_.positions_, at, mesh.positions.data() + element_, count);
        break;
    case Stream::Attributes:
        count = part(all = mesh.positions.size(), sizeof(Attributes));
        done = append(tile_.attributes_, at, attributesOf(mesh, element_, count).data(), count);
        break;
    case Stream::Indices:
        count = part(all = mesh.indices.size(), sizeof(std::uint32_t));
        done = append(tile_.indices_, at, mesh.indices.data() + element_, count);
        break;
    case Stream::FaceNormals:
        count = part(all = mesh.faceNormals.size(), sizeof(OctNormal));
        done = append(tile_.faceNormalBuffer_, at, mesh.faceNormals.data() + element_, count);
        break;
    }
    uploaded_[stream_] += done;
    element_ += count;
    if (element_ == all) {
        element_ = 0;
        if (++stream_ == kStreams) {
            stream_ = 0;
            ++mesh_;
        }
    }
    return done;
}

void GpuTileUpload::makeTexture(const Material& look) {
    int limit = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    const Image& image = content_->images[std::size_t(look.image)];
    fitted_ = {};
    if (image.width > limit || image.height > limit) {
        fitted_ = fitted(image, limit);
        warnings_.push_back("texture of " + std::to_string(image.width) + " x " +
                            std::to_string(image.height) + " scaled down to " +
                            std::to_string(fitted_.width) + " x " + std::to_string(fitted_.height));
    }
    const Image& used = fitted_.rgba.empty() ? image : fitted_;
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &id);
    const int levels = int(std::bit_width(unsigned(std::max(used.width, used.height))));
    glTextureStorage2D(id, levels, GL_SRGB8_ALPHA8, used.width, used.height);
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER,
                        look.nearestFilter ? GL_NEAREST_MIPMAP_LINEAR : GL_LINEAR_MIPMAP_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, look.nearestFilter ? GL_NEAREST : GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, glWrap(look.wrapS));
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, glWrap(look.wrapT));
    tile_.textures_.push_back(Texture(id));
    tile_.bytes_ += textureBytes(used);
    row_ = 0;
}

// Some rows of the present material's texture, or its mipmaps.
std::size_t GpuTileUpload::uploadTexture(std::size_t bytes) {
    const Material& look = content_->materials[material_];
    const auto finish = [&](int texture) {
        tile_.materials_.push_back({look, texture});
        hasTexture_ = false;
        ++material_;
    };
    if (look.image < 0) {
        finish(-1);
        return 0;
    }
    if (!std::exchange(hasTexture_, true))
        makeTexture(look);
    const Image& image = fitted_.rgba.empty() ? content_->images[std::size_t(look.image)] : fitted_;
    const unsigned id = tile_.textures_.back().id();
    if (row_ == image.height) {
        glGenerateTextureMipmap(id);
        finish(int(tile_.textures_.size()) - 1);
        return image.rgba.size() / 3;
    }
    const std::size_t rowBytes = std::size_t(image.width) * 4;
    const int rows =
        int(std::clamp<std::size_t>(bytes / rowBytes, 1, std::size_t(image.height - row_)));
    glTextureSubImage2D(id, 0, 0, row_, image.width, rows, GL_RGBA, GL_UNSIGNED_BYTE,
                        image.rgba.data() + std::size_t(row_) * rowBytes);
    row_ += rows;
    return std::size_t(rows) * rowBytes;
}

} // namespace gnomon::render
