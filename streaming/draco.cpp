#include "streaming/draco.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/compression/point_cloud/point_cloud_kd_tree_decoder.h>
#include <draco/compression/point_cloud/point_cloud_sequential_decoder.h>
#include <draco/metadata/geometry_metadata.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>

namespace gnomon {

namespace {

// What the header tells.
struct Counts {
    std::uint8_t method = 0; // draco::MeshEncoderMethod or PointCloudEncodingMethod
    std::uint64_t vertices = 0, faces = 0;
    std::uint64_t seams = 0; // attributes with a connectivity of their own
};

[[noreturn]] void bad(const std::string& reason) {
    throw BadContent{"Draco: " + reason};
}

std::uint32_t readVarint(draco::DecoderBuffer& buffer) {
    std::uint32_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
        std::uint8_t byte = 0;
        if (!buffer.Decode(&byte)) {
            bad("data ends inside its header");
        }
        value |= std::uint32_t(byte & 0x7fu) << shift;
        if (!(byte & 0x80u)) {
            return value;
        }
    }
    bad("malformed number in its header");
}

std::uint32_t readCount(draco::DecoderBuffer& buffer, bool varint) {
    std::uint32_t value = 0;
    if (varint) {
        return readVarint(buffer);
    }
    if (!buffer.Decode(&value)) {
        bad("data ends inside its header");
    }
    return value;
}

// What stands before the connectivity, by the Draco bitstream specification (2.2 and what older
// writers had instead).
Counts readHeaderCounts(std::span<const std::byte> bytes, draco::EncodedGeometryType wanted) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    char magic[5];
    std::uint8_t major = 0, minor = 0, type = 0, method = 0;
    std::uint16_t flags = 0;
    if (!buffer.Decode(magic, 5) || std::memcmp(magic, "DRACO", 5) != 0) {
        bad("data does not begin with DRACO");
    }
    if (!buffer.Decode(&major) || !buffer.Decode(&minor) || !buffer.Decode(&type) ||
        !buffer.Decode(&method) || !buffer.Decode(&flags)) {
        bad("data ends inside its header");
    }
    if (type != wanted) {
        bad(wanted == draco::POINT_CLOUD ? "not a point cloud" : "not a triangle mesh");
    }
    const unsigned version = major * 256u + minor;
    buffer.set_bitstream_version(std::uint16_t(version));
    if (version >= 0x0103 && (flags & METADATA_FLAG_MASK)) {
        draco::GeometryMetadata metadata;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) {
            bad("malformed metadata");
        }
    }
    const bool varint = version >= 0x0202;
    Counts counts;
    counts.method = method;
    if (wanted == draco::POINT_CLOUD) {
        counts.vertices = readCount(buffer, false);
        return counts;
    }
    if (method == draco::MESH_SEQUENTIAL_ENCODING) {
        counts.faces = readCount(buffer, varint);
        counts.vertices = readCount(buffer, varint);
        return counts;
    }
    if (method != draco::MESH_EDGEBREAKER_ENCODING) {
        bad("unknown encoding method");
    }
    std::uint8_t traversal = 0;
    if (!buffer.Decode(&traversal)) {
        bad("data ends inside its header");
    }
    if (version < 0x0202) {
        readCount(buffer, version >= 0x0200); // number of new vertices, no longer written
    }
    const bool edgebreakerVarint = version >= 0x0200;
    counts.vertices = readCount(buffer, edgebreakerVarint);
    counts.faces = readCount(buffer, edgebreakerVarint);
    std::uint8_t seams = 0;
    if (!buffer.Decode(&seams)) {
        bad("data ends inside its header");
    }
    counts.seams = seams;
    return counts;
}

// Descriptions of attributes, and metadata, become some 70 times their own size before any count is
// met; what is honestly compressed has next to none of them.
void checkDescriptions(std::span<const std::byte> bytes, const ByteBudget& budget) {
    constexpr std::uint64_t kMostEach = 64;
    ByteBudget during = budget;
    during.take(bytes.size(), kMostEach, "Draco header");
}

void checkCounts(const Counts& counts, const DracoExpectation& expected, ByteBudget& during) {
    // Some writers' accessors disagree with what Draco made of them (it may drop degenerate faces
    // or split vertices), so they are taken as a scale, not as the truth.
    constexpr std::uint64_t kSlack = 1024;
    if (counts.faces > 2 * expected.faces + kSlack ||
        counts.vertices > 4 * expected.points + kSlack) {
        bad("header claims " + std::to_string(counts.faces) + " faces and " +
            std::to_string(counts.vertices) + " points where the accessors have " +
            std::to_string(expected.faces) + " and " + std::to_string(expected.points));
    }
    // While decoding, per face and point: corner tables and the order of traversal; for each
    // attribute with seams of its own, a corner table more, whose every corner may be another
    // vertex.
    constexpr std::uint64_t kMeshBytes = 48, kSeamBytes = 40;
    during.take(counts.faces + counts.vertices, kMeshBytes + kSeamBytes * counts.seams,
                "Draco mesh");
}

