// Colours of sun, sky and haze for the sun's height: simple, monotone and continuous through
// sunset, so that a flight through the day never jumps. Not a sky model; a plain look that agrees
// with the sun.
#pragma once

#include "geo/camera.h"
#include "geo/sun.h"
#include "shaders/interface.h"

namespace gnomon {

// Directions come along `meshAxes` (columns, in ECEF), as the visibility pass has its normals.
shader::LookBlock daylight(const SunPosition& sun, const Camera& camera,
                           const glm::dmat3& meshAxes);

// What `daylight` multiplies all light by, as the eye opens in the dark: for light of other
// sources.
double eyeOpening(double sunElevationDegrees);

// Share of the sun's disc above the horizon of an eye at this height, 0…1.
double sunShareAboveHorizon(double elevationDegrees, double eyeHeightMetres);

} // namespace gnomon
