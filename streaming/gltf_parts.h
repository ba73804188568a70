// The parts gltf.cpp is made of: materials with their images, and single primitives. Everything
// here throws BadContent.
#pragma once

#include "streaming/gltf_document.h"

#include <array>
#include <map>

namespace gnomon_tinygltf { // streaming/tinygltf.h
struct Primitive;
struct Texture;
} // namespace gnomon_tinygltf

namespace gnomon {

// Each said once, in the order met.
class Warnings {
  public:
    void add(const std::string& text);
    const std::vector<std::string>& all() const { return all_; }

  private:
    std::vector<std::string> all_;
};

// KHR_texture_transform, and which TEXCOORD the texture wants.
struct TextureMapping {
    bool used = false;
    int texCoord = 0;
    glm::dvec2 offset{0.0}, scale{1.0};
    double rotationRadians = 0.0;

    glm::vec2 apply(const glm::dvec2& uv) const;
};

// Materials in the order they are first used, their images decoded once.
class MaterialTable {
  public:
    MaterialTable(const GltfDocument& document, Warnings& warnings, ByteBudget& budget)
        : document_(document), warnings_(warnings), budget_(budget) {}

    struct Entry {
        std::uint32_t index = 0;
        TextureMapping mapping;
    };
    // -1: glTF's default material.
    const Entry& use(int material);

    std::vector<Material> materials;
    std::vector<Image> images;

  private:
    void readTexture(int texture, Material& out, TextureMapping& mapping);
    int readImage(int image);
    std::optional<int> pickImage(const tinygltf::Texture& texture);

    const GltfDocument& document_;
    Warnings& warnings_;
    ByteBudget& budget_;
    std::map<int, Entry> entries_;
    std::map<int, int> imageIndices_;
};

// Translation, rotation quaternion (x, y, z, w; made unit) and scale, as a matrix.
glm::dmat4 composeTrs(const glm::dvec3& translation, const glm::dvec4& rotation,
                      const glm::dvec3& scale);

// Only the vertices its triangles use, in the mesh's own frame; or points, without triangles.
struct PrimitiveData {
    bool isPoints = false;
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;
    std::vector<std::uint32_t> colors, features;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::uint32_t attributes = 0; // Soup::Attribute
};

struct FeatureIds; // streaming/gltf_features.h
PrimitiveData readPrimitive(const GltfDocument& document, const tinygltf::Primitive& primitive,
                            const TextureMapping& mapping, const FeatureIds& features,
                            Warnings& warnings, const ByteBudget& budget);

} // namespace gnomon
