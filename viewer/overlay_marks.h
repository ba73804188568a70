// What the overlay's marks say: numbers at ticks, the length of a scale bar, where north is.
#pragma once

#include "geo/camera.h"
#include "geo/sun.h"

#include <glm/vec2.hpp>

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

// 1, 2 or 5 times a power of ten: the least that is no less than `value`, the most that is no more.
// For what is above 0.
double niceStepAbove(double value);
double niceStepBelow(double value);

// Multiples of a nice step from `least` to `most`, at most `mostTicks` of them (two are allowed
// always).
struct Ticks {
    double step = 1.0;
    std::vector<double> values;
    // As many decimals as the step has, a true minus sign.
    std::string label(double value) const;
};
Ticks ticksBetween(double least, double most, int mostTicks);

// How long a pixel to the right at the picture's centre is on level ground there. None where a
// scale would say little: as soon as the horizon is in the picture, so that a corner looks level or
// upwards. Short of that the scale between a quarter and three quarters of the picture's height
// changes by a factor of 3 at most.
struct GroundScale {
    double metresPerPixel = 0.0;
    bool oblique = false; // at the picture's edges it is off by more than a tenth
};
std::optional<GroundScale> groundScale(const Camera& camera, Point<Ecef> groundAtCentre);

// The longest bar of a nice length that is no longer than `mostPixels`.
struct ScaleBar {
    double pixels = 0.0;
    std::string label; // "200 m", "5 km"
};
std::optional<ScaleBar> scaleBar(double metresPerPixel, double mostPixels);

// A level plate with the compass on it, as this camera sees it: where a unit step to the north and
// to the east goes, right and up in the picture. Seen flatter than 25 degrees, or from below, it is
// drawn as if from 25 degrees above, so that it can be read.
struct CompassAxes {
    glm::dvec2 north{0.0, 1.0}, east{1.0, 0.0};
};
CompassAxes compassAxes(const Camera& camera);

std::string sunText(double azimuthDegrees, double elevationDegrees);

} // namespace gnomon
