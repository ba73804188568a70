#include "streaming/gltf_features.h"

#include "streaming/feature_columns.h"
#include "streaming/json_slices.h"
#include "streaming/property_table.h"
#include "streaming/tinygltf.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

const tinygltf::Value* extensionOf(const tinygltf::ExtensionMap& extensions, const char* name) {
    const auto it = extensions.find(name);
    return it != extensions.end() ? &it->second : nullptr;
}

// EXT_feature_metadata, which EXT_mesh_features came from, told the ids the same way but for names.
std::optional<FeatureIds> legacyIds(const tinygltf::Primitive& primitive) {
    const auto* extension = extensionOf(primitive.extensions, "EXT_feature_metadata");
    const auto* sets = extension ? member(*extension, "featureIdAttributes") : nullptr;
    if (!sets || sets->ArrayLen() == 0 || !sets->Get(0).IsObject()) {
        return {};
    }
    const auto* set = member(sets->Get(0), "featureIds");
    if (!set) {
        return {};
    }
    FeatureIds ids;
    const auto* attribute = member(*set, "attribute");
    if (attribute && attribute->IsString()) {
        ids.attribute = attribute->Get<std::string>();
        return ids;
    }
    ids.implicit = true;
    constexpr double kMost = 1e15; // far more than there are vertices
    ids.constant = std::uint64_t(std::clamp(numberIn(*set, "constant").value_or(0.0), 0.0, kMost));
    // Without a divisor all vertices are the one feature.
    const double divisor = numberIn(*set, "divisor").value_or(0.0);
    ids.divisor = std::uint64_t(divisor >= 1.0 ? std::min(divisor, kMost) : kMost);
    return ids;
}

} // namespace

std::uint32_t FeatureIds::rowOf(double id) const {
    const double rounded = std::round(id);
    if (!(rounded >= 0.0 && rounded < double(rows)) || (nullId && rounded == double(*nullId))) {
        return kNoFeature;
    }
    const std::uint64_t row = std::uint64_t(firstRow) + std::uint64_t(rounded);
    return row < kNoFeature ? std::uint32_t(row) : kNoFeature;
}

std::uint32_t FeatureIds::rowOfNumber(std::uint64_t number) const {
    return rowOf(double(number / divisor + constant));
}

GltfFeatures::GltfFeatures(const GltfDocument& document, const DecodeOptions& options,
                           Warnings& warnings, ByteBudget& budget)
    : document_(document), warnings_(warnings) {
    const std::string_view extensions = jsonMember(document.json(), "extensions");
    if (!jsonMember(extensions, "EXT_feature_metadata").empty()) {
        warnings.add("EXT_feature_metadata's properties are not read; its ids are");
    }
    const std::string_view metadata = jsonMember(extensions, "EXT_structural_metadata");
    if (metadata.empty()) {
        return;
    }
    PropertyTableReader reader;
    reader.view = [&](std::uint64_t index) -> Result<std::span<const std::byte>> {
        try {
            constexpr std::uint64_t kNone = 0x7fffffff;
            return document.view(int(std::min(index, kNone)));
        } catch (const BadContent& bad) {
            return Error{"", bad.reason, ErrorKind::Input};
        }
    };
    reader.file = [&](const std::string& uri) -> Result<Bytes> {
        try {
            if (auto inside = decodeDataUri(uri)) {
                return std::move(*inside);
            }
        } catch (const BadContent& bad) {
            return Error{"", bad.reason, ErrorKind::Input};
        }
        return options.readUri ? options.readUri(uri)
                               : Result<Bytes>(Error{"", "cannot be read from here"});
    };
    constexpr unsigned kShare = 4; // of what may be used: the mesh matters more
    const std::uint64_t most = budget.left() / kShare;
    ByteBudget share(most);
    auto tables = readPropertyTables(metadata, reader, warnings, share);
    budget.take(most - share.left(), 1, "property tables");
    std::uint64_t rows = 0;
    for (const auto& table : tables) {
        firstRows_.push_back(std::uint32_t(std::min<std::uint64_t>(rows, kNoFeature)));
        rows += table ? table->rows() : 0;
    }
    firstRows_.push_back(std::uint32_t(std::min<std::uint64_t>(rows, kNoFeature)));
    table_ = joinedTables(std::move(tables));
}

