// EXT_structural_metadata, and how glTF says which feature a vertex is of.
#include "glb_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace gnomon {

using namespace test;

namespace {

using Features = std::map<std::uint32_t, std::size_t>; // triangles by feature

// Separate triangles side by side, `features[i]` the id at the three corners of the i-th.
Json& trianglesOf(GlbBuilder& builder, std::size_t count, float y = 0.0f) {
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    for (std::size_t i = 0; i < count; ++i) {
        const float x = float(i) * 10.0f;
        positions.insert(positions.end(), {x, y, 0, x + 1, y, 0, x, y + 1, 0});
        for (std::uint32_t k = 0; k < 3; ++k) {
            indices.push_back(std::uint32_t(3 * i) + k);
        }
    }
    return builder.triangles(positions, indices);
}

template <class T>
std::vector<T> thrice(const std::vector<T>& ids) {
    std::vector<T> out;
    for (const T id : ids) {
        out.insert(out.end(), 3, id);
    }
    return out;
}

Result<TileContent> decoded(const GlbBuilder& builder, const DecodeOptions& options = {}) {
    return decodeContent(builder.glb(), "tile.glb", options);
}

Features featuresOf(const TileContent& content) {
    Features out;
    for (const Mesh& mesh : content.meshes) {
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            ++out[mesh.features.empty() ? kNoFeature : mesh.features[mesh.indices[i]]];
        }
    }
    return out;
}

bool warnsOf(const TileContent& content, const std::string& what) {
    return std::any_of(content.facts.warnings.begin(), content.facts.warnings.end(),
                       [&](const std::string& text) { return text.find(what) != text.npos; });
}

// A class "thing" and one table of it, a property at a time.
class TableBuilder {
  public:
    explicit TableBuilder(std::size_t rows) : rows_(rows) { trianglesOf(glb, 1); }

    template <class T>
    int view(const std::vector<T>& values) {
        return glb.view(values.data(), values.size() * sizeof(T));
    }
    template <class T>
    void property(const std::string& name, const Json& schema, const std::vector<T>& values,
                  Json own = Json::object()) {
        own["values"] = view(values);
        add(name, schema, own);
    }
    void add(const std::string& name, const Json& schema, const Json& own) {
        schema_["classes"]["thing"]["properties"][name] = schema;
        table_[name] = own;
    }
    Json& enums() { return schema_["enums"]; }

    Json extension() const {
        return {
            {"schema", schema_},
            {"propertyTables", {{{"class", "thing"}, {"count", rows_}, {"properties", table_}}}}};
    }
    Result<TileContent> decode() {
        glb.root["extensionsUsed"] = {"EXT_structural_metadata"};
        glb.root["extensions"]["EXT_structural_metadata"] = extension();
        return decoded(glb);
    }
    // JSON of one property, row by row.
    std::vector<std::string> rows(const std::string& name) {
        const auto content = decode();
        std::vector<std::string> out;
        if (!content || !content->features) {
            ADD_FAILURE() << (content ? "no table" : content.error().message());
            return out;
        }
        warnings = content->facts.warnings;
        for (std::uint32_t i = 0; i < content->features->rows(); ++i) {
            for (const Property& property : content->features->row(i)) {
                if (property.name == name) {
                    out.push_back(jsonOf(property.value));
                }
            }
        }
        return out;
    }

    GlbBuilder glb;
    std::vector<std::string> warnings;

  private:
    std::size_t rows_;
    Json schema_ = {{"id", "s"}}, table_ = Json::object();
};

using Rows = std::vector<std::string>;

} // namespace

