#include "viewer/capture_plan.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

constexpr std::int64_t kMostFrames = 10'000'000;

Error usage(const char* option, const std::string& why) {
    return {option, why, ErrorKind::Usage};
}

} // namespace

Result<std::vector<PlannedFrame>> planFrames(const CaptureOptions& options,
                                             const OutputName& output, double flightSeconds) {
    const bool single = !output.isVideo() && !output.perFrame();
    if (single && options.durationSeconds)
        return usage("--duration", "one picture has none; OUT needs {frame} in its name, or a "
                                   "video's ending");
    FrameRange range;
    if (options.frames) {
        range = *options.frames;
    } else if (!single) {
        const double seconds = options.durationSeconds.value_or(flightSeconds);
        if (output.isVideo() && seconds <= 0.0)
            return usage("--duration", "a video needs a length: give --duration, --frames or a "
                                       "camera path");
        const double count = std::max(std::round(seconds * options.framesPerSecond), 1.0);
        if (count > double(kMostFrames))
            return usage("--duration", "that is more than ten million frames");
        range.last = std::int64_t(count) - 1;
    }
    const std::int64_t count = (range.last - range.first) / range.step + 1;
    if (count > kMostFrames)
        return usage("--frames", "that is more than ten million frames");
    if (single && count > 1)
        return usage("--output", std::to_string(count) +
                                     " frames do not fit into one picture; "
                                     "OUT needs {frame} in its name, or a video's ending");
    if (output.isVideo() && !options.aovs.empty())
        return usage("--aov", "goes with pictures ({frame} in OUT), not with a video");
    if (options.shard && !output.perFrame())
        return usage("--shard", "goes with pictures that have {frame} in their name");
    if (options.resume && output.isVideo())
        return usage("--resume", "goes with pictures, not with a video");
    const Shard shard = options.shard.value_or(Shard{});
    std::vector<PlannedFrame> frames;
    for (std::int64_t i = shard.number - 1; i < count; i += shard.count) {
        const std::int64_t index = range.first + i * range.step;
        frames.push_back({index, double(index) / options.framesPerSecond});
    }
    return frames;
}

} // namespace gnomon
