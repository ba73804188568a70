// Random numbers and directions for the geo tests, the same in every run.
#pragma once

#include "geo/bounds.h"

#include <cmath>
#include <random>

namespace gnomon::testing {

class Random {
  public:
    explicit Random(unsigned long seed) : engine_(seed) {}
    double in(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    // Evenly over the orders of magnitude.
    double magnitude(double low, double high) {
        return std::exp(in(std::log(low), std::log(high)));
    }
    glm::dvec3 direction() {
        const double z = in(-1.0, 1.0), turn = in(-std::numbers::pi, std::numbers::pi);
        const double r = std::sqrt(1.0 - z * z);
        return {r * std::cos(turn), r * std::sin(turn), z};
    }

  private:
    std::mt19937_64 engine_;
};

inline double widthDegrees(const Region& r) {
    const double width = r.eastDegrees - r.westDegrees;
    return width < 0.0 ? width + 360.0 : width;
}

// `u`, `v`, `w` from 0 to 1 across, up and over the region; straight from the definition.
inline Point<Ecef> pointIn(const Region& r, double u, double v, double w) {
    return ecefOf({r.westDegrees + u * widthDegrees(r),
                   r.southDegrees + v * (r.northDegrees - r.southDegrees),
                   r.minHeightMetres + w * (r.maxHeightMetres - r.minHeightMetres)});
}

// A uniform number that is often exactly 0 or 1: corners and edges are where bounds break.
inline double edgy(Random& random) {
    const double x = random.in(-0.5, 1.5);
    return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
}

inline Point<Ecef> pointIn(const Region& r, Random& random) {
    const double u = edgy(random), v = edgy(random);
    return pointIn(r, u, v, edgy(random));
}

} // namespace gnomon::testing
