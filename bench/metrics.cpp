#include "bench/metrics.h"

#include "bench/contours.h"
#include "bench/probe_lines.h"
#include "bench/surfaces.h"

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

// Within so many texels false shadow is an edge moved, not acne; false light a leak at the foot of
// an occluder.
constexpr double kNearTexels = 2.0;
// A penumbra narrower than this the map cannot tell from an edge.
constexpr double kLeastPenumbraTexels = 4.0;

// The same even spread for the same numbers (Steele, Lea & Flood, "Fast splittable pseudorandom
// number generators", 2014: its finaliser).
std::uint64_t mixed(std::uint64_t z) {
    z = (z + 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// One of each stretch of pixels, so that all parts of the picture have their share.
std::vector<std::uint32_t> evenly(const std::vector<std::uint32_t>& pixels) {
    if (pixels.size() <= kBandSamples)
        return pixels;
    std::vector<std::uint32_t> chosen(kBandSamples);
    for (std::size_t i = 0; i < kBandSamples; ++i) {
        const std::size_t begin = i * pixels.size() / kBandSamples;
        const std::size_t end = (i + 1) * pixels.size() / kBandSamples;
        chosen[i] = pixels[begin + mixed(i) % (end - begin)];
    }
    return chosen;
}

struct Comparer {
    const RayScene& rays;
    const Reference& reference;
    const Light& light;
    const Answer& answer;
    const Camera& camera;
    const std::vector<float>& truth;
    Comparison out;
    std::vector<std::uint32_t> asked, wrong;

    Comparer(const RayScene& r, const Reference& ref, const Light& l, const Answer& a,
             const Camera& c)
        : rays(r), reference(ref), light(l), answer(a), camera(c),
          truth(a.soft ? ref.visibility : ref.hard) {}

    const SurfacePoint& surface(std::size_t pixel) const { return reference.surfaces[pixel]; }
    bool isAsked(std::size_t pixel, const glm::dvec3& eye) const;
    void classify();
    void judge();
    void band();
    void edges();
    void probes(std::span<const Probe> lines, const Transform<Ecef, Enu>& ecefFromProbes);
    bool inBand(std::uint32_t pixel) const;
};

bool Comparer::isAsked(std::size_t pixel, const glm::dvec3& eye) const {
    const SurfacePoint& s = surface(pixel);
    if (answer.visibility[pixel] < 0.0f || answer.texels[pixel] <= 0.0f ||
        glm::dot(s.normal, towardsLight(light, s.position)) <= 0.0)
        return false;
    if (answer.viewDepths.empty())
        return true;
    const double ratio = double(answer.viewDepths[pixel]) / s.viewDepthMetres;
    return std::isfinite(ratio) && samePlane(s.position, s.normal, eye + ratio * (s.position - eye),
                                             surfaceTolerance(camera, s.viewDepthMetres));
}

// Which pixels are asked, what all of them together are off by, and which are wrong.
void Comparer::classify() {
    const glm::dvec3 eye = rays.stored(camera.position);
    out.verdicts.assign(reference.surfaces.size(), Verdict::NotAsked);
    double absolute = 0.0, square = 0.0;
    for (std::size_t i = 0; i < reference.surfaces.size(); ++i) {
        if (!surface(i).any)
            continue;
        ++out.metrics.pixels;
        if (!isAsked(i, eye))
            continue;
        asked.push_back(std::uint32_t(i));
        const double v = answer.visibility[i], error = v - double(truth[i]);
        absolute += std::abs(error);
        square += error * error;
        out.verdicts[i] = Verdict::Right;
        if (truth[i] <= 0.0f && v >= 0.5)
            out.verdicts[i] = Verdict::FalseLit;
        else if (truth[i] >= 1.0f && v < 0.5)
            out.verdicts[i] = Verdict::FalseShadow;
        if (out.verdicts[i] != Verdict::Right)
            wrong.push_back(std::uint32_t(i));
    }
    out.metrics.litFacing = asked.size();
    if (!asked.empty()) {
        out.metrics.meanAbsolute = absolute / double(asked.size());
        out.metrics.rootMeanSquare = std::sqrt(square / double(asked.size()));
    }
}

bool Comparer::inBand(std::uint32_t pixel) const {
    const SurfacePoint& s = surface(pixel);
    const double radius = (1.0 + answer.filterRadiusTexels) * answer.texels[pixel];
    return rays.changesWithin(s.position, s.normal, light, answer.soft, radius);
}

// Of each wrong pixel: in the band or not; outside it, acne or leak or neither.
void Comparer::judge() {
    std::vector<std::uint8_t> near(wrong.size()), far(wrong.size());
    inParallel(wrong.size(), 64, 0, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t pixel = wrong[i];
            const SurfacePoint& s = surface(pixel);
            const double radius = kNearTexels * answer.texels[pixel];
            near[i] = inBand(pixel);
            far[i] = out.verdicts[pixel] == Verdict::FalseLit
                         ? rays.contactWithin(s.position, s.normal, light, radius)
                         : !rays.shadowWithin(s.position, s.normal, light, answer.soft, radius);
        }
    });
    std::size_t lit[2] = {}, shadow[2] = {}, leak = 0, acne = 0; // outside the band, in it
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        Verdict& verdict = out.verdicts[wrong[i]];
        const bool isLit = verdict == Verdict::FalseLit;
        ++(isLit ? lit : shadow)[near[i]];
        if (!near[i])
            (isLit ? leak : acne) += far[i];
        else
            verdict = isLit ? Verdict::FalseLitInBand : Verdict::FalseShadowInBand;
    }
    const double all = double(std::max<std::size_t>(asked.size(), 1));
    Metrics& m = out.metrics;
    m.falseLit = double(lit[0]) / all;
    m.falseShadow = double(shadow[0]) / all;
    m.falseLitAll = double(lit[0] + lit[1]) / all;
    m.falseShadowAll = double(shadow[0] + shadow[1]) / all;
    m.leak = double(leak) / all;
    m.acne = double(acne) / all;
}

