// Textures back into memory. Waits for the GPU.
#pragma once

#include "render/handles.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace gnomon::render {

// `format` and `type` are GL's and must describe T × channels. `bytes` is the size of `out`.
void readTexture(const Texture& texture, unsigned format, unsigned type, std::size_t bytes,
                 void* out);

// Rows top to bottom (GL's are bottom to top).
template <class T>
std::vector<T> readTopDown(const Texture& texture, int width, int height, int channels,
                           unsigned format, unsigned type) {
    const std::size_t row = std::size_t(width) * std::size_t(channels);
    std::vector<T> up(row * std::size_t(height)), down(up.size());
    readTexture(texture, format, type, up.size() * sizeof(T), up.data());
    for (std::size_t y = 0; y < std::size_t(height); ++y)
        std::copy_n(up.data() + (std::size_t(height) - 1 - y) * row, row, down.data() + y * row);
    return down;
}

} // namespace gnomon::render
