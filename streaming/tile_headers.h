// The containers of 3D Tiles 1.0 (b3dm, i3dm, pnts, cmpt): their headers, and the feature table
// behind each, which tells where a content is, how many things it has, and of points and instances
// where each is. ("Feature table" is 3D Tiles' word; the properties of features, which FeatureTable
// holds, are in the batch table.) Everything here throws BadContent.
#pragma once

#include "streaming/gltf_document.h"

#include <map>

namespace gnomon {

// Where the parts of a b3dm, i3dm or pnts are; all inside the file for certain.
struct TileParts {
    std::string format; // "b3dm", "i3dm", "pnts"
    std::span<const std::byte> featureJson, featureBinary, batchJson, batchBinary;
    std::span<const std::byte> body; // behind the tables: a glTF, or the uri of one
    bool bodyIsUri = false;          // i3dm's only
    // In the header of old b3dm, which have no feature table to tell it.
    std::optional<std::uint32_t> batchLength;
};
TileParts readTileParts(std::span<const std::byte> bytes);

// The tiles inside a cmpt, header and all.
std::vector<std::span<const std::byte>> readComposite(std::span<const std::byte> bytes);

// The values one semantic of a feature table has, one element a point or instance.
class SemanticValues {
  public:
    int components() const { return components_; }
    double at(std::size_t element, int component) const;
    glm::dvec3 vec3(std::size_t element) const {
        return {at(element, 0), at(element, 1), at(element, 2)};
    }

  private:
    friend class TileSemantics;
    std::span<const std::byte> bytes_; // in the binary part, or else
    std::vector<double> numbers_;      // in the JSON
    ComponentType type_ = ComponentType::Float;
    int components_ = 0;
};

// 3DTILES_draco_point_compression: which semantics are in the Draco buffer, by unique id.
struct DracoSemantics {
    std::span<const std::byte> bytes;
    std::map<std::string, std::uint32_t> uniqueIds;
};

// A unit vector packed in an octahedron, its two numbers already within 0…1.
glm::dvec3 octNormal(double x, double y);

class TileSemantics {
  public:
    TileSemantics(const TileParts& parts, ByteBudget& budget);
    ~TileSemantics();
    TileSemantics(const TileSemantics&) = delete;
    TileSemantics& operator=(const TileSemantics&) = delete;

    // Of the whole content; none when the table does not have it.
    std::optional<std::uint32_t> count(const char* name) const;
    bool flag(const char* name) const;
    std::vector<double> numbers(const char* name, std::size_t components, ComponentType type) const;
    std::optional<glm::dvec3> vec3(const char* name) const;

    // Of each of `count` elements; none when the table does not have it.
    std::optional<SemanticValues> values(const char* name, std::size_t count, int components,
                                         ComponentType type) const;
    // BATCH_ID, whose type the table tells.
    std::optional<SemanticValues> batchIds(std::size_t count) const;

    std::optional<DracoSemantics> draco() const;

  private:
    struct Table;
    std::span<const std::byte> binaryOf(const char* name, std::uint64_t offset, std::uint64_t count,
                                        std::uint64_t bytesEach) const;

    std::string format_;
    std::unique_ptr<Table> table_;
    std::span<const std::byte> binary_;
};

} // namespace gnomon
