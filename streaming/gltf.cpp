#include "streaming/gltf.h"

#include "streaming/gltf_features.h"
#include "streaming/gltf_parts.h"
#include "streaming/normal_axes.h"
#include "streaming/tinygltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace gnomon {

namespace {

// What we read, and what changes only looks we do not have. Anything else that a file requires is
// refused by name.
constexpr std::array<std::string_view, 33> kKnownExtensions{"CESIUM_RTC",
                                                            "CESIUM_primitive_outline",
                                                            "EXT_instance_features",
                                                            "EXT_mesh_features",
                                                            "EXT_mesh_gpu_instancing",
                                                            "EXT_meshopt_compression",
                                                            "EXT_structural_metadata",
                                                            "EXT_texture_webp",
                                                            "KHR_draco_mesh_compression",
                                                            "KHR_lights_punctual",
                                                            "KHR_materials_anisotropy",
                                                            "KHR_materials_clearcoat",
                                                            "KHR_materials_dispersion",
                                                            "KHR_materials_emissive_strength",
                                                            "KHR_materials_ior",
                                                            "KHR_materials_iridescence",
                                                            "KHR_materials_pbrSpecularGlossiness",
                                                            "KHR_materials_sheen",
                                                            "KHR_materials_specular",
                                                            "KHR_materials_transmission",
                                                            "KHR_materials_unlit",
                                                            "KHR_materials_variants",
                                                            "KHR_materials_volume",
                                                            "KHR_mesh_quantization",
                                                            "KHR_meshopt_compression",
                                                            "KHR_techniques_webgl",
                                                            "KHR_texture_basisu",
                                                            "KHR_texture_transform",
                                                            "KHR_xmp_json_ld",
                                                            "MAXAR_image_ortho",
                                                            "MAXAR_nonvisual_geometry",
                                                            "NGA_gpm_local",
                                                            "EXT_feature_metadata"};

void checkRequired(const tinygltf::Model& model) {
    for (const std::string& name : model.extensionsRequired) {
        if (std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) ==
            kKnownExtensions.end()) {
            throw BadContent{"requires the glTF extension " + name.substr(0, 80) +
                             ", which is not supported"};
        }
    }
}

glm::dmat4 matrixOf(const tinygltf::Node& node) {
    if (node.matrix.size() == 16) {
        glm::dmat4 m;
        for (int i = 0; i < 16; ++i) {
            m[i / 4][i % 4] = node.matrix[std::size_t(i)];
        }
        return m;
    }
    const auto component = [](const std::vector<double>& v, std::size_t size, std::size_t i,
                              double otherwise) { return v.size() == size ? v[i] : otherwise; };
    const auto& t = node.translation;
    const auto& r = node.rotation;
    const auto& s = node.scale;
    return composeTrs({component(t, 3, 0, 0.0), component(t, 3, 1, 0.0), component(t, 3, 2, 0.0)},
                      {component(r, 4, 0, 0.0), component(r, 4, 1, 0.0), component(r, 4, 2, 0.0),
                       component(r, 4, 3, 1.0)},
                      {component(s, 3, 0, 1.0), component(s, 3, 1, 1.0), component(s, 3, 2, 1.0)});
}

// 3D Tiles' axes have z up.
glm::dmat4 zUpFrom(UpAxis axis) {
    glm::dmat4 m(1.0);
    if (axis == UpAxis::Y) {
        m[1] = {0.0, 0.0, 1.0, 0.0};
        m[2] = {0.0, -1.0, 0.0, 0.0};
    } else if (axis == UpAxis::X) {
        m[0] = {0.0, 0.0, 1.0, 0.0};
        m[2] = {-1.0, 0.0, 0.0, 0.0};
    }
    return m;
}

glm::dmat4 translation(const glm::dvec3& by) {
    glm::dmat4 m(1.0);
    m[3] = glm::dvec4(by, 1.0);
    return m;
}

glm::dvec3 rtcOf(const tinygltf::Model& model) {
    const auto it = model.extensions.find("CESIUM_RTC");
    if (it == model.extensions.end()) {
        return glm::dvec3(0.0);
    }
    const std::vector<double> center = numbersIn(it->second, "center", 3);
    if (center.empty()) {
        throw BadContent{"CESIUM_RTC without a center of three numbers"};
    }
    return {center[0], center[1], center[2]};
}

