// How wrong a technique's picture of the light is, against the reference. Every figure is defined
// in docs/shadows.md, "How error is measured".
//
// Asked are the pixels whose surface faces the light and lies in shadow range; all shares are of
// these. A technique is held against V, the share of the light that arrives, or, when it draws hard
// shadows, against one ray to the light's centre. Wrong are V = 0 drawn as ½ or more (false lit)
// and V = 1 drawn as less (false shadow). The edge band is what lies within a texel and the
// filter's radius, measured in the light's plane, of a change of V.
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
    // Metres along the view axis of what it saw, or empty. A pixel where that is another surface
    // than the ray's, as at silhouettes, is not asked.
    std::vector<float> viewDepths;
    double filterRadiusTexels = 0.0;
    bool soft = true; // held against the whole disc, else against its centre
};

struct Metrics {
    std::uint64_t pixels = 0;    // with a surface
    std::uint64_t litFacing = 0; // of these, facing the light and within shadow range
    // Share of litFacing in the edge band: of kBandSamples pixels spread evenly, so known to a
    // third of a percent (one standard deviation) or better; exact for smaller pictures.
    double band = 0.0;
    double falseLit = 0.0, falseShadow = 0.0;       // outside the band, of litFacing
    double falseLitAll = 0.0, falseShadowAll = 0.0; // in the whole picture
    double meanAbsolute = 0.0, rootMeanSquare = 0.0;
    // Of what is false outside the band: shadow without any reference shadow within 2 texels,
    // light within 2 texels of an occluder's contact.
    double acne = 0.0, leak = 0.0;
    // Mean distance of the contours of V = ½, a contour without a counterpart counted as
    // kMostEdgePixels (bench/contours.h); none where no edge is in the picture.
    std::optional<double> edgePixels;
    // Of the probes' widths from 90 % to 10 %: the largest relative error where the penumbra spans
    // 4 texels or more; the widest drawn one elsewhere, in texels; and of the contact probes how
    // far from the occluder shadow begins, at most.
    std::optional<double> penumbraError;
    std::optional<double> penumbraTexels;
    std::optional<double> peterPanningMetres;
};

inline constexpr std::size_t kBandSamples = 20000;

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
