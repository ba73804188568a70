// Composite tiles, and contents joined into one.
#include "tile_builder.h"

#include "streaming/batch_table.h"
#include "streaming/join_content.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon {

using namespace test;

namespace {

// A triangle at x, with a batch id a vertex, in a b3dm of two features.
std::string b3dmAt(float x, const std::string& names,
                   const std::vector<std::uint32_t>& ids = {1, 1, 1}) {
    GlbBuilder builder;
    Json& primitive = builder.triangles({x, 0, 0, x + 1, 0, 0, x, 1, 0}, {0, 1, 2});
    primitive["attributes"]["_BATCHID"] = builder.accessor(ids, 5125, "SCALAR");
    return b3dmOf(builder.text(), R"({"BATCH_LENGTH":2})", names);
}

const Mesh& meshAt(const TileContent& content, double x) {
    for (const Mesh& mesh : content.meshes) {
        if (std::abs(mesh.origin.xyz.x - x) < 5.0) {
            return mesh;
        }
    }
    ADD_FAILURE() << "no mesh near " << x;
    return content.meshes.front();
}

std::string nested(int depth) {
    std::string inside = cmptOf({});
    for (int i = 1; i < depth; ++i) {
        inside = cmptOf({inside});
    }
    return inside;
}

} // namespace

TEST(Cmpt, HoldsPartsOfEveryKind) {
    TileFile i3dm = i3dmOf(1, GlbBuilder::glbOf(R"({"asset":{"version":"2.0"}})", ""));
    i3dm.features.add<float>("POSITION", {0, 0, 0});
    const auto content = decode(cmptOf(
        {b3dmAt(0, R"({"name":["a","b"]})"), i3dm.text(), pntsOf({100, 0, 0, 101, 0, 0}).text()}));
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.format, "cmpt");
    EXPECT_EQ(content->facts.triangles, 1u + 2 * 4u);
    EXPECT_EQ(content->materials.size(), 2u);
    EXPECT_NE(meshAt(*content, 0).material, meshAt(*content, 100).material);
}

TEST(Cmpt, FeaturesOfItsPartsStayApart) {
    const auto content = decode(cmptOf(
        {b3dmAt(0, R"({"name":["a","b"]})"), b3dmAt(100, R"({"name":["c","d"]})", {0, 0, 0})}));
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_TRUE(content->features);
    EXPECT_EQ(content->features->rows(), 4u);
    const auto nameAt = [&](double x) {
        const std::uint32_t feature = meshAt(*content, x).features.at(0);
        return std::get<std::string>(content->features->row(feature).at(0).value);
    };
    EXPECT_EQ(nameAt(0), "b");
    EXPECT_EQ(nameAt(100), "c");
}

TEST(Cmpt, PartsWithoutATableDoNotTakeTheRowsOfOthers) {
    TileContent bare, named;
    bare.meshes.resize(1);
    bare.meshes[0].features = {0, 5, kNoFeature};
    named.meshes.resize(1);
    named.meshes[0].features = {1};
    named.features = decode(b3dmAt(0, R"({"name":["a","b"]})"))->features;
    std::vector<TileContent> parts;
    parts.push_back(std::move(bare));
    parts.push_back(std::move(named));
    const TileContent whole = joinContents(std::move(parts), "cmpt");
    EXPECT_EQ(whole.meshes[0].features, (std::vector<std::uint32_t>{0, 5, kNoFeature}));
    EXPECT_EQ(whole.meshes[1].features, (std::vector<std::uint32_t>{7}));
    ASSERT_TRUE(whole.features);
    EXPECT_EQ(std::get<std::string>(whole.features->row(7).at(0).value), "b");
}

TEST(Cmpt, IdsBeyondAPartsOwnTableAreNobodys) {
    TileContent part, other;
    part.meshes.resize(1);
    part.meshes[0].features = {9};
    part.features = decode(b3dmAt(0, R"({"name":["a","b"]})"))->features;
    other.meshes.resize(1);
    other.meshes[0].features = {9};
    other.features = part.features;
    std::vector<TileContent> parts;
    parts.push_back(std::move(part));
    parts.push_back(std::move(other));
    const TileContent whole = joinContents(std::move(parts), "cmpt");
    EXPECT_EQ(whole.meshes[0].features.at(0), kNoFeature);
    EXPECT_EQ(whole.meshes[1].features.at(0), kNoFeature);
}

