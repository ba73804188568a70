// Cascades fitted to what is really seen (Lauritzen, Salvi & Lefohn, "Sample distribution shadow
// maps", 2011): near and far from the nearest and farthest surface in the picture, and for each
// cascade the smallest square of the light's plane that holds its surfaces. Sharper than spheres
// around slices, most of all at street level. A slice of a view from above is a strip, many times
// longer than deep: the lattice is turned so that strips lie along it, and a map may be up to four
// times as wide as high, or as high as wide, of as many texels. Near, far, texels and the turn
// stand on ladders and windows on the lattice, so that rounding changes nothing; but a moving
// camera changes rungs every few frames.
#pragma once

#include "shadows/cascades.h"

#include <span>
#include <vector>

namespace gnomon {

// The surfaces in a picture, gathered by view depth.
struct SeenReceivers {
    struct Bin {
        double nearMetres = 0.0, farMetres = 0.0; // of the surfaces in it; no surface: far < near
        LightBox bounds;
        double lowestMetres = 0.0; // above the anchor's horizontal
    };
    std::vector<Bin> bins; // ascending
};

// `viewDepth`: metres along the view axis, rows top to bottom, +inf where there is sky; surfaces
// beyond `rangeMetres` of view depth are left out.
SeenReceivers seenReceivers(const Camera& camera, std::span<const float> viewDepth,
                            const Transform<Light, Ecef>& lightFromEcef,
                            const Transform<Light, Enu>& lightFromAnchor, double rangeMetres);

// The light's axes turned about the light, until the camera's right (or, where the sun shines along
// it, its forward) runs along one of them.
Transform<Light, Light> turnedTowards(const Camera& camera,
                                      const Transform<Light, Ecef>& lightFromEcef);

// Around the surfaces as much is kept as the widest penumbra there may reach: of the highest caster
// on the lowest surface. As fitCascades where nothing is seen.
CascadeSet fitTightCascades(const CascadeInput& input, const ShadowSettings& settings,
                            const SeenReceivers& seen, const CasterBound& casters);

} // namespace gnomon
