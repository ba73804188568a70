#include "viewer/overlay_facts.h"

#include "viewer/water_legend.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace gnomon {

namespace {

struct SourcedLegend {
    Legend legend;
    std::string uri;
};

Legend legendFor(const WaterLayer& water) {
    const WaterLegend told = legendOf(water);
    Legend legend;
    legend.interpolated = told.interpolated;
    legend.title = told.title;
    if (told.title.empty()) { // colours that tell no number
        legend.title = "Water";
        return legend;
    }
    legend.unit = told.unit;
    legend.most = told.most;
    legend.map = told.map;
    const double reached = colorsOf(water) == WaterColors::Speed ? water.surface->fastest()
                                                                 : water.surface->deepestMetres();
    legend.beyond = reached > told.most * (1.0 + 1e-6);
    return legend;
}

// Each once. Where two say different things under one title, the file's name is added.
std::vector<Legend> distinct(std::vector<SourcedLegend> all) {
    std::vector<Legend> legends;
    for (const SourcedLegend& one : all) {
        const bool contradicted = std::any_of(all.begin(), all.end(), [&](const auto& other) {
            return other.legend.title == one.legend.title && !(other.legend == one.legend);
        });
        Legend legend = one.legend;
        if (contradicted)
            legend.title += ", " + std::filesystem::path(one.uri).filename().string();
        if (std::find(legends.begin(), legends.end(), legend) == legends.end())
            legends.push_back(std::move(legend));
    }
    return legends;
}

std::vector<Legend> legendsOf(const Scene& scene) {
    std::vector<SourcedLegend> all;
    for (const WaterLayer& water : scene.waters) {
        Legend legend = legendFor(water);
        if (legend.most > legend.least || legend.interpolated)
            all.push_back({std::move(legend), water.uri});
    }
    for (const Layer& layer : scene.layers) {
        if (!layer.terrain || !layer.terrain->facts().rampHeights)
            continue;
        const auto [least, most] = *layer.terrain->facts().rampHeights;
        all.push_back({{"Terrain height", "m", least, most, ColorMap::Elevation}, layer.uri});
    }
    return distinct(std::move(all));
}

// None when no flood has several steps at known times.
std::optional<FloodTimes> floodTimesOf(const Scene& scene) {
    std::optional<FloodTimes> times;
    for (const WaterLayer& water : scene.waters) {
        const FloodData& data = water.surface->data();
        const bool known = data.stepsAreAbsolute() || water.startSeconds != 0.0;
        if (!known || data.stepSeconds().size() < 2)
            continue;
        const double start = data.stepsAreAbsolute() ? 0.0 : water.startSeconds;
        const double first = start + data.stepSeconds().front();
        const double last = start + data.stepSeconds().back();
        if (!times)
            times = FloodTimes{{first}, {last}};
        times->first.seconds = std::min(times->first.seconds, first);
        times->last.seconds = std::max(times->last.seconds, last);
    }
    return times;
}

// Along the camera's axis to the ellipsoid raised by `heightMetres`, which is one again to within
// the height times the flattening squared.
std::optional<double> distanceTo(const Camera& camera, double heightMetres) {
    const double a = kEquatorialRadiusMetres + heightMetres, b = kPolarRadiusMetres + heightMetres;
    const glm::dvec3 scale(1.0 / a, 1.0 / a, 1.0 / b);
    const glm::dvec3 o = camera.position.xyz * scale, d = camera.forward.xyz * scale;
    const double square = glm::dot(d, d), half = glm::dot(o, d), rest = glm::dot(o, o) - 1.0;
    const double discriminant = half * half - square * rest;
    if (discriminant < 0.0 || half >= 0.0 || rest <= 0.0)
        return {};
    return rest / (-half + std::sqrt(discriminant)); // the nearer, without cancellation
}

} // namespace

OverlayFacts overlayFactsOf(const Scene& scene) {
    OverlayFacts facts;
    facts.legends = legendsOf(scene);
    facts.flood = floodTimesOf(scene);
    facts.credits = scene.credits;
    return facts;
}

std::optional<Point<Ecef>> groundAtCentre(const Camera& camera, const Scene& scene,
                                          std::optional<double> flatGroundMetres) {
    const double flat = flatGroundMetres.value_or(scene.anchor.heightMetres);
    const auto groundBelow = [&](Point<Ecef> p) {
        if (!scene.groundHeights)
            return flat;
        const Geodetic place = geodeticOf(p);
        const double height =
            scene.groundHeights->at({place.longitudeDegrees, place.latitudeDegrees});
        return std::isfinite(height) ? height : flat;
    };
    const auto at = [&](double distance) { return camera.position + distance * camera.forward; };
    const auto clearance = [&](Point<Ecef> p) {
        return geodeticOf(p).heightMetres - groundBelow(p);
    };
    // Terrain may lie this much lower than the flat ground.
    constexpr double kDeepest = 1000.0;
    const double above = clearance(camera.position);
    const auto end = distanceTo(camera, flat - kDeepest);
    if (!(above > 0.0) || !end)
        return {};
    // Steps that grow with the distance find all that is wider than they are; then halves.
    constexpr double kFirst = 0.1, kGrowth = 1.03;
    constexpr int kHalves = 20; // to a millionth of a step
    double before = 0.0, after = kFirst * above;
    while (clearance(at(after)) > 0.0) {
        if (after >= *end)
            return {};
        before = after;
        after = std::min(kGrowth * after, *end);
    }
    for (int i = 0; i < kHalves; ++i) {
        const double middle = 0.5 * (before + after);
        (clearance(at(middle)) > 0.0 ? before : after) = middle;
    }
    return at(after);
}

void setMoment(OverlayFacts& facts, const Scene& scene, const Shot& shot,
               std::optional<double> flatGroundMetres) {
    facts.camera = shot.camera;
    facts.sun = {shot.sun.azimuthDegrees, shot.sun.elevationDegrees};
    facts.time = shot.time;
    facts.timeZone = shot.timeZone;
    facts.groundAtCentre = groundAtCentre(shot.camera, scene, flatGroundMetres);
}

} // namespace gnomon
