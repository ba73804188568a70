#include "streaming/split.h"

#include "geo/ellipsoid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

namespace gnomon {

namespace {

// East, north, up where the content is on the Earth, for boxes that are thin in height; else the
// tile's own axes, made square; else ECEF's.
glm::dmat3 cuttingAxes(Point<Ecef> origin, const Transform<Ecef, Tile>& ecefFromTile) {
    constexpr double kDeepestMetres = -20e3, kHighestMetres = 100e3;
    if (const Result<Geodetic> place = geodeticFromEcef(origin);
        place && place->heightMetres > kDeepestMetres && place->heightMetres < kHighestMetres) {
        return ecefFromEnu(*place).axes();
    }
    const glm::dmat3 axes = ecefFromTile.axes();
    const glm::dvec3 x = glm::normalize(axes[0]);
    const glm::dvec3 z = glm::normalize(glm::cross(x, axes[1]));
    const glm::dmat3 square(x, glm::cross(z, x), z);
    const bool usable = std::abs(glm::determinant(square) - 1.0) < 1e-6; // false for NaN
    return usable ? square : glm::dmat3(1.0);
}

struct Box {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};

    void add(const glm::dvec3& p) {
        min = glm::min(min, p);
        max = glm::max(max, p);
    }
    glm::dvec3 centre() const { return (min + max) / 2.0; }
    glm::dvec3 half() const { return (max - min) / 2.0; }
};

// A triangle's place in the order of meshes.
struct Key {
    std::uint32_t material = 0;
    std::uint64_t cell = 0;
    std::uint32_t triangle = 0;

    bool sameMesh(const Key& o) const { return material == o.material && cell == o.cell; }
    bool operator<(const Key& o) const {
        return material != o.material ? material < o.material
               : cell != o.cell       ? cell < o.cell
                                      : triangle < o.triangle;
    }
};

class Splitter {
  public:
    Splitter(const Soup& soup, const CleanSoup& clean, const Transform<Ecef, Tile>& ecefFromTile,
             const std::optional<glm::dmat3>& meshAxes)
        : soup_(soup), clean_(clean),
          axes_(meshAxes ? *meshAxes : cuttingAxes(clean.origin, ecefFromTile)),
          storedFromEcef_(meshAxes ? glm::transpose(*meshAxes) : glm::dmat3(1.0)) {
        const glm::dmat3 m = ecefFromTile.axes();
        const double sign = glm::determinant(m) < 0.0 ? -1.0 : 1.0;
        normalAxes_ =
            sign * storedFromEcef_ *
            glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
    }

    std::vector<Mesh> run() {
        std::vector<Mesh> meshes;
        const std::vector<Key> keys = sortedKeys();
        for (std::size_t i = 0; i < keys.size();) {
            std::size_t end = i + 1;
            while (end < keys.size() && keys[end].sameMesh(keys[i])) {
                ++end;
            }
            meshes.push_back(build(std::span(&keys[i], end - i)));
            i = end;
        }
        return meshes;
    }

  private:
    glm::dvec3 inAxes(std::uint32_t vertex) const {
        return glm::transpose(axes_) * clean_.local[vertex];
    }

    glm::dvec3 centroid(const Soup::Triangle& t) const {
        return (inAxes(t.vertex[0]) + inAxes(t.vertex[1]) + inAxes(t.vertex[2])) / 3.0;
    }

    std::vector<Key> keysAt(const Box& box, double cellMetres) const {
        const glm::dvec3 extent = box.max - box.min;
        constexpr double kMostCells = double(1 << 20); // an axis, so that three fit 64 bits
        const glm::dvec3 cells =
            glm::clamp(glm::ceil(extent / cellMetres), glm::dvec3(1.0), glm::dvec3(kMostCells));
        std::vector<Key> keys;
        keys.reserve(clean_.triangles.size());
        for (std::uint32_t i = 0; i < clean_.triangles.size(); ++i) {
            const Soup::Triangle& t = clean_.triangles[i];
            const glm::dvec3 at = centroid(t) - box.min;
            std::uint64_t cell = 0;
            for (int axis = 2; axis >= 0; --axis) {
                const double part = extent[axis] > 0.0 ? at[axis] / extent[axis] : 0.0;
                const double n = std::clamp(std::floor(part * cells[axis]), 0.0, cells[axis] - 1.0);
                cell = cell << 21 | std::uint64_t(n);
            }
            keys.push_back({t.material, cell, i});
        }
        std::sort(keys.begin(), keys.end());
        return keys;
    }

