#include "streaming/batch_table.h"
#include "streaming/json_slices.h"
#include "streaming/mesh.h"
#include "streaming/soup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace gnomon {

namespace {

std::span<const std::byte> bytesOf(const std::string& text) {
    return std::as_bytes(std::span(text));
}

struct Read {
    std::shared_ptr<const FeatureTable> table;
    std::vector<std::string> warnings;

    PropertyValue value(std::uint32_t row, const std::string& name) const {
        for (const Property& property : table->row(row)) {
            if (property.name == name) {
                return property.value;
            }
        }
        ADD_FAILURE() << name << " is no property of row " << row;
        return {};
    }
    bool warnsOf(const std::string& what) const {
        for (const std::string& warning : warnings) {
            if (warning.find(what) != std::string::npos) {
                return true;
            }
        }
        return false;
    }
};

Read read(const std::string& json, std::uint32_t rows, const std::string& binary = {}) {
    Read out;
    out.table = readBatchTable(bytesOf(json), bytesOf(binary), rows, out.warnings);
    return out;
}

template <class T>
std::string raw(std::initializer_list<T> values) {
    std::string out(values.size() * sizeof(T), '\0');
    std::memcpy(out.data(), values.begin(), out.size());
    return out;
}

std::string jsonAt(const Read& read, std::uint32_t row, const std::string& name) {
    return jsonOf(read.value(row, name));
}

} // namespace

TEST(BatchTable, KeepsJsonValuesAsTheyAreAndInTheFilesOrder) {
    const Read r = read(R"({ "zeta" : [ 1 , -2.5 , 18446744073709551615 ],
        "name":["a","B\u00fc\"x,]","c"], "ok":[true,false,null],
        "list":[[1, 2],{"a":[1]}, []] })",
                        3);
    ASSERT_TRUE(r.table);
    EXPECT_TRUE(r.warnings.empty());
    const auto row = r.table->row(1);
    ASSERT_EQ(row.size(), 4u);
    EXPECT_EQ(row[0].name, "zeta");
    EXPECT_EQ(row[3].name, "list");
    EXPECT_EQ(r.value(0, "zeta"), PropertyValue(std::int64_t(1)));
    EXPECT_EQ(r.value(1, "zeta"), PropertyValue(-2.5));
    EXPECT_EQ(r.value(2, "zeta"), PropertyValue(std::uint64_t(18446744073709551615u)));
    EXPECT_EQ(r.value(1, "name"), PropertyValue("B\u00fc\"x,]"));
    EXPECT_EQ(r.value(0, "ok"), PropertyValue(true));
    EXPECT_EQ(r.value(2, "ok"), PropertyValue(std::monostate{}));
    EXPECT_EQ(r.value(0, "list"), PropertyValue(JsonText{"[1,2]"}));
    EXPECT_EQ(r.value(1, "list"), PropertyValue(JsonText{R"({"a":[1]})"}));
    EXPECT_TRUE(r.table->row(3).empty());
    EXPECT_TRUE(r.table->row(kNoFeature).empty());
}