TEST(PropertyTable, ReadsScalarsOfEveryComponentType) {
    TableBuilder t(2);
    const auto scalar = [](const char* component) {
        return Json{{"type", "SCALAR"}, {"componentType", component}};
    };
    t.property("i8", scalar("INT8"), std::vector<std::int8_t>{-128, 127});
    t.property("u8", scalar("UINT8"), std::vector<std::uint8_t>{0, 255});
    t.property("i16", scalar("INT16"), std::vector<std::int16_t>{-32768, 5});
    t.property("u16", scalar("UINT16"), std::vector<std::uint16_t>{65535, 5});
    t.property("i32", scalar("INT32"), std::vector<std::int32_t>{INT32_MIN, 5});
    t.property("u32", scalar("UINT32"), std::vector<std::uint32_t>{UINT32_MAX, 5});
    t.property("i64", scalar("INT64"), std::vector<std::int64_t>{INT64_MIN, 5});
    t.property("u64", scalar("UINT64"), std::vector<std::uint64_t>{UINT64_MAX, 5});
    t.property("f32", scalar("FLOAT32"), std::vector<float>{0.1f, -2});
    t.property("f64", scalar("FLOAT64"), std::vector<double>{0.1, -2});
    EXPECT_EQ(t.rows("i8"), (Rows{"-128", "127"}));
    EXPECT_TRUE(t.warnings.empty()) << t.warnings[0];
    EXPECT_EQ(t.rows("u8"), (Rows{"0", "255"}));
    EXPECT_EQ(t.rows("i16"), (Rows{"-32768", "5"}));
    EXPECT_EQ(t.rows("u16"), (Rows{"65535", "5"}));
    EXPECT_EQ(t.rows("i32"), (Rows{"-2147483648", "5"}));
    EXPECT_EQ(t.rows("u32"), (Rows{"4294967295", "5"}));
    EXPECT_EQ(t.rows("i64"), (Rows{"-9223372036854775808", "5"}));
    EXPECT_EQ(t.rows("u64"), (Rows{"18446744073709551615", "5"}));
    EXPECT_EQ(t.rows("f32"), (Rows{"0.1", "-2.0"}));
    EXPECT_EQ(t.rows("f64"), (Rows{"0.1", "-2.0"}));
}

TEST(PropertyTable, ReadsVectorsAndMatrices) {
    TableBuilder t(2);
    t.property("v", {{"type", "VEC3"}, {"componentType", "UINT8"}},
               std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6});
    t.property("m", {{"type", "MAT2"}, {"componentType", "FLOAT32"}},
               std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8.5f});
    EXPECT_EQ(t.rows("v"), (Rows{"[1,2,3]", "[4,5,6]"}));
    EXPECT_EQ(t.rows("m"), (Rows{"[1.0,2.0,3.0,4.0]", "[5.0,6.0,7.0,8.5]"}));
}

TEST(PropertyTable, ReadsStringsBooleansAndEnums) {
    TableBuilder t(3);
    const std::string text = "NorthStra\u00dfe";
    t.add("s", {{"type", "STRING"}},
          {{"values", t.view(std::vector<char>(text.begin(), text.end()))},
           {"stringOffsets", t.view(std::vector<std::uint8_t>{0, 5, 5, 12})},
           {"stringOffsetType", "UINT8"}});
    t.property("b", {{"type", "BOOLEAN"}}, std::vector<std::uint8_t>{0b101});
    t.enums()["use"] = {
        {"valueType", "INT16"},
        {"values", {{{"name", "house"}, {"value", -1}}, {{"name", "shop"}, {"value", 7}}}}};
    t.property("e", {{"type", "ENUM"}, {"enumType", "use"}}, std::vector<std::int16_t>{7, -1, 8});
    EXPECT_EQ(t.rows("s"), (Rows{"\"North\"", "\"\"", "\"Stra\u00dfe\""}));
    EXPECT_EQ(t.rows("b"), (Rows{"true", "false", "true"}));
    EXPECT_EQ(t.rows("e"), (Rows{"\"shop\"", "\"house\"", "8"})) << "8 is no name's";
}

