// KHR_draco_mesh_compression, with what Draco's own encoder makes.
#include "streaming/draco.h"

#include "glb_builder.h"

#include <draco/compression/encode.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gnomon {

using namespace test;

namespace {

constexpr std::uint64_t kPlenty = std::uint64_t(256) << 20;

struct Encoded {
    std::string bytes;
    std::uint32_t position = 0, batch = 0;
    std::uint32_t points = 0, faces = 0;
};

// A bumpy square of 2 · side² triangles with a batch id a vertex.
Encoded encode(int side, int method, int positionBits) {
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

std::string glbOf(const Encoded& encoded) {
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

std::string reasonOf(const std::string& bytes, const DracoExpectation& expected,
                     std::uint64_t budgetBytes = kPlenty) {
    const Bytes exact = bytesOf(bytes);
    ByteBudget budget(budgetBytes);
    try {
        decodeDraco(exact, std::vector<std::uint32_t>{0}, expected, budget);
    } catch (const BadContent& bad) {
        return bad.reason;
    }
    return {};
}

} // namespace

TEST(Draco, GivesBackWhatWasEncoded) {
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        for (const int bits : {0, 14}) {
            const Encoded encoded = encode(20, method, bits);
            const auto content = decode(glbOf(encoded));
            ASSERT_TRUE(content) << content.error().message();
            EXPECT_EQ(content->facts.triangles, 800u);
            const double within = bits == 0 ? 1e-5 : 21.0 / (1 << bits);
            const Mesh& mesh = content->meshes.at(0);
            ASSERT_EQ(mesh.features.size(), mesh.positions.size());
            for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
                const glm::dvec3 p = vertex(mesh, i);
                const double x = std::round(p.x), y = std::round(p.y);
                EXPECT_NEAR(p.x, x, within);
                EXPECT_NEAR(p.y, y, within);
                EXPECT_NEAR(p.z, std::sin(x * 0.7 + y), within);
                EXPECT_EQ(mesh.features[i], std::uint32_t(x + 100 * y));
            }
        }
    }
}

TEST(Draco, AttributesItDoesNotHoldComeFromTheirAccessors) {
    const Encoded encoded = encode(4, draco::MESH_SEQUENTIAL_ENCODING, 0);
    GlbBuilder builder;
    std::vector<std::uint8_t> colors(encoded.points * 4, 51);
    builder.root = Json::parse(glbOf(encoded).substr(20, glbOf(encoded).find("BIN") - 24));
    builder.root.erase("buffers");
    builder.bin = encoded.bytes;
    const int color = builder.accessor(colors, 5121, "VEC4", true);
    builder.root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = color;
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->meshes.at(0).colors.at(0), 0x33333333u);
}

TEST(Draco, HeadersThatClaimMoreThanTheAccessorsAreRefusedUnread) {
    std::string bomb = "DRACO";
    bomb += {2, 2, 1, 0, 0, 0};                       // mesh, sequential
    bomb += {'\xff', '\xff', '\xff', '\xff', '\x0f'}; // 2^32 − 1 faces
    bomb += {'\xff', '\xff', '\xff', '\xff', '\x0f'}; // and points
    bomb += std::string(66, '\0');
    EXPECT_NE(reasonOf(bomb, {100, 100}).find("claims 4294967295 faces"), std::string::npos);
    // Accessors that lie along with it meet the memory that is left.
    const std::uint64_t most = std::uint64_t(1) << 32;
    EXPECT_NE(reasonOf(bomb, {most, most}).find("memory"), std::string::npos);
    std::string fewPoints = bomb;
    fewPoints.replace(16, 5, std::string("\x64\0\0\0\0", 5));
    EXPECT_NE(reasonOf(fewPoints, {100, 100}).find("and 100 points where"), std::string::npos);
    bomb[8] = 1; // edgebreaker
    EXPECT_NE(reasonOf(bomb, {100, 100}).find("claims"), std::string::npos);
}

TEST(Draco, TruncatedDataIsAnErrorAtEveryLength) {
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        const Encoded encoded = encode(5, method, 11);
        for (std::size_t length = 0; length < encoded.bytes.size(); ++length) {
            EXPECT_NE(reasonOf(encoded.bytes.substr(0, length), {encoded.points, encoded.faces}),
                      "")
                << method << " " << length;
        }
    }
}

TEST(Draco, FlippedBytesGiveAnErrorOrIndicesInRange) {
    std::mt19937 random(9);
    int decoded = 0;
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        const Encoded encoded = encode(6, method, 11);
        for (int trial = 0; trial < 3000; ++trial) {
            std::string bad = encoded.bytes;
            for (int k = 0; k < 1 + trial % 3; ++k) {
                bad[random() % bad.size()] = char(random());
            }
            ByteBudget budget(kPlenty);
            try {
                const Bytes exact = bytesOf(bad);
                const DracoMesh mesh =
                    decodeDraco(exact, std::vector<std::uint32_t>{encoded.position},
                                {encoded.points, encoded.faces}, budget);
                ++decoded;
                for (const std::uint32_t i : mesh.indices) {
                    ASSERT_LT(i, mesh.points);
                }
                ASSERT_EQ(mesh.attributes.at(0).values.size(),
                          std::size_t(mesh.points) * std::size_t(mesh.attributes[0].components));
            } catch (const BadContent&) {
            } catch (const std::exception&) { // bad_alloc, length_error: decodeContent's to catch
            }
        }
    }
    EXPECT_GT(decoded, 50);
}

TEST(Draco, GarbageIsRefused) {
    EXPECT_NE(reasonOf("", {1, 1}), "");
    EXPECT_NE(reasonOf("DRACO", {1, 1}), "");
    EXPECT_NE(reasonOf("not draco at all, but long enough", {1, 1}).find("DRACO"),
              std::string::npos);
    EXPECT_NE(reasonOf(std::string("DRACO\2\2\0\0\0\0", 11) + std::string(50, '\1'), {1, 1})
                  .find("not a triangle mesh"),
              std::string::npos);
    const Encoded encoded = encode(3, draco::MESH_EDGEBREAKER_ENCODING, 11);
    ByteBudget budget(kPlenty);
    const Bytes bytes = bytesOf(encoded.bytes);
    EXPECT_THROW(decodeDraco(bytes, std::vector<std::uint32_t>{77}, {16, 18}, budget), BadContent);
}

} // namespace gnomon