TEST(BatchTable, ReadsEveryBinaryComponentTypeAndVectors) {
    const std::string binary = raw<std::int8_t>({-3, 4, 0, 0}) +      // 0
                               raw<std::uint8_t>({250, 1, 0, 0}) +    // 4
                               raw<std::int16_t>({-300, 2}) +         // 8
                               raw<std::uint16_t>({65000, 3}) +       // 12
                               raw<std::int32_t>({-70000, 4}) +       // 16
                               raw<std::uint32_t>({4000000000u, 5}) + // 24
                               raw<float>({0.1f, -8.0f}) +            // 32
                               raw<double>({1e300, 0.1}) +            // 40
                               raw<float>({1, 2, 3, 4, 5, 6.5f});     // 56
    const auto column = [](const char* name, int offset, const char* component,
                           const char* type = "SCALAR") {
        return std::string("\"") + name + "\":{\"byteOffset\":" + std::to_string(offset) +
               ",\"componentType\":\"" + component + "\",\"type\":\"" + type + "\"}";
    };
    const Read r = read("{" + column("a", 0, "BYTE") + "," + column("b", 4, "UNSIGNED_BYTE") + "," +
                            column("c", 8, "SHORT") + "," + column("d", 12, "UNSIGNED_SHORT") +
                            "," + column("e", 16, "INT") + "," + column("f", 24, "UNSIGNED_INT") +
                            "," + column("g", 32, "FLOAT") + "," + column("h", 40, "DOUBLE") + "," +
                            column("v", 56, "FLOAT", "VEC3") + "}",
                        2, binary);
    EXPECT_TRUE(r.warnings.empty()) << r.warnings[0];
    EXPECT_EQ(r.value(0, "a"), PropertyValue(std::int64_t(-3)));
    EXPECT_EQ(r.value(0, "b"), PropertyValue(std::int64_t(250)));
    EXPECT_EQ(r.value(0, "c"), PropertyValue(std::int64_t(-300)));
    EXPECT_EQ(r.value(0, "d"), PropertyValue(std::int64_t(65000)));
    EXPECT_EQ(r.value(0, "e"), PropertyValue(std::int64_t(-70000)));
    EXPECT_EQ(r.value(0, "f"), PropertyValue(std::int64_t(4000000000)));
    EXPECT_EQ(r.value(0, "g"), PropertyValue(0.1)) << "as it was written, not as float rounds it";
    EXPECT_EQ(r.value(0, "h"), PropertyValue(1e300));
    EXPECT_EQ(r.value(1, "h"), PropertyValue(0.1));
    EXPECT_EQ(jsonAt(r, 1, "v"), "[4.0,5.0,6.5]");
}

TEST(BatchTable, AColumnThatIsWrongIsNamedAndTheOthersStay) {
    const std::string tail = R"("type":"SCALAR"}, "good":[1,2]})";
    const char* const wrong[][2] = {
        {R"({"x":{"byteOffset":4,"componentType":"FLOAT",)", "outside"},
        {R"({"x":{"byteOffset":18446744073709551612,"componentType":"FLOAT",)", "outside"},
        {R"({"x":{"byteOffset":-4,"componentType":"FLOAT",)", "byteOffset"},
        {R"({"x":{"componentType":"FLOAT",)", "byteOffset"},
        {R"({"x":{"byteOffset":0,"componentType":"HALF",)", "componentType"},
        {R"({"x":{"byteOffset":0,)", "componentType"},
        {R"({"x":{"byteOffset":0,"componentType":"BYTE","type":"MAT2"}, "y":{)", "type"},
        {R"({"x":7, "y":{)", "neither"},
    };
    for (const auto& [head, reason] : wrong) {
        const Read r = read(head + tail, 2, std::string(8, '\1'));
        ASSERT_TRUE(r.table) << head;
        EXPECT_TRUE(r.warnsOf("column x left out")) << head;
        EXPECT_TRUE(r.warnsOf(reason)) << head;
        EXPECT_EQ(r.value(1, "good"), PropertyValue(std::int64_t(2))) << head;
        EXPECT_EQ(r.table->row(0).size(), 1u) << head;
    }
}

TEST(BatchTable, ArraysOfAnotherLengthThanThereAreFeaturesAreSaid) {
    const Read r = read(R"({"short":[1],"long":[1,2,3]})", 2);
    EXPECT_TRUE(r.warnsOf("short has 1 values for 2"));
    EXPECT_TRUE(r.warnsOf("long has 3 values for 2"));
    EXPECT_EQ(r.value(1, "short"), PropertyValue(std::monostate{}));
    EXPECT_EQ(r.value(1, "long"), PropertyValue(std::int64_t(2)));
}

