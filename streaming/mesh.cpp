#include "streaming/mesh.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

constexpr double kSnorm = 32767.0;

double signOf(double v) {
    return v < 0.0 ? -1.0 : 1.0;
}

template <class T>
std::size_t held(const std::vector<T>& v) {
    return v.size() * sizeof(T);
}

} // namespace

glm::dvec3 decodeOct(OctNormal n) {
    glm::dvec2 p(std::max(n.x / kSnorm, -1.0), std::max(n.y / kSnorm, -1.0));
    const double z = 1.0 - std::abs(p.x) - std::abs(p.y);
    if (z < 0.0) {
        p = {(1.0 - std::abs(p.y)) * signOf(p.x), (1.0 - std::abs(p.x)) * signOf(p.y)};
    }
    return glm::normalize(glm::dvec3(p.x, p.y, z));
}

OctNormal encodeOct(const glm::dvec3& unit) {
    const double sum = std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z);
    if (!(sum > 0.0) || !std::isfinite(sum)) {
        return {};
    }
    glm::dvec2 p(unit.x / sum, unit.y / sum);
    if (unit.z < 0.0) {
        p = {(1.0 - std::abs(p.y)) * signOf(p.x), (1.0 - std::abs(p.x)) * signOf(p.y)};
    }
    // Rounding each number to its nearest is off by up to 6.5e-5 rad; the best of the four lattice
    // points around it halves the worst direction.
    const glm::dvec2 base = glm::floor(p * kSnorm);
    OctNormal best;
    double smallest = 8.0;
    for (int corner = 0; corner < 4; ++corner) {
        const OctNormal n{std::int16_t(std::min(base.x + (corner & 1), kSnorm)),
                          std::int16_t(std::min(base.y + (corner >> 1), kSnorm))};
        const glm::dvec3 off = decodeOct(n) - unit;
        const double squared = glm::dot(off, off);
        if (squared < smallest) {
            smallest = squared;
            best = n;
        }
    }
    return best;
}

std::size_t Mesh::bytes() const {
    return sizeof(Mesh) + held(positions) + held(normals) + held(uvs) + held(colors) +
           held(features) + held(indices) + held(faceNormals);
}

std::size_t TileContent::bytes() const {
    std::size_t total = sizeof(TileContent) + held(materials) + (features ? features->bytes() : 0);
    for (const Mesh& mesh : meshes) {
        total += mesh.bytes();
    }
    for (const Image& image : images) {
        total += sizeof(Image) + held(image.rgba);
    }
    return total;
}

} // namespace gnomon
