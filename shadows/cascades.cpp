#include "shadows/cascades.h"

#include "geo/sun.h"
#include "shadows/splits.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace gnomon {

namespace {

// Of a penumbra's width: tiles may show an error of 8 to 16 pixels, so an eighth to a quarter of
// it.
constexpr double kPixelOfPenumbra = 1.0 / 64.0;
constexpr int kTexelStepsPerOctave = 8; // a texel is at most 9 % larger than it need be

std::int64_t floorDiv(std::int64_t a, std::int64_t b) {
    return a / b - ((a % b != 0 && (a < 0) != (b < 0)) ? 1 : 0);
}

// Half the window's longer side: what the ladder made of the sphere's radius.
double halfWindow(const Cascade& cascade, glm::ivec2 mapSize) {
    return 0.5 * cascade.texelMetres * double(std::max(mapSize.x, mapSize.y));
}

Cascade fitOne(const CascadeInput& input, const ShadowSettings& settings, double fitNear,
               double farMetres) {
    const SliceSphere sphere = minimalSliceSphere(fitNear, farMetres, input.camera.tanHalfWidth(),
                                                  input.camera.tanHalfHeight());
    Cascade cascade;
    const double texel = 2.0 * sphere.radiusMetres / double(settings.mapSize - 2 * kBorderTexels);
    cascade.texelMetres = ladderUp(std::max(texel, kMinTexelMetres), kTexelStepsPerOctave);
    const Point<Ecef> centre =
        input.camera.position + sphere.centreDepthMetres * input.camera.forward;
    const glm::dvec3 light = input.lightFromEcef(centre).xyz;
    const std::int64_t half = settings.mapSize / 2;
    cascade.cornerX = std::int64_t(std::floor(light.x / cascade.texelMetres)) - half;
    cascade.cornerY = std::int64_t(std::floor(light.y / cascade.texelMetres)) - half;
    // The far plane moves in steps fixed to the anchor, below the lowest receiver of the slice.
    const double step = halfWindow(cascade, glm::ivec2(settings.mapSize)) / 4.0;
    cascade.farPlaneMetres = std::floor((light.z - sphere.radiusMetres) / step) * step;
    cascade.depthRangeMetres = light.z + sphere.radiusMetres - cascade.farPlaneMetres;
    return cascade;
}

} // namespace

SliceSphere minimalSliceSphere(double n, double f, double tanHalfWidth, double tanHalfHeight) {
    const double k2 = tanHalfWidth * tanHalfWidth + tanHalfHeight * tanHalfHeight;
    if (k2 >= (f - n) / (f + n))
        return {f, f * std::sqrt(k2)};
    const double radius = 0.5 * std::sqrt((f - n) * (f - n) + 2.0 * (f * f + n * n) * k2 +
                                          (f + n) * (f + n) * k2 * k2);
    return {0.5 * (f + n) * (1.0 + k2), radius};
}

double ladderUp(double value, int stepsPerOctave) {
    const double steps = std::log2(value) * stepsPerOctave;
    // A value that stands on a rung but for rounding stays there.
    return std::exp2(std::ceil(steps - 1e-9) / stepsPerOctave);
}

double ladderDown(double value, int stepsPerOctave) {
    return std::exp2(std::floor(std::log2(value) * stepsPerOctave + 1e-9) / stepsPerOctave);
}

CascadeSet fitCascades(const CascadeInput& input, const ShadowSettings& settings) {
    CascadeSet set;
    set.lightFromEcef = input.lightFromEcef;
    set.meshAxes = input.meshAxes;
    set.mapSize = glm::ivec2(settings.mapSize);
    set.rangeMetres = input.rangeMetres;
    set.fadeMetres = input.fadeMetres;
    const int count = settings.method == ShadowMethod::Single ? 1 : settings.cascades;
    const std::vector<double> splits =
        practicalSplits(input.nearMetres, input.farMetres, count, settings.splitLambda);
    double fitNear = splits[0];
    for (int i = 0; i < count; ++i) {
        const double nearMetres = splits[std::size_t(i)], farMetres = splits[std::size_t(i) + 1];
        // Where the last cascade is mixed in, this one must have data already.
        Cascade cascade = fitOne(input, settings, fitNear, farMetres);
        cascade.nearMetres = i == 0 ? 0.0 : nearMetres;
        cascade.farMetres = farMetres;
        cascade.blendStartMetres = farMetres - settings.blendFraction * (farMetres - nearMetres);
        fitNear = cascade.blendStartMetres;
        set.cascades.push_back(cascade);
    }
    return set;
}

void setDepthRange(Cascade& cascade, glm::ivec2 mapSize, const CasterBound& bound) {
    const double half = halfWindow(cascade, mapSize);
    // The lowest point of the slice's receivers, from the window's centre on the far plane.
    const glm::dvec3 centre((double(cascade.cornerX) + mapSize.x / 2) * cascade.texelMetres,
                            (double(cascade.cornerY) + mapSize.y / 2) * cascade.texelMetres,
                            cascade.farPlaneMetres + half);
    const Transform<Enu, Light> anchorFromLight = rigidInverse(bound.lightFromAnchor);
    const double lowest = anchorFromLight(Point<Light>{centre}).xyz.z - 2.0 * half;
    // With the sun on the horizon or below it even a low caster may stand as far out as there are
    // any.
    double top = bound.lightMaxMetres;
    if (bound.sinElevation > 0.0)
        top = cascade.farPlaneMetres + 2.5 * half + // above every receiver itself
              std::max(bound.topMetres - lowest, 0.0) / bound.sinElevation;
    top = std::max(std::min(top, bound.lightMaxMetres), cascade.farPlaneMetres + 2.5 * half);
    cascade.depthRangeMetres = ladderUp(top - cascade.farPlaneMetres, 2);
}

