#include "viewer/lamps.h"

#include "shadows/paraboloid.h"
#include "viewer/daylight.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gnomon {

double lampShare(double sunElevationDegrees) {
    constexpr double kWarmUpDegrees = 1.0;
    const double t = std::clamp(-sunElevationDegrees / kWarmUpDegrees, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

std::vector<std::size_t> liveLamps(std::span<const Lamp> lamps, const Camera& camera) {
    const View view = perspectiveView(camera);
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < lamps.size(); ++i) {
        const Lamp& lamp = lamps[i];
        const Sphere reach{lamp.position, lamp.rangeMetres};
        if (classify(BoundingVolume(reach), view.planes) == Containment::Outside)
            continue;
        const double power = std::max({lamp.power.r, lamp.power.g, lamp.power.b, 0.0f});
        const double distance = std::max(length(lamp.position - camera.position), lamp.nearMetres);
        order.emplace_back(-power / (distance * distance), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::size_t> live;
    int hemispheres = 0;
    for (const auto& [importance, lamp] : order) {
        hemispheres += shinesAllRound(lamps[lamp]) ? 2 : 1;
        if (hemispheres > kMaxLampHemispheres)
            break;
        live.push_back(lamp);
    }
    return live;
}

View lampView(const Lamp& lamp, const View& camera) {
    View view = camera;
    view.planes.clear();
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            Vector<Ecef> normal;
            normal.xyz[axis] = sign;
            view.planes.push_back({normal, lamp.position - lamp.rangeMetres * normal});
        }
    return view;
}

void LampLights::choose(const Camera& camera, const SunPosition& sun,
                        const ShadowSettings& shadows) {
    live_.clear();
    shadows_ = shadows;
    const double share = lampShare(sun.elevationDegrees);
    exposure_ = share * eyeOpening(sun.elevationDegrees);
    if (share > 0.0 && shadows.lamps != LampMethod::Off && !scene_.lamps.empty())
        live_ = liveLamps(scene_.lamps, camera);
}

void LampLights::addViews(std::vector<View>& views) const {
    for (const std::size_t lamp : live_)
        views.push_back(lampView(scene_.lamps[lamp], views.front()));
}

LampPassInput LampLights::input() const {
    LampPassInput input;
    input.surfaceCamera = surfaceCamera_;
    input.meshAxes = scene_.ecefFromAnchor.axes();
    input.ecefFromAnchor = scene_.ecefFromAnchor;
    input.lamps = scene_.lamps;
    input.live = live_;
    input.exposure = exposure_;
    return input;
}

void LampLights::draw(const render::VisibilityPass& seen, const Camera& surfaceCamera,
                      std::span<const LampCaster> casters) {
    surfaceCamera_ = surfaceCamera;
    if (live_.empty())
        return;
    LampPassInput now = input();
    now.casters = casters;
    pass_.drawMaps(now, shadows_);
    pass_.draw(seen, now, shadows_);
}

std::optional<LampPicture> LampLights::shadowOf(const render::VisibilityPass& seen,
                                                std::size_t lamp) {
    if (std::find(live_.begin(), live_.end(), lamp) == live_.end())
        return std::nullopt;
    return pass_.shadowOf(seen, input(), lamp, shadows_);
}

} // namespace gnomon
