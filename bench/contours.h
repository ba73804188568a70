// How far apart two pictures of the same surfaces have their edges: the contours where a value
// crosses one half, placed between pixels by linear interpolation.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gnomon::bench {

// Which neighbours a contour may run between: those that see the same surface.
enum LinkBits : std::uint8_t { kLinkRight = 1, kLinkBelow = 2 };

struct Contours {
    int width = 0, height = 0;
    std::span<const std::uint8_t> links; // LinkBits a pixel
};

// No distance counts for more than this many pixels; a contour that has no counterpart this near
// is wrong, and how far it is from the next one says nothing.
inline constexpr double kMostEdgePixels = 32.0;

// The mean distance in pixels from each contour to the nearest of the other picture's, the mean of
// both ways; none where neither picture has one.
std::optional<double> contourDistance(const Contours& where, std::span<const float> a,
                                      std::span<const float> b);

} // namespace gnomon::bench
