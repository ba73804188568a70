// A lamp: a point that lights a half space or all round, and casts shadows.
#pragma once

#include "geo/frames.h"

#include <glm/vec3.hpp>

namespace gnomon {

struct Lamp {
    Point<Ecef> position;
    // Unit: lights only the half space this points into, as a street lamp does, fading in over the
    // first 5° of it. Zero: all round.
    Vector<Ecef> facing{{0, 0, 0}};
    double nearMetres = 0.05;  // what is nearer casts nothing: the lamp's own housing
    double rangeMetres = 50.0; // its light has faded out there
    glm::vec3 power{100.0f};   // linear; what reaches a surface facing it 1 m away
};

// Lamps that are lit at once take no more hemispheres' maps than this (all round: two): at the
// default size 134 MB, what two suns' cascades take. The others stay dark.
inline constexpr int kMaxLampHemispheres = 32;

} // namespace gnomon
