// Move-only owners of GL objects. An empty handle has id 0 and owns nothing. No GL header is needed
// to hold one; enums are passed as GL's own numbers by the .cpp files that use them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>

namespace gnomon::render {

// One kind of GL object; Destroy is the function that deletes it.
template <void (*Destroy)(unsigned)>
class Handle {
  public:
    Handle() = default;
    explicit Handle(unsigned id) : id_(id) {}
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    ~Handle() {
        if (id_ != 0)
            Destroy(id_);
    }
    unsigned id() const { return id_; }
    explicit operator bool() const { return id_ != 0; }

  private:
    unsigned id_ = 0;
};

namespace detail {
void destroyBuffer(unsigned id);
void destroyTexture(unsigned id);
void destroyFramebuffer(unsigned id);
void destroyVertexArray(unsigned id);
void destroyQuery(unsigned id);
void destroyProgram(unsigned id);
} // namespace detail

using Buffer = Handle<detail::destroyBuffer>;
using Texture = Handle<detail::destroyTexture>;
using Framebuffer = Handle<detail::destroyFramebuffer>;
using VertexArray = Handle<detail::destroyVertexArray>;
using Query = Handle<detail::destroyQuery>;

// Immutable storage with these bytes (may be null).
Buffer makeBuffer(std::size_t bytes, const void* data);
// Storage that is rewritten every frame.
Buffer makeDynamicBuffer(std::size_t bytes);
void update(const Buffer& buffer, std::size_t bytes, const void* data);
template <class Block>
void update(const Buffer& buffer, const Block& block) {
    update(buffer, sizeof(Block), &block);
}
void bindUniformBlock(unsigned binding, const Buffer& buffer);

// GL's sized internal format; nearest filtering, clamped, no mipmaps.
Texture makeTarget(unsigned format, int width, int height);
Texture makeTargetArray(unsigned format, int width, int height, int layers);
void bindTexture(unsigned unit, const Texture& texture);

} // namespace gnomon::render