    // Cells of kMaxMeshExtentMetres where triangles are dense enough to make meshes worth a draw. A
    // coarse tile is cut into larger cells: it is looked at from afar, and r <= 838 d is all that
    // float positions ask for (a mesh of 2 km may be seen from 1.2 m).
    std::vector<Key> sortedKeys() const {
        constexpr std::size_t kTrianglesAMesh = 256;
        Box box;
        for (const Soup::Triangle& t : clean_.triangles) {
            box.add(centroid(t));
        }
        for (double cell = kMaxMeshExtentMetres;; cell *= 2.0) {
            std::vector<Key> keys = keysAt(box, cell);
            std::size_t meshes = 0;
            for (std::size_t i = 0; i < keys.size(); ++i) {
                meshes += i == 0 || !keys[i].sameMesh(keys[i - 1]);
            }
            const bool whole = !(cell < glm::length(box.max - box.min));
            if (whole || meshes * kTrianglesAMesh <= keys.size()) {
                return keys;
            }
        }
    }

    Mesh build(std::span<const Key> keys);
    void addCorner(Mesh& mesh, const Soup::Triangle& t, int corner, bool closed,
                   const glm::dvec3& faceNormal, OctNormal faceOct, std::uint32_t attributes,
                   std::vector<std::uint32_t>& table) const;

