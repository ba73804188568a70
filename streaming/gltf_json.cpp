#include "streaming/gltf_json.h"

#include "streaming/gltf_document.h"
#include "streaming/tinygltf.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace gnomon {

namespace {

using Json = nlohmann::json;

// Those that are looked up in the model, wherever they stand. What others say comes from the text
// itself, or is not read.
constexpr std::array<std::string_view, 14> kReadExtensions{"CESIUM_RTC",
                                                           "EXT_feature_metadata",
                                                           "EXT_instance_features",
                                                           "EXT_mesh_features",
                                                           "EXT_mesh_gpu_instancing",
                                                           "EXT_texture_webp",
                                                           "KHR_draco_mesh_compression",
                                                           "KHR_gaussian_splatting",
                                                           "KHR_materials_pbrSpecularGlossiness",
                                                           "KHR_materials_unlit",
                                                           "KHR_techniques_webgl",
                                                           "KHR_texture_basisu",
                                                           "KHR_texture_transform",
                                                           "MAXAR_nonvisual_geometry"};

// The kinds of objects in the model, what one takes there, and what is read of each.
struct Kind {
    const char* key;
    std::size_t bytes;
    std::vector<std::string_view> members;
};
const std::vector<Kind>& kinds() {
    static const std::vector<Kind> all{
        {"accessors",
         sizeof(tinygltf::Accessor),
         {"bufferView", "byteOffset", "componentType", "count", "normalized", "sparse", "type"}},
        {"bufferViews",
         sizeof(tinygltf::BufferView),
         {"buffer", "byteLength", "byteOffset", "byteStride"}},
        {"materials",
         sizeof(tinygltf::Material),
         {"alphaCutoff", "alphaMode", "extensions", "pbrMetallicRoughness"}},
        {"meshes", sizeof(tinygltf::Mesh), {"primitives"}},
        {"nodes",
         sizeof(tinygltf::Node),
         {"children", "extensions", "matrix", "mesh", "rotation", "scale", "translation"}},
        {"samplers", sizeof(tinygltf::Sampler), {"magFilter", "wrapS", "wrapT"}},
        {"scenes", sizeof(tinygltf::Scene), {"nodes"}},
        {"textures", sizeof(tinygltf::Texture), {"extensions", "sampler", "source"}},
    };
    return all;
}

template <class Names>
void keepOnly(Json& object, const Names& names) {
    if (!object.is_object()) {
        return;
    }
    for (auto it = object.begin(); it != object.end();) {
        const bool kept = std::find(names.begin(), names.end(), it.key()) != names.end();
        it = kept ? std::next(it) : object.erase(it);
    }
}

// Objects of one kind, of which only `members` are kept.
void keepMembers(Json& objects, const std::vector<std::string_view>& members, std::size_t bytes,
                 const char* what, ByteBudget& budget) {
    if (!objects.is_array()) {
        return;
    }
    budget.take(objects.size(), 2 * bytes, what); // twice: the vector grows by copying
    for (Json& object : objects) {
        keepOnly(object, members);
    }
}

void keepPrimitives(Json& meshes, ByteBudget& budget) {
    static const std::vector<std::string_view> members{"attributes", "extensions", "indices",
                                                       "material", "mode"};
    for (Json& mesh : meshes) {
        if (mesh.is_object() && mesh.contains("primitives")) {
            keepMembers(mesh["primitives"], members, sizeof(tinygltf::Primitive), "primitives",
                        budget);
        }
    }
}

// Takes out, at any depth, extras and extensions that are not read. Returns how many values there
// are inside those that are.
std::size_t strip(Json& value, bool inExtension) {
    std::size_t values = inExtension ? 1 : 0;
    if (value.is_object()) {
        value.erase("extras");
        if (const auto extensions = value.find("extensions"); extensions != value.end()) {
            keepOnly(*extensions, kReadExtensions);
        }
        for (auto it = value.begin(); it != value.end(); ++it) {
            values += strip(it.value(), inExtension || it.key() == "extensions");
        }
    } else if (value.is_array()) {
        for (Json& element : value) {
            values += strip(element, inExtension);
        }
    }
    return values;
}

} // namespace

std::string jsonForModel(Json& root, ByteBudget& budget) {
    Json kept = Json::object();
    for (const char* key :
         {"asset", "extensions", "extensionsRequired", "extensionsUsed", "scene"}) {
        if (const auto it = root.find(key); it != root.end()) {
            kept[key] = std::move(*it);
        }
    }
    if (const auto asset = kept.find("asset"); asset != kept.end()) {
        keepOnly(*asset, std::array<std::string_view, 2>{"copyright", "version"});
    }
    if (const auto own = kept.find("extensions"); own != kept.end()) { // of the whole file
        keepOnly(*own, std::array<std::string_view, 1>{"CESIUM_RTC"});
    }
    for (const Kind& kind : kinds()) {
        if (const auto it = root.find(kind.key); it != root.end()) {
            keepMembers(*it, kind.members, kind.bytes, kind.key, budget);
            kept[kind.key] = std::move(*it);
        }
    }
    if (const auto meshes = kept.find("meshes"); meshes != kept.end() && meshes->is_array()) {
        keepPrimitives(*meshes, budget);
    }
    const std::size_t values = strip(kept, false);
    // An entry of a map has its name and three pointers beside the value.
    budget.take(values, sizeof(tinygltf::Value) + 96, "extensions");
    std::string text = kept.dump();
    // Names of attributes, of things and of extensions, numbers of nodes; the text itself.
    constexpr std::uint64_t kModelBytesPerCharacter = 16;
    budget.take(text.size(), kModelBytesPerCharacter, "JSON");
    return text;
}

} // namespace gnomon
