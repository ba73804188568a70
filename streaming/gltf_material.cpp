#include "streaming/gltf_parts.h"
#include "streaming/image.h"
#include "streaming/tinygltf.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

Wrap wrapOf(int gl) {
    switch (gl) {
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return Wrap::ClampToEdge;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return Wrap::MirroredRepeat;
    default:
        return Wrap::Repeat;
    }
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& map, const std::string& name) {
    const auto it = map.find(name);
    return it != map.end() ? &it->second : nullptr;
}

glm::vec4 colorOf(const std::vector<double>& rgba) {
    glm::vec4 out(1.0f);
    for (int i = 0; i < 4 && std::size_t(i) < rgba.size(); ++i) {
        const double v = rgba[std::size_t(i)];
        out[i] = std::isfinite(v) ? float(std::clamp(v, 0.0, 1.0)) : 1.0f;
    }
    return out;
}

TextureMapping mappingOf(int texCoord, const tinygltf::Value* transform) {
    TextureMapping mapping;
    mapping.used = true;
    mapping.texCoord = texCoord;
    if (!transform) {
        return mapping;
    }
    if (const auto v = numbersIn(*transform, "offset", 2); !v.empty()) {
        mapping.offset = {v[0], v[1]};
    }
    if (const auto v = numbersIn(*transform, "scale", 2); !v.empty()) {
        mapping.scale = {v[0], v[1]};
    }
    mapping.rotationRadians = numberIn(*transform, "rotation").value_or(0.0);
    mapping.texCoord = indexIn(*transform, "texCoord").value_or(texCoord);
    return mapping;
}

struct BaseColor {
    glm::vec4 factor{1.0f};
    int texture = -1, texCoord = 0;
    const tinygltf::Value* transform = nullptr; // KHR_texture_transform

    // Of a textureInfo inside an extension.
    void setTexture(const tinygltf::Value& info) {
        texture = indexIn(info, "index").value_or(-1);
        texCoord = indexIn(info, "texCoord").value_or(0);
        const tinygltf::Value* extensions = member(info, "extensions");
        transform = extensions ? member(*extensions, "KHR_texture_transform") : nullptr;
    }
};

// Shaders of their own, which many of the first tilesets have, cannot be run here; their values
// tell the colour all the same, by a name that everybody used.
void readTechnique(const tinygltf::Value& technique, BaseColor& out) {
    const tinygltf::Value* values = member(technique, "values");
    for (const char* name : {"u_diffuse", "u_tex", "diffuse"}) {
        const tinygltf::Value* value = values ? member(*values, name) : nullptr;
        if (value && value->IsObject()) {
            return out.setTexture(*value);
        }
        if (value) {
            if (const auto rgba = numbersIn(*values, name, 4); !rgba.empty()) {
                out.factor = colorOf(rgba);
            }
            return;
        }
    }
}

BaseColor baseColorOf(const tinygltf::Material& in) {
    BaseColor out;
    const auto& pbr = in.pbrMetallicRoughness;
    out.factor = colorOf(pbr.baseColorFactor);
    out.texture = pbr.baseColorTexture.index;
    out.texCoord = pbr.baseColorTexture.texCoord;
    out.transform = extension(pbr.baseColorTexture.extensions, "KHR_texture_transform");
    if (const auto* v = extension(in.extensions, "KHR_materials_pbrSpecularGlossiness")) {
        if (const auto rgba = numbersIn(*v, "diffuseFactor", 4); !rgba.empty()) {
            out.factor = colorOf(rgba);
        }
        if (const tinygltf::Value* info = member(*v, "diffuseTexture")) {
            out.setTexture(*info);
        }
    }
    if (const auto* v = extension(in.extensions, "KHR_techniques_webgl"); v && out.texture < 0) {
        readTechnique(*v, out);
    }
    return out;
}

} // namespace

void Warnings::add(const std::string& text) {
    constexpr std::size_t kMost = 32; // a hostile file must not fill the report
    if (all_.size() < kMost && std::find(all_.begin(), all_.end(), text) == all_.end()) {
        all_.push_back(text);
    }
}