TEST(PropertyTable, ReadsArraysOfFixedAndVariableLength) {
    TableBuilder t(2);
    t.property("pair",
               {{"type", "SCALAR"}, {"componentType", "INT16"}, {"array", true}, {"count", 2}},
               std::vector<std::int16_t>{1, 2, 3, 4});
    t.add("some", {{"type", "VEC2"}, {"componentType", "UINT8"}, {"array", true}},
          {{"values", t.view(std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6})},
           {"arrayOffsets", t.view(std::vector<std::uint16_t>{0, 1, 3})},
           {"arrayOffsetType", "UINT16"}});
    const std::string text = "abcde";
    t.add("names", {{"type", "STRING"}, {"array", true}},
          {{"values", t.view(std::vector<char>(text.begin(), text.end()))},
           {"arrayOffsets", t.view(std::vector<std::uint64_t>{0, 0, 2})},
           {"arrayOffsetType", "UINT64"},
           {"stringOffsets", t.view(std::vector<std::uint32_t>{0, 2, 5})}});
    t.property("bits", {{"type", "BOOLEAN"}, {"array", true}, {"count", 5}},
               std::vector<std::uint8_t>{0b11100001, 0b11});
    EXPECT_EQ(t.rows("pair"), (Rows{"[1,2]", "[3,4]"}));
    EXPECT_EQ(t.rows("some"), (Rows{"[[1,2]]", "[[3,4],[5,6]]"}));
    EXPECT_EQ(t.rows("names"), (Rows{"[]", R"(["ab","cde"])"}));
    EXPECT_EQ(t.rows("bits"),
              (Rows{"[true,false,false,false,false]", "[true,true,true,true,true]"}));
}

TEST(PropertyTable, NormalisesScalesAndOffsetsTheTableBeforeTheClass) {
    TableBuilder t(2);
    t.property("n", {{"type", "SCALAR"}, {"componentType", "UINT8"}, {"normalized", true}},
               std::vector<std::uint8_t>{0, 255});
    t.property("s",
               {{"type", "SCALAR"}, {"componentType", "INT8"}, {"normalized", true}, {"scale", 10}},
               std::vector<std::int8_t>{-128, 127});
    t.property(
        "v",
        {{"type", "VEC2"}, {"componentType", "FLOAT32"}, {"offset", {100, 200}}, {"scale", {2, 4}}},
        std::vector<float>{1, 1, 2, 2}, {{"offset", {0, -1}}});
    t.property("a",
               {{"type", "SCALAR"},
                {"componentType", "FLOAT64"},
                {"array", true},
                {"count", 2},
                {"offset", {1, 2}}},
               std::vector<double>{10, 10, 20, 20});
    EXPECT_EQ(t.rows("n"), (Rows{"0.0", "1.0"}));
    EXPECT_EQ(t.rows("s"), (Rows{"-10.0", "10.0"})) << "-128 is -1 too";
    EXPECT_EQ(t.rows("v"), (Rows{"[2.0,3.0]", "[4.0,7.0]"}));
    EXPECT_EQ(t.rows("a"), (Rows{"[11.0,12.0]", "[21.0,22.0]"}));
}

TEST(PropertyTable, NoDataIsRawAndGivesTheDefaultOrNothing) {
    TableBuilder t(2);
    t.property(
        "none",
        {{"type", "SCALAR"}, {"componentType", "FLOAT32"}, {"noData", -9999.9}, {"scale", 2}},
        std::vector<float>{-9999.9f, 3});
    t.property(
        "some",
        {{"type", "VEC2"}, {"componentType", "INT16"}, {"noData", {-1, -1}}, {"default", {5, 6}}},
        std::vector<std::int16_t>{-1, -1, -1, 0});
    t.enums()["use"] = {
        {"values", {{{"name", "unknown"}, {"value", 0}}, {{"name", "shop"}, {"value", 1}}}}};
    t.property("e", {{"type", "ENUM"}, {"enumType", "use"}, {"noData", "unknown"}},
               std::vector<std::uint16_t>{0, 1});
    EXPECT_EQ(t.rows("none"), (Rows{"null", "6.0"}));
    EXPECT_EQ(t.rows("some"), (Rows{"[5,6]", "[-1,0]"}));
    EXPECT_EQ(t.rows("e"), (Rows{"null", "\"shop\""}));
}

