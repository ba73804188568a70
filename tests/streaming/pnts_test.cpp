// Point clouds: where points are, their colours, normals and features, and the solids they become.
#include "tile_builder.h"

#include "streaming/points.h"

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gnomon {

using namespace test;

namespace {

const std::vector<float> kCorners{0, 0, 0, 10, 0, 0, 0, 20, 0, 0, 0, 30};

// One entry a solid, in the order of the file, which the order of triangles keeps in a small tile.
struct Solid {
    glm::dvec3 centre{0.0}, normal{0.0};
    std::uint32_t color = 0, feature = 0;
};

std::vector<Solid> solidsIn(const Result<TileContent>& content) {
    std::vector<Solid> out;
    if (!content) {
        ADD_FAILURE() << content.error().message();
        return out;
    }
    for (const Mesh& mesh : content->meshes) {
        for (std::size_t t = 0; t < mesh.indices.size(); t += 12) {
            Solid solid;
            // Three upper faces and the base: each corner is in three of the four.
            for (std::size_t i = t; i < t + 12; ++i) {
                solid.centre += vertex(mesh, mesh.indices[i]) / 12.0;
            }
            const std::uint32_t first = mesh.indices[t];
            solid.normal = decodeOct(mesh.normals[first]);
            solid.color = mesh.colors.empty() ? 0 : mesh.colors[first];
            solid.feature = mesh.features.empty() ? kNoFeature : mesh.features[first];
            out.push_back(solid);
        }
    }
    return out;
}

void expectCentres(const Result<TileContent>& content, const std::vector<glm::dvec3>& wanted,
                   double tolerance = 1e-5) {
    const auto solids = solidsIn(content);
    ASSERT_EQ(solids.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_LT(glm::distance(solids[i].centre, wanted[i]), tolerance) << i;
    }
}

std::string reasonOf(const TileFile& file) {
    const auto content = decode(file.text());
    return content ? std::string("it opened") : content.error().reason;
}

// Linear, as meshes have it, from the 8-bit sRGB of the file.
std::uint32_t linear(int srgb) {
    const double v = srgb / 255.0;
    return std::uint32_t(
        std::lround(255.0 * (v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4))));
}

std::uint32_t rgb(int r, int g, int b) {
    return linear(r) | linear(g) << 8 | linear(b) << 16 | 0xff000000u;
}

// The corners of kCorners as Draco has them, with a colour and a batch id each.
struct DracoCloud {
    std::string bytes;
    std::uint32_t position = 0, color = 0, batch = 0;
};

DracoCloud dracoCloud() {
    draco::PointCloud cloud;
    cloud.set_num_points(4);
    const auto add = [&](draco::GeometryAttribute::Type type, std::int8_t components,
                         draco::DataType data, std::int64_t stride) {
        draco::GeometryAttribute attribute;
        attribute.Init(type, nullptr, components, data, false, stride, 0);
        return cloud.AddAttribute(attribute, true, 4);
    };
    const int position = add(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32, 12);
    const int color = add(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8, 3);
    const int batch = add(draco::GeometryAttribute::GENERIC, 1, draco::DT_UINT16, 2);
    for (std::uint32_t i = 0; i < 4; ++i) {
        const draco::AttributeValueIndex at(i);
        cloud.attribute(position)->SetAttributeValue(at, &kCorners[3 * i]);
        const std::uint8_t shade[3] = {std::uint8_t(60 * i), 10, 255};
        cloud.attribute(color)->SetAttributeValue(at, shade);
        const std::uint16_t id = std::uint16_t(i / 2);
        cloud.attribute(batch)->SetAttributeValue(at, &id);
    }
    draco::ExpertEncoder encoder(cloud);
    encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
    return {std::string(buffer.data(), buffer.size()), cloud.attribute(position)->unique_id(),
            cloud.attribute(color)->unique_id(), cloud.attribute(batch)->unique_id()};
}

TileFile dracoPnts() {
    const DracoCloud cloud = dracoCloud();
    TileFile file;
    file.magic = "pnts";
    file.features.binary = cloud.bytes;
    for (const char* name : {"POSITION", "RGB", "BATCH_ID"}) {
        file.features.json[name] = {{"byteOffset", 0}};
    }
    file.features.json["POINTS_LENGTH"] = 4;
    file.features.json["BATCH_LENGTH"] = 2;
    file.features.json["extensions"]["3DTILES_draco_point_compression"] = {
        {"byteOffset", 0},
        {"byteLength", cloud.bytes.size()},
        {"properties",
         {{"POSITION", cloud.position}, {"RGB", cloud.color}, {"BATCH_ID", cloud.batch}}}};
    return file;
}

} // namespace

