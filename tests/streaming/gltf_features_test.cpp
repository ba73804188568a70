// Which row of a file's property tables a vertex or an instance has, where the file says little or
// says it wrong. property_table_test.cpp has the tables themselves.
#include "glb_builder.h"

#include <gtest/gtest.h>

#include <set>

namespace gnomon {

using namespace test;

namespace {

// A triangle with ids `name` at its corners, and a table of two rows.
GlbBuilder withTable(const std::string& name) {
    GlbBuilder builder;
    builder.triangles({0, 0, 0, 9, 0, 0, 0, 9, 0}, {0, 1, 2});
    Json& primitive = builder.root["meshes"][0]["primitives"][0];
    primitive["attributes"][name] =
        builder.accessor(std::vector<std::uint8_t>{1, 1, 1}, 5121, "SCALAR");
    const std::vector<std::uint8_t> values{10, 11};
    builder.root["extensions"]["EXT_structural_metadata"] = {
        {"schema",
         {{"classes",
           {{"c", {{"properties", {{"n", {{"type", "SCALAR"}, {"componentType", "UINT8"}}}}}}}}}}},
        {"propertyTables",
         {{{"class", "c"},
           {"count", 2},
           {"properties", {{"n", {{"values", builder.view(values.data(), 2)}}}}}}}}};
    return builder;
}

std::set<std::uint32_t> idsOf(const Result<TileContent>& content) {
    std::set<std::uint32_t> out;
    for (const Mesh& mesh : content->meshes) {
        out.insert(mesh.features.begin(), mesh.features.end());
        if (mesh.features.empty()) {
            out.insert(kNoFeature);
        }
    }
    return out;
}

const std::set<std::uint32_t> kNone{kNoFeature};

} // namespace

TEST(GltfFeatureRows, IdsThatNameNoTableHaveNoRowOfIt) {
    for (const char* name : {"_FEATURE_ID_0", "_BATCHID", "BATCHID"}) {
        const auto content = decode(withTable(name));
        ASSERT_TRUE(content) << content.error().message();
        ASSERT_TRUE(content->features);
        EXPECT_EQ(content->features->rows(), 2u);
        EXPECT_EQ(idsOf(content), kNone) << name;
    }
    GlbBuilder legacy = withTable("_FEATURE_ID_0");
    legacy.root["meshes"][0]["primitives"][0]["extensions"]["EXT_feature_metadata"]
               ["featureIdAttributes"] = {{{"featureIds", {{"attribute", "_FEATURE_ID_0"}}}}};
    EXPECT_EQ(idsOf(decode(legacy)), kNone);
}

TEST(GltfFeatureRows, WhereTheExtensionIsNoOtherIdsAreTakenForIts) {
    GlbBuilder builder = withTable("_FEATURE_ID_0");
    Json& sets =
        builder.root["meshes"][0]["primitives"][0]["extensions"]["EXT_mesh_features"]["featureIds"];
    sets = {{{"featureCount", 2}, {"propertyTable", 0}, {"texture", {{"index", 0}}}}};
    EXPECT_EQ(idsOf(decode(builder)), kNone);
    sets = {{{"featureCount", 2}, {"propertyTable", 0}, {"attribute", 3}}};
    EXPECT_EQ(idsOf(decode(builder)), kNone);
    sets = {{{"featureCount", 2}, {"propertyTable", 0}, {"attribute", 0}}};
    EXPECT_EQ(idsOf(decode(builder)), (std::set<std::uint32_t>{1}));
}

TEST(GltfFeatureRows, BatchIdsAreRowsOfTheBatchTableWhereTheFileHasNone) {
    GlbBuilder builder = withTable("_BATCHID");
    for (const Json& metadata : {Json(nullptr), Json::object(), Json{{"propertyTables", {7}}}}) {
        builder.root["extensions"]["EXT_structural_metadata"] = metadata;
        const auto content =
            decode(b3dmOf(builder.text(), R"({"BATCH_LENGTH":2})", R"({"n":["a","b"]})"));
        ASSERT_TRUE(content) << content.error().message();
        EXPECT_EQ(idsOf(content), (std::set<std::uint32_t>{1})) << metadata;
    }
}

TEST(GltfFeatureRows, AreReadBehindAByteOrderMarkToo) {
    GlbBuilder builder = withTable("_FEATURE_ID_0");
    builder.root["meshes"][0]["primitives"][0]["extensions"]["EXT_mesh_features"]["featureIds"] = {
        {{"featureCount", 2}, {"propertyTable", 0}, {"attribute", 0}}};
    const auto content = decode(GlbBuilder::glbOf("\xef\xbb\xbf" + builder.json(), builder.bin));
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_TRUE(content->features);
    EXPECT_EQ(content->features->row(1)[0].value, PropertyValue(std::int64_t(11)));
    EXPECT_EQ(idsOf(content), (std::set<std::uint32_t>{1}));
}

// The instances may be told apart by nothing but their ids.
TEST(GltfInstances, AreAsManyAsAnyOfTheirAttributes) {
    GlbBuilder builder;
    builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    Json& extensions = builder.root["nodes"][0]["extensions"];
    Json& attributes = extensions["EXT_mesh_gpu_instancing"]["attributes"];
    attributes["_FEATURE_ID_0"] =
        builder.accessor(std::vector<std::uint16_t>{2, 0, 5}, 5123, "SCALAR");
    extensions["EXT_instance_features"]["featureIds"] = {{{"featureCount", 3}, {"attribute", 0}}};
    auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    // All three stand in one place, where the last two are duplicates of the first.
    EXPECT_EQ(content->facts.triangles + content->facts.duplicates, 36u);
    EXPECT_EQ(idsOf(content), (std::set<std::uint32_t>{2}));
    // Those that place them come first, and one that is not there is no count.
    attributes["A"] = 99;
    attributes["TRANSLATION"] = builder.floats({0, 0, 0, 50, 0, 0}, "VEC3");
    content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 24u);
    EXPECT_EQ(idsOf(content), (std::set<std::uint32_t>{0, 2}));
    attributes = {{"A", 99}, {"B", "x"}};
    content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 12u);
}

} // namespace gnomon
