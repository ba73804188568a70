#include "viewer/place/glb.h"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace gnomon::builtin {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUnsignedByte = 5121, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kVertices = 34962, kIndices = 34963;

static_assert(std::endian::native == std::endian::little, "glb is little-endian");

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

struct Extent {
    glm::vec3 min{3e38f}, max{-3e38f};
};

Extent extentOf(std::span<const glm::vec3> points) {
    Extent e;
    for (const glm::vec3 p : points) {
        e.min = glm::min(e.min, p);
        e.max = glm::max(e.max, p);
    }
    return e;
}

json array(glm::vec3 v) {
    return json::array({v.x, v.y, v.z});
}

template <class T>
int addAttribute(draco::Mesh& mesh, draco::GeometryAttribute::Type type, int components,
                 draco::DataType dataType, bool normalized, std::span<const T> values) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, std::uint8_t(components), dataType, normalized, sizeof(T), 0);
    const int id = mesh.AddAttribute(attribute, true, std::uint32_t(values.size()));
    for (std::size_t i = 0; i < values.size(); ++i)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(std::uint32_t(i)),
                                              &values[i]);
    return int(mesh.attribute(id)->unique_id());
}

// Told apart from colours, which are four bytes too.
struct Index {
    std::uint32_t value;
};

std::vector<Index> indicesOf(std::span<const std::uint32_t> indices) {
    std::vector<Index> out;
    for (const std::uint32_t i : indices)
        out.push_back({i});
    return out;
}

struct Encoded {
    std::vector<std::byte> bytes;
    json attributes = json::object(); // name → Draco's unique id
    std::size_t points = 0, faces = 0;
};

// Draco's step is range / (2^bits - 1): with that range a whole number of lattice steps and the
// origin on the lattice, every position comes back as it was.
void quantizeOnLattice(draco::Encoder& encoder, const Extent& extent) {
    const glm::vec3 size = extent.max - extent.min;
    const double steps = std::max({size.x, size.y, size.z, 1.0f}) / kLatticeMetres;
    const int bits = int(std::bit_width(std::uint64_t(steps)));
    const auto range = float(double((std::uint64_t(1) << bits) - 1) * kLatticeMetres);
    encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, bits, 3,
                                             &extent.min.x, range);
}

Result<Encoded> encodeDraco(const Shape& shape, std::span<const glm::vec3> positions,
                            const Extent& extent) {
    using Type = draco::GeometryAttribute;
    draco::Mesh mesh;
    mesh.set_num_points(std::uint32_t(positions.size()));
    mesh.SetNumFaces(shape.triangles());
    for (std::uint32_t f = 0; f < shape.triangles(); ++f) {
        draco::Mesh::Face face;
        for (std::uint32_t k = 0; k < 3; ++k)
            face[int(k)] = shape.indices[3 * f + k];
        mesh.SetFace(draco::FaceIndex(f), face);
    }
    std::vector<glm::vec3> normals;
    for (const glm::vec3 n : shape.normals)
        normals.push_back(yUp(glm::dvec3(n)));
    Encoded encoded;
    auto& names = encoded.attributes;
    names["POSITION"] =
        addAttribute<glm::vec3>(mesh, Type::POSITION, 3, draco::DT_FLOAT32, false, positions);
    names["NORMAL"] =
        addAttribute<glm::vec3>(mesh, Type::NORMAL, 3, draco::DT_FLOAT32, false, normals);
    names["TEXCOORD_0"] =
        addAttribute<glm::vec2>(mesh, Type::TEX_COORD, 2, draco::DT_FLOAT32, false, shape.uvs);
    if (!shape.colors.empty())
        names["COLOR_0"] =
            addAttribute<std::uint32_t>(mesh, Type::COLOR, 4, draco::DT_UINT8, true, shape.colors);
    if (!shape.features.empty())
        names["_FEATURE_ID_0"] = addAttribute<std::uint16_t>(
            mesh, Type::GENERIC, 1, draco::DT_UINT16, false, shape.features);
    // Corners of one position become one: the surface is coded as the connected thing it is.
    mesh.DeduplicateAttributeValues();
    mesh.DeduplicatePointIds();
    draco::Encoder encoder;
    encoder.SetSpeedOptions(5, 5);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetTrackEncodedProperties(true);
    quantizeOnLattice(encoder, extent);
    encoder.SetAttributeQuantization(Type::NORMAL, 10);
    encoder.SetAttributeQuantization(Type::TEX_COORD, 14);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodeMeshToBuffer(mesh, &buffer);
    if (!status.ok())
        return Error{"Draco", status.error_msg_string(), ErrorKind::Output};
    encoded.bytes.resize(buffer.size());
    std::memcpy(encoded.bytes.data(), buffer.data(), buffer.size());
    encoded.points = encoder.num_encoded_points();
    encoded.faces = encoder.num_encoded_faces();
    return encoded;
}

} // namespace

Glb::Glb() {
    root_["asset"] = {{"version", "2.0"}, {"generator", "gnomon demo"}};
    root_["scene"] = 0;
    root_["scenes"] = json::array({{{"nodes", {0}}}});
    root_["nodes"] = json::array({{{"name", "tile"}}});
}

