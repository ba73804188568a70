#include "bench/flips.h"

#include <cmath>

namespace gnomon::bench {

namespace {

constexpr double kForwardMetres = 0.017; // a step; no simple ratio to any texel
constexpr double kTurnRadians = 0.013 * kRadiansPerDegree;
constexpr float kLeastFlip = 1.0f / 255.0f;

// Of each pixel, where it stands and what it was answered.
struct Answers {
    Camera camera;
    FrameFacts facts;
    std::vector<float> visibility, cascade, texel;
};

Answers read(FrameRenderer& renderer, const Camera& camera, FrameFacts facts) {
    return {camera, std::move(facts), renderer.aov(Aov::Sun).values,
            renderer.aov(Aov::Cascade).values, renderer.texels().values};
}

std::vector<Point<Ecef>> surfacePoints(const Camera& camera, const std::vector<float>& depth) {
    std::vector<Point<Ecef>> points(depth.size());
    for (int y = 0; y < camera.heightPixels; ++y)
        for (int x = 0; x < camera.widthPixels; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(camera.widthPixels) + std::size_t(x);
            const double u = (2.0 * (x + 0.5) / camera.widthPixels - 1.0) * camera.tanHalfWidth();
            const double v = (1.0 - 2.0 * (y + 0.5) / camera.heightPixels) * camera.tanHalfHeight();
            points[i] = camera.position +
                        double(depth[i]) * (camera.forward + u * camera.right + v * camera.up);
        }
    return points;
}

// Whether one cascade alone answers there, before shadows fade. The blend area of the first
// cascade is taken a little too wide: where it begins depends on the nearest receiver.
bool isPlain(const Answers& a, std::size_t i, Point<Ecef> p, const ShadowSettings& settings) {
    if (a.visibility[i] < 0.0f || a.texel[i] <= 0.0f)
        return false;
    const Vector<Ecef> v = p - a.camera.position;
    if (length(v) > a.facts.shadowRangeMetres - a.facts.shadowFadeMetres)
        return false;
    const auto c = std::size_t(a.cascade[i]);
    if (c >= a.facts.cascades.size())
        return true;
    const CascadeFacts& cascade = a.facts.cascades[c];
    const bool last = c + 1 == a.facts.cascades.size();
    return last || dot(v, a.camera.forward) <
                       cascade.farMetres -
                           settings.blendFraction * (cascade.farMetres - cascade.nearMetres);
}

// The size of a cascade's texels: another size is another map. A map in the eye's perspective is
// one map, whatever it does to its texels.
double texelOf(const Answers& a, std::size_t i) {
    const auto c = std::size_t(a.cascade[i]);
    return c < a.facts.cascades.size() ? a.facts.cascades[c].texelMetres : 0.0;
}

} // namespace

Result<Flips> countFlips(FrameRenderer& renderer, const FrameRequest& request,
                         const ShadowSettings& settings, std::span<const Camera> path,
                         const std::function<bool()>& goOn) {
    Flips out;
    std::vector<Point<Ecef>> points;
    Answers before;
    for (std::size_t step = 0; step < path.size(); ++step) {
        if (goOn && !goOn())
            return Error{"evaluate", "stopped", ErrorKind::Transient};
        FrameRequest next = request;
        next.camera = path[step];
        next.keepSurfaces = step > 0;
        const Result<FrameFacts> facts = renderer.draw(next);
        if (!facts)
            return facts.error();
        Answers now = read(renderer, next.camera, *facts);
        if (step == 0)
            points = surfacePoints(next.camera, renderer.aov(Aov::Depth).values);
        for (std::size_t i = 0; step > 0 && i < points.size(); ++i) {
            if (before.cascade[i] != now.cascade[i] || texelOf(before, i) != texelOf(now, i) ||
                !isPlain(before, i, points[i], settings) || !isPlain(now, i, points[i], settings))
                continue;
            ++out.asked;
            out.flips += std::abs(now.visibility[i] - before.visibility[i]) > kLeastFlip;
        }
        before = std::move(now);
    }
    return out;
}

std::vector<Camera> smallMotion(const Camera& from, int steps) {
    std::vector<Camera> path;
    const Geodetic start = geodeticOf(from.position);
    const Orientation orientation = orientationOf(from);
    for (int i = 0; i < steps; ++i) {
        Camera camera = from;
        Orientation turned = orientation;
        turned.headingDegrees += i * kTurnRadians / kRadiansPerDegree;
        // Level, so that a camera looking down does not dive.
        const Transform<Ecef, Enu> enu = ecefFromEnu(start);
        const double heading = orientation.headingDegrees * kRadiansPerDegree;
        const glm::dvec3 ahead(std::sin(heading), std::cos(heading), 0.0);
        place(camera, geodeticOf(enu(Point<Enu>{i * kForwardMetres * ahead})), turned);
        path.push_back(camera);
    }
    return path;
}

} // namespace gnomon::bench
