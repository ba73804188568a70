// How high the ground is, whatever it is made from: what houses, trees, walls and lamps stand on,
// and what water covers.
#pragma once

#include <glm/vec2.hpp>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace gnomon {

class GroundHeights {
  public:
    virtual ~GroundHeights() = default;
    // `lonLat` in degrees; out: metres above the WGS 84 ellipsoid at the data's full resolution,
    // linear between its points, NaN where it has none. From several threads at once.
    virtual void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const = 0;

    // West, south, east, north in degrees around all it has, where that is known.
    virtual std::optional<std::array<double, 4>> extent() const { return std::nullopt; }

    double at(glm::dvec2 lonLat) const;
};

// The same height everywhere.
std::shared_ptr<const GroundHeights> flatGround(double heightMetres);
// The first of these that has a height at a place tells it.
std::shared_ptr<const GroundHeights>
stackedGround(std::vector<std::shared_ptr<const GroundHeights>> grounds);

// `ground` inside the rings (degrees; even-odd, so holes are rings too), none outside.
std::shared_ptr<const GroundHeights> groundWithin(std::shared_ptr<const GroundHeights> ground,
                                                  std::vector<std::vector<glm::dvec2>> rings);

} // namespace gnomon