TEST(PropertyTable, NoDataOfFloatsMayBeWrittenWithAnyNumberOfDigits) {
    const float least = std::numeric_limits<float>::lowest();
    const auto rowsWith = [&](const Json& noData) {
        TableBuilder t(2);
        t.property("h", {{"type", "SCALAR"}, {"componentType", "FLOAT32"}, {"noData", noData}},
                   std::vector<float>{least, 0.1f});
        return t.rows("h");
    };
    EXPECT_EQ(rowsWith(double(least)), (Rows{"null", "0.1"}));
    EXPECT_EQ(rowsWith(-3.4028235e38), (Rows{"null", "0.1"})) << "beyond floats, by a hair";
    EXPECT_EQ(rowsWith(double(0.1f))[1], "null");
    EXPECT_EQ(rowsWith(0.1)[1], "null");
    EXPECT_EQ(rowsWith(-1e300)[1], "0.1");

    TableBuilder t(2);
    t.property("v",
               {{"type", "VEC2"},
                {"componentType", "FLOAT32"},
                {"array", true},
                {"count", 1},
                {"noData", {{double(least), double(0.1f)}}}},
               std::vector<float>{least, 0.1f, 1, 2});
    t.property("d", {{"type", "SCALAR"}, {"componentType", "FLOAT64"}, {"noData", double(0.1f)}},
               std::vector<double>{0.1, double(0.1f)});
    EXPECT_EQ(t.rows("v"), (Rows{"null", "[[1.0,2.0]]"}));
    EXPECT_EQ(t.rows("d"), (Rows{"0.1", "null"})) << "doubles are as they are";
}

TEST(PropertyTable, APropertyTheTableLeavesOutHasItsDefault) {
    TableBuilder t(2);
    t.property("a", {{"type", "SCALAR"}, {"componentType", "UINT8"}},
               std::vector<std::uint8_t>{1, 2});
    Json extension = t.extension();
    auto& properties = extension["schema"]["classes"]["thing"]["properties"];
    properties["d"] = {{"type", "STRING"}, {"default", "none"}};
    properties["z"] = {{"type", "STRING"}};
    t.glb.root["extensions"]["EXT_structural_metadata"] = extension;
    const auto content = decoded(t.glb);
    ASSERT_TRUE(content) << content.error().message();
    const auto row = content->features->row(1);
    ASSERT_EQ(row.size(), 2u);
    EXPECT_EQ(row[1].name, "d");
    EXPECT_EQ(row[1].value, PropertyValue("none"));
}

TEST(PropertyTable, ReadsItsSchemaFromAFileToo) {
    TableBuilder t(1);
    t.property("zeta", {{"type", "SCALAR"}, {"componentType", "UINT8"}},
               std::vector<std::uint8_t>{9});
    t.property("alpha", {{"type", "SCALAR"}, {"componentType", "UINT8"}},
               std::vector<std::uint8_t>{8});
    Json extension = t.extension();
    // The file's order, which is not that of the letters.
    const std::string schema = R"({"classes":{"thing":{"properties":{
        "zeta":{"type":"SCALAR","componentType":"UINT8"},
        "alpha":{"type":"SCALAR","componentType":"UINT8"}}}}})";
    extension.erase("schema");
    extension["schemaUri"] = "schema.json";
    t.glb.root["extensions"]["EXT_structural_metadata"] = extension;
    DecodeOptions options;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        EXPECT_EQ(uri, "schema.json");
        return bytesOf(schema);
    };
    auto content = decoded(t.glb, options);
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_TRUE(content->features);
    EXPECT_EQ(content->features->classes()[0].properties, (Rows{"zeta", "alpha"}));
    EXPECT_EQ(content->features->row(0)[0].value, PropertyValue(std::int64_t(9)));

    options.readUri = [](const std::string&) -> Result<Bytes> { return Error{"x", "not there"}; };
    content = decoded(t.glb, options);
    ASSERT_TRUE(content) << "the mesh is worth showing without";
    EXPECT_FALSE(content->features);
    EXPECT_TRUE(warnsOf(*content, "schema.json: not there"));
}

