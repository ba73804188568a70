// KHR_draco_mesh_compression, with what Draco's own encoder makes.
#include "streaming/draco.h"

#include "draco_builder.h"

#include <gtest/gtest.h>

#include <cmath>

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

} // namespace gnomon
