// Where a triangle with an alpha test is clear: the rule of shaders/visibility.frag, at the
// texture's full size.
#pragma once

#include "streaming/mesh.h"

#include <glm/vec2.hpp>

#include <cstdint>

namespace gnomon::bench {

// `weights` are the barycentric coordinates of the triangle's second and third corner. `image` may
// be null.
bool isClearAt(const Mesh& mesh, const Material& look, const Image* image, std::uint32_t triangle,
               const glm::dvec2& weights);

// Alpha of an image at a place, 0…1, by GL's rules for wrapping and filtering.
double alphaAt(const Image& image, const Material& look, const glm::dvec2& uv);

} // namespace gnomon::bench
