#include "streaming/draco.h"
#include "streaming/gltf_features.h"
#include "streaming/gltf_parts.h"
#include "streaming/tinygltf.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// One attribute, from an accessor or out of the Draco buffer.
class AttributeSource {
  public:
    explicit AttributeSource(AccessorReader reader) : reader_(std::move(reader)) {}
    AttributeSource(DracoAttribute values, bool normalized)
        : draco_(std::move(values)), normalized_(normalized) {}

    std::size_t count() const {
        return reader_ ? reader_->count() : draco_.values.size() / std::size_t(draco_.components);
    }
    int components() const { return reader_ ? reader_->components() : draco_.components; }
    double value(std::size_t i, int c) const {
        if (reader_) {
            return reader_->value(i, c);
        }
        return normalized_ ? normalizedValue(i, c) : raw(i, c);
    }
    double normalizedValue(std::size_t i, int c) const {
        if (reader_) {
            return reader_->normalizedValue(i, c);
        }
        const double v = raw(i, c);
        return draco_.integerMax > 0.0 ? normalizeInteger(v, draco_.integerMax, draco_.isSigned)
                                       : v;
    }

  private:
    double raw(std::size_t i, int c) const {
        return draco_.values[i * std::size_t(draco_.components) + std::size_t(c)];
    }
    std::optional<AccessorReader> reader_;
    DracoAttribute draco_;
    bool normalized_ = false;
};

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

const tinygltf::Value* extensionOf(const tinygltf::Primitive& primitive, const char* name) {
    const auto it = primitive.extensions.find(name);
    return it != primitive.extensions.end() ? &it->second : nullptr;
}

// Attributes by name, wherever the primitive keeps them.
class Attributes {
  public:
    Attributes(const GltfDocument& document, const tinygltf::Primitive& primitive)
        : document_(document), primitive_(primitive) {}

    // Decodes the Draco buffer when there is one; `wanted` are looked up in it.
    void decode(const std::vector<std::string>& wanted, ByteBudget& budget) {
        const tinygltf::Value* extension = extensionOf(primitive_, "KHR_draco_mesh_compression");
        if (!extension) {
            return;
        }
        const tinygltf::Value* ids = member(*extension, "attributes");
        const auto view = indexIn(*extension, "bufferView");
        if (!ids || !view) {
            throw BadContent{"KHR_draco_mesh_compression without bufferView or attributes"};
        }
        std::vector<std::uint32_t> unique;
        for (const std::string& name : wanted) {
            const auto id = indexIn(*ids, name);
            if (id && *id >= 0 && !name.empty()) {
                dracoNames_.push_back(name);
                unique.push_back(std::uint32_t(*id));
            }
        }
        mesh_ = decodeDraco(document_.view(*view), unique, expectation(), budget);
    }
    const std::optional<DracoMesh>& draco() const { return mesh_; }

    std::optional<AttributeSource> open(const std::string& name, int least, int most,
                                        std::size_t vertices) {
        const auto it = primitive_.attributes.find(name);
        const auto at = std::find(dracoNames_.begin(), dracoNames_.end(), name);
        std::optional<AttributeSource> source;
        if (at != dracoNames_.end()) {
            auto& values = mesh_->attributes[std::size_t(at - dracoNames_.begin())];
            const auto& accessors = document_.model().accessors;
            const bool known = it != primitive_.attributes.end() && it->second >= 0 &&
                               std::size_t(it->second) < accessors.size();
            source.emplace(std::move(values),
                           known && accessors[std::size_t(it->second)].normalized);
        } else if (it != primitive_.attributes.end()) {
            source.emplace(AccessorReader(document_, it->second));
        } else {
            return source;
        }
        if (source->components() < least || source->components() > most) {
            throw BadContent{name + " has " + std::to_string(source->components()) + " components"};
        }
        if (source->count() < vertices) {
            throw BadContent{name + " has values for " + std::to_string(source->count()) + " of " +
                             std::to_string(vertices) + " vertices"};
        }
        return source;
    }

  private:
    DracoExpectation expectation() const {
        const auto& accessors = document_.model().accessors;
        const auto count = [&](int accessor) -> std::uint64_t {
            return accessor >= 0 && std::size_t(accessor) < accessors.size()
                       ? accessors[std::size_t(accessor)].count
                       : 0;
        };
        const auto position = primitive_.attributes.find("POSITION");
        constexpr std::uint64_t kMost = std::uint64_t(1) << 32; // no product of these overflows
        const std::uint64_t points =
            position != primitive_.attributes.end() ? count(position->second) : 0;
        return {std::min(points, kMost), std::min(count(primitive_.indices), kMost) / 3};
    }

    const GltfDocument& document_;
    const tinygltf::Primitive& primitive_;
    std::vector<std::string> dracoNames_;
    std::optional<DracoMesh> mesh_;
};

