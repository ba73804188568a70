// How near and how far shadows are needed in this picture, and how high what casts them stands.
// Fitted to every view by itself; steps of ladders keep it still while the camera moves a little.
#pragma once

#include "geo/camera.h"
#include "geo/sun.h"
#include "geo/view.h"
#include "render/gpu_tile.h"
#include "shadows/cascades.h"
#include "viewer/scene.h"

#include <span>

namespace gnomon {

struct ShadowReach {
    double nearMetres = 1.0;  // view depth of the nearest receiver, at least 1 m
    double farMetres = 2.0;   // view depth where the last cascade ends
    double rangeMetres = 2.0; // distance where shadows have faded out
    double fadeMetres = 1.0;
};

ShadowReach shadowReach(const Scene& scene, const Camera& camera, const SunPosition& sun,
                        std::span<const render::DrawItem> items, const ShadowSettings& settings,
                        const View& cameraView, std::span<const OrientedBox> waters = {});

// The highest and the sunward end of all that casts.
CasterBound casterBound(const Scene& scene, const SunPosition& sun,
                        const Transform<Light, Ecef>& lightFromEcef,
                        std::span<const render::DrawItem> items);

} // namespace gnomon
