// How many metres the constant bias and the dual layers are, from the texel and the filter.
#pragma once

#include "shadows/settings.h"

namespace gnomon {

// Tan of the angle to the sun, 84°, up to which biases by the slope follow it (STEEPEST in
// sun.frag): where the sun grazes they tend to infinity.
inline constexpr double kSteepestSlope = 9.5;

// What a plane at an angle rises, towards the sun, over the farthest texel that the filter reads:
// its centre may be half a texel beyond the filter's radius, in x and in y.
double riseMetres(const ShadowSettings& settings, double texelMetres, double tanAngle);

// ShadowBias::Constant: as given, or enough for planes at up to 45° to the sun. 0 of the others.
double constantBiasMetres(const ShadowSettings& settings, double texelMetres);

// What the nearest layer is moved away from the sun at most: as given, or enough for planes at up
// to 84°; half the gap to the second bounds it anyway, so too much harms little, too little does.
// Without bound for ShadowBias::Midpoint.
double layerOffsetMetres(const ShadowSettings& settings, double texelMetres);

} // namespace gnomon