TEST(BatchTable, RowsThatAreOnlyTheUsedOnesMayBeFewerThanTheColumnsValues) {
    const std::string json = R"({"short":[1],"long":[1,2,3]})";
    Read r;
    ByteBudget budget(10'000);
    r.table = readBatchTable(bytesOf(json), {}, 2, r.warnings, budget, BatchRows::UsedAtLeast);
    EXPECT_FALSE(r.warnsOf("long"));
    EXPECT_TRUE(r.warnsOf("short has 1 values for 2"));
    EXPECT_EQ(r.value(1, "long"), PropertyValue(std::int64_t(2)));
}

TEST(BatchTable, ValuesNoRowHasAreCountedAndTakeNoMemory) {
    std::string json = "{\"a\":[7";
    for (int i = 1; i < 100'000; ++i) {
        json += ",0";
    }
    json += "]}";
    Read r;
    ByteBudget budget(json.size() + 1000);
    r.table = readBatchTable(bytesOf(json), {}, 1, r.warnings, budget);
    EXPECT_TRUE(r.warnsOf("a has 100000 values for 1"));
    EXPECT_EQ(r.value(0, "a"), PropertyValue(std::int64_t(7)));
    EXPECT_LT(r.table->bytes(), json.size() + 1000);
}

TEST(BatchTable, WhatTheBudgetDoesNotAllowIsLeftOutAndNamed) {
    std::string json = R"({"small":[1,2],"large":[0)";
    for (int i = 1; i < 100'000; ++i) {
        json += ",0";
    }
    json += "]}";
    const std::string binary(1000, '\1');
    const auto readWith = [&](std::uint64_t bytes, std::uint32_t rows) {
        Read r;
        ByteBudget budget(bytes);
        r.table = readBatchTable(bytesOf(json), bytesOf(binary), rows, r.warnings, budget);
        return r;
    };
    const Read none = readWith(json.size() - 1, 2);
    EXPECT_TRUE(none.warnsOf("batch table left out: batch table would need more memory"));
    EXPECT_EQ(none.table->rows(), 2u);
    EXPECT_TRUE(readWith(json.size() + 999, 2).warnsOf("table left out")) << "its binary part";
    const Read one = readWith(json.size() + 10'000, 100'000);
    EXPECT_TRUE(one.warnsOf("column large left out: it would need more memory"));
    EXPECT_EQ(one.value(1, "small"), PropertyValue(std::int64_t(2)));
    const Read many = [&] {
        Read r;
        std::string columns = "{\"x\":[]";
        for (int i = 0; i < 10'000; ++i) {
            columns += ",\"\":[]";
        }
        columns += "}";
        ByteBudget budget(columns.size() + 100'000);
        r.table = readBatchTable(bytesOf(columns), {}, 1, r.warnings, budget);
        return r;
    }();
    EXPECT_LT(many.table->bytes(), 60'000u + 100'000u);
    EXPECT_TRUE(many.warnsOf("more flaws"));
}

TEST(BatchTable, AnObjectTooLongForAReferenceIsNotParsed) {
    std::string json = R"({"x":{"byteOffset":0,"componentType":"BYTE","type":"SCALAR","y":[0)";
    for (int i = 0; i < 100'000; ++i) {
        json += ",0";
    }
    const Read r = read(json + R"(]},"good":[1,2]})", 2, std::string(8, '\1'));
    EXPECT_TRUE(r.warnsOf("column x left out: it is too long"));
    EXPECT_EQ(r.table->row(1).size(), 1u);
    EXPECT_EQ(r.value(1, "good"), PropertyValue(std::int64_t(2)));
}

TEST(BatchTable, HierarchiesAreNotedAndSkipped) {
    const Read r = read(R"({"id":[7],"extras":{"a":1},
        "extensions":{"3DTILES_batch_table_hierarchy":{"classes":[]}},"HIERARCHY":{}})",
                        1);
    EXPECT_TRUE(r.warnsOf("3DTILES_batch_table_hierarchy"));
    EXPECT_TRUE(r.warnsOf("hierarchy is not read"));
    ASSERT_EQ(r.table->row(0).size(), 1u);
    EXPECT_EQ(r.value(0, "id"), PropertyValue(std::int64_t(7)));
}

