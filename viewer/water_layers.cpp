#include "viewer/water_layers.h"

#include "viewer/water_legend.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// Calm river water one sees 1.5 m into: extinction is 1.7 over the depth at which a white disc
// vanishes (Poole & Atkins, "Photo-electric measurements of submarine illumination", 1929), more in
// the blue, by what is dissolved, and in the red, by water itself. Of deep water comes back the
// ratio of backscatter to extinction: brownish grey.
constexpr double kSeenMetres = 1.5;
const glm::dvec3 kExtinction = 1.7 / kSeenMetres * glm::dvec3(1.12, 1.0, 1.25);
const glm::dvec3 kScatter(0.066, 0.073, 0.054);

// Mean square slope of wavelets smaller than the smallest ripple, and of the sun's disc, which is
// no point.
constexpr double kSmoothest = 8e-4;

double modulo(double a, double b) {
    return a - b * std::floor(a / b);
}

} // namespace

WaterLayers::Moment WaterLayers::make(const WaterLayer& layer, double seconds) const {
    Moment moment;
    moment.seconds = seconds;
    const Result<std::vector<WaterMesh>> meshes =
        layer.surface->meshes(seconds, scene_.ecefFromAnchor.axes());
    if (!meshes) {
        moment.failure = meshes.error().message();
        return moment;
    }
    moment.water = std::make_unique<render::GpuWater>(*meshes);
    return moment;
}

std::vector<std::string> WaterLayers::show(std::optional<UtcTime> time) {
    std::vector<std::string> failures;
    items_.clear();
    moments_.resize(scene_.waters.size());
    for (std::size_t i = 0; i < moments_.size(); ++i) {
        const WaterLayer& layer = scene_.waters[i];
        const std::vector<double>& steps = layer.surface->data().stepSeconds();
        const double seconds = std::clamp(layer.secondsAt(time), steps.front(),
                                          steps.back()); // it stands still beyond
        std::optional<Moment>& moment = moments_[i];
        if (!moment || moment->seconds != seconds) {
            moment.reset(); // its memory first
            moment = make(layer, seconds);
        }
        if (!moment->water) {
            failures.push_back(moment->failure);
            continue;
        }
        const WaterColors colors = colorsOf(layer);
        const WaterLegend legend = legendOf(layer);
        items_.push_back({moment->water.get(), colors == WaterColors::Natural,
                          colors == WaterColors::Speed, legend.map, legend.most});
    }
    return failures;
}

std::vector<OrientedBox> WaterLayers::boxes() const {
    std::vector<OrientedBox> boxes;
    for (const render::WaterItem& item : items_)
        for (const render::GpuWaterMesh& mesh : item.water->meshes())
            boxes.push_back(mesh.box);
    return boxes;
}

std::size_t WaterLayers::bytes() const {
    std::size_t bytes = 0;
    for (const std::optional<Moment>& moment : moments_)
        if (moment && moment->water)
            bytes += moment->water->bytes();
    return bytes;
}

shader::WaterBlock waterLook(const Camera& camera, const Transform<Ecef, Enu>& ecefFromAnchor) {
    const glm::dvec3 eye = rigidInverse(ecefFromAnchor)(camera.position).xyz;
    shader::WaterBlock look;
    look.waterExtinction = glm::vec4(glm::dvec4(kExtinction, 0.0));
    look.waterScatter = glm::vec4(glm::dvec4(kScatter, 0.0));
    look.rippleOrigin =
        glm::vec4(glm::dvec4(modulo(eye.x, RIPPLE_TILE), modulo(eye.y, RIPPLE_TILE),
                             2.0 * camera.tanHalfHeight() / camera.heightPixels, kSmoothest));
    return look;
}

} // namespace gnomon
