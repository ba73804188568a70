#include "streaming/color_map.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <span>

namespace gnomon {

namespace {

// At equal steps of the number; lightness (CIE L*) falls or rises by about the same from one to the
// next.
constexpr glm::vec3 kDepth[] = {{0.80f, 0.91f, 0.97f}, {0.62f, 0.80f, 0.92f}, {0.43f, 0.68f, 0.85f},
                                {0.26f, 0.55f, 0.76f}, {0.13f, 0.42f, 0.66f}, {0.06f, 0.29f, 0.52f},
                                {0.03f, 0.17f, 0.36f}};
constexpr glm::vec3 kSpeed[] = {{0.99f, 0.91f, 0.60f}, {0.98f, 0.74f, 0.43f}, {0.94f, 0.55f, 0.36f},
                                {0.84f, 0.36f, 0.38f}, {0.66f, 0.22f, 0.44f}, {0.44f, 0.13f, 0.44f},
                                {0.22f, 0.07f, 0.34f}};
constexpr glm::vec3 kElevation[] = {
    {0.20f, 0.34f, 0.24f}, {0.33f, 0.46f, 0.28f}, {0.52f, 0.57f, 0.34f}, {0.68f, 0.65f, 0.42f},
    {0.78f, 0.71f, 0.53f}, {0.86f, 0.81f, 0.70f}, {0.95f, 0.94f, 0.91f}};

std::span<const glm::vec3> keysOf(ColorMap map) {
    switch (map) {
    case ColorMap::Depth:
        return kDepth;
    case ColorMap::Speed:
        return kSpeed;
    case ColorMap::Elevation:
        break;
    }
    return kElevation;
}

} // namespace

glm::vec3 colorAt(ColorMap map, double share) {
    const std::span<const glm::vec3> keys = keysOf(map);
    const double at =
        std::clamp(std::isnan(share) ? 0.0 : share, 0.0, 1.0) * double(keys.size() - 1);
    const auto i = std::min(std::size_t(at), keys.size() - 2);
    return glm::mix(keys[i], keys[i + 1], float(at - double(i)));
}

} // namespace gnomon
