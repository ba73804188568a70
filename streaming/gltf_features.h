// Which feature each vertex of a glTF belongs to, and what the file tells of the features:
// EXT_mesh_features, EXT_instance_features, the older _BATCHID, and the property tables of
// EXT_structural_metadata. Nothing here fails a content: what cannot be read is a warning.
#pragma once

#include "streaming/feature_table.h"
#include "streaming/gltf_parts.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon_tinygltf { // streaming/tinygltf.h
struct Node;
} // namespace gnomon_tinygltf

namespace gnomon {

// Where the ids of a primitive's vertices, or of a node's instances, come from.
struct FeatureIds {
    std::string attribute; // of the primitive, or of its Draco buffer
    int accessor = -1;     // of instances
    bool implicit = false; // the vertex's or instance's own number
    // Of EXT_feature_metadata's implicit ids: number / divisor + constant.
    std::uint64_t constant = 0, divisor = 1;
    std::optional<std::int64_t> nullId;
    // The content's row of id 0, and how many ids have one.
    std::uint32_t firstRow = 0, rows = kNoFeature;

    bool any() const { return implicit || accessor >= 0 || !attribute.empty(); }
    // The row in the content's table. Some writers store ids as floats.
    std::uint32_t rowOf(double id) const;
    std::uint32_t rowOfNumber(std::uint64_t number) const; // when implicit
};

class GltfFeatures {
  public:
    GltfFeatures(const GltfDocument& document, const DecodeOptions& options, Warnings& warnings,
                 ByteBudget& budget);

    FeatureIds of(const tinygltf::Primitive& primitive) const;
    FeatureIds ofInstances(const tinygltf::Node& node) const;
    // All the file's property tables, joined; null when it has none.
    const std::shared_ptr<const FeatureTable>& table() const { return table_; }

  private:
    FeatureIds pick(const tinygltf::Value& extension, bool instances,
                    const std::function<bool(FeatureIds&, int)>& setAttribute) const;
    void setRows(FeatureIds& ids, const std::optional<int>& propertyTable) const;
    bool isScalar(const tinygltf::Primitive& primitive, const std::string& attribute) const;

    const GltfDocument& document_;
    Warnings& warnings_;
    std::shared_ptr<const FeatureTable> table_;
    std::vector<std::uint32_t> firstRows_; // of each property table, and behind the last
};

} // namespace gnomon
