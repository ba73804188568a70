#include "bench/probe_lines.h"

#include "bench/surfaces.h"

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

// Pixels between samples of a line, so that linear interpolation between them hides nothing that
// the pictures show.
constexpr double kPixelsPerSample = 0.25;
constexpr int kMostSamples = 20000;

// Pixel coordinates, whole at pixel centres; none behind the camera.
std::optional<glm::dvec2> toScreen(const Camera& camera, Point<Ecef> p) {
    const Vector<Ecef> v = p - camera.position;
    const double depth = dot(v, camera.forward);
    if (depth <= 0.0)
        return {};
    const double x = dot(v, camera.right) / (depth * camera.tanHalfWidth());
    const double y = dot(v, camera.up) / (depth * camera.tanHalfHeight());
    return glm::dvec2((0.5 + 0.5 * x) * camera.widthPixels - 0.5,
                      (0.5 - 0.5 * y) * camera.heightPixels - 0.5);
}

struct Place {
    glm::dvec2 pixel;
    glm::dvec3 stored, normal;
};

// Where the camera sees the point of the line; none when something is in front of it.
std::optional<Place> lookAt(const ProbePictures& in, Point<Ecef> p) {
    const auto pixel = toScreen(in.camera, p);
    if (!pixel)
        return {};
    const glm::dvec3 eye = in.rays.stored(in.camera.position), stored = in.rays.stored(p);
    const double distance = glm::length(stored - eye);
    const RayHit hit = in.rays.first(eye, (stored - eye) / distance);
    if (!hit.any ||
        !samePlane(hit.position, hit.normal, stored, surfaceTolerance(in.camera, distance)))
        return {};
    return Place{*pixel, stored, hit.normal};
}

struct Read {
    double truth = 0.0, drawn = 0.0, weight = 0.0;
    float texel = 0.0f;
};

Read readAround(const ProbePictures& in, const Place& place) {
    Read read;
    const int x0 = int(std::floor(place.pixel.x)), y0 = int(std::floor(place.pixel.y));
    const double fx = place.pixel.x - x0, fy = place.pixel.y - y0;
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const int x = x0 + i, y = y0 + j;
            const double weight = (i ? fx : 1.0 - fx) * (j ? fy : 1.0 - fy);
            if (x < 0 || y < 0 || x >= in.reference.width || y >= in.reference.height ||
                weight <= 0.0)
                continue;
            const std::size_t pixel = std::size_t(y) * std::size_t(in.reference.width) + x;
            const SurfacePoint& s = in.reference.surfaces[pixel];
            if (!s.any || in.drawn[pixel] < 0.0f || in.texels[pixel] <= 0.0f ||
                glm::dot(s.normal, place.normal) < kSameSurfaceCosine ||
                !samePlane(s.position, s.normal, place.stored,
                           surfaceTolerance(in.camera, s.viewDepthMetres)))
                continue;
            read.truth += weight * in.truth[pixel];
            read.drawn += weight * in.drawn[pixel];
            read.weight += weight;
            read.texel = std::max(read.texel, in.texels[pixel]);
        }
    return read;
}

// The normal of the surface the line lies on. At its ends another surface may touch the line.
std::optional<glm::dvec3> normalOf(const ProbePictures& in, Point<Ecef> from, Point<Ecef> to) {
    for (const double t : {0.5, 0.4, 0.6, 0.25, 0.75, 0.1, 0.9})
        if (const auto place = lookAt(in, from + t * (to - from)))
            return place->normal;
    return {};
}

// Samples so near that the picture's pixels decide, not they.
int sampleCount(const Camera& camera, Point<Ecef> from, Point<Ecef> to) {
    const auto a = toScreen(camera, from), b = toScreen(camera, to);
    if (!a || !b)
        return kMostSamples;
    return int(std::clamp(glm::length(*b - *a) / kPixelsPerSample, 16.0, double(kMostSamples)));
}

} // namespace

ProbeSamples sampleProbe(const ProbePictures& in, const Probe& probe,
                         const Transform<Ecef, Enu>& ecefFromProbes) {
    ProbeSamples out;
    const Point<Ecef> from = ecefFromProbes(Point<Enu>{probe.from});
    const Point<Ecef> to = ecefFromProbes(Point<Enu>{probe.to});
    const double metres = length(to - from);
    const auto normal = normalOf(in, from, to);
    if (metres <= 0.0 || !normal)
        return out;
    const int count = sampleCount(in.camera, from, to);
    std::vector<float> texels;
    for (int i = 0; i <= count; ++i) {
        const double t = double(i) / count;
        const auto place = lookAt(in, from + t * (to - from));
        if (!place || glm::dot(place->normal, *normal) < kSameSurfaceCosine)
            continue;
        const Read read = readAround(in, *place);
        if (read.weight <= 0.0)
            continue;
        out.metres.push_back(t * metres);
        out.reference.push_back(read.truth / read.weight);
        out.drawn.push_back(read.drawn / read.weight);
        texels.push_back(read.texel);
    }
    if (!texels.empty())
        out.texelMetres = texels[texels.size() / 2];
    const glm::dvec3 along = in.rays.stored(to - from) / metres;
    const glm::dvec3 towards =
        towardsLight(in.light, 0.5 * (in.rays.stored(from) + in.rays.stored(to)));
    out.lightPerMetre = glm::length(along - glm::dot(along, towards) * towards);
    return out;
}

std::optional<double> fallWidth(std::span<const double> metres, std::span<const double> values) {
    // Where values fall below a bound, counted from a sample on.
    struct Fall {
        std::size_t sample;
        double metres;
    };
    const auto fall = [&](double bound, std::size_t from) -> std::optional<Fall> {
        for (std::size_t i = std::max<std::size_t>(from, 1); i < values.size(); ++i)
            if (values[i - 1] >= bound && values[i] < bound) {
                const double t = (values[i - 1] - bound) / (values[i - 1] - values[i]);
                return Fall{i, metres[i - 1] + t * (metres[i] - metres[i - 1])};
            }
        return {};
    };
    const auto high = fall(0.9, 1);
    const auto low = high ? fall(0.1, high->sample) : std::nullopt;
    return low ? std::optional(low->metres - high->metres) : std::nullopt;
}

double shadowStart(std::span<const double> metres, std::span<const double> values) {
    for (std::size_t i = 0; i < values.size(); ++i)
        if (values[i] < 0.5) {
            if (i == 0)
                return metres[0];
            const double t = (values[i - 1] - 0.5) / (values[i - 1] - values[i]);
            return metres[i - 1] + t * (metres[i] - metres[i - 1]);
        }
    return metres.empty() ? 0.0 : metres.back();
}

} // namespace gnomon::bench