TEST(BatchTable, OneThatCannotBeReadStillGivesItsRowsWithoutProperties) {
    for (const std::string& json :
         {std::string("{\"a\":[1,2}"), std::string("[1,2]"), std::string("nonsense"),
          "{\"a\":" + std::string(1000, '[') + std::string(1000, ']') + "}"}) {
        const Read r = read(json, 2);
        ASSERT_TRUE(r.table);
        EXPECT_EQ(r.table->rows(), 2u);
        EXPECT_TRUE(r.table->row(1).empty());
        ASSERT_EQ(r.warnings.size(), 1u);
        EXPECT_LT(r.warnings[0].size(), 120u);
    }
    EXPECT_TRUE(read("", 5).warnings.empty());
    EXPECT_EQ(read("", 5).table->rows(), 5u);
    EXPECT_FALSE(read(R"({"a":[]})", 0).table);
}

TEST(BatchTable, ForgivesWhatExportersWrite) {
    const Read r = read("{\"a\":[NaN,2],\"b\":[\"Stra\xdf"
                        "e\",\"Stra\u00dfe\"]}  \0",
                        2);
    EXPECT_EQ(r.value(0, "a"), PropertyValue(std::monostate{}));
    EXPECT_EQ(r.value(0, "b"), PropertyValue("Stra\u00dfe")) << "Latin-1";
    EXPECT_EQ(r.value(1, "b"), PropertyValue("Stra\u00dfe")) << "UTF-8";
}

TEST(BatchTable, WhatOnlyLooksLikeUtf8IsLatin1Too) {
    const auto latin1 = [](std::string_view text) {
        std::string out;
        for (const char c : text) {
            const auto u = static_cast<unsigned char>(c);
            out += u < 0x80 ? std::string(1, c)
                            : std::string{char(0xc0u | u >> 6), char(0x80u | (u & 0x3fu))};
        }
        return out;
    };
    for (const std::string text :
         {"\xc0\x80", "\xc1\xbf", "\xe0\x80\x80", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xed\xbf\xbf",
          "\xf0\x80\x80\x80", "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80"}) {
        const Read r = read("{\"a\":[\"" + text + "\"]}", 1);
        EXPECT_TRUE(r.warnings.empty());
        EXPECT_EQ(r.value(0, "a"), PropertyValue(latin1(text))) << latin1(text);
    }
    for (const std::string text :
         {"\xc2\x80", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80", "\xf0\x90\x80\x80",
          "\xf4\x8f\xbf\xbf"}) { // and one that is not, so that all are looked at
        const Read r = read("{\"a\":[\"" + text + "\",\"\xe0\"]}", 2);
        EXPECT_EQ(r.value(0, "a"), PropertyValue(text)) << text;
    }
}

TEST(BatchTable, HoldsItsTextAndBinaryOnceHoweverManyColumnsNameThem) {
    const std::string binary(1 << 20, '\1');
    std::string json = "{\"t\":[\"" + std::string(1 << 16, 'x') + "\"]";
    for (int i = 0; i < 1000; ++i) {
        json += ",\"c" + std::to_string(i) +
                R"(":{"byteOffset":0,"componentType":"DOUBLE","type":"SCALAR"})";
    }
    const Read r = read(json + "}", 1u << 17, binary);
    EXPECT_EQ(r.table->classes()[0].properties.size(), 1001u);
    EXPECT_GE(r.table->bytes(), binary.size() + json.size());
    EXPECT_LT(r.table->bytes(), binary.size() + json.size() + 400'000);
}

TEST(BatchTable, ManyFlawsAreCountedNotAllNamed) {
    std::string json = "{\"a\":1";
    for (int i = 0; i < 500; ++i) {
        json += ",\"c" + std::to_string(i) + "\":1";
    }
    EXPECT_LT(read(json + "}", 1).warnings.size(), 12u);
    EXPECT_TRUE(read(json + "}", 1).warnsOf("more flaws"));
}

