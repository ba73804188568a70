// Colours of vertices as Mesh::colors has them.
#pragma once

#include <glm/vec3.hpp>

#include <cstdint>

namespace gnomon {

// `srgb` as on a screen, 0…1; `shade` of it as light, cut to what 8 bits hold.
std::uint32_t linearRgba(const glm::dvec3& srgb, double shade = 1.0);

} // namespace gnomon
