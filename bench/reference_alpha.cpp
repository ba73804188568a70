#include "bench/reference_alpha.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon::bench {

namespace {

// Texel `i` of `size`, as GL's wrap modes fold it (OpenGL 4.5 core, table 8.20).
int wrapped(double i, int size, Wrap mode) {
    const auto modulo = [](double x, double period) { return x - period * std::floor(x / period); };
    double out = i;
    switch (mode) {
    case Wrap::Repeat:
        out = modulo(i, size);
        break;
    case Wrap::MirroredRepeat: {
        const double back = modulo(i, 2.0 * size) - size;
        out = size - 1 - (back >= 0.0 ? back : -1.0 - back);
        break;
    }
    case Wrap::ClampToEdge:
        break;
    }
    return int(std::clamp(out, 0.0, double(size - 1)));
}

double texel(const Image& image, const Material& look, double x, double y) {
    const auto column = std::size_t(wrapped(x, image.width, look.wrapS));
    const auto row = std::size_t(wrapped(y, image.height, look.wrapT));
    return image.rgba[4 * (row * std::size_t(image.width) + column) + 3] / 255.0;
}

} // namespace

double alphaAt(const Image& image, const Material& look, const glm::dvec2& uv) {
    if (image.rgba.empty() || !std::isfinite(uv.x) || !std::isfinite(uv.y))
        return 1.0;
    const double x = uv.x * image.width, y = uv.y * image.height;
    if (look.nearestFilter)
        return texel(image, look, std::floor(x), std::floor(y));
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const double fx = x - 0.5 - left, fy = y - 0.5 - top;
    const auto row = [&](double j) {
        return (1.0 - fx) * texel(image, look, left, j) + fx * texel(image, look, left + 1.0, j);
    };
    return (1.0 - fy) * row(top) + fy * row(top + 1.0);
}

bool isClearAt(const Mesh& mesh, const Material& look, const Image* image, std::uint32_t triangle,
               const glm::dvec2& weights) {
    const std::array<double, 3> share{1.0 - weights.x - weights.y, weights.x, weights.y};
    double alpha = double(look.baseColor.a), corner = 0.0;
    glm::dvec2 uv(0.0);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t i = mesh.indices[3 * std::size_t(triangle) + k];
        if (!mesh.uvs.empty())
            uv += share[k] * glm::dvec2(mesh.uvs[i]);
        corner += share[k] * (mesh.colors.empty() ? 1.0 : double(mesh.colors[i] >> 24) / 255.0);
    }
    alpha *= corner;
    if (image)
        alpha *= alphaAt(*image, look, uv);
    return alpha < double(look.alphaCutoff);
}

} // namespace gnomon::bench