TEST(FeatureTables, JoinedOnesFollowOneAnother) {
    std::vector<std::string> warnings;
    const std::string a = R"({"id":["a0","a1"]})", b = R"({"id":["b0"]})";
    const auto first = readBatchTable(bytesOf(a), {}, 2, warnings);
    const auto second = readBatchTable(bytesOf(b), {}, 1, warnings);
    const auto all = joinedTables({nullptr, first, nullptr, second});
    ASSERT_TRUE(all);
    EXPECT_EQ(all->rows(), 3u);
    EXPECT_EQ(all->row(0)[0].value, PropertyValue("a0"));
    EXPECT_EQ(all->row(2)[0].value, PropertyValue("b0"));
    EXPECT_TRUE(all->row(3).empty());
    EXPECT_EQ(all->classes().size(), 2u);
    EXPECT_GT(all->bytes(), first->bytes() + second->bytes());
    EXPECT_FALSE(joinedTables({nullptr}));
    EXPECT_EQ(joinedTables({first}), first);
    const auto huge = readBatchTable({}, {}, 0xffffffffu, warnings);
    const auto two = joinedTables({huge, first});
    EXPECT_LT(two->rows(), kNoFeature);
    EXPECT_TRUE(two->row(0xfffffffe).empty());
}

TEST(FeatureTables, AnIdIsWhatPeopleCallIt) {
    const auto id = [](std::vector<Property> row) { return idOf(row, 5); };
    EXPECT_EQ(id({{"height", 3.0}, {"gml:id", "NL.1"}}), "NL.1");
    EXPECT_EQ(id({{"name", "Town hall"}, {"GML_ID", "x"}}), "x");
    EXPECT_EQ(id({{"BIN", std::int64_t(1001234)}}), "1001234");
    EXPECT_EQ(id({{"id", std::monostate{}}, {"name", "Town hall"}}), "Town hall");
    EXPECT_EQ(id({{"height", 2.0}, {"blockid", "036"}}), "036");
    EXPECT_EQ(id({{"blockid", "036"}, {"name", "Town hall"}}), "Town hall");
    EXPECT_EQ(id({{"id", ""}, {"height", 2.0}}), "5");
}

TEST(FeatureTables, ValuesAreWrittenAsJson) {
    EXPECT_EQ(jsonOf(std::monostate{}), "null");
    EXPECT_EQ(jsonOf("a\"b"), R"("a\"b")");
    EXPECT_EQ(jsonOf(std::numeric_limits<double>::quiet_NaN()), "null");
    EXPECT_EQ(jsonOf(std::string("\xff")), "\"\ufffd\"") << "the replacement character";
    EXPECT_EQ(jsonOf(JsonText{"[1]"}), "[1]");
}

TEST(JsonSlices, AreTakenOneAfterAnother) {
    std::string seen;
    eachJsonMember(R"({"a":[1, "x"],"b":{}})", [&](const JsonMember& member) {
        seen += std::string(member.key) + "=" + std::string(member.value) + ";";
        eachJsonElement(member.value, [&](std::string_view v) { seen += std::string(v) + "|"; });
    });
    EXPECT_EQ(seen, "a=[1, \"x\"];1|\"x\"|b={};");
}

TEST(JsonSlices, StayInsideWhatIsCutShort) {
    const std::string whole = R"({"a":[1,{"b":"x\"]"},[2]], "c":"y" , "d":{"e":null}})";
    for (std::size_t n = 0; n <= whole.size(); ++n) {
        const std::string cut = whole.substr(0, n); // its own memory, so that a sanitizer sees
        for (const JsonMember& member : jsonMembers(cut)) {
            for (const std::string_view part : jsonElements(member.value)) {
                jsonMembers(part);
            }
        }
    }
    ASSERT_EQ(jsonMembers(whole).size(), 3u);
    EXPECT_EQ(jsonElements(jsonMember(whole, "a")).size(), 3u);
    EXPECT_EQ(jsonElements(jsonMember(whole, "a"))[1], R"({"b":"x\"]"})");
    EXPECT_EQ(jsonMember(jsonMember(whole, "d"), "e"), "null");
    EXPECT_EQ(jsonMember(whole, "f"), "");
}

} // namespace gnomon
