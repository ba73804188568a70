// Bytes that lie. Each must come back as an error with one line, or be put right; nothing may
// crash, hang or take much memory. Run these under AddressSanitizer as well.
#include "glb_builder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

namespace gnomon {

using namespace test;

namespace {

// Everything a small file can have: a texture, colours, features, two nodes, sparse values.
GlbBuilder rich() {
    GlbBuilder builder;
    Json& primitive =
        builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    const std::string png = pngOf(2, 2, 4, "0123456789abcdef");
    builder.root["images"] = Json::array({{{"bufferView", builder.view(png.data(), png.size())}}});
    builder.root["textures"] = Json::array({{{"source", 0}}});
    builder.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    primitive["material"] = 0;
    primitive["attributes"]["TEXCOORD_0"] = builder.floats(std::vector<float>(16, 0.5f), "VEC2");
    primitive["attributes"]["_BATCHID"] = builder.floats(std::vector<float>(8, 1.0f), "SCALAR");
    const std::vector<std::uint16_t> which = {7};
    const std::vector<float> value = {1, 1, 1};
    const int indexView = builder.view(which.data(), 2), valueView = builder.view(value.data(), 12);
    builder.root["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", indexView}, {"componentType", 5123}}},
        {"values", {{"bufferView", valueView}}}};
    builder.root["nodes"] = Json::array({{{"children", {1}}}, {{"mesh", 0}}});
    builder.root["scenes"] = Json::array({{{"nodes", {0}}}});
    return builder;
}

Json& primitiveOf(GlbBuilder& builder) {
    return builder.root["meshes"][0]["primitives"][0];
}

void expectError(const std::string& text, const std::string& words) {
    const auto content = decode(text);
    ASSERT_FALSE(content) << words;
    EXPECT_EQ(content.error().subject, "tile");
    EXPECT_NE(content.error().reason.find(words), std::string::npos) << content.error().reason;
    EXPECT_EQ(content.error().reason.find('\n'), std::string::npos) << content.error().reason;
    EXPECT_LT(content.error().reason.size(), 400u);
}
void expectError(const GlbBuilder& builder, const std::string& words) {
    expectError(builder.text(), words);
}

} // namespace

TEST(HostileContent, TheFixtureItselfIsFine) {
    const auto content = decode(rich());
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.closedTriangles, 12u);
    EXPECT_EQ(content->images.size(), 1u);
}

TEST(HostileContent, EveryTruncationIsAnError) {
    const std::string glb = rich().text();
    const std::string b3dm =
        b3dmOf(glb, R"({"BATCH_LENGTH":1,"RTC_CENTER":[1,2,3]})", R"({"a":[1]})");
    for (const std::string& whole : {glb, b3dm}) {
        ASSERT_TRUE(decode(whole));
        for (std::size_t length = 0; length < whole.size(); ++length) {
            // From a buffer of exactly that size, so that a sanitizer sees any byte read beyond.
            const Bytes cut = bytesOf(whole.substr(0, length));
            EXPECT_FALSE(decodeContent(cut, "tile", plain())) << length;
        }
    }
}

// The length fields put right, so that the cut is met further in.
TEST(HostileContent, EveryTruncationOfTheBinaryPartIsAnError) {
    const GlbBuilder builder = rich();
    const std::string json = builder.json();
    for (std::size_t length = 0; length < builder.bin.size(); ++length) {
        // Rounded up to four: the padding may stand for the last bytes.
        if ((length + 3) / 4 * 4 < builder.bin.size()) {
            EXPECT_FALSE(decode(GlbBuilder::glbOf(json, builder.bin.substr(0, length)))) << length;
        }
    }
}

TEST(HostileContent, FlippedBytesNeverCrash) {
    const std::string good = b3dmOf(rich().text(), R"({"BATCH_LENGTH":1})");
    std::mt19937 random(5);
    int decoded = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        std::string bad = good;
        for (int k = 0; k < 1 + trial % 4; ++k) {
            bad[random() % bad.size()] = char(random());
        }
        decoded += bool(decode(bad));
    }
    EXPECT_GT(decoded, 100); // most of it is payload
    EXPECT_LT(decoded, 3900);
}

TEST(HostileContent, NumbersInTheJsonMayBeAnything) {
    const GlbBuilder good = rich();
    const Json flat = good.root.flatten();
    std::vector<std::string> paths;
    for (const auto& [path, value] : flat.items()) {
        if (value.is_number()) {
            paths.push_back(path);
        }
    }
    ASSERT_GT(paths.size(), 40u);
    for (const std::string& path : paths) {
        for (const Json& value :
             {Json(-1), Json(0), Json(1), Json(7), Json(65536), Json(0x7fffffff), Json(0xffffffffu),
              Json(0xffffffffffffffffu), Json(std::int64_t(-1) << 62), Json(1e300), Json(-0.5),
              Json("text"), Json(nullptr), Json::array(), Json::object()}) {
            GlbBuilder builder = good;
            builder.root[Json::json_pointer(path)] = value;
            const auto content = decode(builder); // whatever it is, it comes back
            if (!content) {
                EXPECT_FALSE(content.error().reason.empty());
            }
        }
    }
}

