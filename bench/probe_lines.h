// What a probe's line sees of a picture: the shadow's value along it, and what is read off that.
#pragma once

#include "bench/reference.h"
#include "bench/scenes.h"

#include <optional>
#include <span>
#include <vector>

namespace gnomon::bench {

// Values along a line, in order; a place that the camera does not see is left out.
struct ProbeSamples {
    std::vector<double> metres; // from the line's start
    std::vector<double> reference, drawn;
    double texelMetres = 0.0;   // of the map, at the middle sample
    double lightPerMetre = 1.0; // of the light's plane along a metre of the line
};

struct ProbePictures {
    const RayScene& rays;
    const Reference& reference;
    std::span<const float> truth, drawn, texels; // a value a pixel
    const Camera& camera;
    const Light& light;
};

// Both pictures are read bilinearly, of the pixels that see the surface the line lies on.
ProbeSamples sampleProbe(const ProbePictures& pictures, const Probe& probe,
                         const Transform<Ecef, Enu>& ecefFromProbes);

// The way on which values fall from 0.9 to 0.1; none when they do not.
std::optional<double> fallWidth(std::span<const double> metres, std::span<const double> values);
// Where values are below one half for the first time; the whole line's length when never.
double shadowStart(std::span<const double> metres, std::span<const double> values);

// Of a straight edge under a disc of even light, the share of the penumbra's full width that lies
// between 10 % and 90 %: the solution of ½ + (x √(1−x²) + asin x) / π = 0.9.
inline constexpr double kFallShareOfPenumbra = 0.6870;

} // namespace gnomon::bench
