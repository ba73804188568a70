// Well spread points on the sun's disc.
#pragma once

#include <glm/vec2.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::bench {

// The first points of Sobol's sequence in two dimensions, shifted digit by digit by `pattern`,
// which keeps every one of its strata filled (Kollig & Keller, "Efficient multidimensional
// sampling", 2002), mapped to the unit disc (Shirley & Chiu, "A low distortion map between disk and
// square", 1997). One point is the centre.
void discPoints(std::uint32_t pattern, std::span<glm::vec2> out);

// Few enough patterns for tables to stay in a processor's cache, and more than neighbours a pixel
// could look like.
inline constexpr std::uint32_t kDiscPatterns = 256;
std::uint32_t patternOf(std::uint32_t seed); // below kDiscPatterns

// All patterns of so many points.
class DiscTable {
  public:
    explicit DiscTable(int rays);
    std::span<const glm::vec2> points(std::uint32_t seed) const {
        return std::span(points_).subspan(patternOf(seed) * rays_, rays_);
    }

  private:
    std::size_t rays_;
    std::vector<glm::vec2> points_;
};

} // namespace gnomon::bench