// Where the file has tables, ids that none of them tells of are none: they would be taken for rows
// of another.
void GltfFeatures::setRows(FeatureIds& ids, const std::optional<int>& propertyTable) const {
    if (firstRows_.empty()) {
        return;
    }
    const std::size_t tables = firstRows_.size() - 1;
    const bool known = propertyTable && *propertyTable >= 0 && std::size_t(*propertyTable) < tables;
    if (propertyTable && !known) {
        warnings_.add("feature ids name property table " + std::to_string(*propertyTable) + " of " +
                      std::to_string(tables));
    }
    const std::size_t at = known ? std::size_t(*propertyTable) : tables;
    ids.firstRow = firstRows_[at];
    ids.rows = known ? firstRows_[at + 1] - firstRows_[at] : 0;
}

// The first set of ids that has properties; else the first that can be read.
FeatureIds GltfFeatures::pick(const tinygltf::Value& extension, bool instances,
                              const std::function<bool(FeatureIds&, int)>& setAttribute) const {
    const tinygltf::Value* sets = member(extension, "featureIds");
    FeatureIds best;
    bool bestHasTable = false, byTexture = false;
    for (std::size_t i = 0; sets && i < sets->ArrayLen(); ++i) {
        const tinygltf::Value& set = sets->Get(int(i));
        if (!set.IsObject()) {
            continue;
        }
        FeatureIds ids;
        const auto attribute = indexIn(set, "attribute");
        if (attribute ? !setAttribute(ids, *attribute) : set.Has("texture")) {
            byTexture = byTexture || !attribute;
            continue;
        }
        ids.implicit = !attribute;
        ids.nullId = indexIn(set, "nullFeatureId");
        const auto table = indexIn(set, "propertyTable");
        setRows(ids, table);
        if (!best.any() || (table && !bestHasTable)) {
            best = ids;
            bestHasTable = table.has_value();
        }
    }
    if (byTexture && !best.any()) {
        warnings_.add(std::string(instances ? "EXT_instance_features" : "EXT_mesh_features") +
                      " by texture is not supported: those features have no ids");
    }
    return best;
}

// What is none, or is wrong, leaves the mesh without ids rather than the tile without a mesh.
bool GltfFeatures::isScalar(const tinygltf::Primitive& primitive,
                            const std::string& attribute) const {
    const auto it = primitive.attributes.find(attribute);
    if (it == primitive.attributes.end()) {
        return false;
    }
    const auto& accessors = document_.model().accessors;
    const bool scalar = it->second >= 0 && std::size_t(it->second) < accessors.size() &&
                        accessors[std::size_t(it->second)].type == TINYGLTF_TYPE_SCALAR;
    if (!scalar) {
        warnings_.add(shownName(attribute) + " is no scalar, so it is not read");
    }
    return scalar;
}

FeatureIds GltfFeatures::of(const tinygltf::Primitive& primitive) const {
    if (const auto* extension = extensionOf(primitive.extensions, "EXT_mesh_features")) {
        return pick(*extension, false, [&](FeatureIds& ids, int attribute) {
            ids.attribute = "_FEATURE_ID_" + std::to_string(attribute);
            return isScalar(primitive, ids.attribute);
        });
    }
    FeatureIds ids;
    if (const auto legacy = legacyIds(primitive);
        legacy && (legacy->implicit || isScalar(primitive, legacy->attribute))) {
        ids = *legacy;
    }
    for (const char* name : {"_FEATURE_ID_0", "_BATCHID", "BATCHID"}) {
        if (!ids.any() && isScalar(primitive, name)) {
            ids.attribute = name;
        }
    }
    if (table_) { // none of these names a table of the file; a batch table is another matter
        setRows(ids, {});
    }
    return ids;
}

FeatureIds GltfFeatures::ofInstances(const tinygltf::Node& node) const {
    const auto* instancing = extensionOf(node.extensions, "EXT_mesh_gpu_instancing");
    const auto* extension = extensionOf(node.extensions, "EXT_instance_features");
    if (!instancing || !extension) {
        return {};
    }
    const tinygltf::Value* attributes = member(*instancing, "attributes");
    return pick(*extension, true, [&](FeatureIds& ids, int attribute) {
        const auto accessor = attributes
                                  ? indexIn(*attributes, "_FEATURE_ID_" + std::to_string(attribute))
                                  : std::nullopt;
        ids.accessor = accessor.value_or(-1);
        return ids.accessor >= 0;
    });
}

} // namespace gnomon
