#include "streaming/features/vertex_color.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

std::uint32_t linear8(double srgb, double shade) {
    const double linear = srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
    return std::uint32_t(std::lround(255.0 * std::clamp(linear * shade, 0.0, 1.0)));
}

} // namespace

std::uint32_t linearRgba(const glm::dvec3& srgb, double shade) {
    return linear8(srgb.r, shade) | linear8(srgb.g, shade) << 8 | linear8(srgb.b, shade) << 16 |
           0xff000000u;
}

} // namespace gnomon
