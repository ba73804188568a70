// What glTF's extensions change: quantised attributes, moved textures, other pictures, points.
#include "glb_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon {

using namespace test;

namespace {

const std::vector<float> kTriangle{0, 0, 0, 1, 0, 0, 0, 1, 0};

// A triangle with uvs (0, 0), (1, 0), (0, 1) and a picture.
struct Textured : GlbBuilder {
    Textured() {
        Json& primitive = triangles(kTriangle, {0, 1, 2});
        primitive["attributes"]["TEXCOORD_0"] = floats({0, 0, 1, 0, 0, 1}, "VEC2");
        primitive["attributes"]["TEXCOORD_1"] = floats({5, 5, 6, 5, 5, 6}, "VEC2");
        primitive["material"] = 0;
        addImage(pngOf(1, 1, 3, "abc"));
        root["textures"] = Json::array({{{"source", 0}}});
        root["materials"] =
            Json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
    }
    void addImage(const std::string& file) {
        root["images"].push_back({{"bufferView", view(file.data(), file.size())}});
    }
    Json& textureInfo() { return root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]; }
    Json& transform() { return textureInfo()["extensions"]["KHR_texture_transform"]; }
};

// The uvs of the corners at (0, 0), (1, 0) and (0, 1).
std::vector<glm::vec2> uvsOf(const Result<TileContent>& content) {
    std::vector<glm::vec2> out(3, glm::vec2(NAN));
    if (!content) {
        ADD_FAILURE() << content.error().message();
        return out;
    }
    const Mesh& mesh = content->meshes.at(0);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::dvec3 at = vertex(mesh, i);
        out[at.x > 0.5 ? 1 : at.y > 0.5 ? 2 : 0] = mesh.uvs.at(i);
    }
    return out;
}

void expectUvs(const GlbBuilder& builder, const std::vector<glm::vec2>& wanted) {
    const auto uvs = uvsOf(decode(builder));
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(uvs[i].x, wanted[i].x, 1e-6) << i;
        EXPECT_NEAR(uvs[i].y, wanted[i].y, 1e-6) << i;
    }
}

} // namespace

TEST(TextureTransform, OffsetsAndScales) {
    Textured builder;
    builder.transform() = {{"offset", {0.5, 0.25}}, {"scale", {2, 3}}};
    expectUvs(builder, {{0.5, 0.25}, {2.5, 0.25}, {0.5, 3.25}});
}

TEST(TextureTransform, TurnsUvsCounterClockwiseSeenWithVDown) {
    Textured builder;
    builder.transform() = {{"rotation", std::numbers::pi / 2}};
    // Seen in the picture, v pointing down, (1, 0) turns up to (0, -1) and (0, 1) right to (1, 0).
    expectUvs(builder, {{0, 0}, {0, -1}, {1, 0}});
}

TEST(TextureTransform, ScalesThenTurnsThenOffsets) {
    Textured builder;
    builder.transform() = {
        {"offset", {10, 20}}, {"rotation", std::numbers::pi / 2}, {"scale", {2, 3}}};
    expectUvs(builder, {{10, 20}, {10, 18}, {13, 20}});
}

TEST(TextureTransform, ItsTexCoordOverridesTheTextures) {
    Textured builder;
    builder.transform() = {{"texCoord", 1}};
    expectUvs(builder, {{5, 5}, {6, 5}, {5, 6}});
    builder.textureInfo()["texCoord"] = 1;
    builder.transform() = {{"texCoord", 0}, {"offset", {1, 1}}};
    expectUvs(builder, {{1, 1}, {2, 1}, {1, 2}});
    builder.transform() = {{"offset", {1, 1}}};
    expectUvs(builder, {{6, 6}, {7, 6}, {6, 7}});
}

TEST(TextureTransform, AppliesToOneMaterialAlone) {
    Textured builder;
    builder.root["materials"].push_back(builder.root["materials"][0]);
    builder.transform() = {{"offset", {1, 1}}};
    Json second = builder.root["meshes"][0]["primitives"][0];
    second["material"] = 1;
    builder.root["meshes"][0]["primitives"] = Json::array({second});
    expectUvs(builder, {{0, 0}, {1, 0}, {0, 1}});
}

TEST(TextureTransform, WorksOnQuantisedUvsAfterTheirNormalisation) {
    Textured builder;
    builder.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
        builder.accessor(std::vector<std::uint16_t>{0, 0, 65535, 0, 0, 65535}, 5123, "VEC2", true);
    builder.transform() = {{"scale", {4, 2}}};
    expectUvs(builder, {{0, 0}, {4, 0}, {0, 2}});
}