TEST(Cmpt, RowsBeyond32BitsAreNobodys) {
    std::vector<std::string> warnings;
    std::vector<TileContent> parts(2);
    parts[0].features = readBatchTable({}, {}, 0xfffffff0u, warnings);
    parts[1].features = readBatchTable({}, {}, 100, warnings);
    parts[1].meshes.resize(1);
    parts[1].meshes[0].features = {3, 14, 15, 99};
    const TileContent whole = joinContents(std::move(parts), "cmpt");
    EXPECT_EQ(whole.meshes[0].features,
              (std::vector<std::uint32_t>{0xfffffff3u, 0xfffffffeu, kNoFeature, kNoFeature}));
}

TEST(Cmpt, ImagesAndMaterialsAreRenumbered) {
    GlbBuilder textured;
    Json& primitive = textured.triangles({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2});
    primitive["attributes"]["TEXCOORD_0"] = textured.floats({0, 0, 1, 0, 0, 1}, "VEC2");
    primitive["material"] = 0;
    const std::string png = pngOf(1, 1, 3, "abc");
    textured.root["images"] =
        Json::array({{{"bufferView", textured.view(png.data(), png.size())}}});
    textured.root["textures"] = Json::array({{{"source", 0}}});
    textured.root["materials"] =
        Json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
    const std::string b3dm = b3dmOf(textured.text());
    const auto content = decode(cmptOf({b3dm, b3dm}));
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_EQ(content->images.size(), 2u);
    ASSERT_EQ(content->meshes.size(), 2u);
    EXPECT_EQ(content->materials.at(std::size_t(content->meshes[1].material)).image, 1);
}

TEST(Cmpt, WhatThousandsOfPartsSayIsNotAllKept) {
    std::vector<TileContent> parts(40000);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const std::string name = std::to_string(i);
        parts[i].facts.warnings = {"flaw " + name, "again"};
        parts[i].facts.extensions = {"EXT_" + name};
        parts[i].facts.copyright = "owner " + name;
    }
    const ContentFacts facts = joinContents(std::move(parts), "cmpt").facts;
    EXPECT_EQ(facts.warnings.size(), 64u);
    EXPECT_EQ(facts.warnings.at(1), "again");
    EXPECT_EQ(facts.extensions.size(), 64u);
    EXPECT_EQ(facts.copyright.find("owner 0; owner 1; "), 0u);
    EXPECT_LT(facts.copyright.size(), 4096u);
}

TEST(Cmpt, MayBeNestedButNotWithoutEnd) {
    EXPECT_TRUE(decode(nested(8)));
    const auto content = decode(nested(9));
    ASSERT_FALSE(content);
    EXPECT_NE(content.error().reason.find("cmpt nested deeper than 8"), std::string::npos);
}

TEST(Cmpt, OneBadPartFailsTheTileAndIsNamed) {
    const auto content =
        decode(cmptOf({b3dmAt(0, ""), "vctr" + std::string("\1\0\0\0\x0c\0\0\0", 8)}));
    ASSERT_FALSE(content);
    EXPECT_EQ(content.error().reason, "part 2 of the cmpt: vctr content is not supported");
}

TEST(Cmpt, CountsAndLengthsThatLieAreRefused) {
    std::string tile = cmptOf({b3dmAt(0, "")});
    std::string more = tile;
    putAt(more, 12, 0xffffffffu);
    EXPECT_EQ(decode(more).error().reason, "cmpt whose part 2 of 4294967295 is not all there");
    for (const std::uint32_t length : {0u, 11u, 0xffffffffu}) {
        std::string wrong = tile;
        putAt(wrong, 16 + 8, length);
        EXPECT_NE(decode(wrong).error().reason.find("part 1 of 1"), std::string::npos) << length;
    }
}

TEST(Cmpt, CutAtAnyLengthItFailsWithAReason) {
    cutEverywhere(cmptOf({b3dmAt(0, R"({"name":["a","b"]})"), pntsOf({1, 2, 3}).text()}),
                  [](const Result<TileContent>& content, std::size_t n) {
                      ASSERT_FALSE(content) << n;
                      EXPECT_EQ(content.error().reason.find('\n'), std::string::npos);
                  });
}

} // namespace gnomon
