// Shadows that flicker: the surfaces of one frame are asked again while the camera moves by less
// than a texel. Nothing in the scene moves, so that nothing may change, as long as a surface is
// looked up in the same map.
#pragma once

#include "viewer/frame.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace gnomon::bench {

struct Flips {
    std::uint64_t flips = 0; // answers that changed by more than 1/255 from one step to the next
    std::uint64_t asked = 0; // of so many asked in the same cascade, unmixed, before shadows fade
};

// The frames along a path, the first one's surfaces asked in all. `request` brings all but the
// camera; `goOn` is asked before each frame.
Result<Flips> countFlips(FrameRenderer& renderer, const FrameRequest& request,
                         const ShadowSettings& settings, std::span<const Camera> path,
                         const std::function<bool()>& goOn);

// A small motion: as a hand-held camera, forward and turning by steps far below a texel.
std::vector<Camera> smallMotion(const Camera& from, int steps);

} // namespace gnomon::bench
