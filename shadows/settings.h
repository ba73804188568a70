// What a user may choose about shadows. Plain values; the defaults need no tuning for any scene.
#pragma once

#include <optional>
#include <string>

#include "geo/result.h"

namespace gnomon {

enum class ShadowMethod { Off, Single, Cascades };
// What keeps a surface from shading itself. ReceiverPlane: each texel is compared at its own centre
// with the receiver's plane (shaders/sun.frag). FrontFace: the same, and of closed components the
// maps hold the faces turned away from the sun.
enum class ShadowBias { ReceiverPlane, FrontFace };
// Which faces of casters are left out of the maps. Auto: back faces of closed components, which
// nothing sees from the sun; nothing of open ones. FrontOfClosed is FrontFace's.
enum class ShadowCull { Auto, None, Front, Back, FrontOfClosed };
enum class ShadowFilter { None, Bilinear, Pcf, Pcss };

inline constexpr int kMaxCascades = 5;

struct ShadowSettings {
    ShadowMethod method = ShadowMethod::Cascades;
    ShadowBias bias = ShadowBias::ReceiverPlane;
    ShadowCull cull = ShadowCull::Auto; // overrides what the bias asks for
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
};

// The command line's words: "csm", "off", "single"; "none", "bilinear", "pcf:5", "pcss:16,32".
Result<ShadowMethod> parseShadowMethod(const std::string& text);
Failure parseShadowFilter(const std::string& text, ShadowSettings& settings);
Result<ShadowBias> parseShadowBias(const std::string& text); // "receiver-plane", "frontface"
Result<ShadowCull> parseShadowCull(const std::string& text);
// Of the bias, unless `cull` says otherwise.
ShadowCull cullOf(const ShadowSettings& settings);
std::string describe(const ShadowSettings& settings);

} // namespace gnomon