// Turns a run of indices into triangles by the primitive's mode; `restart` cuts strips and fans.
Triangles assemble(const std::vector<std::uint32_t>& indices, int mode, std::uint32_t restart) {
    Triangles out;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        out.reserve(indices.size() / 3);
        for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
            out.push_back({indices[i], indices[i + 1], indices[i + 2]});
        }
        return out;
    }
    out.reserve(indices.size());
    std::size_t start = 0;
    for (std::size_t i = 0; i < indices.size(); ++i) {
        if (indices[i] == restart) {
            start = i + 1;
        } else if (i >= start + 2) {
            const bool fan = mode == TINYGLTF_MODE_TRIANGLE_FAN;
            const bool odd = !fan && ((i - start) & 1u);
            const std::uint32_t a = fan ? indices[start] : indices[i - 2], b = indices[i - 1];
            if (odd) {
                out.push_back({b, a, indices[i]});
            } else {
                out.push_back({a, b, indices[i]});
            }
        }
    }
    return out;
}

std::uint32_t restartOf(ComponentType type) {
    switch (type) {
    case ComponentType::UnsignedByte:
        return 0xffu;
    case ComponentType::UnsignedShort:
        return 0xffffu;
    default:
        return 0xffffffffu;
    }
}

struct IndexRun {
    std::vector<std::uint32_t> indices;
    std::uint32_t restart = 0xffffffffu;
};

IndexRun readIndices(const GltfDocument& document, const tinygltf::Primitive& primitive,
                     std::size_t vertices, ByteBudget& budget) {
    constexpr std::uint64_t kBytesPerIndex = 4 + 12; // a strip has a triangle an index
    IndexRun out;
    std::vector<std::uint32_t>& indices = out.indices;
    if (primitive.indices < 0) {
        budget.take(vertices, kBytesPerIndex, "primitive");
        indices.resize(vertices);
        for (std::size_t i = 0; i < vertices; ++i) {
            indices[i] = std::uint32_t(i);
        }
    } else {
        const AccessorReader reader(document, primitive.indices);
        const ComponentType type = reader.componentType();
        if (reader.components() != 1 ||
            (type != ComponentType::UnsignedByte && type != ComponentType::UnsignedShort &&
             type != ComponentType::UnsignedInt)) {
            throw BadContent{"indices are not unsigned integers"};
        }
        out.restart = restartOf(type);
        budget.take(reader.count(), kBytesPerIndex, "indices");
        indices.resize(reader.count());
        for (std::size_t i = 0; i < indices.size(); ++i) {
            indices[i] = reader.index(i);
        }
    }
    return out;
}

void checkIndex(std::uint32_t index, std::size_t vertices) {
    if (index >= vertices) {
        throw BadContent{"index " + std::to_string(index) + " of " + std::to_string(vertices) +
                         " vertices"};
    }
}

// Renumbers the triangles by first use and returns which of the `vertices` they use, in that order.
// Exporters share one large vertex buffer among many primitives, so its size must not matter.
std::vector<std::uint32_t> compact(Triangles& triangles, std::size_t vertices, ByteBudget& budget) {
    std::uint32_t largest = 0;
    for (const auto& t : triangles) {
        largest = std::max({largest, t[0], t[1], t[2]});
    }
    std::vector<std::uint32_t> used;
    if (triangles.empty()) {
        return used;
    }
    checkIndex(largest, vertices);
    const std::uint64_t corners = std::uint64_t(triangles.size()) * 3;
    // A number for each vertex, where that is not many times the corners; else for each corner.
    const bool dense = largest / 8 <= corners;
    budget.take(std::min<std::uint64_t>(corners, std::uint64_t(largest) + 1),
                2 * sizeof(std::uint32_t), "vertices"); // `used`, which grows by copying
    budget.take(dense ? std::uint64_t(largest) + 1 : 2 * corners, sizeof(std::uint32_t),
                "vertices");
    std::vector<std::uint32_t> sorted;
    if (!dense) {
        sorted.reserve(std::size_t(corners));
        for (const auto& t : triangles) {
            sorted.insert(sorted.end(), t.begin(), t.end());
        }
        std::sort(sorted.begin(), sorted.end());
        sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    }
    constexpr std::uint32_t kUnused = 0xffffffffu;
    std::vector<std::uint32_t> number(dense ? std::size_t(largest) + 1 : sorted.size(), kUnused);
    for (auto& t : triangles) {
        for (std::uint32_t& index : t) {
            const std::size_t slot =
                dense ? index
                      : std::size_t(std::lower_bound(sorted.begin(), sorted.end(), index) -
                                    sorted.begin());
            if (number[slot] == kUnused) {
                number[slot] = std::uint32_t(used.size());
                used.push_back(index);
            }
            index = number[slot];
        }
    }
    return used;
}

std::uint32_t packColor(const AttributeSource& source, std::size_t i) {
    std::uint32_t packed = 0xff000000u;
    for (int c = 0; c < source.components(); ++c) {
        const double v = source.normalizedValue(i, c);
        const double clamped = v > 0.0 ? std::min(v, 1.0) : 0.0; // NaN is 0
        packed &= ~(0xffu << (8 * c));
        packed |= std::uint32_t(std::lround(clamped * 255.0)) << (8 * c);
    }
    return packed;
}