glm::vec2 TextureMapping::apply(const glm::dvec2& uv) const {
    const double c = std::cos(rotationRadians), s = std::sin(rotationRadians);
    const glm::dvec2 scaled = uv * scale;
    // v points down, so a counter-clockwise turn of the uvs has its signs this way round.
    const glm::dvec2 turned(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
    const glm::vec2 out(turned + offset);
    return std::isfinite(out.x) && std::isfinite(out.y) ? out : glm::vec2(0.0f);
}

const MaterialTable::Entry& MaterialTable::use(int material) {
    const auto& all = document_.model().materials;
    if (material < -1 || material >= int(all.size())) {
        throw BadContent{"material " + std::to_string(material) + " does not exist"};
    }
    if (const auto it = entries_.find(material); it != entries_.end()) {
        return it->second;
    }
    Material out;
    Entry entry;
    entry.index = std::uint32_t(materials.size());
    if (material >= 0) {
        const tinygltf::Material& in = all[std::size_t(material)];
        const BaseColor base = baseColorOf(in);
        if (extension(in.extensions, "KHR_techniques_webgl")) {
            warnings_.add(
                "shaders of KHR_techniques_webgl are not run: drawn in their colour alone");
        }
        out.baseColor = base.factor;
        out.unlit = extension(in.extensions, "KHR_materials_unlit") != nullptr;
        out.alphaTest = in.alphaMode == "MASK" || in.alphaMode == "BLEND";
        out.alphaCutoff = in.alphaMode == "MASK" ? float(in.alphaCutoff) : 0.5f;
        if (base.texture >= 0) {
            entry.mapping = mappingOf(base.texCoord, base.transform);
            readTexture(base.texture, out, entry.mapping);
        }
    }
    materials.push_back(out);
    return entries_.emplace(material, entry).first->second;
}

std::optional<int> MaterialTable::pickImage(const tinygltf::Texture& texture) {
    if (const auto* webp = extension(texture.extensions, "EXT_texture_webp")) {
        if (const auto source = indexIn(*webp, "source")) {
            return source;
        }
    }
    if (texture.source >= 0) {
        return texture.source;
    }
    if (extension(texture.extensions, "KHR_texture_basisu")) {
        warnings_.add("KHR_texture_basisu textures cannot be read: drawn without");
    } else {
        warnings_.add("texture without an image: drawn without");
    }
    return {};
}

void MaterialTable::readTexture(int index, Material& out, TextureMapping& mapping) {
    const auto& model = document_.model();
    if (std::size_t(index) >= model.textures.size()) {
        throw BadContent{"texture " + std::to_string(index) + " does not exist"};
    }
    const tinygltf::Texture& texture = model.textures[std::size_t(index)];
    if (texture.sampler >= 0 && std::size_t(texture.sampler) < model.samplers.size()) {
        const tinygltf::Sampler& sampler = model.samplers[std::size_t(texture.sampler)];
        out.wrapS = wrapOf(sampler.wrapS);
        out.wrapT = wrapOf(sampler.wrapT);
        out.nearestFilter = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    const std::optional<int> image = pickImage(texture);
    out.image = image ? readImage(*image) : -1;
    mapping.used = out.image >= 0;
}

int MaterialTable::readImage(int image) {
    if (const auto it = imageIndices_.find(image); it != imageIndices_.end()) {
        return it->second;
    }
    int index = -1;
    const Bytes bytes = document_.imageBytes(image);
    if (sniffImage(bytes) == ImageFormat::Ktx2) {
        warnings_.add("KTX2 images cannot be read: drawn without");
    } else {
        try {
            images.push_back(decodeImage(bytes, budget_));
        } catch (const BadContent& bad) {
            throw BadContent{"image " + std::to_string(image) + ": " + bad.reason};
        }
        index = int(images.size()) - 1;
    }
    imageIndices_.emplace(image, index);
    return index;
}

} // namespace gnomon
