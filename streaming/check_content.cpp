#include "streaming/check_content.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gnomon {

namespace {

using Flaw = std::optional<std::string>;

template <class Vector>
bool isFinite(const Vector& v) {
    for (int i = 0; i < v.length(); ++i) {
        if (!std::isfinite(v[i])) {
            return false;
        }
    }
    return true;
}

// NaN and infinity are the floats whose exponent is all ones: one integer test a component, without
// a branch, so that the loop is as fast as memory.
bool areFinite(const float* values, std::size_t count) {
    static_assert(sizeof(float) == 4 && std::numeric_limits<float>::is_iec559);
    constexpr std::uint32_t kExponent = 0x7f800000u;
    bool bad = false;
    for (std::size_t i = 0; i < count; ++i) {
        bad |= (std::bit_cast<std::uint32_t>(values[i]) & kExponent) == kExponent;
    }
    return !bad;
}

bool isOneEach(std::size_t size, std::size_t vertices) {
    return size == 0 || size == vertices;
}

Flaw flawOfVertices(const Mesh& mesh) {
    const std::size_t n = mesh.positions.size();
    if (mesh.normals.size() != n || !isOneEach(mesh.uvs.size(), n) ||
        !isOneEach(mesh.colors.size(), n) || !isOneEach(mesh.features.size(), n)) {
        return "an attribute has another count than its " + std::to_string(n) + " vertices";
    }
    static_assert(sizeof(glm::vec3) == 3 * sizeof(float) && sizeof(glm::vec2) == 2 * sizeof(float));
    if (n > 0 && !areFinite(&mesh.positions[0].x, 3 * n)) {
        return "a position is not finite";
    }
    if (!mesh.uvs.empty() && !areFinite(&mesh.uvs[0].x, 2 * n)) {
        return "a texture coordinate is not finite";
    }
    return {};
}

Flaw flawOfTriangles(const Mesh& mesh) {
    if (mesh.indices.size() % 3 != 0) {
        return "its indices make no whole triangles";
    }
    const std::uint32_t largest =
        mesh.indices.empty() ? 0 : *std::max_element(mesh.indices.begin(), mesh.indices.end());
    if (!mesh.indices.empty() && largest >= mesh.positions.size()) {
        return "index " + std::to_string(largest) + " of " + std::to_string(mesh.positions.size()) +
               " vertices";
    }
    if (mesh.faceNormals.size() != mesh.triangles()) {
        return std::to_string(mesh.faceNormals.size()) + " face normals for " +
               std::to_string(mesh.triangles()) + " triangles";
    }
    if (std::uint64_t(mesh.closedTriangles) + mesh.skirtTriangles > mesh.triangles()) {
        return "more closed triangles and skirts than there are triangles";
    }
    return {};
}

// Features are not looked at: numbers behind a table's last row are features without properties
// (gltf_features.h), and nobody indexes with them.
Flaw flawOf(const Mesh& mesh, std::size_t materials) {
    const glm::dmat3& axes = mesh.box.halfAxes;
    if (!isFinite(mesh.origin.xyz) || !isFinite(mesh.box.centre.xyz) || !isFinite(axes[0]) ||
        !isFinite(axes[1]) || !isFinite(axes[2])) {
        return "its place or box is not finite";
    }
    if (!(std::isfinite(mesh.radiusMetres) && mesh.radiusMetres >= 0.0)) {
        return "its radius is no length";
    }
    if (mesh.material < 0 || std::size_t(mesh.material) >= materials) {
        return "material " + std::to_string(mesh.material) + " of " + std::to_string(materials);
    }
    Flaw flaw = flawOfVertices(mesh);
    return flaw ? flaw : flawOfTriangles(mesh);
}

Flaw flawOf(const Material& material, std::size_t images) {
    if (material.image < -1 || material.image >= std::ptrdiff_t(images)) {
        return "image " + std::to_string(material.image) + " of " + std::to_string(images);
    }
    if (!isFinite(material.baseColor) || !std::isfinite(material.alphaCutoff)) {
        return "a colour is not finite";
    }
    return {};
}

Flaw flawOf(const Image& image) {
    if (image.width < 1 || image.height < 1 ||
        image.rgba.size() / 4 / std::size_t(image.width) != std::size_t(image.height) ||
        image.rgba.size() % (4 * std::size_t(image.width)) != 0) {
        return "its pixels are not " + std::to_string(image.width) + " x " +
               std::to_string(image.height);
    }
    return {};
}

template <class Things, class... More>
Flaw firstFlaw(const char* kind, const Things& things, const More&... more) {
    for (std::size_t i = 0; i < things.size(); ++i) {
        if (const Flaw flaw = flawOf(things[i], more...)) {
            return "decoded to a " + std::string(kind) + ' ' + std::to_string(i) +
                   " that cannot be: " + *flaw;
        }
    }
    return {};
}

} // namespace

std::optional<std::string> brokenPromise(const TileContent& content) {
    Flaw flaw = firstFlaw("mesh", content.meshes, content.materials.size());
    flaw = flaw ? flaw : firstFlaw("material", content.materials, content.images.size());
    return flaw ? flaw : firstFlaw("image", content.images);
}

} // namespace gnomon