TEST(MeshQuantization, PositionsOfEveryType) {
    const auto check = [](auto values, int type, bool normalized, double one) {
        GlbBuilder builder;
        Json& primitive = builder.triangles(kTriangle, {0, 1, 2});
        primitive["attributes"]["POSITION"] = builder.accessor(values, type, "VEC3", normalized);
        builder.root["nodes"][0]["scale"] = {2, 2, 2};
        builder.root["nodes"][0]["translation"] = {10, 0, 0};
        builder.root["extensionsRequired"] = {"KHR_mesh_quantization"};
        const auto content = decode(builder);
        ASSERT_TRUE(content) << content.error().message();
        double farthest = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            farthest = std::max(farthest, vertex(content->meshes.at(0), i).x);
        }
        EXPECT_NEAR(farthest, 10 + 2 * one, 1e-4) << type;
    };
    check(std::vector<std::int8_t>{0, 0, 0, 100, 0, 0, 0, 100, 0}, 5120, false, 100);
    check(std::vector<std::int8_t>{0, 0, 0, 127, 0, 0, 0, 127, 0}, 5120, true, 1);
    check(std::vector<std::uint8_t>{0, 0, 0, 200, 0, 0, 0, 200, 0}, 5121, false, 200);
    check(std::vector<std::uint8_t>{0, 0, 0, 255, 0, 0, 0, 255, 0}, 5121, true, 1);
    check(std::vector<std::int16_t>{0, 0, 0, 3000, 0, 0, 0, 1, 0}, 5122, false, 3000);
    check(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 0, 1, 0}, 5122, true, 1);
    check(std::vector<std::uint16_t>{0, 0, 0, 60000, 0, 0, 0, 1, 0}, 5123, false, 60000);
    check(std::vector<std::uint16_t>{0, 0, 0, 65535, 0, 0, 0, 1, 0}, 5123, true, 1);
}

TEST(MeshQuantization, NormalsOfBytes) {
    GlbBuilder builder;
    Json& primitive = builder.triangles(kTriangle, {0, 1, 2});
    const std::vector<std::int8_t> normals{0, 76, 102, 0, 76, 102, 0, 76, 102};
    primitive["attributes"]["NORMAL"] = builder.accessor(normals, 5120, "VEC3", true);
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    const glm::dvec3 n = decodeOct(content->meshes.at(0).normals.at(0));
    EXPECT_NEAR(n.y, 0.6, 0.01);
    EXPECT_NEAR(n.z, 0.8, 0.01);
}

TEST(Basisu, FallsBackToTheOtherPictureOfTheFile) {
    Textured builder;
    builder.addImage(std::string("\xabKTX 20\xbb\r\n\x1a\n", 12));
    builder.root["textures"][0]["extensions"]["KHR_texture_basisu"]["source"] = 1;
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->images.size(), 1u);
    EXPECT_TRUE(content->facts.warnings.empty());
}

TEST(Basisu, IsRefusedByNameWhereTheFileGivesNothingElse) {
    Textured builder;
    builder.root["images"] = Json::array();
    builder.addImage(std::string("\xabKTX 20\xbb\r\n\x1a\n", 12));
    builder.root["textures"][0] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
    builder.root["extensionsRequired"] = {"KHR_texture_basisu"};
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 1u); // it still casts
    EXPECT_TRUE(content->images.empty());
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_NE(content->facts.warnings[0].find("KHR_texture_basisu"), std::string::npos);
}

TEST(Webp, IsPreferredToTheFallbackBesideIt) {
    // A lossless WebP of one pixel.
    const std::string webp("RIFF\x1a\0\0\0WEBPVP8L\x0d\0\0\0\x2f\0\0\0\x10\x07\x10\x11\x11\x88\x88"
                           "\xfe\x07\0",
                           34);
    Textured builder;
    builder.addImage(webp);
    builder.root["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
    builder.root["images"][0] = {{"uri", "missing.png"}};
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_EQ(content->images.size(), 1u);
    EXPECT_EQ(content->images[0].width, 1);
}

TEST(Unlit, IsTheMaterials) {
    Textured builder;
    builder.root["materials"][0]["extensions"]["KHR_materials_unlit"] = Json::object();
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_TRUE(content->materials.at(0).unlit);
    EXPECT_FALSE(decode(Textured())->materials.at(0).unlit);
}

TEST(TechniquesWebgl, GiveTheirPictureOrColour) {
    Textured builder;
    Json& material = builder.root["materials"][0];
    material.erase("pbrMetallicRoughness");
    Json& values = material["extensions"]["KHR_techniques_webgl"]["values"];
    values["u_diffuse"] = {{"index", 0}, {"texCoord", 1}};
    expectUvs(builder, {{5, 5}, {6, 5}, {5, 6}});
    values["u_diffuse"] = {0.25, 0.5, 0.75, 1.0};
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->materials.at(0).baseColor, glm::vec4(0.25f, 0.5f, 0.75f, 1.0f));
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_NE(content->facts.warnings[0].find("KHR_techniques_webgl"), std::string::npos);
}