// One place where a mesh stands.
struct Copy {
    glm::dmat4 tileFromMesh{1.0};
    std::optional<std::uint32_t> feature; // of the whole; else the vertices' own
};

// Sets the features of a node's instances.
void addFeatures(const GltfDocument& document, const FeatureIds& ids, std::vector<Copy>& copies,
                 Warnings& warnings) {
    if (ids.implicit) {
        for (std::size_t i = 0; i < copies.size(); ++i) {
            copies[i].feature = ids.rowOfNumber(i);
        }
    } else if (ids.accessor >= 0) {
        const AccessorReader reader(document, ids.accessor);
        if (reader.components() != 1 || reader.count() < copies.size()) {
            return warnings.add("EXT_instance_features with ids for too few of the instances");
        }
        for (std::size_t i = 0; i < copies.size(); ++i) {
            copies[i].feature = ids.rowOf(reader.value(i, 0));
        }
    }
}

// The count of an attribute that does not place the instances; nullopt for none that can be read.
std::optional<std::size_t> countOfOthers(const GltfDocument& document,
                                         const tinygltf::Value* attributes) {
    const auto& accessors = document.model().accessors;
    for (const std::string& name : attributes ? attributes->Keys() : std::vector<std::string>()) {
        const int accessor = indexIn(*attributes, name).value_or(-1);
        if (accessor >= 0 && std::size_t(accessor) < accessors.size()) {
            return accessors[std::size_t(accessor)].count;
        }
    }
    return {};
}

// EXT_mesh_gpu_instancing; one where it is when the node has none.
std::vector<Copy> instancesOf(const GltfDocument& document, const tinygltf::Node& node,
                              ByteBudget& budget) {
    const auto it = node.extensions.find("EXT_mesh_gpu_instancing");
    if (it == node.extensions.end()) {
        return {Copy{}};
    }
    const tinygltf::Value* attributes = member(it->second, "attributes");
    const auto open = [&](const char* name, int components) {
        std::optional<AccessorReader> reader;
        const auto accessor = attributes ? indexIn(*attributes, name) : std::nullopt;
        if (accessor) {
            reader.emplace(document, *accessor);
            if (reader->components() != components) {
                throw BadContent{std::string("instances' ") + name + " is of a wrong type"};
            }
        }
        return reader;
    };
    const auto t = open("TRANSLATION", 3), r = open("ROTATION", 4), s = open("SCALE", 3);
    std::optional<std::size_t> count;
    for (const auto* reader : {&t, &r, &s}) {
        if (*reader && count && *count != (*reader)->count()) {
            throw BadContent{"EXT_mesh_gpu_instancing with attributes of different lengths"};
        }
        count = *reader ? (*reader)->count() : count;
    }
    if (!count) { // as many as there are ids, say, all in one place
        count = countOfOthers(document, attributes);
    }
    if (!count) {
        return {Copy{}};
    }
    budget.take(*count, sizeof(Copy) * 2, "instances");
    std::vector<Copy> out;
    out.reserve(*count);
    for (std::size_t i = 0; i < *count; ++i) {
        const auto vec3 = [i](const std::optional<AccessorReader>& a, double otherwise) {
            return a ? glm::dvec3(a->value(i, 0), a->value(i, 1), a->value(i, 2))
                     : glm::dvec3(otherwise);
        };
        const glm::dvec4 q = r ? glm::dvec4(r->normalizedValue(i, 0), r->normalizedValue(i, 1),
                                            r->normalizedValue(i, 2), r->normalizedValue(i, 3))
                               : glm::dvec4(0.0, 0.0, 0.0, 1.0);
        out.push_back({composeTrs(vec3(t, 0.0), q, vec3(s, 1.0)), {}});
    }
    return out;
}

// Where each mesh stands, by mesh in the order first met.
struct Placed {
    int mesh = -1;
    std::vector<Copy> copies;
};

std::vector<int> rootNodes(const tinygltf::Model& model) {
    const int scenes = int(model.scenes.size());
    if (scenes > 0) {
        const int scene =
            model.defaultScene >= 0 && model.defaultScene < scenes ? model.defaultScene : 0;
        return model.scenes[std::size_t(scene)].nodes;
    }
    std::vector<bool> isChild(model.nodes.size(), false);
    for (const auto& node : model.nodes) {
        for (const int child : node.children) {
            if (child >= 0 && std::size_t(child) < isChild.size()) {
                isChild[std::size_t(child)] = true;
            }
        }
    }
    std::vector<int> roots;
    for (std::size_t i = 0; i < isChild.size(); ++i) {
        if (!isChild[i]) {
            roots.push_back(int(i));
        }
    }
    return roots;
}