void Comparer::band() {
    const std::vector<std::uint32_t> chosen = evenly(asked);
    std::vector<std::uint8_t> near(chosen.size());
    inParallel(chosen.size(), 64, 0, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            near[i] = inBand(chosen[i]);
    });
    if (!chosen.empty())
        out.metrics.band = double(std::count(near.begin(), near.end(), 1)) / double(chosen.size());
}

void Comparer::edges() {
    const int width = reference.width, height = reference.height;
    std::vector<std::uint8_t> links(reference.surfaces.size(), 0);
    const auto joined = [&](std::size_t a, std::size_t b) {
        if (out.verdicts[a] == Verdict::NotAsked || out.verdicts[b] == Verdict::NotAsked)
            return false;
        const SurfacePoint &p = surface(a), &q = surface(b);
        // A curved surface may bend away by the angle that still counts as one.
        const double bend = std::sqrt(1.0 - kSameSurfaceCosine * kSameSurfaceCosine) *
                            glm::length(q.position - p.position);
        const bool bends = glm::dot(p.normal, q.normal) < 1.0 - 1e-9;
        return glm::dot(p.normal, q.normal) >= kSameSurfaceCosine &&
               samePlane(p.position, p.normal, q.position,
                         surfaceTolerance(camera, p.viewDepthMetres) + (bends ? bend : 0.0));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(width) + std::size_t(x);
            if (x + 1 < width && joined(i, i + 1))
                links[i] |= kLinkRight;
            if (y + 1 < height && joined(i, i + std::size_t(width)))
                links[i] |= kLinkBelow;
        }
    out.metrics.edgePixels = contourDistance({width, height, links}, answer.visibility, truth);
}

void Comparer::probes(std::span<const Probe> lines, const Transform<Ecef, Enu>& ecefFromProbes) {
    const auto keepLargest = [](std::optional<double>& most, double value) {
        most = most ? std::max(*most, value) : value;
    };
    for (const Probe& line : lines) {
        const ProbeSamples s =
            sampleProbe({rays, reference, truth, answer.visibility, answer.texels, camera, light},
                        line, ecefFromProbes);
        if (s.metres.empty())
            continue;
        if (line.kind == Probe::Kind::Contact) {
            keepLargest(
                out.metrics.peterPanningMetres,
                std::max(shadowStart(s.metres, s.drawn) - shadowStart(s.metres, s.reference), 0.0));
            continue;
        }
        const auto drawn = fallWidth(s.metres, s.drawn), real = fallWidth(s.metres, s.reference);
        const double texel = s.texelMetres;
        const bool spans =
            answer.soft && real &&
            *real * s.lightPerMetre / kFallShareOfPenumbra >= kLeastPenumbraTexels * texel;
        if (spans) // one that is not drawn at all has no width
            keepLargest(out.metrics.penumbraError, std::abs(drawn.value_or(0.0) / *real - 1.0));
        else if (drawn)
            keepLargest(out.metrics.penumbraTexels, *drawn * s.lightPerMetre / texel);
    }
}

} // namespace

Comparison compare(const RayScene& rays, const Reference& reference, const Light& light,
                   const Answer& answer, const Camera& camera, std::span<const Probe> probes,
                   const Transform<Ecef, Enu>& ecefFromProbes) {
    Comparer comparer(rays, reference, light, answer, camera);
    comparer.classify();
    comparer.judge();
    comparer.band();
    comparer.edges();
    comparer.probes(probes, ecefFromProbes);
    return std::move(comparer.out);
}

} // namespace gnomon::bench
