// The texels of a tile as a drape sees them: a smooth grid of places, so that few of them need to
// be transformed exactly.
#pragma once

#include <glm/vec2.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace gnomon {

// Turns places into others where they stand; NaN for what has none.
using ExactPlaces = std::function<void(std::vector<glm::dvec2>& places)>;

// `exact` of every texel's place, most of them interpolated: off by at most an eighth of the way to
// the next texel, or of `fineEnough` where that is more. Where the map is too bent for that, or
// torn (the antimeridian), every texel is asked for.
std::vector<glm::dvec2> mappedTexels(std::span<const glm::dvec2> texels, int width,
                                     const ExactPlaces& exact, double fineEnough);

// Paints `color` over the texel at `rgba`, as far as `share` (0…1) covers it.
void paintOver(std::uint8_t* rgba, const double color[3], double share);

} // namespace gnomon