TEST(Pnts, APointIsTheCentreOfAClosedSolid) {
    const auto content = decode(pntsOf(kCorners).text());
    expectCentres(content, {{0, 0, 0}, {10, 0, 0}, {0, 20, 0}, {0, 0, 30}});
    EXPECT_EQ(content->facts.format, "pnts");
    EXPECT_EQ(content->facts.triangles, 16u);
    EXPECT_EQ(content->facts.closedTriangles, 16u);
    EXPECT_EQ(content->meshes.at(0).closedTriangles, 16u);
    EXPECT_EQ(content->features, nullptr);
}

TEST(Pnts, AddsRtcCenterInDoubleAndHasZUpWhateverItsGltfHave) {
    TileFile file = pntsOf(kCorners);
    file.features.json["RTC_CENTER"] = {1215012.25, -4736313.125, 4081605.5};
    DecodeOptions options;
    options.gltfUpAxis = UpAxis::Y;
    const auto solids = solidsIn(decode(file.text(), options));
    EXPECT_LT(glm::distance(solids.at(3).centre, glm::dvec3(1215012.25, -4736313.125, 4081635.5)),
              1e-5);
}

TEST(Pnts, ReadsQuantisedPositions) {
    TileFile file = pntsOf({});
    file.features.json = {{"POINTS_LENGTH", 2},
                          {"QUANTIZED_VOLUME_OFFSET", {100, 200, 300}},
                          {"QUANTIZED_VOLUME_SCALE", {10, 20, 50}}};
    file.features.add<std::uint16_t>("POSITION_QUANTIZED", {0, 0, 0, 65535, 32767, 13107});
    expectCentres(decode(file.text()), {{100, 200, 300}, {110, 200 + 20 * 32767 / 65535.0, 310}});
}

TEST(Pnts, ColoursOfEveryKindBecomeLinear) {
    TileFile file = pntsOf({0, 0, 0, 9, 0, 0});
    file.features.add<std::uint16_t>("RGB565", {0xf800, 0x07e0 | 0x0010});
    auto solids = solidsIn(decode(file.text()));
    EXPECT_EQ(solids.at(0).color, rgb(255, 0, 0));
    EXPECT_EQ(solids.at(1).color,
              0xff00ff00u |
                  std::uint32_t(std::lround(255 * std::pow((16 / 31.0 + 0.055) / 1.055, 2.4)))
                      << 16);
    file.features.add<std::uint8_t>("RGB", {255, 128, 0, 10, 20, 30});
    solids = solidsIn(decode(file.text()));
    EXPECT_EQ(solids.at(0).color, rgb(255, 128, 0));
    EXPECT_EQ(solids.at(1).color, rgb(10, 20, 30));
    file.features.add<std::uint8_t>("RGBA", {1, 2, 3, 255, 50, 60, 70, 255});
    solids = solidsIn(decode(file.text()));
    EXPECT_EQ(solids.at(0).color, rgb(1, 2, 3));
    EXPECT_EQ(solids.at(1).color, rgb(50, 60, 70));
}

TEST(Pnts, AConstantColourIsTheMaterials) {
    TileFile file = pntsOf(kCorners);
    auto content = decode(file.text());
    ASSERT_TRUE(content);
    EXPECT_TRUE(content->meshes.at(0).colors.empty());
    EXPECT_NEAR(content->materials.at(0).baseColor.g, float(linear(169)) / 255, 1e-6);
    file.features.json["CONSTANT_RGBA"] = {255, 128, 0, 255};
    content = decode(file.text());
    ASSERT_TRUE(content);
    EXPECT_NEAR(content->materials.at(0).baseColor.r, 1.0, 1e-6);
    EXPECT_NEAR(content->materials.at(0).baseColor.g, float(linear(128)) / 255, 1e-6);
    EXPECT_NEAR(content->materials.at(0).baseColor.b, 0.0, 1e-6);
}