TEST(PropertyTable, AColumnThatIsWrongIsNamedAndTheOthersStay) {
    const Json u8 = {{"type", "SCALAR"}, {"componentType", "UINT8"}};
    const auto with = [](Json schema, const Json& more) {
        schema.update(more);
        return schema;
    };
    struct Case {
        Json schema, own;
        const char* reason;
    };
    const Json strings = {{"type", "STRING"}}, list = with(u8, {{"array", true}});
    const std::vector<Case> cases = {
        {u8, {{"values", 99}}, "bufferView 99 does not exist"},
        {u8, {{"values", -1}}, "no values"},
        {u8, {{"values", 1e300}}, "no values"},
        {u8, Json::object(), "no values"},
        {with(u8, {{"type", "VEC4"}}), {{"values", "small"}}, "bytes of the"},
        {with(u8, {{"type", "VEC5"}}), {{"values", "small"}}, "type VEC5"},
        {with(u8, {{"type", 7}}), {{"values", "small"}}, "type"},
        {with(u8, {{"componentType", "FLOAT16"}}), {{"values", "small"}}, "componentType FLOAT16"},
        {with(list, {{"count", 0}}), {{"values", "small"}}, "count of 0"},
        {with(list, {{"count", 9223372036854775807}}), {{"values", "small"}}, "bytes of the"},
        {with(list, {{"count", UINT64_MAX}}), {{"values", "small"}}, "counted"},
        {list, {{"values", "small"}}, "arrayOffsets"},
        {list, {{"values", "small"}, {"arrayOffsets", "small"}}, "arrayOffsets"},
        {list,
         {{"values", "small"}, {"arrayOffsets", "small"}, {"arrayOffsetType", "INT8"}},
         "INT8"},
        {list,
         {{"values", "small"}, {"arrayOffsets", "falling"}, {"arrayOffsetType", "UINT8"}},
         "backwards"},
        {list,
         {{"values", "small"}, {"arrayOffsets", "far"}, {"arrayOffsetType", "UINT8"}},
         "bytes of the"},
        {strings, {{"values", "small"}}, "stringOffsets"},
        {strings,
         {{"values", "small"}, {"stringOffsets", "far"}, {"stringOffsetType", "UINT8"}},
         "bytes of the"},
        {{{"type", "ENUM"}, {"enumType", "nowhere"}}, {{"values", "small"}}, "nowhere"},
        {{{"type", "ENUM"}}, {{"values", "small"}}, "enumType"},
        {with(u8, {{"scale", {1, 2}}}), {{"values", "small"}}, "scale"},
        {with(u8, {{"offset", "x"}}), {{"values", "small"}}, "offset"},
        {with(u8, {{"default", std::string(100000, 'x')}}), {{"values", "small"}}, "too large"},
    };
    for (const Case& one : cases) {
        TableBuilder t(2);
        const std::map<std::string, int> views = {
            {"small", t.view(std::vector<std::uint8_t>{1, 2, 3})},
            {"falling", t.view(std::vector<std::uint8_t>{0, 2, 1})},
            {"far", t.view(std::vector<std::uint8_t>{0, 2, 200})}};
        Json own = one.own;
        for (auto& [key, value] : own.items()) {
            if (value.is_string() && views.contains(value.get<std::string>())) {
                value = views.at(value.get<std::string>());
            }
        }
        t.add("bad", one.schema, own);
        t.property("good", u8, std::vector<std::uint8_t>{4, 5});
        EXPECT_EQ(t.rows("good"), (Rows{"4", "5"})) << one.reason;
        EXPECT_EQ(t.rows("bad"), Rows{}) << one.reason;
        ASSERT_EQ(t.warnings.size(), 1u) << one.reason;
        EXPECT_NE(t.warnings[0].find("bad left out"), std::string::npos) << t.warnings[0];
        EXPECT_NE(t.warnings[0].find(one.reason), std::string::npos) << t.warnings[0];
    }
}

