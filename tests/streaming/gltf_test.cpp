// What a glTF may be made of, each read through decodeContent.
#include "glb_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gnomon {

using namespace test;

namespace {

const std::vector<float> kTriangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};

GlbBuilder triangle() {
    GlbBuilder builder;
    builder.triangles(kTriangle, {0, 1, 2});
    return builder;
}

Json& primitiveOf(GlbBuilder& builder) {
    return builder.root["meshes"][0]["primitives"][0];
}

// The corners of all triangles, in order, in ECEF.
std::vector<glm::dvec3> cornersOf(const TileContent& content) {
    std::vector<glm::dvec3> out;
    for (const Mesh& mesh : content.meshes) {
        for (const std::uint32_t i : mesh.indices) {
            out.push_back(vertex(mesh, i));
        }
    }
    return out;
}

void expectCorners(const Result<TileContent>& content, const std::vector<glm::dvec3>& expected,
                   double within = 1e-6) {
    ASSERT_TRUE(content) << content.error().message();
    const std::vector<glm::dvec3> corners = cornersOf(*content);
    ASSERT_EQ(corners.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_LT(glm::distance(corners[i], expected[i]), within)
            << i << ": " << corners[i].x << " " << corners[i].y << " " << corners[i].z;
    }
}

const Mesh& onlyMesh(const Result<TileContent>& content) {
    return content.value().meshes.at(0);
}

} // namespace

TEST(Gltf, ABoxComesOutClosedWithItsFacesNormals) {
    GlbBuilder builder;
    builder.triangles(boxCorners(glm::vec3(-1.0f), glm::vec3(1.0f)), boxTriangles());
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.format, "glb");
    EXPECT_EQ(content->facts.triangles, 12u);
    EXPECT_EQ(content->facts.closedTriangles, 12u);
    ASSERT_EQ(content->meshes.size(), 1u);
    const Mesh& mesh = content->meshes[0];
    EXPECT_EQ(mesh.closedTriangles, 12u);
    EXPECT_EQ(mesh.positions.size(), 24u); // a corner has three normals
    EXPECT_TRUE(mesh.uvs.empty());
    EXPECT_TRUE(mesh.colors.empty());
    EXPECT_TRUE(mesh.features.empty());
    for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
        const glm::dvec3 face = decodeOct(mesh.faceNormals[t]);
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh.indices[3 * t + std::uint32_t(k)];
            EXPECT_GT(glm::dot(face, vertex(mesh, v)), 0.9); // outward
            EXPECT_GT(glm::dot(face, decodeOct(mesh.normals[v])), 0.999);
        }
    }
    EXPECT_NEAR(mesh.radiusMetres, std::sqrt(3.0), 1e-6);
}

TEST(Gltf, ReadsIndicesOfEveryWidthAndNone) {
    for (const int type : {5121, 5123, 5125, 0}) {
        GlbBuilder builder = triangle();
        Json& primitive = primitiveOf(builder);
        primitive.erase("indices");
        if (type == 5121) {
            primitive["indices"] =
                builder.accessor(std::vector<std::uint8_t>{2, 0, 1}, type, "SCALAR");
        } else if (type == 5123) {
            primitive["indices"] =
                builder.accessor(std::vector<std::uint16_t>{2, 0, 1}, type, "SCALAR");
        } else if (type == 5125) {
            primitive["indices"] = builder.indices({2, 0, 1});
        }
        const auto expected = type == 0 ? std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}
                                        : std::vector<glm::dvec3>{{0, 1, 0}, {0, 0, 0}, {1, 0, 0}};
        expectCorners(decode(builder), expected);
    }
}

TEST(Gltf, StripsAndFansKeepTheirFacing) {
    const std::vector<float> strip = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    GlbBuilder builder;
    builder.triangles(strip, {0, 1, 2, 3})["mode"] = 5;
    auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.triangles, 2u);
    EXPECT_NEAR(content->facts.areaVector.z, 1.0, 1e-12);

    GlbBuilder fan;
    fan.triangles({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 3})["mode"] = 6;
    content = decode(fan);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.triangles, 2u);
    EXPECT_NEAR(content->facts.areaVector.z, 1.0, 1e-12);
}