TEST(Pnts, PointsHalfSeenThroughAreOpaqueAndThoseNotSeenAreLeftOut) {
    TileFile file = pntsOf({0, 0, 0, 9, 0, 0});
    file.features.add<std::uint8_t>("RGBA", {1, 2, 3, 0, 50, 60, 70, 20});
    const auto content = decode(file.text());
    expectCentres(content, {{9, 0, 0}});
    EXPECT_EQ(solidsIn(content).at(0).color, rgb(50, 60, 70));
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_EQ(content->facts.warnings[0], "points half seen through are drawn opaque");
}

TEST(Pnts, NormalsPlainAndPackedAreForShading) {
    TileFile file = pntsOf({0, 0, 0, 9, 0, 0});
    file.features.add<float>("NORMAL", {0, 0, 2, 0, -1, 0});
    auto solids = solidsIn(decode(file.text()));
    EXPECT_NEAR(solids.at(0).normal.z, 1.0, 1e-3);
    EXPECT_NEAR(solids.at(1).normal.y, -1.0, 1e-3);
    file = pntsOf({0, 0, 0, 9, 0, 0});
    file.features.add<std::uint8_t>("NORMAL_OCT16P", {128, 128, 128, 0});
    solids = solidsIn(decode(file.text()));
    EXPECT_NEAR(solids.at(0).normal.z, 1.0, 1e-2);
    EXPECT_NEAR(solids.at(1).normal.y, -1.0, 1e-2);
}

TEST(Pnts, BatchIdsNameGroupsOfPoints) {
    TileFile file = pntsOf(kCorners);
    file.features.json["BATCH_LENGTH"] = 2;
    file.features.add<std::uint8_t>("BATCH_ID", {1, 1, 0, 0});
    file.features.json["BATCH_ID"]["componentType"] = "UNSIGNED_BYTE";
    file.batchJson = R"({"kind":["roof","wall"]})";
    const auto content = decode(file.text());
    const auto solids = solidsIn(content);
    EXPECT_EQ(solids.at(0).feature, 1u);
    EXPECT_EQ(solids.at(3).feature, 0u);
    ASSERT_TRUE(content->features);
    EXPECT_EQ(content->features->rows(), 2u);
    EXPECT_EQ(std::get<std::string>(content->features->row(1).at(0).value), "wall");
}

TEST(Pnts, WithoutBatchIdsEachPointIsAFeatureOfItsTable) {
    TileFile file = pntsOf(kCorners);
    file.batchJson = R"({"t":[1,2,3,4]})";
    const auto content = decode(file.text());
    EXPECT_EQ(solidsIn(content).at(2).feature, 2u);
    ASSERT_TRUE(content->features);
    EXPECT_EQ(std::get<std::int64_t>(content->features->row(2).at(0).value), 3);
}

TEST(Pnts, ReadsWhatDracoHolds) {
    const auto content = decode(dracoPnts().text());
    expectCentres(content, {{0, 0, 0}, {10, 0, 0}, {0, 20, 0}, {0, 0, 30}}, 0.01);
    const auto solids = solidsIn(content);
    EXPECT_EQ(solids.at(2).color, rgb(120, 10, 255));
    EXPECT_EQ(solids.at(1).feature, 0u);
    EXPECT_EQ(solids.at(2).feature, 1u);
    EXPECT_EQ(content->facts.extensions,
              std::vector<std::string>{"3DTILES_draco_point_compression"});
}

TEST(Pnts, ColumnsOfTheBatchTableMayBeInTheDracoBufferToo) {
    TileFile file = dracoPnts();
    const std::uint32_t id =
        file.features
            .json["extensions"]["3DTILES_draco_point_compression"]["properties"]["BATCH_ID"];
    file.features.json["extensions"]["3DTILES_draco_point_compression"]["properties"].erase(
        "BATCH_ID");
    file.features.json.erase("BATCH_ID");
    file.features.json.erase("BATCH_LENGTH");
    Json batch = {{"half", {{"byteOffset", 0}, {"componentType", "SHORT"}, {"type", "SCALAR"}}}};
    batch["extensions"]["3DTILES_draco_point_compression"]["properties"]["half"] = id;
    file.batchJson = batch.dump();
    const auto content = decode(file.text());
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_TRUE(content->features);
    EXPECT_TRUE(content->facts.warnings.empty()) << content->facts.warnings[0];
    for (std::uint32_t i = 0; i < 4; ++i) {
        const auto row = content->features->row(i);
        ASSERT_EQ(row.size(), 1u);
        EXPECT_EQ(row[0].name, "half");
        EXPECT_EQ(jsonOf(row[0].value), std::to_string(i / 2));
    }
}

