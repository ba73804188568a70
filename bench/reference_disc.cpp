#include "bench/reference_disc.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon::bench {

namespace {

// A mixing of all bits into all (Steele, Lea & Flood, "Fast splittable pseudorandom number
// generators", 2014).
std::uint64_t mixed(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

// Sobol's first dimension: the digits of i behind the point, the last first.
std::uint32_t sobolFirst(std::uint32_t i) {
    std::uint32_t out = 0;
    for (std::uint32_t column = 1u << 31; i != 0; i >>= 1, column >>= 1)
        if (i & 1u)
            out ^= column;
    return out;
}

// The second: the columns of its matrix are those of Pascal's triangle modulo 2.
std::uint32_t sobolSecond(std::uint32_t i) {
    std::uint32_t out = 0;
    for (std::uint32_t column = 1u << 31; i != 0; i >>= 1, column ^= column >> 1)
        if (i & 1u)
            out ^= column;
    return out;
}

double inUnit(std::uint32_t bits) {
    return (double(bits) + 0.5) / 4294967296.0;
}

glm::vec2 discFromSquare(double u, double v) {
    const double a = 2.0 * u - 1.0, b = 2.0 * v - 1.0;
    if (a == 0.0 && b == 0.0)
        return glm::vec2(0.0f);
    constexpr double kQuarter = std::numbers::pi / 4.0;
    const bool wide = std::abs(a) > std::abs(b);
    const double radius = wide ? a : b;
    const double angle = wide ? kQuarter * (b / a) : kQuarter * (2.0 - a / b);
    return {float(radius * std::cos(angle)), float(radius * std::sin(angle))};
}

} // namespace

void discPoints(std::uint32_t pattern, std::span<glm::vec2> out) {
    if (out.size() == 1) {
        out[0] = glm::vec2(0.0f);
        return;
    }
    const std::uint64_t shift = mixed(pattern);
    for (std::uint32_t i = 0; i < out.size(); ++i)
        out[i] = discFromSquare(inUnit(sobolFirst(i) ^ std::uint32_t(shift)),
                                inUnit(sobolSecond(i) ^ std::uint32_t(shift >> 32)));
}

std::uint32_t patternOf(std::uint32_t seed) {
    // Neighbouring pixels get unlike patterns.
    return std::uint32_t(mixed(~std::uint64_t(seed))) % kDiscPatterns;
}

DiscTable::DiscTable(int rays) : rays_(std::size_t(std::max(rays, 1))) {
    points_.resize(rays_ * kDiscPatterns);
    for (std::uint32_t p = 0; p < kDiscPatterns; ++p)
        discPoints(p, std::span(points_).subspan(p * rays_, rays_));
}

} // namespace gnomon::bench