TEST(HostileContent, ABinChunkLongerThanTheFileIsRefused) {
    const GlbBuilder builder = rich();
    std::string text = builder.text();
    const std::size_t at = 20 + (builder.json().size() + 3) / 4 * 4; // the BIN chunk's length
    for (const int more : {1, 4, 8, 9, 1 << 20}) {
        std::string bad = text;
        std::uint32_t length;
        std::memcpy(&length, &bad[at], 4);
        length += std::uint32_t(more);
        std::memcpy(&bad[at], &length, 4);
        expectError(bad, "longer than the file");
    }
    GlbBuilder shorter = rich();
    Json whole = Json::parse(shorter.json());
    whole["buffers"][0]["byteLength"] = shorter.bin.size() + 8;
    expectError(GlbBuilder::glbOf(whole.dump(), shorter.bin), "should have");
}

TEST(HostileContent, ABufferOfNoBytesIsNotAnException) {
    GlbBuilder builder = rich();
    Json whole = Json::parse(builder.json());
    whole["buffers"][0]["byteLength"] = 0;
    expectError(GlbBuilder::glbOf(whole.dump(), builder.bin), "outside");
    expectError(GlbBuilder::glbOf(whole.dump(), ""), "outside");
}

TEST(HostileContent, ViewsAndAccessorsOutsideTheirBuffersAreRefused) {
    for (const char* key : {"byteOffset", "byteLength"}) {
        for (const std::uint64_t value : {std::uint64_t(1) << 20, ~std::uint64_t(0),
                                          ~std::uint64_t(0) - 100, std::uint64_t(1) << 32}) {
            GlbBuilder builder = rich();
            builder.root["bufferViews"][0][key] = value; // positions
            expectError(builder, "outside its buffer");
            builder = rich();
            builder.root["bufferViews"][2][key] = value; // the image
            expectError(builder, "outside its buffer");
        }
    }
    for (const std::uint64_t count : {std::uint64_t(9), std::uint64_t(1) << 31,
                                      std::uint64_t(0x1555555555555556), ~std::uint64_t(0)}) {
        GlbBuilder builder = rich();
        builder.root["accessors"][0]["count"] = count;
        expectError(builder, "accessor 0");
    }
    GlbBuilder builder = rich();
    builder.root["accessors"][0]["byteOffset"] = ~std::uint64_t(0) - 3;
    expectError(builder, "accessor 0");
}

TEST(HostileContent, IndicesBeyondTheVerticesAreRefused) {
    GlbBuilder builder = rich();
    std::vector<std::uint32_t> indices = boxTriangles();
    indices[20] = 8;
    primitiveOf(builder)["indices"] = builder.indices(indices);
    expectError(builder, "index 8 of 8 vertices");
    indices[20] = 0xffffffffu;
    primitiveOf(builder)["indices"] = builder.indices(indices);
    expectError(builder, "index 4294967295");
}

TEST(HostileContent, SparseIndicesOutOfRangeOrOrderAreRefused) {
    for (const std::vector<std::uint16_t>& which :
         {std::vector<std::uint16_t>{8, 9}, {3, 3}, {4, 2}, {1, 0xffff}}) {
        GlbBuilder builder = rich();
        const std::vector<float> values(6, 0.0f);
        const int indexView = builder.view(which.data(), 4);
        const int valueView = builder.view(values.data(), 24);
        builder.root["accessors"][0]["sparse"] = {
            {"count", 2},
            {"indices", {{"bufferView", indexView}, {"componentType", 5123}}},
            {"values", {{"bufferView", valueView}}}};
        expectError(builder, "sparse");
    }
}

TEST(HostileContent, NestingDeeperThan64IsRefusedBeforeParsing) {
    const auto nested = [](int depth) {
        GlbBuilder builder = rich();
        std::string json = builder.json();
        json.pop_back(); // its closing brace
        json += R"(,"extras":)" + std::string(std::size_t(depth), '[') +
                std::string(std::size_t(depth), ']') + "}";
        return GlbBuilder::glbOf(json, builder.bin);
    };
    EXPECT_TRUE(decode(nested(63)));
    expectError(nested(64), "nested deeper than 64");
    expectError(nested(200000), "nested deeper than 64");
    expectError(b3dmOf(rich().text(), std::string(4000, '[')), "nested deeper than 64");
    // Brackets within a string do not count.
    GlbBuilder builder = rich();
    builder.root["asset"]["copyright"] = std::string(500, '[') + "\"\\" + std::string(500, '{');
    EXPECT_TRUE(decode(builder));
}

TEST(HostileContent, TypesThatDoNotFitAreNamed) {
    GlbBuilder builder = rich();
    builder.root["accessors"][0]["type"] = "VEC2";
    expectError(builder, "POSITION has 2 components");
    builder = rich();
    builder.root["accessors"][0]["type"] = "MAT4";
    expectError(builder, "accessor 0 has a type");
    builder = rich();
    builder.root["accessors"][1]["componentType"] = 5126;
    expectError(builder, "indices are not unsigned integers");
    builder = rich();
    builder.root["accessors"][0]["componentType"] = 5124;
    expectError(builder, "accessor 0 has a type");
    builder = rich();
    primitiveOf(builder)["mode"] = 9;
    expectError(builder, "mode 9");
    builder = rich();
    builder.root["asset"]["version"] = "1.0";
    expectError(builder, "version 1.0");
}

