// What the overlay says, from a scene and a moment of it.
#pragma once

#include "viewer/overlay.h"
#include "viewer/shot.h"

namespace gnomon {

// What stays from frame to frame: legends, the flood's times, credits.
OverlayFacts overlayFactsOf(const Scene& scene);

// The rest. `flatGroundMetres`: of the ground above the ellipsoid where no terrain is.
void setMoment(OverlayFacts& facts, const Scene& scene, const Shot& shot,
               std::optional<double> flatGroundMetres);

// Where the middle of the picture meets the ground, under whatever stands there; none when it looks
// past it.
std::optional<Point<Ecef>> groundAtCentre(const Camera& camera, const Scene& scene,
                                          std::optional<double> flatGroundMetres);

} // namespace gnomon
