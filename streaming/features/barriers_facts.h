// From the lines and polygons of a file to barriers: how high, how wide, over which time they
// stand; what is missing is assumed, and said.
#pragma once

#include "streaming/features/barriers.h"

#include <cstdint>

namespace gnomon {

// How high the crest is.
enum class CrestFrom : std::uint8_t {
    Ground, // `metres` above the ground all along
    Level,  // level, at `metres` above the ellipsoid
    Shape,  // where the vertices themselves are
};

enum class BarrierMaterial : std::uint8_t { Wall, Earth, Sand };

struct BarrierFacts {
    std::string id;
    bool isArea = false;
    FeaturePart rings; // of a line: one
    CrestFrom crest = CrestFrom::Ground;
    double metres = 0.0;
    double widthMetres = 0.0; // of a line
    BarrierMaterial material = BarrierMaterial::Wall;
    std::optional<UtcTime> from, until;
};

// One for each line and each polygon; notes and what is left out go into `file`.
std::vector<BarrierFacts> barriersOf(FeatureFile& file, const BarrierOptions& options);

// Says so in `file`.
void leaveOutBarrier(FeatureFile& file, const std::string& id, const std::string& why);

} // namespace gnomon
