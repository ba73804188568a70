// Time against error, a point a technique, as an SVG that reads in light and in dark surroundings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace gnomon::bench {

struct PlotPoint {
    std::string name;
    double milliseconds = 0.0;
    double wrong = 0.0;        // share of pixels
    double meanAbsolute = 0.0; // of the light's share
};

struct PlotFacts {
    std::string title, subtitle;
    std::uint64_t pixels = 0; // that were asked: no share below one of them is known
};

// Two panels below each other: wrong pixels, and mean absolute error, both on logarithmic scales.
std::string plotSvg(const PlotFacts& facts, std::span<const PlotPoint> points);

// Indices of the points that no other beats in one without losing in the other; by rising time.
std::vector<std::size_t> paretoFront(std::span<const double> time, std::span<const double> error);

} // namespace gnomon::bench