std::vector<Placed> walk(const GltfDocument& document, const glm::dmat4& tileFromGltf,
                         const GltfFeatures& features, Warnings& warnings, ByteBudget& budget) {
    const auto& model = document.model();
    struct Visit {
        int node;
        glm::dmat4 tileFromParent;
    };
    std::vector<Visit> open;
    std::vector<bool> visited(model.nodes.size(), false);
    std::vector<Placed> placed;
    std::map<int, std::size_t> placedOf;
    const auto push = [&](const std::vector<int>& nodes, const glm::dmat4& matrix) {
        budget.take(nodes.size(), sizeof(Visit) * 2, "nodes");
        for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) {
            open.push_back({*it, matrix});
        }
    };
    push(rootNodes(model), tileFromGltf);
    while (!open.empty()) {
        const Visit visit = open.back();
        open.pop_back();
        if (visit.node < 0 || std::size_t(visit.node) >= model.nodes.size()) {
            throw BadContent{"node " + std::to_string(visit.node) + " does not exist"};
        }
        if (visited[std::size_t(visit.node)]) {
            warnings.add("node with more than one parent, or its own ancestor: drawn once");
            continue;
        }
        visited[std::size_t(visit.node)] = true;
        const tinygltf::Node& node = model.nodes[std::size_t(visit.node)];
        const glm::dmat4 tileFromNode = visit.tileFromParent * matrixOf(node);
        if (node.mesh >= 0) {
            if (std::size_t(node.mesh) >= model.meshes.size()) {
                throw BadContent{"mesh " + std::to_string(node.mesh) + " does not exist"};
            }
            const auto [it, isNew] = placedOf.emplace(node.mesh, placed.size());
            if (isNew) {
                placed.push_back({node.mesh, {}});
            }
            std::vector<Copy> copies = instancesOf(document, node, budget);
            addFeatures(document, features.ofInstances(node), copies, warnings);
            for (Copy& copy : copies) {
                copy.tileFromMesh = tileFromNode * copy.tileFromMesh;
                placed[it->second].copies.push_back(copy);
            }
        }
        push(node.children, tileFromNode);
    }
    return placed;
}

// The places, normals and attributes of a copy's vertices behind those there are: of a soup or a
// cloud alike.
void appendVertices(const PrimitiveData& primitive, const Copy& copy,
                    std::vector<glm::dvec3>& positions, std::vector<glm::vec3>& normals,
                    std::vector<std::uint32_t>& colors, std::vector<std::uint32_t>& features) {
    const glm::dmat3 normalAxes = normalAxesOf(glm::dmat3(copy.tileFromMesh));
    for (const glm::dvec3& p : primitive.positions) {
        positions.push_back(glm::dvec3(copy.tileFromMesh * glm::dvec4(p, 1.0)));
    }
    for (const glm::vec3& normal : primitive.normals) {
        normals.push_back(turnedNormal(normalAxes, normal));
    }
    colors.insert(colors.end(), primitive.colors.begin(), primitive.colors.end());
    if (!copy.feature) {
        features.insert(features.end(), primitive.features.begin(), primitive.features.end());
    }
    normals.resize(positions.size(), glm::vec3(0.0f));
    colors.resize(positions.size(), 0xffffffffu);
    features.resize(positions.size(), copy.feature.value_or(kNoFeature));
}

void append(const PrimitiveData& primitive, const Copy& copy, std::uint32_t material, Soup& soup) {
    const bool mirrored = glm::determinant(glm::dmat3(copy.tileFromMesh)) < 0.0;
    const std::uint32_t first = std::uint32_t(soup.positions.size());
    appendVertices(primitive, copy, soup.positions, soup.normals, soup.colors, soup.features);
    soup.uvs.insert(soup.uvs.end(), primitive.uvs.begin(), primitive.uvs.end());
    soup.uvs.resize(soup.positions.size(), glm::vec2(0.0f));
    const std::uint32_t attributes = primitive.attributes | (copy.feature ? Soup::Features : 0u);
    for (const auto& t : primitive.triangles) {
        Soup::Triangle triangle{{first + t[0], first + t[1], first + t[2]}, material, attributes};
        if (mirrored) {
            std::swap(triangle.vertex[1], triangle.vertex[2]);
        }
        soup.triangles.push_back(triangle);
    }
}