// An attribute is described in five bytes, and may have 255 components of 8 bytes at every point.
// Those that nobody asked for are decoded like any other.
void checkAttributes(const draco::PointCloud& cloud, bool kdTree, ByteBudget& during) {
    std::uint64_t dimensions = 0;
    for (std::int32_t i = 0; i < cloud.num_attributes(); ++i) {
        const draco::PointAttribute& attribute = *cloud.attribute(i);
        const std::uint64_t components = attribute.num_components();
        const int size = draco::DataTypeLength(attribute.data_type());
        if (size < 1) {
            bad("attribute of an unknown data type");
        }
        // The values, and while decoding each component as an integer; which value a point has, and
        // the order they come in.
        const std::uint64_t each =
            components * (std::uint64_t(size) + sizeof(std::int32_t)) + 2 * sizeof(std::uint32_t);
        during.take(cloud.num_points(), each, "Draco attributes");
        dimensions += components;
    }
    if (kdTree) { // two stacks of 32 levels a dimension, of a point each
        during.take(2 * (32 * dimensions + 1), dimensions * sizeof(std::uint32_t) + 32,
                    "Draco attributes");
    }
}

// Draco makes room for the values as soon as all attributes are described. Here that is known, and
// nothing of it is taken yet.
template <class Decoder>
class Budgeted final : public Decoder {
  public:
    explicit Budgeted(ByteBudget& during) : during_(during) {}

  private:
    bool DecodeAllAttributes() override {
        constexpr bool kdTree = std::is_same_v<Decoder, draco::PointCloudKdTreeDecoder>;
        checkAttributes(*this->point_cloud(), kdTree, during_);
        return Decoder::DecodeAllAttributes();
    }

    ByteBudget& during_;
};

template <class Decoder, class Geometry>
std::unique_ptr<Geometry> decodeAs(std::span<const std::byte> bytes, ByteBudget& during) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    auto geometry = std::make_unique<Geometry>();
    Budgeted<Decoder> decoder(during);
    const draco::Status status = decoder.Decode(draco::DecoderOptions(), &buffer, geometry.get());
    if (!status.ok()) {
        bad(status.error_msg_string());
    }
    return geometry;
}

template <class T>
double load(const std::uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return double(value);
}

using Loader = double (*)(const std::uint8_t*);

struct ComponentType {
    Loader load = nullptr;
    double integerMax = 0.0;
    bool isSigned = false;
};

template <class T>
ComponentType componentType() {
    const bool integer = std::numeric_limits<T>::is_integer;
    return {&load<T>, integer ? double(std::numeric_limits<T>::max()) : 0.0,
            integer && std::numeric_limits<T>::is_signed};
}

ComponentType componentTypeOf(draco::DataType type) {
    switch (type) {
    case draco::DT_INT8:
        return componentType<std::int8_t>();
    case draco::DT_UINT8:
    case draco::DT_BOOL:
        return componentType<std::uint8_t>();
    case draco::DT_INT16:
        return componentType<std::int16_t>();
    case draco::DT_UINT16:
        return componentType<std::uint16_t>();
    case draco::DT_INT32:
        return componentType<std::int32_t>();
    case draco::DT_UINT32:
        return componentType<std::uint32_t>();
    case draco::DT_FLOAT32:
        return componentType<float>();
    case draco::DT_FLOAT64:
        return componentType<double>();
    default:
        bad("attribute of an unknown data type");
    }
}