TEST(PropertyTable, TablesWithoutTheirClassOrSchemaAreNamed) {
    const auto warningsOf = [](const std::function<void(Json&)>& damage) {
        TableBuilder t(1);
        t.property("a", {{"type", "SCALAR"}, {"componentType", "UINT8"}},
                   std::vector<std::uint8_t>{9});
        Json extension = t.extension();
        damage(extension);
        t.glb.root["extensions"]["EXT_structural_metadata"] = extension;
        const auto content = decoded(t.glb);
        EXPECT_TRUE(content);
        EXPECT_FALSE(content && content->features);
        return content && !content->facts.warnings.empty() ? content->facts.warnings[0] : "";
    };
    EXPECT_NE(warningsOf([](Json& e) { e.erase("schema"); }).find("no schema"), std::string::npos);
    EXPECT_NE(warningsOf([](Json& e) { e["schema"] = 7; }).find("no schema"), std::string::npos);
    EXPECT_NE(warningsOf([](Json& e) { e["propertyTables"][0]["class"] = "b"; }).find("class b"),
              std::string::npos);
    EXPECT_NE(warningsOf([](Json& e) { e["propertyTables"][0].erase("count"); }).find("no count"),
              std::string::npos);
    EXPECT_NE(warningsOf([](Json& e) { e["propertyTables"][0] = 3; }).find("no count"),
              std::string::npos);
    EXPECT_EQ(warningsOf([](Json& e) { e["propertyTables"] = "none"; }), "");
}

TEST(PropertyTable, ManyTablesOfManyPropertiesCannotTakeAllMemoryOrTime) {
    TableBuilder t(1);
    Json extension = t.extension();
    for (int i = 0; i < 20000; ++i) {
        extension["schema"]["classes"]["thing"]["properties"]["p" + std::to_string(i)] = {
            {"type", "STRING"}, {"default", "some text, so that there is something to copy"}};
    }
    for (int i = 0; i < 20000; ++i) {
        extension["propertyTables"].push_back({{"class", "thing"}, {"count", 1}});
    }
    t.glb.root["extensions"]["EXT_structural_metadata"] = extension;
    const auto content = decoded(t.glb);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_TRUE(warnsOf(*content, "memory"));
}

