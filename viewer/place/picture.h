// The place's pictures: the ground seen from above, and two facades.
#pragma once

#include "geo/result.h"
#include "viewer/place/plan.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gnomon::builtin {

// sRGB, with four channels also alpha (not multiplied in); rows from north to south.
struct Pixels {
    int size = 0, channels = 3;
    std::vector<std::uint8_t> rgb;

    explicit Pixels(int across = 0, int perPixel = 3)
        : size(across), channels(perPixel), rgb(std::size_t(across) * across * perPixel, 0) {}
    std::uint8_t* at(int x, int y) { return &rgb[(std::size_t(y) * size + x) * channels]; }
    const std::uint8_t* at(int x, int y) const {
        return &rgb[(std::size_t(y) * size + x) * channels];
    }
};

inline constexpr int kGroundPixels = 512;

// Fills the part of `pixels` (which shows `shown`) that lies in the cell.
void paintGround(Pixels& pixels, const Rect& shown, const Plan& plan, const Cell& cell);
// `child` at half its size into quarter (east, north) of `parent`.
void shrinkInto(Pixels& parent, const Pixels& child, bool east, bool north);

// 4 bays by 4 storeys that repeat; white walls (vertex colours tint them), white at the corner.
Pixels facadePixels(Facade facade, std::uint64_t seed);

Result<std::vector<std::byte>> encodeJpeg(const Pixels& pixels, int quality);
Result<std::vector<std::byte>> encodePng(const Pixels& pixels);

} // namespace gnomon::builtin
