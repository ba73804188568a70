// Meshes as Draco's own encoder writes them, and a glb around one.
#pragma once

#include "glb_builder.h"

#include <draco/compression/encode.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace gnomon::test {

struct DracoEncoded {
    std::string bytes;
    std::uint32_t position = 0, batch = 0;
    std::uint32_t points = 0, faces = 0;
};

// A bumpy square of 2 · side² triangles with a batch id a vertex, and `unused` attributes of zeros.
inline DracoEncoded dracoEncode(int side, int method, int positionBits, int unused = 0) {
    draco::Mesh mesh;
    const auto points = std::uint32_t((side + 1) * (side + 1));
    mesh.set_num_points(points);
    draco::GeometryAttribute position, batch;
    position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    batch.Init(draco::GeometryAttribute::GENERIC, nullptr, 1, draco::DT_UINT16, false, 2, 0);
    const int p = mesh.AddAttribute(position, true, points);
    const int b = mesh.AddAttribute(batch, true, points);
    for (int y = 0; y <= side; ++y) {
        for (int x = 0; x <= side; ++x) {
            const draco::AttributeValueIndex i(std::uint32_t(y * (side + 1) + x));
            const std::array<float, 3> at{float(x), float(y), float(std::sin(x * 0.7 + y))};
            const std::uint16_t id = std::uint16_t(x + 100 * y);
            mesh.attribute(p)->SetAttributeValue(i, at.data());
            mesh.attribute(b)->SetAttributeValue(i, &id);
        }
    }
    draco::GeometryAttribute zeros;
    zeros.Init(draco::GeometryAttribute::GENERIC, nullptr, 4, draco::DT_INT32, false, 16, 0);
    for (int k = 0; k < unused; ++k) {
        const int attribute = mesh.AddAttribute(zeros, true, points);
        const std::array<std::int32_t, 4> zero{};
        for (std::uint32_t i = 0; i < points; ++i) {
            mesh.attribute(attribute)->SetAttributeValue(draco::AttributeValueIndex(i),
                                                         zero.data());
        }
    }
    for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
            const auto i = std::uint32_t(y * (side + 1) + x), up = i + std::uint32_t(side) + 1;
            mesh.AddFace({draco::PointIndex(i), draco::PointIndex(i + 1), draco::PointIndex(up)});
            mesh.AddFace(
                {draco::PointIndex(up), draco::PointIndex(i + 1), draco::PointIndex(up + 1)});
        }
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    if (positionBits > 0) {
        encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, positionBits);
    }
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    return {std::string(buffer.data(), buffer.size()), mesh.attribute(p)->unique_id(),
            mesh.attribute(b)->unique_id(), points, std::uint32_t(mesh.num_faces())};
}

inline std::string dracoGlbOf(const DracoEncoded& encoded) {
    GlbBuilder builder;
    const int view = builder.view(encoded.bytes.data(), encoded.bytes.size());
    builder.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    builder.root["accessors"] =
        Json::array({{{"componentType", 5126}, {"count", encoded.points}, {"type", "VEC3"}},
                     {{"componentType", 5123}, {"count", encoded.points}, {"type", "SCALAR"}},
                     {{"componentType", 5125}, {"count", encoded.faces * 3}, {"type", "SCALAR"}}});
    builder.node(
        {{"mesh", builder.mesh(
                      {{"attributes", {{"POSITION", 0}, {"_BATCHID", 1}}},
                       {"indices", 2},
                       {"extensions",
                        {{"KHR_draco_mesh_compression",
                          {{"bufferView", view},
                           {"attributes",
                            {{"POSITION", encoded.position}, {"_BATCHID", encoded.batch}}}}}}}})}});
    return builder.text();
}

} // namespace gnomon::test
