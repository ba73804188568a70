#include "shadows/plane_finder.h"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon {

namespace {

// What rounding of positions and normals makes of a plane close to the eye.
constexpr double kPlaneToleranceMetres = 5e-4;
constexpr double kSmallestShare = 0.01;
// A plane with a hundredth of the samples is then guessed at least twice.
constexpr std::size_t kGuesses = 256;
constexpr std::size_t kFinalists = 16;

struct Sample {
    glm::dvec3 position, normal;
    double viewDepth;
};

std::vector<Sample> sunlitSamples(const SeenSurfaces& seen, const glm::dvec3& towardsSun,
                                  std::size_t& all) {
    const int width = seen.camera.widthPixels, height = seen.camera.heightPixels;
    constexpr double kWanted = 16384.0;
    const int step =
        std::clamp(int(std::lround(std::sqrt(double(width) * height / kWanted))), 4, 8);
    const SurfaceReader read(seen);
    std::vector<Sample> samples;
    all = 0;
    for (int y = step / 2; y < height; y += step)
        for (int x = step / 2; x < width; x += step) {
            ++all;
            if (read.sky(x, y))
                continue;
            const glm::dvec3 normal = read.normal(x, y);
            if (glm::dot(normal, towardsSun) >= kMinPlaneFacing)
                samples.push_back({read.position(x, y), normal, read.viewDepth(x, y)});
        }
    return samples;
}

double pixelsPerRadian(const Camera& camera) {
    return 0.5 * camera.heightPixels / camera.tanHalfHeight();
}

// Through a point. Off the plane by h, a point's shadow is looked up h / facing away along the
// light: half a pixel at most, as the eye sees it.
ReceiverPlane planeThrough(const glm::dvec3& point, const glm::dvec3& normal,
                           const glm::dvec3& towardsSun, const Camera& camera) {
    ReceiverPlane plane;
    plane.normal = normal;
    plane.offsetMetres = -glm::dot(normal, point);
    plane.toleranceMetres = kPlaneToleranceMetres;
    plane.tolerancePerW = 0.5 * glm::dot(normal, towardsSun) / pixelsPerRadian(camera);
    return plane;
}

double toleranceAt(const ReceiverPlane& plane, const Sample& s) {
    return plane.toleranceMetres + plane.tolerancePerW * s.viewDepth;
}

bool isOn(const ReceiverPlane& plane, const Sample& s, double tolerances = 1.0) {
    return std::abs(plane.distance(s.position)) <= tolerances * toleranceAt(plane, s) &&
           glm::dot(plane.normal, s.normal) >= kSamePlaneCosine;
}

std::size_t countOn(const ReceiverPlane& plane, const std::vector<Sample>& samples,
                    std::size_t stride) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < samples.size(); i += stride)
        count += isOn(plane, samples[i]) ? 1 : 0;
    return count;
}