PointCloud cloudOf(const PrimitiveData& primitive, const std::vector<Copy>& copies,
                   std::uint32_t material) {
    PointCloud cloud;
    cloud.material = material;
    bool hasFeatures = primitive.attributes & Soup::Features;
    for (const Copy& copy : copies) {
        appendVertices(primitive, copy, cloud.positions, cloud.normals, cloud.colors,
                       cloud.features);
        hasFeatures = hasFeatures || copy.feature;
    }
    if (!(primitive.attributes & Soup::Normals)) {
        cloud.normals = {};
    }
    if (!(primitive.attributes & Soup::Colors)) {
        cloud.colors = {};
    }
    if (!hasFeatures) {
        cloud.features = {};
    }
    return cloud;
}

std::vector<std::string> extensionsOf(const tinygltf::Model& model) {
    std::vector<std::string> names = model.extensionsUsed;
    names.insert(names.end(), model.extensionsRequired.begin(), model.extensionsRequired.end());
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    constexpr std::size_t kMost = 64;
    names.resize(std::min(names.size(), kMost));
    return names;
}

} // namespace

glm::dmat4 composeTrs(const glm::dvec3& t, const glm::dvec4& rotation, const glm::dvec3& s) {
    const double length = glm::length(rotation);
    const glm::dvec4 q = length > 0.0 ? rotation / length : glm::dvec4(0.0, 0.0, 0.0, 1.0);
    const double x = q.x, y = q.y, z = q.z, w = q.w;
    glm::dmat4 m(1.0);
    m[0] = s.x * glm::dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0);
    m[1] = s.y * glm::dvec4(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0);
    m[2] = s.z * glm::dvec4(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0);
    m[3] = glm::dvec4(t, 1.0);
    return m;
}

GltfContent readGltf(std::span<const std::byte> bytes, const DecodeOptions& options,
                     const std::optional<glm::dvec3>& rtcCenter, ByteBudget& budget) {
    const GltfDocument document(bytes, options, budget);
    const tinygltf::Model& model = document.model();
    if (model.asset.version.empty() || model.asset.version[0] != '2') {
        throw BadContent{"glTF of version " + model.asset.version.substr(0, 20) +
                         "; only 2 is supported"};
    }
    checkRequired(model);

    GltfContent out;
    Warnings warnings;
    const glm::dmat4 tileFromGltf =
        translation(rtcCenter ? *rtcCenter : rtcOf(model)) * zUpFrom(options.gltfUpAxis);
    MaterialTable materials(document, warnings, budget);
    const GltfFeatures features(document, options, warnings, budget);
    for (const Placed& placed : walk(document, tileFromGltf, features, warnings, budget)) {
        for (const auto& primitive : model.meshes[std::size_t(placed.mesh)].primitives) {
            if (primitive.extensions.contains("MAXAR_nonvisual_geometry")) {
                warnings.add("MAXAR_nonvisual_geometry is not drawn");
                continue;
            }
            const MaterialTable::Entry& material = materials.use(primitive.material);
            const PrimitiveData data = readPrimitive(document, primitive, material.mapping,
                                                     features.of(primitive), warnings, budget);
            const std::uint64_t copies = placed.copies.size();
            const std::uint64_t each = data.positions.size() * kBytesPerSoupVertex +
                                       data.triangles.size() * kBytesPerSoupTriangle;
            budget.take(copies, std::max<std::uint64_t>(each, 1), "geometry");
            if (data.isPoints) {
                out.points.push_back(cloudOf(data, placed.copies, material.index));
                continue;
            }
            for (const Copy& copy : placed.copies) {
                append(data, copy, material.index, out.soup);
            }
        }
    }
    out.materials = std::move(materials.materials);
    out.images = std::move(materials.images);
    out.features = features.table();
    out.extensions = extensionsOf(model);
    out.copyright = model.asset.copyright;
    out.warnings = warnings.all();
    return out;
}

} // namespace gnomon
