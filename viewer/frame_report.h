// The frame report: what every frame needed and cost, as JSON.
#pragma once

#include "viewer/frame.h"
#include "viewer/options.h"

#include <string>
#include <vector>

namespace gnomon {

struct ReportedFrame {
    std::int64_t index = 0;
    std::optional<UtcTime> time; // none when the sun was set by angles
    Camera camera;
    SunPosition sun;
    FrameFacts facts;
    std::vector<std::string> files;     // written; empty when the frame was given up
    std::vector<std::string> tileNames; // by the ids in the tile picture, when that was asked for
};

struct FrameReport {
    std::string renderer;
    std::string settingsHash;
    std::vector<ReportedFrame> frames;
    std::vector<std::int64_t> kept; // frames that were there already (--resume)
    std::vector<Error> skipped;
    std::vector<std::string> credits;   // of the data shown
    std::optional<double> fullDetailMs; // from the start to the first complete frame

    std::string json() const;
};

// Of all that decides how a frame looks, but for the inputs' bytes.
std::string settingsHash(const PictureOptions& options);
std::string settingsHash(const CaptureOptions& options); // and of what is written beside it

// The most memory this process has had, MB (10^6 bytes); 0 where it is not known.
double peakResidentMegabytes();

} // namespace gnomon