glm::dvec4 casterReach(const CasterBound& bound, const Transform<Light, Ecef>& lightFromEcef,
                       const glm::dmat3& meshAxes, Point<Ecef> from) {
    const Transform<Enu, Light> anchorFromLight = rigidInverse(bound.lightFromAnchor);
    const double height = anchorFromLight(lightFromEcef(from)).xyz.z;
    const glm::dvec3 up =
        rigidInverse(lightFromEcef)(bound.lightFromAnchor(Vector<Enu>{{0, 0, 1}})).xyz;
    const double perMetre = 1.0 / std::max(bound.sinElevation, 1e-4);
    return {glm::transpose(meshAxes) * -up * perMetre, (bound.topMetres - height) * perMetre};
}

View casterView(const CascadeSet& set, const Cascade& cascade) {
    const Transform<Ecef, Light> ecefFromLight = rigidInverse(set.lightFromEcef);
    const double t = cascade.texelMetres;
    const glm::dvec3 low(double(cascade.cornerX) * t, double(cascade.cornerY) * t,
                         cascade.farPlaneMetres);
    const glm::dvec3 high(low.x + t * set.mapSize.x, low.y + t * set.mapSize.y, low.z);
    const Point<Ecef> lowEcef = ecefFromLight(Point<Light>{low});
    const Point<Ecef> highEcef = ecefFromLight(Point<Light>{high});
    const Vector<Ecef> x = ecefFromLight(Vector<Light>{{1, 0, 0}});
    const Vector<Ecef> y = ecefFromLight(Vector<Light>{{0, 1, 0}});
    const Vector<Ecef> z = ecefFromLight(Vector<Light>{{0, 0, 1}});
    View view;
    view.planes = {{x, lowEcef}, {-x, highEcef}, {y, lowEcef}, {-y, highEcef}, {z, lowEcef}};
    view.eye = ecefFromLight(Point<Light>{0.5 * (low + high)});
    view.forward = -z;
    view.pixelMetres = t;
    // What stands farther towards the sun than the slice is deep throws a penumbra as wide as the
    // sun's disc from there: a pixel may be this share of it.
    view.pixelGrowth =
        kPixelOfPenumbra * 2.0 * std::tan(0.5 * kSunDiameterDegrees * kRadiansPerDegree);
    view.growthFromMetres = t * std::max(set.mapSize.x, set.mapSize.y);
    return view;
}

CascadePages pagesOf(const Cascade& cascade, glm::ivec2 mapSize) {
    const std::int64_t m = mapSize.x, n = mapSize.y;
    CascadePages out;
    const std::int64_t x0 = floorDiv(cascade.cornerX, m), x1 = floorDiv(cascade.cornerX + m - 1, m);
    const std::int64_t y0 = floorDiv(cascade.cornerY, n), y1 = floorDiv(cascade.cornerY + n - 1, n);
    for (std::int64_t py = y0; py <= y1; ++py)
        for (std::int64_t px = x0; px <= x1; ++px) {
            CascadePage page;
            page.originX = px * m;
            page.originY = py * n;
            const std::int64_t left = std::max(cascade.cornerX, page.originX);
            const std::int64_t bottom = std::max(cascade.cornerY, page.originY);
            page.x = int(left - page.originX);
            page.y = int(bottom - page.originY);
            page.width = int(std::min(cascade.cornerX + m, page.originX + m) - left);
            page.height = int(std::min(cascade.cornerY + n, page.originY + n) - bottom);
            out.pages[std::size_t(out.count++)] = page;
        }
    return out;
}

glm::dvec3 windowFromLight(const Cascade& cascade, const glm::dvec3& light) {
    return {light.x / cascade.texelMetres - double(cascade.cornerX),
            light.y / cascade.texelMetres - double(cascade.cornerY),
            light.z - cascade.farPlaneMetres};
}

glm::dvec3 pageFromLight(const Cascade& cascade, const CascadePage& page, const glm::dvec3& light) {
    return {light.x / cascade.texelMetres - double(page.originX),
            light.y / cascade.texelMetres - double(page.originY), light.z - cascade.farPlaneMetres};
}

LightBox lightBox(const Transform<Light, Ecef>& lightFromEcef, const OrientedBox& box) {
    const glm::dvec3 centre = lightFromEcef(box.centre).xyz;
    const glm::dmat3 half = lightFromEcef.axes() * box.halfAxes;
    const glm::dvec3 extent = glm::abs(half[0]) + glm::abs(half[1]) + glm::abs(half[2]);
    return {centre - extent, centre + extent};
}

bool touches(const Cascade& cascade, const CascadePage& page, const LightBox& box) {
    const glm::dvec3 low = pageFromLight(cascade, page, box.min);
    const glm::dvec3 high = pageFromLight(cascade, page, box.max);
    return high.x >= page.x && low.x <= page.x + page.width && high.y >= page.y &&
           low.y <= page.y + page.height && high.z >= 0.0;
}

} // namespace gnomon
