// Which frames a capture draws, and at which second of the flight each is.
#pragma once

#include "viewer/options.h"
#include "viewer/output_name.h"

#include <vector>

namespace gnomon {

struct PlannedFrame {
    std::int64_t index = 0;
    double seconds = 0.0;
};

// `flightSeconds`: of the camera path, 0 when there is none. A flight of D seconds has D · fps
// frames, at least one. Fails (Usage) when several frames would go into one picture, and for a
// shard or a resumed run of what is no row of pictures. A shard may have no frames.
Result<std::vector<PlannedFrame>> planFrames(const CaptureOptions& options,
                                             const OutputName& output, double flightSeconds);

} // namespace gnomon
