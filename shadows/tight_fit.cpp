#include "shadows/tight_fit.h"

#include "shadows/splits.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gnomon {

namespace {

// Bins a factor of 2^(1/8) wide in view depth, from 1/8 m to 2^25 m: beyond the Earth's size. A
// split within a bin takes the whole bin into both cascades.
constexpr int kBinsPerOctave = 8;
constexpr int kLowestOctave = -3, kOctaves = 28;
constexpr int kBins = kBinsPerOctave * kOctaves;
constexpr int kDepthStepsPerOctave = 8;
constexpr int kTightTexelStepsPerOctave = 16; // a texel is at most 4.4 % larger than it need be
constexpr int kTurnSteps = 128; // a full turn; strips lie askew by 1.4 degrees at most
// Sides of a map are the size asked for times and over a power of 2 up to this; and no side is
// longer than every OpenGL 4.5 has textures.
constexpr int kMostAspectOctaves = 2, kLongestSide = 16384;

int binOf(double depthMetres) {
    const double octave = std::log2(depthMetres) - kLowestOctave;
    return std::clamp(int(octave * kBinsPerOctave), 0, kBins - 1);
}

struct Extent {
    double nearMetres = std::numeric_limits<double>::infinity();
    double farMetres = 0.0;
    LightBox bounds{glm::dvec3(std::numeric_limits<double>::infinity()),
                    glm::dvec3(-std::numeric_limits<double>::infinity())};
    double lowestMetres = std::numeric_limits<double>::infinity();

    bool empty() const { return farMetres <= 0.0; }
    void add(const SeenReceivers::Bin& bin) {
        nearMetres = std::min(nearMetres, bin.nearMetres);
        farMetres = std::max(farMetres, bin.farMetres);
        bounds.min = glm::min(bounds.min, bin.bounds.min);
        bounds.max = glm::max(bounds.max, bin.bounds.max);
        lowestMetres = std::min(lowestMetres, bin.lowestMetres);
    }
};

// Half the width of the widest penumbra on these surfaces.
double penumbraMetres(const Extent& extent, const CasterBound& casters, double diameterDegrees) {
    const double sine = std::max(casters.sinElevation, 1e-4);
    const double reach = std::min(std::max(casters.topMetres - extent.lowestMetres, 0.0) / sine,
                                  std::max(casters.lightMaxMetres - extent.bounds.min.z, 0.0));
    return reach * std::tan(0.5 * diameterDegrees * kRadiansPerDegree);
}

// What a cascade's window has to hold: the surfaces, and a margin around them.
struct Wanted {
    LightBox bounds;
    double marginMetres = 0.0;
    bool any = false; // there are surfaces
};

double texelFor(const Wanted& wanted, glm::ivec2 mapSize) {
    const glm::dvec3 size = wanted.bounds.max - wanted.bounds.min;
    const glm::dvec2 texels = glm::dvec2(mapSize) - 2.0 * kBorderTexels;
    const double texel = std::max((size.x + 2.0 * wanted.marginMetres) / texels.x,
                                  (size.y + 2.0 * wanted.marginMetres) / texels.y);
    return ladderUp(std::max(texel, kMinTexelMetres), kTightTexelStepsPerOctave);
}

// One for all cascades, as the maps are layers of one texture: that of the finest texels, by their
// geometric mean; the squarest of equals.
glm::ivec2 mapSizeFor(std::span<const Wanted> wanted, int squareSize) {
    glm::ivec2 best(squareSize);
    double least = std::numeric_limits<double>::infinity();
    for (const int octaves : {0, 1, -1, 2, -2}) {
        const int longer = squareSize << std::abs(octaves),
                  shorter = squareSize >> std::abs(octaves);
        if (longer > kLongestSide)
            continue;
        const glm::ivec2 size =
            octaves > 0 ? glm::ivec2(longer, shorter) : glm::ivec2(shorter, longer);
        double sum = 0.0;
        for (const Wanted& window : wanted)
            sum += window.any ? std::log2(texelFor(window, size)) : 0.0;
        if (sum < least) {
            least = sum;
            best = size;
        }
    }
    return best;
}

// The window around what is wanted, its far plane below all of it.
void fitWindow(Cascade& cascade, const Wanted& wanted, glm::ivec2 mapSize) {
    const LightBox& bounds = wanted.bounds;
    cascade.texelMetres = texelFor(wanted, mapSize);
    const glm::dvec3 centre = 0.5 * (bounds.min + bounds.max);
    cascade.cornerX = std::int64_t(std::floor(centre.x / cascade.texelMetres)) - mapSize.x / 2;
    cascade.cornerY = std::int64_t(std::floor(centre.y / cascade.texelMetres)) - mapSize.y / 2;
    // What rounding and the filter's slope may reach below the lowest receiver.
    const double spare = 4.0 * cascade.texelMetres + wanted.marginMetres;
    // Steps fixed to the anchor.
    const double step = 0.125 * cascade.texelMetres * std::max(mapSize.x, mapSize.y);
    cascade.farPlaneMetres = std::floor((bounds.min.z - spare) / step) * step;
    cascade.depthRangeMetres = bounds.max.z + spare - cascade.farPlaneMetres;
}

} // namespace