DracoAttribute readAttribute(const draco::PointCloud& cloud, std::uint32_t uniqueId,
                             ByteBudget& budget) {
    const draco::PointAttribute* attribute = cloud.GetAttributeByUniqueId(uniqueId);
    if (!attribute) {
        bad("no attribute with unique id " + std::to_string(uniqueId));
    }
    const ComponentType type = componentTypeOf(attribute->data_type());
    DracoAttribute out;
    out.components = attribute->num_components();
    if (out.components < 1 || out.components > 16) {
        bad("attribute with " + std::to_string(out.components) + " components");
    }
    out.integerMax = type.integerMax;
    out.isSigned = type.isSigned;
    const std::uint64_t size = std::uint64_t(draco::DataTypeLength(attribute->data_type()));
    const std::uint64_t held = attribute->buffer() ? attribute->buffer()->data_size() : 0;
    const std::uint64_t points = cloud.num_points();
    if (!attribute->is_mapping_identity() && attribute->indices_map_size() < points) {
        bad("attribute maps fewer points than there are");
    }
    budget.take(points * std::uint64_t(out.components), sizeof(double), "Draco attribute");
    out.values.resize(points * std::size_t(out.components));
    std::size_t write = 0;
    for (draco::PointIndex i(0); i < std::uint32_t(points); ++i) {
        const std::uint64_t value = attribute->mapped_index(i).value();
        const std::uint64_t offset = std::uint64_t(attribute->byte_offset()) +
                                     value * std::uint64_t(attribute->byte_stride());
        const std::uint64_t bytes = size * std::uint64_t(out.components);
        if (value >= attribute->size() || offset > held || bytes > held - offset) {
            bad("point without a value");
        }
        const std::uint8_t* at = attribute->buffer()->data() + offset;
        for (int c = 0; c < out.components; ++c) {
            out.values[write++] = type.load(at + std::uint64_t(c) * size);
        }
    }
    return out;
}

// Takes from `budget` what stays when the decoding is over.
void keep(const DracoMesh& mesh, ByteBudget& budget) {
    budget.take(mesh.indices.size(), sizeof(std::uint32_t), "Draco mesh");
    for (const DracoAttribute& attribute : mesh.attributes) {
        budget.take(attribute.values.size(), sizeof(double), "Draco attribute");
    }
}

} // namespace

DracoMesh decodeDraco(std::span<const std::byte> bytes, std::span<const std::uint32_t> uniqueIds,
                      const DracoExpectation& expected, ByteBudget& budget) {
    checkDescriptions(bytes, budget);
    const Counts counts = readHeaderCounts(bytes, draco::TRIANGULAR_MESH);
    ByteBudget during = budget;
    checkCounts(counts, expected, during);
    const std::unique_ptr<draco::Mesh> mesh =
        counts.method == draco::MESH_SEQUENTIAL_ENCODING
            ? decodeAs<draco::MeshSequentialDecoder, draco::Mesh>(bytes, during)
            : decodeAs<draco::MeshEdgebreakerDecoder, draco::Mesh>(bytes, during);

    DracoMesh out;
    out.points = mesh->num_points();
    during.take(std::uint64_t(mesh->num_faces()) * 3, sizeof(std::uint32_t), "Draco mesh");
    out.indices.reserve(std::size_t(mesh->num_faces()) * 3);
    for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
        for (const draco::PointIndex& point : mesh->face(f)) {
            if (point.value() >= out.points) {
                bad("index " + std::to_string(point.value()) + " of " + std::to_string(out.points) +
                    " points");
            }
            out.indices.push_back(point.value());
        }
    }
    for (const std::uint32_t id : uniqueIds) {
        out.attributes.push_back(readAttribute(*mesh, id, during));
    }
    keep(out, budget);
    return out;
}

DracoMesh decodeDracoPoints(std::span<const std::byte> bytes,
                            std::span<const std::uint32_t> uniqueIds, std::uint32_t points,
                            ByteBudget& budget) {
    checkDescriptions(bytes, budget);
    const Counts counts = readHeaderCounts(bytes, draco::POINT_CLOUD);
    if (counts.vertices != points) {
        bad("header claims " + std::to_string(counts.vertices) + " points of " +
            std::to_string(points));
    }
    if (counts.method != draco::POINT_CLOUD_SEQUENTIAL_ENCODING &&
        counts.method != draco::POINT_CLOUD_KD_TREE_ENCODING) {
        bad("unknown encoding method");
    }
    ByteBudget during = budget;
    const std::unique_ptr<draco::PointCloud> cloud =
        counts.method == draco::POINT_CLOUD_SEQUENTIAL_ENCODING
            ? decodeAs<draco::PointCloudSequentialDecoder, draco::PointCloud>(bytes, during)
            : decodeAs<draco::PointCloudKdTreeDecoder, draco::PointCloud>(bytes, during);
    if (cloud->num_points() != points) {
        bad("not the points its header claims");
    }
    DracoMesh out;
    out.points = points;
    for (const std::uint32_t id : uniqueIds) {
        out.attributes.push_back(readAttribute(*cloud, id, during));
    }
    keep(out, budget);
    return out;
}

} // namespace gnomon
