// What is written over a captured picture: the time and the sun, legends of what is coloured by
// number, a scale bar, where north is, and whose data it is. On dark plates along the edges; never
// in the middle (from 30 to 70 % of width and height). A pure function of the facts: the same give
// the same bytes.
//
// Sizes go with the picture's. What finds no room at a legible size is left out: the scale bar and
// the compass silently, legends and credits are named.
#pragma once

#include "geo/camera.h"
#include "geo/time.h"
#include "streaming/color_map.h"
#include "viewer/font.h"
#include "viewer/frame.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct Legend {
    std::string title, unit;        // "Water depth", "m"
    double least = 0.0, most = 0.0; // of the colours; without a range there is no bar, only words
    ColorMap map = ColorMap::Depth;
    bool beyond = false;       // the last colour also stands for all that is more
    bool interpolated = false; // between a few points: it is said
    bool operator==(const Legend&) const = default;
};

// When the flood begins and ends.
struct FloodTimes {
    UtcTime first, last;
};

struct OverlayFacts {
    Camera camera;
    SunAngles sun;
    std::optional<UtcTime> time;
    std::optional<std::string> timeZone; // as in ZonedTime
    std::optional<Point<Ecef>> groundAtCentre;
    std::vector<Legend> legends;
    std::optional<FloodTimes> flood;
    std::vector<std::string> credits;
};

class Overlay {
  public:
    // Fails when there is no font.
    static Result<std::unique_ptr<Overlay>> create();
    explicit Overlay(std::unique_ptr<Font> font) : font_(std::move(font)) {}

    // Gives what found no room: "the legend of Water depth", "the credits".
    std::vector<std::string> draw(Picture& picture, const OverlayFacts& facts) const;

  private:
    std::unique_ptr<Font> font_;
};

// Of text for a picture of this size, in pixels: 1/45 of its height, no less than 11.
int overlayTextPixels(int width, int height);

} // namespace gnomon