void Glb::setOrigin(glm::dvec3 origin) {
    root_["nodes"][0]["translation"] = array(yUp(origin));
}

void Glb::use(const char* extension, bool required) {
    for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
        if (!required && list[10] == 'R')
            continue;
        json& names = root_[list];
        if (std::find(names.begin(), names.end(), extension) == names.end())
            names.push_back(extension);
    }
}

int Glb::addView(std::span<const std::byte> bytes, int target) {
    binary_.resize((binary_.size() + 7) / 8 * 8, std::byte{0});
    json view{{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes.size()}};
    if (target)
        view["target"] = target;
    binary_.insert(binary_.end(), bytes.begin(), bytes.end());
    root_["bufferViews"].push_back(std::move(view));
    return int(root_["bufferViews"].size()) - 1;
}

template <class T>
int Glb::addAccessor(std::span<const T> values, const char* type, int target) {
    json accessor{{"bufferView", addView(std::as_bytes(values), target)},
                  {"count", values.size()},
                  {"type", type}};
    constexpr bool kColor = std::is_same_v<T, std::uint32_t>;
    accessor["componentType"] = std::is_same_v<T, std::uint16_t> ? kUnsignedShort
                                : std::is_same_v<T, Index>       ? kUnsignedInt
                                : kColor                         ? kUnsignedByte
                                                                 : kFloat;
    if (kColor)
        accessor["normalized"] = true;
    if constexpr (std::is_same_v<T, glm::vec3>) {
        const Extent e = extentOf(values);
        accessor["min"] = array(e.min);
        accessor["max"] = array(e.max);
    }
    root_["accessors"].push_back(std::move(accessor));
    return int(root_["accessors"].size()) - 1;
}

int Glb::addTexture(std::span<const std::byte> image, const char* mimeType, bool repeat) {
    constexpr int kRepeat = 10497, kClamp = 33071, kLinear = 9729, kTrilinear = 9987;
    root_["images"].push_back({{"bufferView", addView(image)}, {"mimeType", mimeType}});
    const int wrap = repeat ? kRepeat : kClamp;
    root_["samplers"].push_back(
        {{"magFilter", kLinear}, {"minFilter", kTrilinear}, {"wrapS", wrap}, {"wrapT", wrap}});
    const int index = int(root_["images"].size()) - 1;
    root_["textures"].push_back({{"source", index}, {"sampler", index}});
    return index;
}

int Glb::addMaterial(const char* name, int texture, bool doubleSided) {
    json pbr{{"metallicFactor", 0}, {"roughnessFactor", 1}};
    if (texture >= 0)
        pbr["baseColorTexture"] = {{"index", texture}};
    json material{{"name", name}, {"pbrMetallicRoughness", pbr}};
    if (doubleSided)
        material["doubleSided"] = true;
    root_["materials"].push_back(std::move(material));
    return int(root_["materials"].size()) - 1;
}

int Glb::addCutoutMaterial(const char* name, int texture) {
    const int index = addMaterial(name, texture, true);
    root_["materials"].back()["alphaMode"] = "MASK"; // at 0.5, unless it says otherwise
    return index;
}

void Glb::addNode(const char* name, int mesh, json extensions) {
    json node{{"name", name}, {"mesh", mesh}};
    if (!extensions.is_null())
        node["extensions"] = std::move(extensions);
    children_.push_back(root_["nodes"].size());
    root_["nodes"].push_back(std::move(node));
}

Failure Glb::addMesh(const char* name, const Shape& shape, int material) {
    if (shape.indices.empty())
        return std::nullopt;
    std::vector<glm::vec3> positions;
    for (const glm::dvec3 p : shape.positions)
        positions.push_back(yUp(p));
    const Extent extent = extentOf(positions);
    const Result<Encoded> encoded = encodeDraco(shape, positions, extent);
    if (!encoded)
        return encoded.error();
    use("KHR_draco_mesh_compression", true);
    json& accessors = root_["accessors"];
    const auto accessor = [&](const char* type, int component, std::size_t count) {
        accessors.push_back({{"componentType", component}, {"count", count}, {"type", type}});
        return accessors.size() - 1;
    };
    json attributes;
    attributes["POSITION"] = accessor("VEC3", kFloat, encoded->points);
    accessors.back()["min"] = array(extent.min);
    accessors.back()["max"] = array(extent.max);
    attributes["NORMAL"] = accessor("VEC3", kFloat, encoded->points);
    attributes["TEXCOORD_0"] = accessor("VEC2", kFloat, encoded->points);
    if (!shape.colors.empty()) {
        attributes["COLOR_0"] = accessor("VEC4", kUnsignedByte, encoded->points);
        accessors.back()["normalized"] = true;
    }
    json extensions{
        {"KHR_draco_mesh_compression",
         {{"bufferView", addView(encoded->bytes)}, {"attributes", encoded->attributes}}}};
    if (!shape.features.empty()) {
        attributes["_FEATURE_ID_0"] = accessor("SCALAR", kUnsignedShort, encoded->points);
        use("EXT_mesh_features", false);
        json ids{{"featureCount", rows_}, {"attribute", 0}};
        if (hasTable_)
            ids["propertyTable"] = 0;
        extensions["EXT_mesh_features"] = {{"featureIds", json::array({ids})}};
    }
    json primitive{{"attributes", attributes}, {"material", material}, {"mode", 4}};
    primitive["indices"] = accessor("SCALAR", kUnsignedInt, encoded->faces * 3);
    primitive["extensions"] = std::move(extensions);
    root_["meshes"].push_back({{"name", name}, {"primitives", json::array({primitive})}});
    addNode(name, int(root_["meshes"].size()) - 1, nullptr);
    return std::nullopt;
}