    const Soup& soup_;
    const CleanSoup& clean_;
    glm::dmat3 axes_; // columns: the cutting axes in ECEF
    glm::dmat3 storedFromEcef_;
    glm::dvec3 centre_{0.0}; // of the mesh being built, from the content's origin, stored axes
    glm::dmat3 normalAxes_;  // turns the tile's normals into the stored axes, but for their length
};

// The vertices of a mesh under construction, found again by value: an open-addressing table of
// indices, sized for the worst case.
std::uint64_t hashOf(const Mesh& mesh, std::size_t v) {
    const auto bits = [](float f) { return std::uint64_t(std::bit_cast<std::uint32_t>(f)); };
    std::uint64_t h = 0;
    const auto add = [&h](std::uint64_t value) {
        h = (h ^ value) * 0x9e3779b97f4a7c15ull;
        h ^= h >> 29;
    };
    add(bits(mesh.positions[v].x) | bits(mesh.positions[v].y) << 32);
    add(bits(mesh.positions[v].z) | std::uint64_t(std::uint16_t(mesh.normals[v].x)) << 32 |
        std::uint64_t(std::uint16_t(mesh.normals[v].y)) << 48);
    if (!mesh.uvs.empty()) {
        add(bits(mesh.uvs[v].x) | bits(mesh.uvs[v].y) << 32);
    }
    if (!mesh.features.empty()) {
        add(mesh.features[v]);
    }
    return h;
}

bool sameVertex(const Mesh& mesh, std::size_t a, std::size_t b) {
    return mesh.positions[a] == mesh.positions[b] && mesh.normals[a].x == mesh.normals[b].x &&
           mesh.normals[a].y == mesh.normals[b].y &&
           (mesh.uvs.empty() || mesh.uvs[a] == mesh.uvs[b]) &&
           (mesh.colors.empty() || mesh.colors[a] == mesh.colors[b]) &&
           (mesh.features.empty() || mesh.features[a] == mesh.features[b]);
}

template <class T>
void popIfAny(std::vector<T>& v) {
    if (!v.empty()) {
        v.pop_back();
    }
}

// Keeps the vertex just pushed, or takes it back when the mesh has its like.
std::uint32_t settleLast(Mesh& mesh, std::vector<std::uint32_t>& table) {
    constexpr std::uint32_t kNone = 0xffffffffu;
    const std::uint32_t last = std::uint32_t(mesh.positions.size() - 1);
    for (std::size_t i = hashOf(mesh, last) & (table.size() - 1);;
         i = (i + 1) & (table.size() - 1)) {
        if (table[i] == kNone) {
            table[i] = last;
            return last;
        }
        if (sameVertex(mesh, table[i], last)) {
            mesh.positions.pop_back();
            mesh.normals.pop_back();
            popIfAny(mesh.uvs);
            popIfAny(mesh.colors);
            popIfAny(mesh.features);
            return table[i];
        }
    }
}

void Splitter::addCorner(Mesh& mesh, const Soup::Triangle& t, int corner, bool closed,
                         const glm::dvec3& faceNormal, OctNormal faceOct, std::uint32_t attributes,
                         std::vector<std::uint32_t>& table) const {
    const std::uint32_t v = t.vertex[corner];
    const glm::dvec3 stored = normalAxes_ * glm::dvec3(soup_.normals[v]);
    const double length = glm::length(stored);
    OctNormal normal = faceOct;
    if (length > 0.0 && std::isfinite(length)) {
        // What bounds a solid faces outward; on an open surface the shader looks at the viewer.
        const bool inward = closed && glm::dot(stored, faceNormal) < 0.0;
        normal = encodeOct((inward ? -stored : stored) / length);
    }
    // From the mesh's centre, both near: the Earth's radius never enters.
    mesh.positions.push_back(glm::vec3(storedFromEcef_ * clean_.local[v] - centre_));
    mesh.normals.push_back(normal);
    if (attributes & Soup::Uvs) {
        mesh.uvs.push_back(soup_.uvs[v]);
    }
    if (attributes & Soup::Colors) {
        mesh.colors.push_back(soup_.colors[v]);
    }
    if (attributes & Soup::Features) {
        mesh.features.push_back(soup_.features[v]);
    }
    mesh.indices.push_back(settleLast(mesh, table));
}

Mesh Splitter::build(std::span<const Key> keys) {
    Mesh mesh;
    mesh.material = int(keys.front().material);
    Box box;
    std::uint32_t attributes = 0;
    std::vector<std::uint32_t> order;
    for (const bool closed : {true, false}) {
        for (const Key& key : keys) {
            if (bool(clean_.closed[key.triangle]) == closed) {
                order.push_back(key.triangle);
            }
        }
        mesh.closedTriangles = closed ? std::uint32_t(order.size()) : mesh.closedTriangles;
    }
    for (const std::uint32_t i : order) {
        const Soup::Triangle& t = clean_.triangles[i];
        attributes |= t.attributes;
        for (const std::uint32_t v : t.vertex) {
            box.add(inAxes(v));
        }
    }
    mesh.origin = Point<Ecef>{clean_.origin.xyz + axes_ * box.centre()};
    centre_ = storedFromEcef_ * (axes_ * box.centre());

    std::vector<std::uint32_t> table(std::bit_ceil(order.size() * 6 + 16), 0xffffffffu);
    mesh.indices.reserve(order.size() * 3);
    mesh.faceNormals.reserve(order.size());
    for (const std::uint32_t i : order) {
        const Soup::Triangle& t = clean_.triangles[i];
        const glm::dvec3& a = clean_.local[t.vertex[0]];
        const glm::dvec3 face =
            storedFromEcef_ * glm::normalize(glm::cross(clean_.local[t.vertex[1]] - a,
                                                        clean_.local[t.vertex[2]] - a));
        const OctNormal oct = encodeOct(face);
        mesh.faceNormals.push_back(oct);
        for (int corner = 0; corner < 3; ++corner) {
            addCorner(mesh, t, corner, clean_.closed[i], face, oct, attributes, table);
        }
    }

    Box tight; // of the floats, not of what they were rounded from
    double farthest = 0.0;
    for (const glm::vec3& p : mesh.positions) {
        tight.add(glm::transpose(storedFromEcef_ * axes_) * glm::dvec3(p));
        farthest = std::max(farthest, glm::dot(glm::dvec3(p), glm::dvec3(p)));
    }
    const glm::dvec3 half = tight.half();
    mesh.box.centre = Point<Ecef>{mesh.origin.xyz + axes_ * tight.centre()};
    mesh.box.halfAxes = glm::dmat3(axes_[0] * half.x, axes_[1] * half.y, axes_[2] * half.z);
    mesh.radiusMetres = std::sqrt(farthest);
    mesh.positions.shrink_to_fit();
    mesh.normals.shrink_to_fit();
    mesh.uvs.shrink_to_fit();
    mesh.colors.shrink_to_fit();
    mesh.features.shrink_to_fit();
    return mesh;
}

} // namespace

std::vector<Mesh> split(const Soup& soup, const CleanSoup& clean,
                        const Transform<Ecef, Tile>& ecefFromTile,
                        const std::optional<glm::dmat3>& meshAxes) {
    return clean.triangles.empty() ? std::vector<Mesh>{}
                                   : Splitter(soup, clean, ecefFromTile, meshAxes).run();
}

} // namespace gnomon
