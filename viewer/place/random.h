// Random numbers that are the same on every machine and compiler (the distributions of <random> are
// not). SplitMix64: Steele, Lea & Flood, "Fast splittable pseudorandom number generators", 2014.
#pragma once

#include <cstdint>

namespace gnomon::builtin {

inline std::uint64_t mix64(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
}

// One number for a seed and a lattice point; `salt` tells uses apart.
inline std::uint64_t hash(std::uint64_t seed, std::int64_t x, std::int64_t y, std::uint64_t salt) {
    std::uint64_t h = mix64(seed + 0x9e3779b97f4a7c15ull * (salt + 1));
    h = mix64(h ^ (std::uint64_t(x) * 0x9e3779b97f4a7c15ull));
    return mix64(h ^ (std::uint64_t(y) * 0xc2b2ae3d27d4eb4full));
}

// [0, 1) from the upper 53 bits.
inline double unitOf(std::uint64_t h) {
    return double(h >> 11) * 0x1p-53;
}

class Random {
  public:
    explicit Random(std::uint64_t state) : state_(state) {}

    double unit() { return unitOf(mix64(state_ += 0x9e3779b97f4a7c15ull)); }
    double in(double low, double high) { return low + (high - low) * unit(); }
    bool chance(double probability) { return unit() < probability; }
    // 0 … n-1
    int pick(int n) { return int(unit() * n); }

  private:
    std::uint64_t state_;
};

// Smooth noise in [0, 1] with lattice spacing 1.
double valueNoise(std::uint64_t seed, double x, double y);

inline double smoothstep(double from, double to, double x) {
    const double t = (x - from) / (to - from);
    return t <= 0 ? 0 : t >= 1 ? 1 : t * t * (3 - 2 * t);
}
inline double mix(double a, double b, double t) {
    return a + (b - a) * t;
}

} // namespace gnomon::builtin
