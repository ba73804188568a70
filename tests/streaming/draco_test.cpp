// KHR_draco_mesh_compression, with what Draco's own encoder makes.
#include "streaming/draco.h"

#include "draco_builder.h"

#include <gtest/gtest.h>

#include <draco/point_cloud/point_cloud.h>

#include <cmath>
#include <functional>

namespace gnomon {

using namespace test;

namespace {

constexpr std::uint64_t kPlenty = std::uint64_t(256) << 20;

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

std::string reasonOfPoints(const std::string& bytes, std::uint32_t points,
                           std::uint64_t budgetBytes) {
    const Bytes exact = bytesOf(bytes);
    ByteBudget budget(budgetBytes);
    try {
        decodeDracoPoints(exact, std::vector<std::uint32_t>{0}, points, budget);
    } catch (const BadContent& bad) {
        return bad.reason;
    }
    return {};
}

// Places, and `more` attributes of so many components beside them; all zero.
std::string zeroPoints(std::uint32_t points, int more, std::int8_t components, draco::DataType type,
                       int method) {
    draco::PointCloud cloud;
    cloud.set_num_points(points);
    draco::GeometryAttribute place, other;
    place.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false, 12, 0);
    const int size = components * draco::DataTypeLength(type);
    other.Init(draco::GeometryAttribute::GENERIC, nullptr, components, type, false, size, 0);
    cloud.AddAttribute(place, true, points);
    for (int i = 0; i < more; ++i)
        cloud.AddAttribute(other, true, points);
    const std::vector<char> zeros(std::size_t(size) + 12);
    for (int a = 0; a < cloud.num_attributes(); ++a)
        for (std::uint32_t i = 0; i < points; ++i)
            cloud.attribute(a)->SetAttributeValue(draco::AttributeValueIndex(i), zeros.data());
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodePointCloudToBuffer(cloud, &buffer).ok());
    return std::string(buffer.data(), buffer.size());
}

constexpr std::uint64_t kMegabyte = std::uint64_t(1) << 20;

} // namespace

TEST(Draco, GivesBackWhatWasEncoded) {
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        for (const int bits : {0, 14}) {
            const DracoEncoded encoded = dracoEncode(20, method, bits);
            const auto content = decode(dracoGlbOf(encoded));
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
    const DracoEncoded encoded = dracoEncode(4, draco::MESH_SEQUENTIAL_ENCODING, 0);
    GlbBuilder builder;
    std::vector<std::uint8_t> colors(encoded.points * 4, 51);
    builder.root =
        Json::parse(dracoGlbOf(encoded).substr(20, dracoGlbOf(encoded).find("BIN") - 24));
    builder.root.erase("buffers");
    builder.bin = encoded.bytes;
    const int color = builder.accessor(colors, 5121, "VEC4", true);
    builder.root["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = color;
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->meshes.at(0).colors.at(0), 0x33333333u);
}

TEST(Draco, GarbageIsRefused) {
    EXPECT_NE(reasonOf("", {1, 1}), "");
    EXPECT_NE(reasonOf("DRACO", {1, 1}), "");
    EXPECT_NE(reasonOf("not draco at all, but long enough", {1, 1}).find("DRACO"),
              std::string::npos);
    EXPECT_NE(reasonOf(std::string("DRACO\2\2\0\0\0\0", 11) + std::string(50, '\1'), {1, 1})
                  .find("not a triangle mesh"),
              std::string::npos);
    const DracoEncoded encoded = dracoEncode(3, draco::MESH_EDGEBREAKER_ENCODING, 11);
    ByteBudget budget(kPlenty);
    const Bytes bytes = bytesOf(encoded.bytes);
    EXPECT_THROW(decodeDraco(bytes, std::vector<std::uint32_t>{77}, {16, 18}, budget), BadContent);
}

// A few bytes describe an attribute, and values that are all alike take next to none.
TEST(Draco, AttributesThatNobodyAskedForCountAgainstTheBudget) {
    constexpr std::uint32_t kPoints = 20'000;
    for (const int method :
         {draco::POINT_CLOUD_SEQUENTIAL_ENCODING, draco::POINT_CLOUD_KD_TREE_ENCODING}) {
        const std::string bomb = zeroPoints(kPoints, 16, 4, draco::DT_INT32, method);
        EXPECT_LT(bomb.size(), 1000u);
        EXPECT_NE(reasonOfPoints(bomb, kPoints, 10 * kMegabyte).find("memory"), std::string::npos)
            << "5 MB of values and as much of what they are decoded from";
        EXPECT_EQ(reasonOfPoints(bomb, kPoints, 16 * kMegabyte), "") << method;
        EXPECT_EQ(reasonOfPoints(zeroPoints(kPoints, 0, 4, draco::DT_INT32, method), kPoints,
                                 2 * kMegabyte),
                  "");
    }
    // The same of a mesh; cut along seams, each attribute has a connectivity of its own as well.
    const struct {
        int method, unused;
        std::uint64_t tooLittle, enough;
    } meshes[] = {{draco::MESH_SEQUENTIAL_ENCODING, 40, 12 * kMegabyte, 18 * kMegabyte},
                  {draco::MESH_EDGEBREAKER_ENCODING, 16, 24 * kMegabyte, 29 * kMegabyte}};
    for (const auto& [method, unused, tooLittle, enough] : meshes) {
        const DracoEncoded mesh = dracoEncode(100, method, 11, unused);
        const DracoExpectation expected{mesh.points, mesh.faces};
        EXPECT_NE(reasonOf(mesh.bytes, expected, tooLittle).find("attributes would need"),
                  std::string::npos);
        EXPECT_EQ(reasonOf(mesh.bytes, expected, enough), "");
    }
    const DracoEncoded mesh = dracoEncode(100, draco::MESH_EDGEBREAKER_ENCODING, 11, 16);
    EXPECT_NE(
        reasonOf(mesh.bytes, {mesh.points, mesh.faces}, 16 * kMegabyte).find("mesh would need"),
        std::string::npos)
        << "seams";
}

// The tree's decoder has stacks of 32 levels a dimension, each of a number a dimension.
TEST(Draco, DimensionsOfATreeCountAgainstTheBudget) {
    const std::string bomb =
        zeroPoints(1, 3, 127, draco::DT_UINT8, draco::POINT_CLOUD_KD_TREE_ENCODING);
    EXPECT_NE(reasonOfPoints(bomb, 1, 20 * kMegabyte).find("memory"), std::string::npos);
    EXPECT_EQ(reasonOfPoints(bomb, 1, 60 * kMegabyte), "");
}

TEST(Draco, DescriptionsCountAgainstTheBudget) {
    std::string bomb("DRACO\2\2\1\1\0\x80", 11); // a mesh, with metadata
    bomb += std::string("\xff\xff\x3f", 3);      // of a million attributes,
    bomb += std::string(3 * kMegabyte, '\0');    // each of three bytes
    EXPECT_NE(reasonOf(bomb, {1, 1}, 64 * kMegabyte).find("memory"), std::string::npos);
}

} // namespace gnomon
