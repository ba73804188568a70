// The axes that shadow maps are drawn along. They belong to the scene's anchor and the sun, never
// to the camera, so that a caster falls on the same texels from wherever it is looked at.
#pragma once

#include "geo/frames.h"

namespace gnomon {

// Right, up, towards the sun, as columns, in the frame of `towardsSun` (unit). Orthonormal to
// rounding and continuous everywhere but for a sun in the nadir (Duff et al., "Building an
// orthonormal basis, revisited", 2017, with its one branch turned to where no sun shines from).
glm::dmat3 lightAxes(const glm::dvec3& towardsSun);

// Origin at the anchor.
Transform<Light, Ecef> lightFromEcef(const Transform<Ecef, Enu>& ecefFromAnchor,
                                     Vector<Ecef> towardsSun);

} // namespace gnomon
