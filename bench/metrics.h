// How wrong a technique's picture of the light is, against the reference. Every figure is defined
// in docs/shadows.md, "How error is measured".
#pragma once

#include "bench/reference.h"
#include "bench/scenes.h"

#include <optional>
#include <vector>

namespace gnomon::bench {

// A technique's answer, a value a pixel, rows top to bottom.
struct Answer {
    std::vector<float> visibility; // 0…1, -1 sky
    std::vector<float> texels; // metres across a texel in the light's plane; 0: beyond the shadows
    double filterRadiusTexels = 0.0;
    bool soft = true; // held against the whole disc, else against its centre
};

struct Metrics {
    std::uint64_t pixels = 0;                 // with a surface
    std::uint64_t litFacing = 0;              // of these, facing the light and within shadow range
    double band = 0.0;                        // share of litFacing in the edge band
    double falseLit = 0.0, falseShadow = 0.0; // outside the band, of litFacing
    double falseLitAll = 0.0, falseShadowAll = 0.0; // in the whole picture
    double meanAbsolute = 0.0, rootMeanSquare = 0.0;
    double acne = 0.0, leak = 0.0;
    std::optional<double> edgePixels;         // none where no edge is in the picture
    std::optional<double> penumbraError;      // relative, where probes span 4 texels or more
    std::optional<double> penumbraTexels;     // the drawn width elsewhere, the widest
    std::optional<double> peterPanningMetres; // the largest of the contact probes
};

// What became of a pixel, for the pictures in false colour.
enum class Verdict : std::uint8_t {
    NotAsked,
    Right,
    FalseLit,
    FalseShadow,
    FalseLitInBand,
    FalseShadowInBand
};

struct Comparison {
    Metrics metrics;
    std::vector<Verdict> verdicts;
};

Comparison compare(const RayScene& rays, const Reference& reference, const Light& light,
                   const Answer& answer, const Camera& camera, std::span<const Probe> probes,
                   const Transform<Ecef, Enu>& ecefFromProbes);

} // namespace gnomon::bench
