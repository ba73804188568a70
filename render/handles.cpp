#include "render/handles.h"

#include <epoxy/gl.h>

namespace gnomon::render {

namespace detail {
void destroyBuffer(unsigned id) {
    glDeleteBuffers(1, &id);
}
void destroyTexture(unsigned id) {
    glDeleteTextures(1, &id);
}
void destroyFramebuffer(unsigned id) {
    glDeleteFramebuffers(1, &id);
}
void destroyVertexArray(unsigned id) {
    glDeleteVertexArrays(1, &id);
}
void destroyQuery(unsigned id) {
    glDeleteQueries(1, &id);
}
void destroyProgram(unsigned id) {
    glDeleteProgram(id);
}
} // namespace detail

Buffer makeBuffer(std::size_t bytes, const void* data) {
    unsigned id = 0;
    glCreateBuffers(1, &id);
    // GL refuses storage of no bytes; an empty attribute still needs a buffer to name.
    glNamedBufferStorage(id, GLsizeiptr(bytes == 0 ? 16 : bytes), bytes == 0 ? nullptr : data, 0);
    return Buffer(id);
}

Buffer makeDynamicBuffer(std::size_t bytes) {
    unsigned id = 0;
    glCreateBuffers(1, &id);
    glNamedBufferStorage(id, GLsizeiptr(bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
    return Buffer(id);
}

void update(const Buffer& buffer, std::size_t bytes, const void* data) {
    glNamedBufferSubData(buffer.id(), 0, GLsizeiptr(bytes), data);
}

void bindUniformBlock(unsigned binding, const Buffer& buffer) {
    glBindBufferBase(GL_UNIFORM_BUFFER, binding, buffer.id());
}

namespace {
void setNearestClamped(unsigned id) {
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}
} // namespace

Texture makeTarget(unsigned format, int width, int height) {
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &id);
    glTextureStorage2D(id, 1, format, width, height);
    setNearestClamped(id);
    return Texture(id);
}

Texture makeTargetArray(unsigned format, int width, int height, int layers) {
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &id);
    glTextureStorage3D(id, 1, format, width, height, layers);
    setNearestClamped(id);
    return Texture(id);
}

void bindTexture(unsigned unit, const Texture& texture) {
    glBindTextureUnit(unit, texture.id());
}

} // namespace gnomon::render