TEST(HostileContent, ReferencesToNothingAreNamed) {
    const auto with = [](const char* pointer, const Json& value) {
        GlbBuilder builder = rich();
        builder.root[Json::json_pointer(pointer)] = value;
        return builder;
    };
    expectError(with("/nodes/1/mesh", 5), "mesh 5 does not exist");
    expectError(with("/nodes/0/children/0", 9), "node 9 does not exist");
    expectError(with("/scenes/0/nodes/0", -3), "node -3 does not exist");
    expectError(with("/meshes/0/primitives/0/material", 3), "material 3 does not exist");
    expectError(with("/meshes/0/primitives/0/attributes/POSITION", 99), "accessor 99");
    expectError(with("/textures/0/source", 4), "image 4 does not exist");
    expectError(with("/images/0/bufferView", 44), "bufferView 44 does not exist");
    expectError(with("/bufferViews/0/buffer", 1), "a buffer that does not exist");
}

TEST(HostileContent, NonFiniteVerticesAreDroppedAndCounted) {
    GlbBuilder builder;
    std::vector<float> corners = boxCorners(glm::vec3(0.0f), glm::vec3(1.0f));
    corners[0] = NAN;
    corners[4] = INFINITY;
    builder.triangles(corners, boxTriangles());
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_GT(content->facts.invalid, 6u);
    EXPECT_EQ(content->facts.invalid + content->facts.triangles, 12u);
    for (const Mesh& mesh : content->meshes) {
        for (const glm::vec3& p : mesh.positions) {
            EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
        }
        EXPECT_TRUE(std::isfinite(mesh.radiusMetres));
    }
}

// A kilobyte that asks for gigabytes: by instances, by nodes, by an accessor without data.
TEST(HostileContent, SmallFilesThatAskForMuchAreRefusedQuickly) {
    double slowest = 0.0;
    const auto expectRefused = [&](const GlbBuilder& builder, const char* words) {
        const std::string text = builder.text();
        const auto start = std::chrono::steady_clock::now();
        expectError(text, words);
        const auto took = std::chrono::steady_clock::now() - start;
        slowest = std::max(slowest, std::chrono::duration<double>(took).count());
    };
    GlbBuilder instances = rich();
    instances.root["accessors"].push_back(
        {{"componentType", 5126}, {"count", 50000000}, {"type", "VEC3"}});
    instances
        .root["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        instances.root["accessors"].size() - 1;
    expectRefused(instances, "memory");

    GlbBuilder copies = rich();
    copies.root["accessors"].push_back(
        {{"componentType", 5126}, {"count", 800000}, {"type", "VEC3"}});
    copies.root["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        copies.root["accessors"].size() - 1;
    expectRefused(copies, "geometry would need more memory");

    GlbBuilder empty = rich();
    empty.root["accessors"].push_back(
        {{"componentType", 5126}, {"count", 4000000000u}, {"type", "VEC3"}});
    primitiveOf(empty).erase("indices");
    primitiveOf(empty)["attributes"] = {{"POSITION", empty.root["accessors"].size() - 1}};
    expectRefused(empty, "memory");

    GlbBuilder nodes = rich();
    nodes.root["nodes"] = Json::array();
    for (int i = 0; i < 1000000; ++i) {
        nodes.root["nodes"].push_back(Json::object());
    }
    expectRefused(nodes, "nodes would need more memory");
    EXPECT_LT(slowest, 5.0);
}

TEST(HostileContent, NodesThatShareChildrenDoNotMultiply) {
    GlbBuilder builder = rich();
    builder.root["nodes"] = Json::array();
    for (int i = 0; i < 60; ++i) { // 2^60 ways down
        builder.node({{"children", {i + 1, i + 1}}});
    }
    builder.node({{"mesh", 0}});
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 12u);
}

TEST(HostileContent, MalformedJsonAndUrisAreErrors) {
    expectError(std::string("{\"asset\":{\"version\":\"2.0\"}, nonsense"), "malformed JSON");
    expectError(std::string("{}"), "asset");
    GlbBuilder builder = rich();
    builder.root["images"][0] = {{"uri", "data:image/png;base64,****"}};
    expectError(builder, "base64");
    builder.root["images"][0] = {{"uri", "http://elsewhere/a.png"}};
    expectError(builder, "cannot be read from here");
    builder.root["images"][0] = Json::object();
    expectError(builder, "image 0");
}

TEST(HostileContent, ADecodedSizeBeyondTheCallersIsRefused) {
    DecodeOptions options = plain();
    options.maxBytes = 10000;
    EXPECT_FALSE(decode(rich(), options));
    options.maxBytes = 1 << 20;
    EXPECT_TRUE(decode(rich(), options));
}

} // namespace gnomon