TEST(Gltf, TheRestartIndexCutsAStrip) {
    GlbBuilder builder;
    Json& primitive =
        builder.triangles({0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 5, 1, 0}, {0, 1, 2});
    primitive["mode"] = 5;
    primitive["indices"] =
        builder.accessor(std::vector<std::uint16_t>{0, 1, 2, 0xffff, 3, 4, 5}, 5123, "SCALAR");
    expectCorners(decode(builder),
                  {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
}

TEST(Gltf, The65536thVertexCanBeUsedByATriangle) {
    std::vector<float> positions(65536 * 3, 0.0f);
    positions[3] = 1.0f;
    positions[3 * 65535 + 1] = 1.0f;
    GlbBuilder builder;
    builder.triangles(positions, {0, 1, 2});
    primitiveOf(builder)["indices"] =
        builder.accessor(std::vector<std::uint16_t>{0, 1, 65535}, 5123, "SCALAR");
    expectCorners(decode(builder), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
}

TEST(Gltf, LinesAreLeftOutAndSaidSo) {
    for (const int mode : {1, 2, 3}) {
        GlbBuilder builder = triangle();
        primitiveOf(builder)["mode"] = mode;
        const auto content = decode(builder);
        ASSERT_TRUE(content);
        EXPECT_EQ(content->facts.triangles, 0u);
        EXPECT_TRUE(content->meshes.empty());
        ASSERT_EQ(content->facts.warnings.size(), 1u);
        EXPECT_NE(content->facts.warnings[0].find("lines are not drawn"), std::string::npos);
    }
}

TEST(Gltf, NodesMultiplyUp) {
    GlbBuilder builder;
    builder.triangles(kTriangle, {0, 1, 2});
    builder.root["nodes"] = Json::array(
        {{{"children", {1}}, {"translation", {10, 0, 0}}},
         {{"mesh", 0},
          {"rotation", {0, 0, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2}}, // 90° about z
          {"scale", {2, 2, 2}}}});
    expectCorners(decode(builder), {{10, 0, 0}, {10, 2, 0}, {8, 0, 0}});
    builder.root["nodes"][1] = {{"mesh", 0},
                                {"matrix", {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}}};
    expectCorners(decode(builder), {{10, 0, 0}, {10, 2, 0}, {8, 0, 0}});
}

TEST(Gltf, AMirroringNodeKeepsFacesUp) {
    GlbBuilder builder = triangle();
    builder.root["nodes"][0]["scale"] = {-1, 1, 1};
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_NEAR(content->facts.areaVector.z, 0.5, 1e-12);

    primitiveOf(builder)["attributes"]["NORMAL"] =
        builder.floats({0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f}, "VEC3");
    const auto shaded = decode(builder);
    ASSERT_TRUE(shaded);
    const glm::dvec3 expected(-0.6, 0.0, 0.8);
    EXPECT_GT(glm::dot(decodeOct(onlyMesh(shaded).normals[0]), expected), 1.0 - 1e-8);
}

TEST(Gltf, ShowsTheDefaultSceneElseTheFirst) {
    GlbBuilder builder = triangle();
    builder.node({{"mesh", 0}, {"translation", {5, 0, 0}}});
    EXPECT_EQ(decode(builder)->facts.triangles, 2u); // no scene: all
    builder.root["scenes"] = Json::array({{{"nodes", {0}}}, {{"nodes", {1}}}});
    expectCorners(decode(builder), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    builder.root["scene"] = 1;
    expectCorners(decode(builder), {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
}

TEST(Gltf, ANodeLoopEndsAndIsSaid) {
    GlbBuilder builder = triangle();
    builder.root["nodes"][0]["children"] = {1};
    builder.node({{"children", {0}}, {"translation", {0, 0, 5}}});
    builder.root["scenes"] = Json::array({{{"nodes", {0}}}});
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.triangles, 1u);
    EXPECT_EQ(content->facts.warnings.size(), 1u);
}

TEST(Gltf, EveryUpAxisEndsAsZ) {
    const GlbBuilder builder = triangle(); // along x and y
    DecodeOptions options;
    options.gltfUpAxis = UpAxis::Z;
    expectCorners(decode(builder, options), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    options.gltfUpAxis = UpAxis::Y;
    expectCorners(decode(builder, options), {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}});
    options.gltfUpAxis = UpAxis::X;
    expectCorners(decode(builder, options), {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}});
}

TEST(Gltf, TransformsAreAppliedInTheStandardsOrder) {
    // Tile transform · RTC · up axis · node.
    GlbBuilder builder = triangle();
    builder.root["nodes"][0]["translation"] = {0, 7, 0};
    builder.root["extensions"] = {{"CESIUM_RTC", {{"center", {100, 200, 300}}}}};
    DecodeOptions options; // y up
    options.ecefFromTile.matrix = glm::dmat4(2.0);
    options.ecefFromTile.matrix[3] = {6378137.0, 0.0, 0.0, 1.0};
    expectCorners(decode(builder, options),
                  {{6378337, 400, 614}, {6378339, 400, 614}, {6378337, 400, 616}}, 1e-5);
}

TEST(Gltf, ReadsNormalizedAndPlainIntegerPositions) {
    GlbBuilder builder = triangle();
    builder.root["extensionsRequired"] = {"KHR_mesh_quantization"};
    const auto positions = [&](int accessor) {
        primitiveOf(builder)["attributes"]["POSITION"] = accessor;
        return decode(builder);
    };
    // Rows of four: attributes are aligned to four bytes.
    const auto strided = [&](int accessor, int stride) {
        const int view = builder.root["accessors"][std::size_t(accessor)]["bufferView"];
        builder.root["bufferViews"][std::size_t(view)]["byteStride"] = stride;
        builder.root["accessors"][std::size_t(accessor)]["type"] = "VEC3";
        return accessor;
    };
    expectCorners(
        positions(strided(builder.accessor(std::vector<std::int16_t>{0, 0, 0, 9, 32767, 0, 0, 9,
                                                                     -32768, -32767, 0, 9},
                                           5122, "VEC4", true),
                          8)),
        {{0, 0, 0}, {1, 0, 0}, {-1, -1, 0}});
    expectCorners(
        positions(strided(
            builder.accessor(std::vector<std::uint16_t>{0, 0, 0, 9, 65535, 0, 0, 9, 0, 65535, 0, 9},
                             5123, "VEC4", true),
            8)),
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    expectCorners(positions(strided(builder.accessor(std::vector<std::int8_t>{0, 0, 0, 9, 127, 0, 0,
                                                                              9, 0, -128, 0, 9},
                                                     5120, "VEC4", true),
                                    4)),
                  {{0, 0, 0}, {1, 0, 0}, {0, -1, 0}});
    expectCorners(positions(strided(builder.accessor(std::vector<std::uint8_t>{0, 0, 0, 9, 200, 0,
                                                                               0, 9, 0, 100, 0, 9},
                                                     5121, "VEC4"),
                                    4)),
                  {{0, 0, 0}, {200, 0, 0}, {0, 100, 0}});
}

TEST(Gltf, SparseAccessorsReplaceWhatTheyName) {
    GlbBuilder builder = triangle();
    const std::vector<std::uint16_t> which = {1};
    const std::vector<float> value = {3, 0, 4};
    const int indexView = builder.view(which.data(), 2);
    const int valueView = builder.view(value.data(), 12);
    Json& accessor = builder.root["accessors"][0];
    accessor["sparse"] = {{"count", 1},
                          {"indices", {{"bufferView", indexView}, {"componentType", 5123}}},
                          {"values", {{"bufferView", valueView}}}};
    expectCorners(decode(builder), {{0, 0, 0}, {3, 0, 4}, {0, 1, 0}});
    accessor.erase("bufferView"); // then the others are zero
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.degenerate, 1u);
}

TEST(Gltf, KeepsColoursTextureCoordinatesAndFeatures) {
    GlbBuilder builder = triangle();
    Json& attributes = primitiveOf(builder)["attributes"];
    attributes["COLOR_0"] = builder.accessor(
        std::vector<std::uint8_t>{255, 0, 0, 0, 0, 255, 0, 0, 0, 0, 51, 0}, 5121, "VEC4", true);
    attributes["_BATCHID"] = builder.floats({0.0f, 6.9999f, -1.0f}, "SCALAR");
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    const Mesh& mesh = onlyMesh(content);
    EXPECT_EQ(mesh.colors, (std::vector<std::uint32_t>{0x000000ff, 0x0000ff00, 0x00330000}));
    EXPECT_EQ(mesh.features, (std::vector<std::uint32_t>{0, 7, kNoFeature}));

    attributes["COLOR_0"] = builder.floats({1, 0.5f, 0, 2, -1, 0, 0, 0, NAN}, "VEC3");
    const auto floats = decode(builder);
    ASSERT_TRUE(floats);
    EXPECT_EQ(onlyMesh(floats).colors,
              (std::vector<std::uint32_t>{0xff0080ff, 0xff0000ff, 0xff000000}));

    attributes["COLOR_0"] = builder.accessor(
        std::vector<std::uint16_t>{65535, 0, 0, 9, 0, 65535, 0, 9, 0, 0, 0, 9}, 5123, "VEC4", true);
    EXPECT_EQ(onlyMesh(decode(builder)).colors[0], 0x000000ffu);
}

TEST(Gltf, FeatureIdsComeFromWhereTheExtensionSays) {
    GlbBuilder builder = triangle();
    Json& primitive = primitiveOf(builder);
    primitive["attributes"]["_FEATURE_ID_1"] =
        builder.accessor(std::vector<std::uint32_t>{5, 6, 7}, 5125, "SCALAR");
    primitive["extensions"]["EXT_mesh_features"] = {
        {"featureIds",
         Json::array({{{"featureCount", 9}, {"attribute", 1}, {"nullFeatureId", 6}}})}};
    EXPECT_EQ(onlyMesh(decode(builder)).features, (std::vector<std::uint32_t>{5, kNoFeature, 7}));
    primitive["extensions"]["EXT_mesh_features"] = {
        {"featureIds", Json::array({{{"featureCount", 3}}})}}; // the vertex's own number
    EXPECT_EQ(onlyMesh(decode(builder)).features, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST(Gltf, StoredNormalsFollowRotationAndUnevenScale) {
    GlbBuilder builder = triangle();
    const float s = std::sqrt(0.5f);
    primitiveOf(builder)["attributes"]["NORMAL"] =
        builder.floats({s, 0, s, s, 0, s, s, 0, s}, "VEC3");
    builder.root["nodes"][0]["scale"] = {2, 1, 1};
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    const glm::dvec3 expected = glm::normalize(glm::dvec3(0.5, 0.0, 1.0));
    EXPECT_GT(glm::dot(decodeOct(onlyMesh(content).normals[0]), expected), 1.0 - 1e-8);
}

TEST(Gltf, NormalsThatPointIntoASolidAreTurnedOut) {
    GlbBuilder builder;
    const std::vector<float> corners = boxCorners(glm::vec3(-1.0f), glm::vec3(1.0f));
    std::vector<float> inward;
    for (const float c : corners) {
        inward.push_back(-c / std::sqrt(3.0f));
    }
    builder.triangles(corners, boxTriangles());
    primitiveOf(builder)["attributes"]["NORMAL"] = builder.floats(inward, "VEC3");
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    const Mesh& mesh = onlyMesh(content);
    EXPECT_EQ(mesh.positions.size(), 8u); // smooth: a vertex a corner
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        EXPECT_GT(glm::dot(decodeOct(mesh.normals[i]), vertex(mesh, i)), 1.7);
    }
}

TEST(Gltf, MaterialsCarryOverWhatIsDrawn) {
    GlbBuilder builder = triangle();
    builder.root["materials"] =
        Json::array({{{"name", "unused"}},
                     {{"pbrMetallicRoughness", {{"baseColorFactor", {0.25, 0.5, 0.75, 1.0}}}},
                      {"alphaMode", "MASK"},
                      {"alphaCutoff", 0.25},
                      {"extensions", {{"KHR_materials_unlit", Json::object()}}}}});
    builder.root["extensionsUsed"] = {"KHR_materials_unlit"};
    builder.root["asset"]["copyright"] = "somebody";
    primitiveOf(builder)["material"] = 1;
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    ASSERT_EQ(content->materials.size(), 1u);
    const Material& material = content->materials[0];
    EXPECT_EQ(material.baseColor, glm::vec4(0.25f, 0.5f, 0.75f, 1.0f));
    EXPECT_TRUE(material.unlit);
    EXPECT_TRUE(material.alphaTest);
    EXPECT_EQ(material.alphaCutoff, 0.25f);
    EXPECT_EQ(material.image, -1);
    EXPECT_EQ(content->facts.copyright, "somebody");
    EXPECT_EQ(content->facts.extensions, std::vector<std::string>{"KHR_materials_unlit"});
}

TEST(Gltf, TexturesComeWithTheirCoordinatesTransformedAndChosen) {
    GlbBuilder builder = triangle();
    const std::string png = pngOf(2, 1, 3, "abcdef");
    builder.root["images"] = Json::array({{{"bufferView", builder.view(png.data(), png.size())}}});
    builder.root["samplers"] =
        Json::array({{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}});
    builder.root["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
    Json& info = builder.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    info = {{"index", 0}, {"texCoord", 1}};
    Json& primitive = primitiveOf(builder);
    primitive["material"] = 0;
    primitive["attributes"]["TEXCOORD_0"] = builder.floats({9, 9, 9, 9, 9, 9}, "VEC2");
    primitive["attributes"]["TEXCOORD_1"] = builder.floats({0, 0, 1, 0, 0, 1}, "VEC2");
    auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_EQ(content->images.size(), 1u);
    EXPECT_EQ(content->images[0].width, 2);
    EXPECT_EQ(content->images[0].rgba,
              (std::vector<std::uint8_t>{'a', 'b', 'c', 255, 'd', 'e', 'f', 255}));
    const Material material = content->materials.at(0);
    EXPECT_EQ(material.image, 0);
    EXPECT_EQ(material.wrapS, Wrap::ClampToEdge);
    EXPECT_EQ(material.wrapT, Wrap::MirroredRepeat);
    EXPECT_TRUE(material.nearestFilter);
    EXPECT_EQ(onlyMesh(content).uvs, (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));

    // A quarter turn: u runs up the image, v to its right.
    info["extensions"]["KHR_texture_transform"] = {
        {"offset", {0.5, 0.25}}, {"rotation", std::numbers::pi / 2}, {"scale", {2, 3}}};
    content = decode(builder);
    ASSERT_TRUE(content);
    const std::vector<glm::vec2> expected = {{0.5, 0.25}, {0.5, -1.75}, {3.5, 0.25}};
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_LT(glm::distance(onlyMesh(content).uvs[i], expected[i]), 1e-6f) << i;
    }
    info["extensions"]["KHR_texture_transform"] = {{"texCoord", 0}};
    EXPECT_EQ(onlyMesh(decode(builder)).uvs[0], glm::vec2(9.0f));
}

TEST(Gltf, BasisTexturesAreDrawnWithoutAndSaid) {
    GlbBuilder builder = triangle();
    builder.root["extensionsRequired"] = {"KHR_texture_basisu"};
    builder.root["images"] = Json::array({{{"uri", "x.ktx2"}}});
    builder.root["textures"] =
        Json::array({{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}});
    builder.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    primitiveOf(builder)["material"] = 0;
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 1u);
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_NE(content->facts.warnings[0].find("KHR_texture_basisu"), std::string::npos);
}

TEST(Gltf, InstancesBecomeTriangles) {
    GlbBuilder builder = triangle();
    const int translations = builder.floats({0, 0, 0, 10, 0, 0, 20, 0, 0}, "VEC3");
    const float h = std::sqrt(0.5f);
    const int rotations = builder.floats({0, 0, 0, 1, 0, 0, h, h, 0, 0, 0, 1}, "VEC4");
    const int scales = builder.floats({1, 1, 1, 1, 1, 1, 3, 3, 3}, "VEC3");
    builder.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", translations}, {"ROTATION", rotations}, {"SCALE", scales}};
    builder.root["nodes"][0]["translation"] = {0, 0, 1};
    expectCorners(decode(builder), {{0, 0, 1},
                                    {1, 0, 1},
                                    {0, 1, 1},
                                    {10, 0, 1},
                                    {10, 1, 1},
                                    {9, 0, 1},
                                    {20, 0, 1},
                                    {23, 0, 1},
                                    {20, 3, 1}});
}

TEST(Gltf, UnknownRequiredExtensionsAreRefusedByName) {
    for (const char* name : {"VENDOR_new_geometry", "KHR_gaussian_splatting_compression_spz"}) {
        GlbBuilder builder = triangle();
        builder.root["extensionsRequired"] = {name};
        const auto content = decode(builder);
        ASSERT_FALSE(content);
        EXPECT_EQ(content.error().subject, "tile");
        EXPECT_NE(content.error().reason.find(name), std::string::npos);
        builder.root["extensionsRequired"] = Json::array();
        builder.root["extensionsUsed"] = {name};
        EXPECT_TRUE(decode(builder));
    }
}

TEST(Gltf, ReadsJsonWithDataAndExternalBuffers) {
    GlbBuilder builder = triangle();
    DecodeOptions options = plain();
    std::string asked;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        asked = uri;
        return bytesOf(builder.bin);
    };
    builder.root["buffers"] =
        Json::array({{{"byteLength", builder.bin.size()}, {"uri", "folder/a%20b.bin"}}});
    auto content = decode(builder.root.dump(), options);
    expectCorners(content, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    EXPECT_EQ(content->facts.format, "gltf");
    EXPECT_EQ(asked, "folder/a%20b.bin"); // resolving is the source's

    // 0, 1.0f, 0 and so on: kTriangle and 0, 1, 2.
    builder.root["buffers"][0]["uri"] =
        "data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAEAAAACAAAA";
    asked.clear();
    expectCorners(decode(builder.root.dump(), options), {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    EXPECT_TRUE(asked.empty());

    builder.root["buffers"][0]["uri"] = "../secret.bin";
    options.readUri = [](const std::string& uri) -> Result<Bytes> {
        return Error{uri, "leaves the folder"};
    };
    content = decode(builder.root.dump(), options);
    ASSERT_FALSE(content);
    EXPECT_NE(content.error().reason.find("../secret.bin: leaves the folder"), std::string::npos);
}

} // namespace gnomon
