// A small writer of binary glTF: meshes (Draco or plain), instanced meshes, pictures, a property
// table.
#pragma once

#include "geo/result.h"
#include "viewer/place/shape.h"

#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace gnomon::builtin {

// One column of the buildings' table.
struct Column {
    std::string name, componentType; // "UINT32", "FLOAT32"
    std::vector<std::byte> values;   // little-endian
};

struct Instances {
    std::vector<glm::vec3> translations; // glTF axes: east, up, south
    std::vector<glm::vec4> rotations;    // unit quaternions x, y, z, w
    std::vector<glm::vec3> scales;
};

// glTF's Y is up: east, up, south.
inline glm::vec3 yUp(glm::dvec3 p) {
    return {float(p.x), float(p.z), float(-p.y)};
}

class Glb {
  public:
    Glb();

    // Everything hangs on one node, moved to `origin` (east, north, up).
    void setOrigin(glm::dvec3 origin);
    int addTexture(std::span<const std::byte> image, const char* mimeType, bool repeat);
    // `texture` < 0: none.
    int addMaterial(const char* name, int texture, bool doubleSided);
    // Cut out where its texture's alpha is below a half; seen from both sides.
    int addCutoutMaterial(const char* name, int texture);
    // Compressed; lattice positions are kept exactly.
    Failure addMesh(const char* name, const Shape& shape, int material);
    // Not compressed: vertices to a float's last bit, in the order given.
    void addPlainMesh(const char* name, const Shape& shape, int material);
    // The same shape many times, not compressed.
    void addInstanced(const char* name, const Shape& shape, int material, const Instances& where);
    // What the shapes' feature ids mean; `rows` of them.
    void setTable(std::size_t rows, const std::vector<Column>& columns);

    std::vector<std::byte> finish();

  private:
    int addView(std::span<const std::byte> bytes, int target = 0);
    template <class T>
    int addAccessor(std::span<const T> values, const char* type, int target);
    void use(const char* extension, bool required);
    // A primitive's attributes and material, without indices.
    nlohmann::json plainPrimitive(const Shape& shape, int material);
    void addNode(const char* name, int mesh, nlohmann::json extensions);

    nlohmann::json root_;
    nlohmann::json children_ = nlohmann::json::array();
    std::vector<std::byte> binary_;
    std::size_t rows_ = 0;
    bool hasTable_ = false;
};

} // namespace gnomon::builtin
