#include "render/readback.h"

#include <epoxy/gl.h>

namespace gnomon::render {

void readTexture(const Texture& texture, unsigned format, unsigned type, std::size_t bytes,
                 void* out) {
    glGetTextureImage(texture.id(), 0, format, type, int(bytes), out);
}

} // namespace gnomon::render
