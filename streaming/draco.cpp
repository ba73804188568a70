#include "streaming/draco.h"

#include <draco/compression/decode.h>
#include <draco/metadata/geometry_metadata.h>
#include <draco/metadata/metadata_decoder.h>

#include <cstring>

namespace gnomon {

namespace {

struct Counts {
    std::uint64_t vertices = 0, faces = 0;
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
    return counts;
}

void checkCounts(const Counts& counts, const DracoExpectation& expected, ByteBudget& budget) {
    // Some writers' accessors disagree with what Draco made of them (it may drop degenerate faces
    // or split vertices), so they are taken as a scale, not as the truth.
    constexpr std::uint64_t kSlack = 1024;
    if (counts.faces > 2 * expected.faces + kSlack ||
        counts.vertices > 4 * expected.points + kSlack) {
        bad("header claims " + std::to_string(counts.faces) + " faces and " +
            std::to_string(counts.vertices) + " points where the accessors have " +
            std::to_string(expected.faces) + " and " + std::to_string(expected.points));
    }
    // Corner tables, traversal stacks and portable attributes while decoding, per face and point.
    constexpr std::uint64_t kDecoderBytes = 64;
    ByteBudget during = budget;
    during.take(counts.faces + counts.vertices, kDecoderBytes, "Draco mesh");
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

} // namespace

DracoMesh decodeDraco(std::span<const std::byte> bytes, std::span<const std::uint32_t> uniqueIds,
                      const DracoExpectation& expected, ByteBudget& budget) {
    checkCounts(readHeaderCounts(bytes, draco::TRIANGULAR_MESH), expected, budget);

    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) {
        bad(decoded.status().error_msg_string());
    }
    const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
    if (!mesh) {
        bad("no mesh inside");
    }

    DracoMesh out;
    out.points = mesh->num_points();
    budget.take(std::uint64_t(mesh->num_faces()) * 3, sizeof(std::uint32_t), "Draco mesh");
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
        out.attributes.push_back(readAttribute(*mesh, id, budget));
    }
    return out;
}

DracoMesh decodeDracoPoints(std::span<const std::byte> bytes,
                            std::span<const std::uint32_t> uniqueIds, std::uint32_t points,
                            ByteBudget& budget) {
    const Counts counts = readHeaderCounts(bytes, draco::POINT_CLOUD);
    if (counts.vertices != points) {
        bad("header claims " + std::to_string(counts.vertices) + " points of " +
            std::to_string(points));
    }
    checkCounts(counts, {points, 0}, budget);

    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!decoded.ok()) {
        bad(decoded.status().error_msg_string());
    }
    const std::unique_ptr<draco::PointCloud> cloud = std::move(decoded).value();
    if (!cloud || cloud->num_points() != points) {
        bad("not the points its header claims");
    }
    DracoMesh out;
    out.points = points;
    for (const std::uint32_t id : uniqueIds) {
        out.attributes.push_back(readAttribute(*cloud, id, budget));
    }
    return out;
}

} // namespace gnomon