json Glb::plainPrimitive(const Shape& shape, int material) {
    std::vector<glm::vec3> positions, normals;
    for (std::size_t i = 0; i < shape.positions.size(); ++i) {
        positions.push_back(yUp(shape.positions[i]));
        normals.push_back(yUp(glm::dvec3(shape.normals[i])));
    }
    json primitive{{"material", material}, {"mode", 4}};
    primitive["attributes"]["POSITION"] = addAccessor<glm::vec3>(positions, "VEC3", kVertices);
    primitive["attributes"]["NORMAL"] = addAccessor<glm::vec3>(normals, "VEC3", kVertices);
    primitive["attributes"]["COLOR_0"] =
        addAccessor<std::uint32_t>(shape.colors, "VEC4", kVertices);
    return primitive;
}

void Glb::addPlainMesh(const char* name, const Shape& shape, int material) {
    if (shape.indices.empty())
        return;
    json primitive = plainPrimitive(shape, material);
    if (!shape.uvs.empty())
        primitive["attributes"]["TEXCOORD_0"] =
            addAccessor<glm::vec2>(shape.uvs, "VEC2", kVertices);
    primitive["indices"] = addAccessor<Index>(indicesOf(shape.indices), "SCALAR", kIndices);
    root_["meshes"].push_back({{"name", name}, {"primitives", json::array({primitive})}});
    addNode(name, int(root_["meshes"].size()) - 1, nullptr);
}

void Glb::addInstanced(const char* name, const Shape& shape, int material, const Instances& where) {
    if (where.translations.empty())
        return;
    json primitive = plainPrimitive(shape, material);
    std::vector<std::uint16_t> indices(shape.indices.begin(), shape.indices.end());
    primitive["indices"] = addAccessor<std::uint16_t>(indices, "SCALAR", kIndices);
    root_["meshes"].push_back({{"name", name}, {"primitives", json::array({primitive})}});
    use("EXT_mesh_gpu_instancing", true);
    const json attributes{{"TRANSLATION", addAccessor<glm::vec3>(where.translations, "VEC3", 0)},
                          {"ROTATION", addAccessor<glm::vec4>(where.rotations, "VEC4", 0)},
                          {"SCALE", addAccessor<glm::vec3>(where.scales, "VEC3", 0)}};
    addNode(name, int(root_["meshes"].size()) - 1,
            {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}});
}

void Glb::setTable(std::size_t rows, const std::vector<Column>& columns) {
    rows_ = rows;
    hasTable_ = rows > 0;
    if (!hasTable_)
        return;
    json schema, table;
    for (const Column& c : columns) {
        schema[c.name] = {{"type", "SCALAR"}, {"componentType", c.componentType}};
        table[c.name] = {{"values", addView(c.values)}};
    }
    use("EXT_structural_metadata", false);
    root_["extensions"]["EXT_structural_metadata"] = {
        {"schema", {{"id", "place"}, {"classes", {{"building", {{"properties", schema}}}}}}},
        {"propertyTables", json::array({{{"name", "buildings"},
                                         {"class", "building"},
                                         {"count", rows},
                                         {"properties", table}}})}};
}

std::vector<std::byte> Glb::finish() {
    constexpr std::uint32_t kMagic = 0x46546c67, kJsonChunk = 0x4e4f534a, kBinChunk = 0x004e4942;
    if (!children_.empty())
        root_["nodes"][0]["children"] = children_;
    binary_.resize((binary_.size() + 7) / 8 * 8, std::byte{0});
    root_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
    std::string text = root_.dump();
    // The header and a chunk's own take 20 bytes; 3D Tiles wants the whole a multiple of 8.
    while ((20 + text.size()) % 8)
        text += ' ';
    std::vector<std::byte> out;
    const auto put32 = [&](std::size_t v) {
        const auto word = std::uint32_t(v);
        const auto* p = reinterpret_cast<const std::byte*>(&word);
        out.insert(out.end(), p, p + 4);
    };
    put32(kMagic);
    put32(2);
    put32(12 + 8 + text.size() + 8 + binary_.size());
    put32(text.size());
    put32(kJsonChunk);
    const auto* p = reinterpret_cast<const std::byte*>(text.data());
    out.insert(out.end(), p, p + text.size());
    put32(binary_.size());
    put32(kBinChunk);
    out.insert(out.end(), binary_.begin(), binary_.end());
    return out;
}

} // namespace gnomon::builtin