TEST(GltfPoints, BecomeSolidsWithTheirColoursAndFeatures) {
    GlbBuilder builder;
    Json& primitive = builder.triangles({0, 0, 0, 10, 0, 0, 0, 10, 0, 0, 0, 99}, {2, 1, 0});
    primitive["mode"] = 0; // the last is not named, so it is not there
    primitive["attributes"]["COLOR_0"] =
        builder.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1}, "VEC3");
    primitive["attributes"]["_FEATURE_ID_0"] = builder.floats({5, 6, 7, 8}, "SCALAR");
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 12u);
    EXPECT_EQ(content->facts.closedTriangles, 12u);
    const Mesh& mesh = content->meshes.at(0);
    for (std::size_t t = 0; t < 3; ++t) {
        glm::dvec3 centre(0.0);
        for (std::size_t i = 12 * t; i < 12 * t + 12; ++i) {
            centre += vertex(mesh, mesh.indices[i]) / 12.0;
        }
        const std::uint32_t first = mesh.indices[12 * t];
        const std::uint32_t wanted = centre.x > 5 ? 6 : centre.y > 5 ? 7 : 5;
        EXPECT_EQ(mesh.features.at(first), wanted);
        EXPECT_EQ(mesh.colors.at(first), 0xff000000u | 0xffu << (8 * (wanted - 5)));
    }
}

TEST(GltfPoints, StandBesideTrianglesAndAtEachInstance) {
    GlbBuilder builder;
    builder.triangles(kTriangle, {0, 1, 2});
    Json points = builder.root["meshes"][0]["primitives"][0];
    points["mode"] = 0;
    builder.root["meshes"][0]["primitives"].push_back(points);
    const int at = builder.floats({0, 0, 0, 100, 0, 0}, "VEC3");
    builder.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", at}};
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 2 * (1u + 3 * 4u));
    EXPECT_EQ(content->facts.closedTriangles, 24u);
}

TEST(GltfPoints, IndicesOutOfRangeAreRefused) {
    GlbBuilder builder;
    builder.triangles(kTriangle, {0, 3, 2})["mode"] = 0;
    const auto content = decode(builder);
    ASSERT_FALSE(content);
    EXPECT_EQ(content.error().reason, "index 3 of 3 vertices");
}

TEST(GltfPoints, GaussianSplatsAreRefusedByName) {
    GlbBuilder builder;
    Json& primitive = builder.triangles(kTriangle, {0, 1, 2});
    primitive["mode"] = 0;
    primitive["extensions"]["KHR_gaussian_splatting"] = Json::object();
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 0u);
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_NE(content->facts.warnings[0].find("KHR_gaussian_splatting"), std::string::npos);
}

TEST(UpAxis, TurnsTheModelAndCesiumRtcMovesItAfterwards) {
    GlbBuilder builder;
    builder.triangles({1, 2, 3, 1, 2, 4, 1, 3, 3}, {0, 1, 2});
    builder.root["extensions"]["CESIUM_RTC"]["center"] = {1215012.5, -4736313.25, 4081605.0};
    const glm::dvec3 centre(1215012.5, -4736313.25, 4081605.0);
    const auto first = [&](UpAxis up) {
        DecodeOptions options;
        options.gltfUpAxis = up;
        const auto content = decode(builder, options);
        if (!content) {
            ADD_FAILURE() << content.error().message();
            return glm::dvec3(0.0);
        }
        const Mesh& mesh = content->meshes.at(0);
        return vertex(mesh, mesh.indices[0]);
    };
    EXPECT_LT(glm::distance(first(UpAxis::Z), centre + glm::dvec3(1, 2, 3)), 1e-6);
    EXPECT_LT(glm::distance(first(UpAxis::Y), centre + glm::dvec3(1, -3, 2)), 1e-6);
    EXPECT_LT(glm::distance(first(UpAxis::X), centre + glm::dvec3(-3, 2, 1)), 1e-6);
}

TEST(Refused, ByName) {
    const auto reason = [](const std::string& bytes) { return decode(bytes).error().reason; };
    EXPECT_EQ(reason("vctr\1\0\0\0"), "vctr content is not supported");
    EXPECT_EQ(reason("geom\1\0\0\0"), "geom content is not supported");
    EXPECT_EQ(reason("subt\1\0\0\0"), "subt content is not supported");
    EXPECT_NE(reason("PK\x03\x04..").find("3tz"), std::string::npos);
    EXPECT_EQ(reason("what?"), "neither b3dm, i3dm, pnts, cmpt, glb nor glTF");
}

} // namespace gnomon