TEST(GltfFeatures, ComeByAttributeRangeOrOldNames) {
    struct Case {
        std::string name;
        std::function<void(GlbBuilder&, Json&)> setUp;
        Features expected;
    };
    const auto attribute = [](const char* name, auto ids, int type) {
        return [=](GlbBuilder& b, Json& primitive) {
            primitive["attributes"][name] = b.accessor(thrice(ids), type, "SCALAR");
        };
    };
    const auto sets = [](Json& primitive, const Json& list) {
        primitive["extensions"]["EXT_mesh_features"]["featureIds"] = list;
    };
    const std::vector<std::uint16_t> ids{7, 3, 7};
    const std::vector<float> floats{7.0f, 2.9999f, -1.0f};
    const std::vector<Case> cases = {
        {"_BATCHID", attribute("_BATCHID", ids, 5123), {{7, 2}, {3, 1}}},
        {"float _BATCHID", attribute("_BATCHID", floats, 5126), {{7, 1}, {3, 1}, {kNoFeature, 1}}},
        {"_FEATURE_ID_0", attribute("_FEATURE_ID_0", ids, 5123), {{7, 2}, {3, 1}}},
        {"EXT_mesh_features",
         [&](GlbBuilder& b, Json& primitive) {
             attribute("_BATCHID", std::vector<std::uint16_t>{1, 1, 1}, 5123)(b, primitive);
             attribute("_FEATURE_ID_1", ids, 5123)(b, primitive);
             sets(primitive, {{{"featureCount", 2}, {"attribute", 1}, {"nullFeatureId", 3}}});
         },
         {{7, 2}, {kNoFeature, 1}}},
        {"texture first, attribute second",
         [&](GlbBuilder& b, Json& primitive) {
             attribute("_FEATURE_ID_0", ids, 5123)(b, primitive);
             sets(primitive, {{{"featureCount", 2}, {"texture", {{"index", 0}}}},
                              {{"featureCount", 2}, {"attribute", 0}}});
         },
         {{7, 2}, {3, 1}}},
        {"an attribute that is not there",
         [&](GlbBuilder& b, Json& primitive) {
             attribute("_BATCHID", ids, 5123)(b, primitive);
             sets(primitive, {{{"featureCount", 2}, {"attribute", 4}}, 7, "x"});
         },
         {{kNoFeature, 3}}},
        {"nothing", [](GlbBuilder&, Json&) {}, {{kNoFeature, 3}}},
    };
    for (const Case& one : cases) {
        GlbBuilder builder;
        one.setUp(builder, trianglesOf(builder, 3));
        const auto content = decoded(builder);
        ASSERT_TRUE(content) << one.name << content.error().message();
        EXPECT_EQ(featuresOf(*content), one.expected) << one.name;
    }
}

TEST(GltfFeatures, AnImplicitRangeCountsTheFilesVertices) {
    GlbBuilder builder;
    Json& primitive = trianglesOf(builder, 2);
    primitive["extensions"]["EXT_mesh_features"]["featureIds"] = {{{"featureCount", 6}}};
    const auto content = decoded(builder);
    ASSERT_TRUE(content);
    std::set<std::uint32_t> all;
    for (const Mesh& mesh : content->meshes) {
        all.insert(mesh.features.begin(), mesh.features.end());
    }
    EXPECT_EQ(all, (std::set<std::uint32_t>{0, 1, 2, 3, 4, 5}));
}