glm::vec3 normalAt(const AttributeSource& source, std::size_t i) {
    const glm::dvec3 n(source.value(i, 0), source.value(i, 1), source.value(i, 2));
    const double length = glm::length(n);
    return length > 0.0 && std::isfinite(length) ? glm::vec3(n / length) : glm::vec3(0.0f);
}

void readVertices(Attributes& attributes, const AttributeSource& positions,
                  const std::vector<std::uint32_t>& used, const TextureMapping& mapping,
                  const FeatureIds& features, PrimitiveData& out) {
    const std::size_t total = positions.count();
    out.positions.reserve(used.size());
    for (const std::uint32_t i : used) {
        out.positions.emplace_back(positions.value(i, 0), positions.value(i, 1),
                                   positions.value(i, 2));
    }
    if (const auto normals = attributes.open("NORMAL", 3, 3, total)) {
        out.attributes |= Soup::Normals;
        for (const std::uint32_t i : used) {
            out.normals.push_back(normalAt(*normals, i));
        }
    }
    if (mapping.used) {
        const std::string name = "TEXCOORD_" + std::to_string(mapping.texCoord);
        if (const auto uvs = attributes.open(name, 2, 2, total)) {
            out.attributes |= Soup::Uvs;
            for (const std::uint32_t i : used) {
                out.uvs.push_back(mapping.apply({uvs->value(i, 0), uvs->value(i, 1)}));
            }
        }
    }
    if (const auto colors = attributes.open("COLOR_0", 3, 4, total)) {
        out.attributes |= Soup::Colors;
        for (const std::uint32_t i : used) {
            out.colors.push_back(packColor(*colors, i));
        }
    }
    const auto ids = features.attribute.empty() ? std::nullopt
                                                : attributes.open(features.attribute, 1, 1, total);
    if (ids || features.implicit) {
        out.attributes |= Soup::Features;
        for (const std::uint32_t i : used) {
            out.features.push_back(ids ? features.rowOf(ids->value(i, 0))
                                       : features.rowOfNumber(i));
        }
    }
}

Triangles readTriangles(const GltfDocument& document, const tinygltf::Primitive& primitive,
                        const Attributes& attributes, std::size_t vertices, ByteBudget& budget) {
    if (attributes.draco()) {
        const std::vector<std::uint32_t>& indices = attributes.draco()->indices;
        budget.take(indices.size(), sizeof(std::uint32_t), "indices");
        return assemble(indices, TINYGLTF_MODE_TRIANGLES, 0xffffffffu);
    }
    const IndexRun run = readIndices(document, primitive, vertices, budget);
    return assemble(run.indices, primitive.mode, run.restart);
}

} // namespace

PrimitiveData readPrimitive(const GltfDocument& document, const tinygltf::Primitive& primitive,
                            const TextureMapping& mapping, const FeatureIds& features,
                            Warnings& warnings, const ByteBudget& budget) {
    PrimitiveData out;
    if (primitive.mode >= TINYGLTF_MODE_LINE && primitive.mode <= TINYGLTF_MODE_LINE_STRIP) {
        warnings.add("lines are not drawn");
        return out;
    }
    if (extensionOf(primitive, "KHR_gaussian_splatting")) {
        warnings.add("gaussian splats (KHR_gaussian_splatting) are not drawn");
        return out;
    }
    if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN) {
        throw BadContent{"primitive mode " + std::to_string(primitive.mode) + " does not exist"};
    }
    ByteBudget scratch = budget; // what this function holds is given back when it returns
    Attributes attributes(document, primitive);
    attributes.decode({"POSITION", "NORMAL", "TEXCOORD_" + std::to_string(mapping.texCoord),
                       "COLOR_0", features.attribute},
                      scratch);
    const auto positions = attributes.open("POSITION", 3, 3, 0);
    if (!positions) {
        warnings.add("primitive without POSITION left out");
        return out;
    }
    std::vector<std::uint32_t> used;
    out.isPoints = primitive.mode == TINYGLTF_MODE_POINTS;
    if (out.isPoints) {
        used = readIndices(document, primitive, positions->count(), scratch).indices;
        for (const std::uint32_t index : used) {
            checkIndex(index, positions->count());
        }
    } else {
        out.triangles = readTriangles(document, primitive, attributes, positions->count(), scratch);
        scratch.take(out.triangles.size(), 3 * sizeof(std::uint32_t), "triangles");
        used = compact(out.triangles, positions->count(), scratch);
    }
    scratch.take(used.size(), sizeof(glm::dvec3) + sizeof(glm::vec3) + sizeof(glm::vec2) + 8,
                 "vertices");
    readVertices(attributes, *positions, used, mapping, features, out);
    return out;
}

} // namespace gnomon
