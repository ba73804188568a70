// What a user may choose about shadows. Plain values; the defaults need no tuning for any scene.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "geo/result.h"

namespace gnomon {

// Single: one map for all. PlaneOptimal: cascades, and for the planes that fill most of the picture
// maps that sample them as the eye does (shadows/projective.h). Perspective: one map in the eye's
// own perspective.
enum class ShadowMethod { Off, Single, Cascades, PlaneOptimal, Perspective };
// What keeps a surface from shading itself.
enum class ShadowBias {
    Constant,      // so many metres towards the sun
    Slope,         // what the receiver rises within the filter's radius, by its slope
    Normal,        // the receiver moved along its normal by as much
    ReceiverPlane, // each texel compared at its own centre with the receiver's plane
                   // (shaders/sun.frag)
    FrontFace,     // the same, and of closed components the maps hold the faces turned away
    Midpoint,      // maps half way between the two nearest layers (Woo, 1992)
    DualPeel,      // maps behind the nearest layer by half the gap to the second, at most a little
    DualAtomic,    // (Weiskopf & Ertl, 2003); in two passes, or in one by atomics
};
// Which faces of casters are left out of the maps. Auto: back faces of closed components, which
// nothing sees from the sun; nothing of open ones. FrontOfClosed is FrontFace's.
enum class ShadowCull { Auto, None, Front, Back, FrontOfClosed };
// Jitter: 4 x 4 taps jittered by the lattice cell (Weiskopf & Ertl). PcssRatio: the penumbra
// divided by the blocker's distance, as for a near light (Fernando, 2005): wrong for the sun, to
// compare.
enum class ShadowFilter { None, Bilinear, Jitter, Pcf, Pcss, PcssRatio };
// Stable: spheres around the slices, still while the camera turns. Tight: the receivers really
// seen; sharper, but its texels change with every frame.
// Auto: tight for a picture that stands alone, stable for one of many in motion.
enum class ShadowFit { Auto, Stable, Tight };
// How lamps cast: one paraboloid map a hemisphere, or six faces of a cube.
enum class LampMethod { Off, Paraboloid, Cube };

inline constexpr int kMaxCascades = 5;
inline constexpr int kMaxPlanes = 8;

struct ShadowSettings {
    ShadowMethod method = ShadowMethod::Cascades;
    ShadowBias bias = ShadowBias::ReceiverPlane;
    ShadowCull cull = ShadowCull::Auto; // overrides what the bias asks for
    // Constant's bias; the most that the dual layers move. By the texel and the filter when not
    // given.
    std::optional<double> biasMetres;
    ShadowFilter filter = ShadowFilter::Pcss;
    int pcfWidth = 3;        // taps across, 1…9
    int blockerSamples = 16; // PCSS
    int filterSamples = 32;
    int cascades = 4;   // 1…5
    int mapSize = 2048; // texels across, 512…8192
    double splitLambda = 0.85;
    std::optional<double> rangeMetres; // how far from the eye shadows reach; fitted when not given
    std::optional<double> fadeMetres;  // over the last of which they fade; a tenth of the range
    double blendFraction = 0.1;        // of a cascade, mixed with the next
    double lightDiameterDegrees = 0.533;
    ShadowFit fit = ShadowFit::Auto;
    int planes = 1; // of interest, PlaneOptimal
    LampMethod lamps = LampMethod::Paraboloid;
    // Paraboloid maps bend straight edges: triangles are cut until none is off by more than so many
    // texels; 0 does not cut.
    double lampEdgeTexels = 0.5;
};

// The command line's words, as in kMethods and its like (settings.cpp): "csm", "plane-optimal:3";
// "constant:0.5"; "pcf:5", "pcss:16,32". A failure changes nothing and names the choices.
Failure parseShadowMethod(const std::string& text, ShadowSettings& settings);
Failure parseShadowBias(const std::string& text, ShadowSettings& settings);
Failure parseShadowFilter(const std::string& text, ShadowSettings& settings);
Result<ShadowCull> parseShadowCull(const std::string& text);
Result<ShadowFit> parseShadowFit(const std::string& text);
// A whole technique, shadows+bias+filter, of which the last two may be left out:
// "csm+dual-peel+pcss:16,32", "csm+pcf:3". Also a lamps' technique: "paraboloid", "cube".
Failure parseTechnique(const std::string& text, ShadowSettings& settings);
// A row a word that parseTechnique takes for each part, and what it is: for --list and --help.
struct TechniqueWord {
    enum class Part { Shadows, Bias, Filter, Lamps } part;
    const char *word, *meaning;
};
std::span<const TechniqueWord> techniqueWords();
// Its name, as parseTechnique takes it, and what else differs from the defaults.
std::string describe(const ShadowSettings& settings);
std::string nameOf(ShadowBias bias);
std::string filterText(const ShadowSettings& settings);
std::string methodText(const ShadowSettings& settings);

// Which faces go into the maps: of the bias, unless `cull` says otherwise.
ShadowCull cullOf(const ShadowSettings& settings);
// Half the width of what the filter reads, in texels; of PCSS its least.
double filterRadiusTexels(const ShadowSettings& settings);
// The receiver's plane decides, texel by texel; else one bias for all of them.
bool comparesWithPlane(ShadowBias bias);
bool hasTwoLayers(ShadowBias bias);

} // namespace gnomon