TEST(GltfFeatures, OldMetadataIsNotedAndItsIdsAreRead) {
    GlbBuilder builder;
    Json& primitive = trianglesOf(builder, 3);
    primitive["extensions"]["EXT_feature_metadata"]["featureIdAttributes"] = {
        {{"featureTable", "t"}, {"featureIds", {{"constant", 4}, {"divisor", 3}}}}};
    builder.root["extensions"]["EXT_feature_metadata"] = {{"schema", Json::object()}};
    builder.root["extensionsUsed"] = {"EXT_feature_metadata"};
    auto content = decoded(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(featuresOf(*content), (Features{{4, 1}, {5, 1}, {6, 1}}));
    EXPECT_TRUE(warnsOf(*content, "EXT_feature_metadata"));
    auto& ids = builder.root["meshes"][0]["primitives"][0]["extensions"]["EXT_feature_metadata"]
                            ["featureIdAttributes"][0]["featureIds"];
    ids = {{"constant", 1e300}, {"divisor", -4}};
    content = decoded(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(featuresOf(*content), (Features{{kNoFeature, 3}}));
}

TEST(GltfFeatures, ByTextureAreRefusedByName) {
    GlbBuilder builder;
    Json& primitive = trianglesOf(builder, 1);
    primitive["extensions"]["EXT_mesh_features"]["featureIds"] = {
        {{"featureCount", 4}, {"texture", {{"index", 0}, {"channels", {0}}}}}};
    const auto content = decoded(builder);
    ASSERT_TRUE(content);
    EXPECT_TRUE(warnsOf(*content, "EXT_mesh_features by texture"));
    EXPECT_EQ(featuresOf(*content), (Features{{kNoFeature, 1}}));
}

// Two tables behind one another: a primitive's ids count in its own.
TEST(GltfFeatures, EachPrimitiveCountsInItsOwnTable) {
    GlbBuilder builder;
    float y = 0.0f;
    const auto primitive = [&](const Json& set) {
        Json& made = trianglesOf(builder, 2, y += 10.0f); // elsewhere: no duplicates
        made["attributes"]["_FEATURE_ID_0"] =
            builder.accessor(thrice(std::vector<std::uint8_t>{0, 1}), 5121, "SCALAR");
        made["extensions"]["EXT_mesh_features"]["featureIds"] = {set};
    };
    primitive({{"featureCount", 2}, {"attribute", 0}, {"propertyTable", 0}});
    primitive({{"featureCount", 2}, {"attribute", 0}, {"propertyTable", 1}});
    primitive({{"featureCount", 2}, {"attribute", 0}});
    primitive({{"featureCount", 2}, {"attribute", 0}, {"propertyTable", 9}});
    const std::vector<std::uint8_t> values{10, 11, 20};
    const int first = builder.view(values.data(), 2), second = builder.view(&values[2], 1);
    const auto table = [](int rows, int view) {
        return Json{{"class", "c"}, {"count", rows}, {"properties", {{"n", {{"values", view}}}}}};
    };
    builder.root["extensions"]["EXT_structural_metadata"] = {
        {"schema",
         {{"classes",
           {{"c", {{"properties", {{"n", {{"type", "SCALAR"}, {"componentType", "UINT8"}}}}}}}}}}},
        {"propertyTables", {table(2, first), table(1, second)}}};
    const auto content = decoded(builder);
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_TRUE(content->features);
    EXPECT_EQ(content->features->rows(), 3u);
    EXPECT_EQ(content->features->row(2)[0].value, PropertyValue(std::int64_t(20)));
    // The second table has one row only; the third and fourth primitive's ids have none.
    const Features found = featuresOf(*content);
    EXPECT_EQ(found.at(0), 1u);
    EXPECT_EQ(found.at(1), 1u);
    EXPECT_EQ(found.at(2), 1u);
    EXPECT_EQ(found.at(kNoFeature), 5u);
    EXPECT_TRUE(warnsOf(*content, "property table 9 of 2"));
    EXPECT_GT(content->bytes(), content->features->bytes());
}

TEST(GltfFeatures, InstancesAreFeaturesOfTheirOwn) {
    GlbBuilder builder;
    trianglesOf(builder, 1);
    Json& node = builder.root["nodes"][0];
    const int places = builder.floats({0, 0, 0, 50, 0, 0, 100, 0, 0}, "VEC3");
    node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", places},
        {"_FEATURE_ID_0", builder.accessor(std::vector<std::uint16_t>{2, 0, 2}, 5123, "SCALAR")},
        {"_FEATURE_ID_1", builder.accessor(std::vector<std::uint16_t>{2}, 5123, "SCALAR")}};
    const auto features = [&](const Json& sets) {
        node["extensions"]["EXT_instance_features"]["featureIds"] = sets;
        const auto content = decoded(builder);
        EXPECT_TRUE(content);
        return content ? featuresOf(*content) : Features{};
    };
    EXPECT_EQ(features({{{"featureCount", 2}, {"attribute", 0}}}), (Features{{0, 1}, {2, 2}}));
    EXPECT_EQ(features({{{"featureCount", 2}, {"attribute", 0}, {"nullFeatureId", 2}}}),
              (Features{{0, 1}, {kNoFeature, 2}}));
    EXPECT_EQ(features({{{"featureCount", 3}}}), (Features{{0, 1}, {1, 1}, {2, 1}}));
    EXPECT_EQ(features({{{"featureCount", 2}, {"attribute", 1}}}), (Features{{kNoFeature, 3}}))
        << "too few ids";
    EXPECT_EQ(features({{{"featureCount", 2}, {"attribute", 7}}}), (Features{{kNoFeature, 3}}));
}

} // namespace gnomon