// Least squares over its samples, each in units of its tolerance; the plane as it was where they do
// not span one.
ReceiverPlane refined(const ReceiverPlane& plane, const std::vector<Sample>& samples,
                      const glm::dvec3& towardsSun, const Camera& camera) {
    glm::dvec3 centre(0.0);
    double total = 0.0;
    for (const Sample& s : samples)
        if (isOn(plane, s)) {
            const double weight = 1.0 / std::pow(toleranceAt(plane, s), 2);
            centre += weight * s.position;
            total += weight;
        }
    if (total == 0.0)
        return plane;
    centre /= total;
    const glm::dvec3 along = glm::normalize(glm::cross(
        plane.normal, std::abs(plane.normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 across = glm::cross(plane.normal, along);
    double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
    for (const Sample& s : samples)
        if (isOn(plane, s)) {
            const double weight = 1.0 / std::pow(toleranceAt(plane, s), 2);
            const glm::dvec3 d = s.position - centre;
            const double x = glm::dot(d, along), y = glm::dot(d, across),
                         z = glm::dot(d, plane.normal);
            xx += weight * x * x, xy += weight * x * y, yy += weight * y * y;
            xz += weight * x * z, yz += weight * y * z;
        }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-9 * xx * yy))
        return plane;
    const double slopeX = (xz * yy - yz * xy) / determinant;
    const double slopeY = (yz * xx - xz * xy) / determinant;
    const glm::dvec3 normal = glm::normalize(plane.normal - slopeX * along - slopeY * across);
    return planeThrough(centre, normal, towardsSun, camera);
}

// The plane with most samples among guesses through single ones, spread evenly over them.
ReceiverPlane bestPlane(const std::vector<Sample>& samples, const glm::dvec3& towardsSun,
                        const Camera& camera) {
    struct Guess {
        ReceiverPlane plane;
        std::size_t count;
    };
    std::vector<Guess> guesses;
    const std::size_t tries = std::min(kGuesses, samples.size());
    const std::size_t stride = std::max<std::size_t>(samples.size() / 2048, 1);
    for (std::size_t i = 0; i < tries; ++i) {
        const Sample& s = samples[(2 * i + 1) * samples.size() / (2 * tries)];
        const ReceiverPlane plane = planeThrough(s.position, s.normal, towardsSun, camera);
        guesses.push_back({plane, countOn(plane, samples, stride)});
    }
    // A guess's normal is rounded, or that of one small face: a better plane may start badly.
    const auto more = [](const Guess& a, const Guess& b) { return a.count > b.count; };
    std::stable_sort(guesses.begin(), guesses.end(), more);
    guesses.resize(std::min(guesses.size(), kFinalists));
    for (Guess& g : guesses) {
        g.count = countOn(g.plane, samples, 1);
        for (int round = 0; round < 3; ++round) {
            const ReceiverPlane better = refined(g.plane, samples, towardsSun, camera);
            const std::size_t count = countOn(better, samples, 1);
            if (count < g.count)
                break;
            g = {better, count};
        }
    }
    return std::min_element(guesses.begin(), guesses.end(), more)->plane;
}

// Half of what is on the one is on the other too, or nearly.
bool nearlyEqual(const ReceiverPlane& plane, const ReceiverPlane& other,
                 const std::vector<Sample>& samples) {
    std::size_t on = 0, both = 0;
    for (const Sample& s : samples)
        if (isOn(plane, s)) {
            ++on;
            both += isOn(other, s, 2.0) ? 1 : 0;
        }
    return 2 * both >= on;
}

} // namespace

SurfaceReader::SurfaceReader(const SeenSurfaces& seen) : seen_(seen) {
    const glm::dmat3 stored = glm::transpose(seen.meshAxes);
    right_ = stored * seen.camera.right.xyz * seen.camera.tanHalfWidth();
    up_ = stored * seen.camera.up.xyz * seen.camera.tanHalfHeight();
    forward_ = stored * seen.camera.forward.xyz;
}

double SurfaceReader::viewDepth(int x, int y) const {
    return double(seen_.viewDepth[index(x, y)]);
}

glm::dvec3 SurfaceReader::position(int x, int y) const {
    const double u = (2.0 * x + 1.0) / seen_.camera.widthPixels - 1.0;
    const double v = 1.0 - (2.0 * y + 1.0) / seen_.camera.heightPixels;
    return viewDepth(x, y) * (forward_ + u * right_ + v * up_);
}

glm::dvec3 SurfaceReader::normal(int x, int y) const {
    const std::uint16_t* oct = &seen_.normals[4 * index(x, y)];
    const double a = oct[0] / 65535.0 * 2.0 - 1.0, b = oct[1] / 65535.0 * 2.0 - 1.0;
    glm::dvec3 n(a, b, 1.0 - std::abs(a) - std::abs(b));
    if (n.z < 0.0) {
        n.x = std::copysign(1.0 - std::abs(b), a);
        n.y = std::copysign(1.0 - std::abs(a), b);
    }
    return glm::normalize(n);
}

std::vector<FoundPlane> findPlanes(const SeenSurfaces& seen, const glm::dvec3& towardsSun,
                                   int count) {
    std::size_t all = 0;
    std::vector<Sample> samples = sunlitSamples(seen, towardsSun, all);
    std::vector<FoundPlane> found;
    while (int(found.size()) < count && !samples.empty()) {
        const ReceiverPlane plane = bestPlane(samples, towardsSun, seen.camera);
        const std::size_t on = countOn(plane, samples, 1);
        if (double(on) < kSmallestShare * double(all))
            break;
        const bool known = std::any_of(found.begin(), found.end(), [&](const FoundPlane& f) {
            return nearlyEqual(plane, f.plane, samples);
        });
        if (!known)
            found.push_back({plane, double(on) / double(all)});
        std::erase_if(samples, [&](const Sample& s) { return isOn(plane, s); });
    }
    return found;
}

} // namespace gnomon
