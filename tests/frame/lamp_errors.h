// Lamps' shadows held against rays in double: how far what a map holds, or a picture shows, is off.
#pragma once

#include "shadows/lamp_pass.h"
#include "tests/frame/lamp_rays.h"
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace gnomon::test {

// The maps of one lamp alone, and rays to the centres of their texels.
struct Maps {
    explicit Maps(const ShadowSettings& settings, const Lamp& lamp, SmallScene& scene) {
        const auto tiles = scene.renderer().residentTiles();
        for (const ResidentTile& tile : tiles)
            for (std::uint32_t m = 0; m < tile.content->meshes.size(); ++m)
                casters.push_back({tile.content, m, nullptr});
        input.meshAxes = scene.scene().ecefFromAnchor.axes();
        input.ecefFromAnchor = scene.scene().ecefFromAnchor;
        input.lamps = std::span(&lamp, 1);
        input.live = std::span(&zero, 1);
        input.casters = casters;
        const auto start = std::chrono::steady_clock::now();
        pass.drawMaps(input, settings);
        maps = lampMaps(settings, lamp);
        for (int m = 0; m < maps.count; ++m)
            texels.push_back(pass.read(0, m));
        milliseconds =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                .count();
        lampFromEnu = lampFromEcef(input.ecefFromAnchor, lamp) * input.ecefFromAnchor;
    }

    LampPass pass;
    LampPassInput input;
    std::size_t zero = 0;
    std::vector<LampCaster> casters;
    LampMaps maps;
    std::vector<std::vector<float>> texels;
    double milliseconds = 0;
    Transform<LampFrame, Enu> lampFromEnu;
};

struct MapErrors {
    std::size_t compared = 0, wrong = 0, inexplicable = 0;
    double worstTexels = 0.0; // how far off the farthest edge is
};

// Every texel of a map (one in `step` each way) holds the distance of what a ray through its centre
// meets. One that holds another plane's is off by as much as it is to the nearest ray that meets
// that plane.
inline MapErrors errorsOf(const Maps& m, const LampRays& rays, int step) {
    MapErrors out;
    const glm::dmat3 enuFromLamp = glm::transpose(m.lampFromEnu.axes());
    const int n = m.maps.texels;
    for (int map = 0; map < m.maps.count; ++map)
        for (int y = kLampGuardTexels; y < n - kLampGuardTexels; y += step)
            for (int x = kLampGuardTexels; x < n - kLampGuardTexels; x += step) {
                const glm::dvec2 at(x + 0.5, y + 0.5);
                const auto ray = [&](const glm::dvec2& p) {
                    return enuFromLamp * lampDirection(m.maps, {map, p});
                };
                if (m.maps.method == LampMethod::Paraboloid &&
                    glm::length(at - 0.5 * n) > 0.5 * n - kLampGuardTexels)
                    continue; // the other map's
                const double stored =
                    m.texels[std::size_t(map)][std::size_t(y) * std::size_t(n) + std::size_t(x)];
                const glm::dvec3 v = ray(at);
                const auto agrees = [&](double d) {
                    return stored == d || std::abs(stored - d) < 1e-4 * d;
                };
                ++out.compared;
                if (agrees(rays.nearest(v).distance))
                    continue;
                ++out.wrong;
                double off = 1e9;
                for (double r = 0.05; r < 60.0 && off > 60.0; r += r < 1.0 ? 0.05 : 0.5)
                    for (int k = 0; k < 32; ++k) {
                        const double a = k * std::numbers::pi / 16;
                        const LampRays::Hit hit =
                            rays.nearest(ray(at + r * glm::dvec2(std::cos(a), std::sin(a))));
                        // Its plane; or, by a face that is seen edge on, about as far.
                        if (std::isinf(hit.distance)
                                ? std::isinf(stored)
                                : agrees(rays.planeDistance(hit.triangle, v)) ||
                                      std::abs(stored - hit.distance) < 0.01 * hit.distance)
                            off = r;
                    }
                if (off > 60.0)
                    ++out.inexplicable;
                else
                    out.worstTexels = std::max(out.worstTexels, off);
            }
    return out;
}

// A picture's pixels against rays; those that disagree by how far the nearest edge is, in texels.
struct Disagreement {
    std::size_t compared = 0, lit = 0, dark = 0, away = 0, wrong = 0;
    std::size_t acne = 0, leaks = 0; // farther than 2 texels from any edge
    std::size_t falseAway = 0, specks = 0;
    std::size_t clear = 0, spotted = 0; // no edge within 3 texels; of these, neither 0 nor 1
    double worstTexels = 0.0;

    void operator+=(const Disagreement& d) {
        compared += d.compared, lit += d.lit, dark += d.dark, away += d.away, wrong += d.wrong;
        acne += d.acne, leaks += d.leaks, falseAway += d.falseAway, specks += d.specks;
        clear += d.clear, spotted += d.spotted;
        worstTexels = std::max(worstTexels, d.worstTexels);
    }
};

// What rays said of a picture's pixels, asked once: 0 dark, 1 lit, -1 not asked yet.
using Truths = std::vector<std::int8_t>;

// The nearest change of `truth` on the receiver's plane around a pixel, in texels, or `most`. Where
// the face itself ends there is an edge too.
inline double edgeDistance(const LampRays& rays, const glm::dvec3& to, const glm::dvec3& normal,
                           double texel, double tolerance, bool truth, double most, double step,
                           bool faceEnds = true) {
    const double distance = glm::length(to);
    const glm::dvec3 side = glm::normalize(glm::cross(
        to, std::abs(to.z) < 0.9 * distance ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
    const glm::dvec3 up = glm::cross(side, to / distance);
    for (double r = step; r < most; r += r < 2.0 ? step : 1.0)
        for (int k = 0; k < 16; ++k) {
            const double a = k * std::numbers::pi / 8;
            const glm::dvec3 v =
                glm::normalize(-to + r * texel * (std::cos(a) * side + std::sin(a) * up));
            const double along = glm::dot(normal, -to) / glm::dot(normal, v);
            if (!(along > 0.0) || rays.visible(rays.lamp() + along * v, tolerance) != truth ||
                (faceEnds && rays.nearest(v).distance > 1.001 * along))
                return r;
        }
    return most;
}

inline Disagreement disagreementOf(const Shot& shot, const FloatPicture& visibility,
                                   const FloatPicture& texels, const LampRays& rays, bool allRound,
                                   Truths& truths) {
    Disagreement out;
    truths.resize(shot.position.size(), -1);
    for (std::size_t i = 0; i < shot.position.size(); ++i) {
        if (shot.sky(i)) {
            EXPECT_EQ(visibility.values[i], -1.0f);
            continue;
        }
        const glm::dvec3 &p = shot.position[i], &normal = shot.normal[i];
        const glm::dvec3 to = rays.lamp() - p;
        const double distance = glm::length(to), facing = glm::dot(normal, to) / distance;
        const bool unlit = !allRound && to.z < -1e-4;
        if (facing < -1e-3 || unlit) {
            ++out.away;
            out.falseAway += visibility.values[i] != 0.0f;
            continue;
        }
        if (facing < 0.01 || (!allRound && to.z < 1e-4))
            continue; // seen edge on from the lamp
        const double tolerance = 2e-5 * (1.0 + shot.depth[i]) / facing;
        if (truths[i] < 0)
            truths[i] = rays.visible(p, tolerance);
        const bool truth = truths[i] == 1;
        ++(truth ? out.lit : out.dark);
        ++out.compared;
        const double texel = texels.values[i];
        const auto edge = [&](double most, double step, bool faceEnds = true) {
            return edgeDistance(rays, to, normal, texel, tolerance, truth, most, step, faceEnds);
        };
        if ((visibility.values[i] >= 0.5f) == truth) {
            if (i % 47 == 0 && edge(3.0, 0.75) >= 3.0) {
                ++out.clear;
                out.spotted += visibility.values[i] != (truth ? 1.0f : 0.0f);
            }
            continue;
        }
        ++out.wrong;
        const double off = edge(12.0, 0.1);
        (truth ? out.acne : out.leaks) += off > 2.0;
        // Dark on a face that no shadow is near: not even at the face's own edge.
        if (truth)
            out.specks += edge(3.0, 0.25, false) > 2.0;
        out.worstTexels = std::max(out.worstTexels, off);
    }
    return out;
}

} // namespace gnomon::test