SeenReceivers seenReceivers(const Camera& camera, std::span<const float> viewDepth,
                            const Transform<Light, Ecef>& lightFromEcef,
                            const Transform<Light, Enu>& lightFromAnchor, double rangeMetres) {
    const glm::dvec3 anchorUp = lightFromAnchor(Vector<Enu>{{0, 0, 1}}).xyz;
    const glm::dvec3 eye = lightFromEcef(camera.position).xyz;
    const glm::dvec3 forward = lightFromEcef(camera.forward).xyz;
    const glm::dvec3 right = lightFromEcef(camera.right).xyz * camera.tanHalfWidth();
    const glm::dvec3 up = lightFromEcef(camera.up).xyz * camera.tanHalfHeight();
    std::vector<Extent> bins(kBins);
    const int w = camera.widthPixels, h = camera.heightPixels;
    // The logarithm is only needed where a pixel leaves its neighbour's bin.
    int bin = 0;
    double low = 0.0, high = -1.0;
    for (int y = 0; y < h; ++y) {
        const glm::dvec3 row = forward + (1.0 - (2.0 * y + 1.0) / h) * up;
        for (int x = 0; x < w; ++x) {
            const double d = viewDepth[std::size_t(y) * std::size_t(w) + std::size_t(x)];
            if (!(d > 0.0 && d <= rangeMetres))
                continue;
            if (d < low || d >= high) {
                bin = binOf(d);
                low = std::exp2(double(bin) / kBinsPerOctave + kLowestOctave);
                high = std::exp2(double(bin + 1) / kBinsPerOctave + kLowestOctave);
            }
            const glm::dvec3 light = eye + d * (row + ((2.0 * x + 1.0) / w - 1.0) * right);
            Extent& extent = bins[std::size_t(bin)];
            extent.nearMetres = std::min(extent.nearMetres, d);
            extent.farMetres = std::max(extent.farMetres, d);
            extent.bounds.min = glm::min(extent.bounds.min, light);
            extent.bounds.max = glm::max(extent.bounds.max, light);
            extent.lowestMetres = std::min(extent.lowestMetres, glm::dot(anchorUp, light));
        }
    }
    SeenReceivers seen;
    for (const Extent& extent : bins)
        if (!extent.empty())
            seen.bins.push_back(
                {extent.nearMetres, extent.farMetres, extent.bounds, extent.lowestMetres});
    return seen;
}

Transform<Light, Light> turnedTowards(const Camera& camera,
                                      const Transform<Light, Ecef>& lightFromEcef) {
    const glm::dvec2 right(lightFromEcef(camera.right).xyz);
    const glm::dvec2 forward(lightFromEcef(camera.forward).xyz);
    const glm::dvec2 along = glm::length(right) > glm::length(forward) ? right : forward;
    constexpr double kStep = 2.0 * std::numbers::pi / kTurnSteps;
    const double angle = std::round(std::atan2(along.y, along.x) / kStep) * kStep;
    glm::dmat4 turn(1.0);
    turn[0] = {std::cos(angle), -std::sin(angle), 0.0, 0.0};
    turn[1] = {std::sin(angle), std::cos(angle), 0.0, 0.0};
    return {turn};
}

CascadeSet fitTightCascades(const CascadeInput& input, const ShadowSettings& settings,
                            const SeenReceivers& seen, const CasterBound& casters) {
    CascadeSet set = fitCascades(input, settings);
    if (seen.bins.empty())
        return set;
    const double nearMetres =
        ladderDown(std::max(seen.bins.front().nearMetres, kMinTexelMetres), kDepthStepsPerOctave);
    const double farMetres =
        std::max(ladderUp(seen.bins.back().farMetres, kDepthStepsPerOctave), 1.01 * nearMetres);
    const std::size_t count = set.cascades.size();
    const std::vector<double> splits =
        practicalSplits(nearMetres, farMetres, int(count), settings.splitLambda);
    std::vector<Wanted> wanted(count);
    double fitNear = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        Cascade& cascade = set.cascades[i];
        cascade.nearMetres = i == 0 ? 0.0 : splits[i];
        cascade.farMetres = splits[i + 1];
        cascade.blendStartMetres =
            cascade.farMetres - settings.blendFraction * (splits[i + 1] - splits[i]);
        Extent extent;
        for (const SeenReceivers::Bin& bin : seen.bins)
            if (bin.farMetres >= fitNear && bin.nearMetres <= cascade.farMetres)
                extent.add(bin);
        if (!extent.empty())
            wanted[i] = {extent.bounds,
                         penumbraMetres(extent, casters, settings.lightDiameterDegrees), true};
        fitNear = cascade.blendStartMetres;
    }
    set.mapSize = mapSizeFor(wanted, settings.mapSize);
    for (std::size_t i = 0; i < count; ++i)
        if (wanted[i].any)
            fitWindow(set.cascades[i], wanted[i], set.mapSize);
    return set;
}

} // namespace gnomon
