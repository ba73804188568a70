// Colours for numbers: each map's lightness runs one way only, so that it reads the same for the
// colour-blind and in grey (Crameri et al., "The misuse of colour in science communication", 2020).
#pragma once

#include <glm/vec3.hpp>

namespace gnomon {

enum class ColorMap {
    Depth,     // of water: pale to deep blue
    Speed,     // yellow to dark violet
    Elevation, // deep green through ochre to near white
};

// sRGB, 0…1; `share` is cut to 0…1.
glm::vec3 colorAt(ColorMap map, double share);

} // namespace gnomon