TEST(Pnts, WhatIsMissingOrLiesIsNamed) {
    TileFile file = pntsOf(kCorners);
    file.features.json.erase("POSITION");
    EXPECT_EQ(reasonOf(file), "pnts without POSITION or POSITION_QUANTIZED");
    file.features.add<std::uint16_t>("POSITION_QUANTIZED", std::vector<std::uint16_t>(12));
    EXPECT_EQ(reasonOf(file), "pnts with POSITION_QUANTIZED, but without its volume");
    file = pntsOf(kCorners);
    file.features.json["POINTS_LENGTH"] = 5;
    EXPECT_EQ(reasonOf(file), "pnts: POSITION lies outside the feature table");
    file.features.json["POINTS_LENGTH"] = 4294967295u;
    EXPECT_EQ(reasonOf(file), "pnts: malformed POINTS_LENGTH");
    file.features.json["POINTS_LENGTH"] = 4294967294u;
    EXPECT_NE(reasonOf(file).find("memory"), std::string::npos);
    file.features.json.erase("POINTS_LENGTH");
    EXPECT_EQ(reasonOf(file), "pnts without POINTS_LENGTH");
    file = dracoPnts();
    file.features.json["POINTS_LENGTH"] = 3;
    EXPECT_EQ(reasonOf(file), "Draco: header claims 4 points of 3");
    file = dracoPnts();
    file.features.json["extensions"]["3DTILES_draco_point_compression"]["byteLength"] = 4000;
    EXPECT_NE(reasonOf(file).find("lies outside the feature table"), std::string::npos);
    file = dracoPnts();
    file.features.json["extensions"]["3DTILES_draco_point_compression"]["properties"]["RGB"] = 77;
    EXPECT_EQ(reasonOf(file), "Draco: no attribute with unique id 77");
}

TEST(Pnts, PlacesThatAreNoNumbersAreLeftOut) {
    const auto content = decode(pntsOf({NAN, 0, 0, 1, 2, 3, 0, INFINITY, 0, 0, 0, 1e30f}).text());
    expectCentres(content, {{1, 2, 3}});
    EXPECT_EQ(content->facts.invalid, 3u);
}

TEST(Pnts, AreThinnedRatherThanRefusedWhereMemoryIsShort) {
    std::vector<float> positions;
    for (int i = 0; i < 100000; ++i) {
        positions.insert(positions.end(), {float(i % 400), float(i / 400), 0.0f});
    }
    DecodeOptions options = plain();
    options.maxBytes = std::size_t(40) << 20;
    const auto content = decode(pntsOf(positions).text(), options);
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_GT(content->facts.triangles, 4 * 15000u);
    EXPECT_LT(content->facts.triangles, 4 * 60000u);
    ASSERT_EQ(content->facts.warnings.size(), 1u);
    EXPECT_NE(content->facts.warnings[0].find("points left out"), std::string::npos);
}

TEST(Pnts, CutAtAnyLengthItFailsWithAReason) {
    TileFile whole = pntsOf(kCorners);
    whole.features.add<std::uint8_t>("RGB", std::vector<std::uint8_t>(12, 9));
    whole.batchJson = R"({"a":[1,2,3,4]})";
    for (const TileFile& file : {whole, dracoPnts()}) {
        cutEverywhere(file.text(), [](const Result<TileContent>& content, std::size_t n) {
            ASSERT_FALSE(content) << n;
            EXPECT_EQ(content.error().reason.find('\n'), std::string::npos);
        });
    }
}

TEST(Pnts, DracoCutAtAnyLengthItFailsWithAReason) {
    const TileFile whole = dracoPnts();
    for (std::size_t n = 0; n < whole.features.binary.size(); ++n) {
        TileFile cut = whole;
        cut.features.binary.resize(n);
        cut.features.json["extensions"]["3DTILES_draco_point_compression"]["byteLength"] = n;
        EXPECT_NE(reasonOf(cut), "") << n;
    }
}

} // namespace gnomon
