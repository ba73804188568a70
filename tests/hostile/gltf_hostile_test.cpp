// HOSTILE.md, items 1 to 12: glTF that lies. Each must come back as an error with one line, or be
// put right; nothing may crash, hang or take much memory.
#include "streaming/check_content.h"
#include "streaming/loader.h"
#include "tests/hostile/confined.h"
#include "tests/hostile/families.h"
#include "tests/hostile/family_files.h"
#include "tests/streaming/draco_builder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include <sys/inotify.h>
#include <unistd.h>

namespace gnomon::test {

namespace {

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

TEST(HostileGltf, TheFixtureItselfIsFine) {
    const auto content = decode(richGlb());
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.closedTriangles, 12u);
    EXPECT_EQ(content->images.size(), 1u);
}

// The length fields put right, so that the cut is met further in.
TEST(HostileGltf, Item12EveryTruncationOfTheBinaryPartIsAnError) {
    const GlbBuilder builder = richGlb();
    const std::string json = builder.json();
    for (std::size_t length = 0; length < builder.bin.size(); ++length) {
        // Rounded up to four: the padding may stand for the last bytes.
        if ((length + 3) / 4 * 4 < builder.bin.size()) {
            EXPECT_FALSE(decode(GlbBuilder::glbOf(json, builder.bin.substr(0, length)))) << length;
        }
    }
}

TEST(HostileGltf, NumbersInTheJsonMayBeAnything) {
    const GlbBuilder good = richGlb();
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

TEST(HostileGltf, Item01BinChunkLongerThanTheFile) {
    const GlbBuilder builder = richGlb();
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
    GlbBuilder shorter = richGlb();
    Json whole = Json::parse(shorter.json());
    whole["buffers"][0]["byteLength"] = shorter.bin.size() + 8;
    expectError(GlbBuilder::glbOf(whole.dump(), shorter.bin), "should have");
}

TEST(HostileGltf, Item05ABufferOfNoBytesIsNotAnException) {
    GlbBuilder builder = richGlb();
    Json whole = Json::parse(builder.json());
    whole["buffers"][0]["byteLength"] = 0;
    expectError(GlbBuilder::glbOf(whole.dump(), builder.bin), "outside");
    expectError(GlbBuilder::glbOf(whole.dump(), ""), "outside");
}

TEST(HostileGltf, Item02ViewsAndAccessorsOutsideTheirBuffersAreRefused) {
    for (const char* key : {"byteOffset", "byteLength"}) {
        for (const std::uint64_t value : {std::uint64_t(1) << 20, ~std::uint64_t(0),
                                          ~std::uint64_t(0) - 100, std::uint64_t(1) << 32}) {
            GlbBuilder builder = richGlb();
            builder.root["bufferViews"][0][key] = value; // positions
            expectError(builder, "outside its buffer");
            builder = richGlb();
            builder.root["bufferViews"][2][key] = value; // the image
            expectError(builder, "outside its buffer");
        }
    }
    for (const std::uint64_t count : {std::uint64_t(9), std::uint64_t(1) << 31,
                                      std::uint64_t(0x1555555555555556), ~std::uint64_t(0)}) {
        GlbBuilder builder = richGlb();
        builder.root["accessors"][0]["count"] = count;
        expectError(builder, "accessor 0");
    }
    GlbBuilder builder = richGlb();
    builder.root["accessors"][0]["byteOffset"] = ~std::uint64_t(0) - 3;
    expectError(builder, "accessor 0");
}

TEST(HostileGltf, Item07IndicesBeyondTheVerticesAreRefused) {
    GlbBuilder builder = richGlb();
    std::vector<std::uint32_t> indices = boxTriangles();
    indices[20] = 8;
    primitiveOf(builder)["indices"] = builder.indices(indices);
    expectError(builder, "index 8 of 8 vertices");
    indices[20] = 0xffffffffu;
    primitiveOf(builder)["indices"] = builder.indices(indices);
    expectError(builder, "index 4294967295");
}

namespace {

// `json` of a model of one triangle with "@" for `many`, as a web server would send it.
std::string gzippedModel(const std::string& json, const std::string& many) {
    std::string whole = json;
    whole.replace(whole.find("\"@\""), 3, many);
    return gzippedText(GlbBuilder::glbOf(whole, std::string(36, '\0')));
}

std::string repeated(const std::string& one, std::size_t count) {
    std::string out;
    for (std::size_t i = 0; i < count; ++i)
        out += one;
    return out;
}

GlbBuilder oneTriangle() {
    GlbBuilder builder;
    const int positions = builder.floats({0, 0, 0, 9, 0, 0, 0, 9, 0}, "VEC3");
    builder.node({{"mesh", builder.mesh({{"attributes", {{"POSITION", positions}}}})}});
    return builder;
}

Outcome decodeConfined(const std::string& text) {
    return runConfined(
        [&] {
            const auto content = decode(text);
            return content ? std::string() : content.error().reason;
        },
        {.warmUp = readOneOfEach});
}

} // namespace

// Each value of the text would be some 400 bytes of the model.
TEST(HostileGltf, WhatNobodyReadsNeverReachesTheModel) {
    GlbBuilder builder = oneTriangle();
    const std::string zeros = "[" + repeated("0,", 4'500'000) + "0]";
    for (const char* where :
         {"/nodes/0/extras", "/nodes/0/extensions/VENDOR_of_something",
          "/meshes/0/primitives/0/targets", "/meshes/0/weights", "/asset/extras",
          "/accessors/0/sparse/extras", "/nodes/0/extensions/EXT_mesh_gpu_instancing/extras"}) {
        Json root = Json::parse(builder.json());
        root[Json::json_pointer(where)] = "@";
        if (root["accessors"][0].contains("sparse"))
            root["accessors"][0]["sparse"]["count"] = 0;
        const Outcome outcome = decodeConfined(gzippedModel(root.dump(), zeros));
        EXPECT_EQ(outcome.trouble(), "") << where;
    }
}

TEST(HostileGltf, WhatIsReadOfTheJsonIsCountedBeforeItIsTakenUp) {
    GlbBuilder builder = oneTriangle();
    const struct {
        const char* where;
        std::string many, words;
    } cases[] = {
        {"/nodes/0/extensions/EXT_instance_features/featureIds",
         "[" + repeated("0,", 2'000'000) + "0]", "extensions would need"},
        {"/meshes/0/primitives", "[" + repeated("{\"attributes\":{}},", 450'000) + "{}]",
         "primitives would need"},
        {"/nodes/0/extras", "[" + repeated("{},", 4'000'000) + "{}]", "JSON would need"},
    };
    for (const auto& one : cases) {
        Json root = Json::parse(builder.json());
        root[Json::json_pointer(one.where)] = "@";
        const Outcome outcome = decodeConfined(gzippedModel(root.dump(), one.many));
        EXPECT_EQ(outcome.trouble(), "") << one.where;
        EXPECT_NE(outcome.said.find(one.words), std::string::npos) << outcome.said;
    }
}

// A sparse accessor without a view is any number of zeros for no bytes, and one index far away.
TEST(HostileGltf, Item07ALargeIndexTakesNoTableOfItsSize) {
    const std::uint32_t count = 12'000'000, far = 8 * count - 8;
    GlbBuilder builder = oneTriangle();
    const std::uint32_t first = 0;
    const int which = builder.view(&first, 4), value = builder.view(&far, 4);
    builder.root["accessors"].push_back(
        {{"componentType", 5125},
         {"count", count},
         {"type", "SCALAR"},
         {"sparse",
          {{"count", 1},
           {"indices", {{"bufferView", which}, {"componentType", 5125}}},
           {"values", {{"bufferView", value}}}}}});
    primitiveOf(builder)["indices"] = 1;
    Outcome outcome = decodeConfined(builder.text());
    EXPECT_EQ(outcome.trouble(), "");
    EXPECT_EQ(outcome.said, "index 95999992 of 3 vertices");
    // With as many vertices it is the table that is asked of the budget.
    builder.root["accessors"][0] = {{"componentType", 5126}, {"count", far + 1}, {"type", "VEC3"}};
    outcome = decodeConfined(builder.text());
    EXPECT_EQ(outcome.trouble(), "");
    EXPECT_NE(outcome.said.find("memory"), std::string::npos) << outcome.said;
}

TEST(HostileGltf, Item08SparseIndicesOutOfRangeOrOrderAreRefused) {
    for (const std::vector<std::uint16_t>& which :
         {std::vector<std::uint16_t>{8, 9}, {3, 3}, {4, 2}, {1, 0xffff}}) {
        GlbBuilder builder = richGlb();
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

TEST(HostileGltf, Item03NestingDeeperThan64IsRefusedBeforeParsing) {
    const auto nested = [](int depth) {
        GlbBuilder builder = richGlb();
        std::string json = builder.json();
        json.pop_back(); // its closing brace
        json += R"(,"extras":)" + std::string(std::size_t(depth), '[') +
                std::string(std::size_t(depth), ']') + "}";
        return GlbBuilder::glbOf(json, builder.bin);
    };
    EXPECT_TRUE(decode(nested(63)));
    expectError(nested(64), "nested deeper than 64");
    expectError(nested(200000), "nested deeper than 64");
    expectError(b3dmOf(richGlb().text(), std::string(4000, '[')), "nested deeper than 64");
    // Brackets within a string do not count.
    GlbBuilder builder = richGlb();
    builder.root["asset"]["copyright"] = std::string(500, '[') + "\"\\" + std::string(500, '{');
    EXPECT_TRUE(decode(builder));
}

TEST(HostileGltf, Item11TypesThatDoNotFitAreNamed) {
    GlbBuilder builder = richGlb();
    builder.root["accessors"][0]["type"] = "VEC2";
    expectError(builder, "POSITION has 2 components");
    builder = richGlb();
    builder.root["accessors"][0]["type"] = "MAT4";
    expectError(builder, "accessor 0 has a type");
    builder = richGlb();
    builder.root["accessors"][1]["componentType"] = 5126;
    expectError(builder, "indices are not unsigned integers");
    builder = richGlb();
    builder.root["accessors"][0]["componentType"] = 5124;
    expectError(builder, "accessor 0 has a type");
    builder = richGlb();
    primitiveOf(builder)["mode"] = 9;
    expectError(builder, "mode 9");
    builder = richGlb();
    builder.root["asset"]["version"] = "1.0";
    expectError(builder, "version 1.0");
}

TEST(HostileGltf, ReferencesToNothingAreNamed) {
    const auto with = [](const char* pointer, const Json& value) {
        GlbBuilder builder = richGlb();
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

TEST(HostileGltf, Item06NonFiniteVerticesAreDroppedAndCounted) {
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

TEST(HostileGltf, Item08NodesThatShareChildrenDoNotMultiply) {
    GlbBuilder builder = richGlb();
    builder.root["nodes"] = Json::array();
    for (int i = 0; i < 60; ++i) { // 2^60 ways down
        builder.node({{"children", {i + 1, i + 1}}});
    }
    builder.node({{"mesh", 0}});
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 12u);
}

TEST(HostileGltf, MalformedJsonAndUrisAreErrors) {
    expectError(std::string("{\"asset\":{\"version\":\"2.0\"}, nonsense"), "malformed JSON");
    expectError(std::string("{}"), "asset");
    GlbBuilder builder = richGlb();
    builder.root["images"][0] = {{"uri", "data:image/png;base64,****"}};
    expectError(builder, "base64");
    builder.root["images"][0] = {{"uri", "http://elsewhere/a.png"}};
    expectError(builder, "cannot be read from here");
    builder.root["images"][0] = Json::object();
    expectError(builder, "image 0");
}

TEST(HostileGltf, ADecodedSizeBeyondTheCallersIsRefused) {
    DecodeOptions options = plain();
    options.maxBytes = 10000;
    EXPECT_FALSE(decode(richGlb(), options));
    options.maxBytes = 1 << 20;
    EXPECT_TRUE(decode(richGlb(), options));
}

// The same where it only comes out of the decompression: Draco's own decoder lets it pass.
TEST(HostileGltf, Item07IndicesBeyondTheVerticesAreRefusedAfterDecompression) {
    DracoEncoded encoded = dracoEncode(6, draco::MESH_SEQUENTIAL_ENCODING, 11);
    // Header of 11 bytes; numbers of faces and points, a byte each; raw indices of a byte each.
    ASSERT_EQ(std::uint8_t(encoded.bytes[11]), encoded.faces);
    ASSERT_EQ(std::uint8_t(encoded.bytes[12]), encoded.points);
    ASSERT_EQ(encoded.bytes[13], 1);
    ASSERT_TRUE(decode(dracoGlbOf(encoded)));
    encoded.bytes[14 + 20] = char(encoded.points);
    expectError(dracoGlbOf(encoded), "index 49 of 49 points");
    encoded.bytes[14 + 20] = '\xff';
    expectError(dracoGlbOf(encoded), "index 255 of 49 points");
}

TEST(HostileGltf, Item08NodeLoopsEnd) {
    GlbBuilder builder = richGlb();
    builder.root["nodes"] = Json::array(
        {{{"children", {1}}}, {{"mesh", 0}, {"children", {2}}}, {{"children", {0, 2}}}});
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 12u);
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_NE(content->facts.warnings[0].find("ancestor"), std::string::npos);
}

TEST(HostileGltf, Item09ZeroAreaTrianglesAreDroppedAndCounted) {
    GlbBuilder builder;
    std::vector<float> corners = boxCorners(glm::vec3(0.0f), glm::vec3(1.0f));
    corners.insert(corners.end(), {5, 5, 5, 6, 6, 6, 7, 7, 7}); // on a line
    std::vector<std::uint32_t> triangles = boxTriangles();
    triangles.insert(triangles.end(), {8, 9, 10, 8, 8, 9, 10, 10, 10});
    builder.triangles(corners, triangles);
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.triangles, 12u);
    EXPECT_EQ(content->facts.degenerate, 3u);
    GlbBuilder nothing;
    nothing.triangles({5, 5, 5, 6, 6, 6, 7, 7, 7}, {0, 1, 2});
    const auto none = decode(nothing);
    ASSERT_TRUE(none) << none.error().message();
    EXPECT_TRUE(none->meshes.empty());
}

// With 65536 vertices and short indices, the last vertex has the number that cuts strips.
TEST(HostileGltf, Item10VerticesUpToTheRestartIndex) {
    for (const std::uint32_t vertices : {65535u, 65536u}) {
        for (const int mode : {4, 5}) { // triangles, a strip
            GlbBuilder builder;
            std::vector<float> positions;
            for (std::uint32_t i = 0; i < vertices; ++i)
                positions.insert(positions.end(), {float(i % 256), float(i / 256), float(i % 3)});
            const int position = builder.floats(positions, "VEC3");
            const auto last = std::uint16_t(vertices - 1);
            const std::vector<std::uint16_t> indices = {0, 1, 256, last, 2, 300};
            const int index = builder.accessor(indices, 5123, "SCALAR");
            builder.node({{"mesh", builder.mesh({{"attributes", {{"POSITION", position}}},
                                                 {"indices", index},
                                                 {"mode", mode}})}});
            const auto content = decode(builder);
            ASSERT_TRUE(content) << content.error().message();
            // Of a strip of six, the restart index leaves one triangle before it and none after.
            const bool cut = mode == 5 && last == 0xffff;
            EXPECT_EQ(content->facts.triangles, mode == 4 ? 2u : cut ? 1u : 4u) << vertices;
        }
    }
}

TEST(HostileGltf, Item11UnknownRequiredExtensionsAreNamed) {
    GlbBuilder builder = richGlb();
    builder.root["extensionsRequired"] = {"VENDOR_of_something"};
    expectError(builder, "VENDOR_of_something");
    builder.root["extensionsRequired"] = {std::string(100'000, 'x')};
    expectError(builder, "xxxx");
    builder.root["extensionsRequired"] = {"two\nlines"};
    const auto content = decode(builder);
    ASSERT_FALSE(content);
    EXPECT_EQ(content.error().message().find('\n'), std::string::npos);
}

namespace {

// The folder that a user named, and a file outside it that nobody may look into.
class Watched {
  public:
    Watched() {
        secret_ = folder_.write("secret.bin", std::string(288, '\0'));
        std::filesystem::create_directories(folder_ / "root");
        watch_ = ::inotify_init1(IN_NONBLOCK);
        ::inotify_add_watch(watch_, secret_.c_str(), IN_OPEN | IN_ACCESS);
    }
    ~Watched() { ::close(watch_); }
    bool wasOpened() const {
        char buffer[4096];
        return ::read(watch_, buffer, sizeof buffer) > 0;
    }
    const std::string& secret() const { return secret_; }
    std::string root() const { return folder_ / "root"; }
    void write(const std::string& name, const std::string& text) const {
        folder_.write("root/" + name, text);
    }

  private:
    Folder folder_;
    std::string secret_;
    int watch_ = -1;
};

std::vector<Error> errorsOf(const Watched& watched, const std::string& file) {
    std::vector<Error> errors;
    const auto opened = StreamedTileset::open(fileSource(watched.root()), file, {}, {});
    if (!opened)
        return {opened.error()};
    View view;
    view.eye = {{0.5, 0.5, 0.5}};
    view.forward = {{1, 0, 0}};
    view.pixelsPerRadian = 1e6;
    settle(**opened, {&view, 1}, {}, std::chrono::steady_clock::now() + std::chrono::seconds(30));
    for (const FailedTile& failed : (*opened)->failures())
        errors.push_back(failed.error);
    for (const LeftOut& left : (*opened)->tree().facts().leftOut)
        errors.push_back(left.error);
    return errors;
}

} // namespace

TEST(HostileGltf, Item04UrisThatLeadAwayAreDeniedAndNeverOpened) {
    const Watched watched;
    std::filesystem::create_symlink(watched.secret(), watched.root() + "/link.bin");
    std::filesystem::create_directory_symlink("..", watched.root() + "/up");
    const std::string uris[] = {"../secret.bin",
                                "%2e%2e/secret.bin",
                                "%2E%2e%2Fsecret.bin",
                                "x/../../secret.bin",
                                watched.secret(),
                                "file://" + watched.secret(),
                                "FILE:" + watched.secret(),
                                "//localhost" + watched.secret(),
                                "link.bin",
                                "up/secret.bin"};
    const std::string sphere = R"("boundingVolume":{"sphere":[0,0,0,9]},"geometricError":1)";
    const auto tileset = [&](const std::string& root) {
        return R"({"asset":{"version":"1.1"},"geometricError":9,"root":{)" + sphere + "," + root +
               "}}";
    };
    for (const std::string& uri : uris) {
        // As a tile's content, an external tileset, a subtree; a glTF's buffer and its image.
        watched.write("content.json", tileset(R"("content":{"uri":")" + uri + "\"}"));
        watched.write("external.json", tileset(R"("content":{"uri":")" + uri + R"(?a.json"})"));
        watched.write("implicit.json",
                      R"({"asset":{"version":"1.1"},"geometricError":9,"root":{"geometricError":9,)"
                      R"("boundingVolume":{"box":[0,0,0,9,0,0,0,9,0,0,0,9]},"implicitTiling":{)"
                      R"("subdivisionScheme":"QUADTREE","subtreeLevels":2,"availableLevels":2,)"
                      R"("subtrees":{"uri":")" +
                          uri + "\"}}}}");
        GlbBuilder buffer;
        buffer.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
        buffer.root["buffers"] = Json::array({{{"byteLength", 240}, {"uri", uri}}});
        buffer.bin.clear();
        watched.write("buffer.gltf", buffer.json());
        GlbBuilder image = richGlb();
        image.root["images"][0] = {{"uri", uri}};
        watched.write("image.glb", image.text());
        for (const char* file :
             {"content.json", "external.json", "implicit.json", "buffer.gltf", "image.glb"}) {
            const std::vector<Error> errors = errorsOf(watched, file);
            EXPECT_FALSE(errors.empty()) << file << " with " << uri;
            for (const Error& error : errors)
                EXPECT_EQ(error.message().find('\n'), std::string::npos) << error.message();
        }
    }
    EXPECT_FALSE(watched.wasOpened());
    // That it would have been noticed.
    (void)contentsOf(watched.secret());
    EXPECT_TRUE(watched.wasOpened());
}

namespace {

TileContent whole() {
    return *decode(richGlb());
}

} // namespace

// What stands behind every decoder: were one of them wrong, this is where it would end.
TEST(HostileContent, EveryBrokenPromiseIsTold) {
    ASSERT_FALSE(brokenPromise(whole()));
    const float nan = std::nanf(""), inf = std::numeric_limits<float>::infinity();
    const struct {
        const char* words;
        std::function<void(TileContent&)> spoil;
    } cases[] = {
        {"position", [=](TileContent& c) { c.meshes[0].positions[3].y = nan; }},
        {"position", [=](TileContent& c) { c.meshes[0].positions.back().z = -inf; }},
        {"texture coordinate", [=](TileContent& c) { c.meshes[0].uvs[1].x = inf; }},
        {"another count", [](TileContent& c) { c.meshes[0].normals.pop_back(); }},
        {"another count", [](TileContent& c) { c.meshes[0].uvs.pop_back(); }},
        {"another count", [](TileContent& c) { c.meshes[0].features.emplace_back(); }},
        {"another count", [](TileContent& c) { c.meshes[0].colors.resize(1); }},
        {"index ",
         [](TileContent& c) {
             c.meshes[0].indices[5] = std::uint32_t(c.meshes[0].positions.size());
         }},
        {"index 4294967295", [](TileContent& c) { c.meshes[0].indices.back() = 0xffffffffu; }},
        {"whole triangles", [](TileContent& c) { c.meshes[0].indices.pop_back(); }},
        {"face normals", [](TileContent& c) { c.meshes[0].faceNormals.pop_back(); }},
        {"closed triangles", [](TileContent& c) { c.meshes[0].closedTriangles = 13; }},
        {"closed triangles", [](TileContent& c) { c.meshes[0].skirtTriangles = 0xffffffffu; }},
        {"material 1 of 1", [](TileContent& c) { c.meshes[0].material = 1; }},
        {"material -1 of 1", [](TileContent& c) { c.meshes[0].material = -1; }},
        {"material 0 of 0", [](TileContent& c) { c.materials.clear(); }},
        {"place or box", [=](TileContent& c) { c.meshes[0].origin.xyz.x = nan; }},
        {"place or box", [=](TileContent& c) { c.meshes[0].box.halfAxes[1][2] = inf; }},
        {"radius", [=](TileContent& c) { c.meshes[0].radiusMetres = nan; }},
        {"radius", [](TileContent& c) { c.meshes[0].radiusMetres = -1.0; }},
        {"image 1 of 1", [](TileContent& c) { c.materials[0].image = 1; }},
        {"image -2 of 1", [](TileContent& c) { c.materials[0].image = -2; }},
        {"colour", [=](TileContent& c) { c.materials[0].baseColor.a = nan; }},
        {"colour", [=](TileContent& c) { c.materials[0].alphaCutoff = inf; }},
        {"pixels", [](TileContent& c) { c.images[0].rgba.pop_back(); }},
        {"pixels", [](TileContent& c) { c.images[0].width = 0; }},
        {"pixels", [](TileContent& c) { c.images[0].height = -2; }},
    };
    for (const auto& [words, spoil] : cases) {
        TileContent content = whole();
        spoil(content);
        const auto broken = brokenPromise(content);
        ASSERT_TRUE(broken) << words;
        EXPECT_NE(broken->find(words), std::string::npos) << *broken;
    }
}

} // namespace gnomon::test
