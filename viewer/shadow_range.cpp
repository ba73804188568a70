#include "viewer/shadow_range.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

// Steps of the ladders that near and far stand on. Nearer than the ladder would have it is never
// needed, farther costs resolution: so near is coarse and far is fine.
constexpr int kNearStepsPerOctave = 2;
constexpr int kFarStepsPerOctave = 8;
// Without a range given, shadows reach this far, or this many times the nearest distance: the
// texels of the last cascade then stay near the size of a pixel there.
constexpr double kDefaultRangeMetres = 5000.0;
constexpr double kDefaultRangePerNear = 100.0;
// Of the range, over which shadows fade where it cuts them off.
constexpr double kDefaultFadeFraction = 0.1;
// The caster bound's height rises in steps, so that a tile that comes or goes seldom moves it.
constexpr double kTopStepMetres = 16.0;

double cosineOfCorner(const Camera& camera) {
    return 1.0 / std::sqrt(1.0 + camera.tanHalfWidth() * camera.tanHalfWidth() +
                           camera.tanHalfHeight() * camera.tanHalfHeight());
}

} // namespace

ShadowReach shadowReach(const Scene& scene, const Camera& camera, const SunPosition& sun,
                        std::span<const render::DrawItem> items, const ShadowSettings& settings,
                        const View& cameraView, std::span<const OrientedBox> waters) {
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0.0;
    const auto add = [&](const BoundingVolume& box) {
        if (classify(box, cameraView.planes) == Containment::Outside)
            return;
        const double depth = extentAlong(box, camera.position, camera.forward).max;
        if (depth <= 0.0)
            return;
        nearest = std::min(nearest, distanceTo(box, camera.position));
        farthest = std::max(farthest, depth);
    };
    for (const render::DrawItem& item : items)
        add(item.mesh->box);
    for (const OrientedBox& water : waters)
        add(water);
    ShadowReach reach;
    if (farthest <= 0.0)
        return reach; // nothing is seen: anything will do
    const double corner = cosineOfCorner(camera);
    reach.nearMetres = ladderDown(std::max(nearest * corner, 1.0), kNearStepsPerOctave);

    // Nothing is shadowed farther out than the scene's own shadows fall.
    const double fall =
        scene.heightMetres / std::max(std::tan(sun.elevationDegrees * kRadiansPerDegree), 0.02);
    const double sceneEnd =
        length(scene.ecefFromAnchor.origin() - camera.position) + scene.radiusMetres + fall;
    const double wanted = ladderUp(std::max(std::min(farthest, sceneEnd), 2.0 * reach.nearMetres),
                                   kFarStepsPerOctave);
    const double limit = settings.rangeMetres.value_or(
        std::max(kDefaultRangeMetres, kDefaultRangePerNear * reach.nearMetres));
    reach.farMetres = std::max(std::min(wanted, limit), 1.01 * reach.nearMetres);
    if (wanted <= limit) {
        // All that is seen is covered, to the corners of the picture: there is nothing to fade.
        reach.rangeMetres = reach.farMetres / corner;
        reach.fadeMetres = settings.fadeMetres.value_or(1e-3 * reach.farMetres);
    } else {
        reach.rangeMetres = reach.farMetres;
        reach.fadeMetres = settings.fadeMetres.value_or(kDefaultFadeFraction * reach.farMetres);
    }
    reach.fadeMetres = std::max(reach.fadeMetres, 1e-3);
    return reach;
}

CasterBound casterBound(const Scene& scene, const SunPosition& sun,
                        const Transform<Light, Ecef>& lightFromEcef,
                        std::span<const render::DrawItem> items) {
    CasterBound bound;
    bound.lightFromAnchor = lightFromEcef * scene.ecefFromAnchor;
    // The sun's height over the anchor's own horizontal, along which heights are counted.
    const Vector<Enu> towards = rigidInverse(scene.ecefFromAnchor)(sun.towards);
    bound.sinElevation = std::max(towards.xyz.z, 0.0);
    bound.topMetres = -std::numeric_limits<double>::infinity();
    bound.lightMaxMetres = -std::numeric_limits<double>::infinity();
    const Vector<Ecef> up = scene.ecefFromAnchor(Vector<Enu>{{0, 0, 1}});
    const Point<Ecef> anchor = scene.ecefFromAnchor.origin();
    for (const render::DrawItem& item : items) {
        if (item.tileId == 0) // the ground: nothing stands below it, and its boxes span continents
            continue;
        bound.topMetres =
            std::max(bound.topMetres, extentAlong(BoundingVolume(item.mesh->box), anchor, up).max);
        bound.lightMaxMetres =
            std::max(bound.lightMaxMetres, lightBox(lightFromEcef, item.mesh->box).max.z);
    }
    if (!std::isfinite(bound.topMetres))
        bound.topMetres = bound.lightMaxMetres = 0.0; // nothing casts
    bound.topMetres = std::ceil(bound.topMetres / kTopStepMetres) * kTopStepMetres;
    return bound;
}

} // namespace gnomon
