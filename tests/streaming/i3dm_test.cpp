// Instanced models: where each instance stands, how it is turned, and what it is called.
#include "tile_builder.h"

#include "geo/ellipsoid.h"
#include "streaming/tile_headers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon {

using namespace test;

namespace {

// Corners at (1, 0, 0), (0, 2, 0), (0, 0, 3): every axis can be told from the others.
std::string markerGlb() {
    GlbBuilder builder;
    builder.triangles({1, 0, 0, 0, 2, 0, 0, 0, 3}, {0, 1, 2});
    return builder.text();
}

std::vector<glm::dvec3> cornersOf(const Result<TileContent>& content) {
    std::vector<glm::dvec3> out;
    if (!content) {
        ADD_FAILURE() << content.error().message();
        return out;
    }
    for (const Mesh& mesh : content->meshes) {
        for (const std::uint32_t i : mesh.indices) {
            out.push_back(vertex(mesh, i));
        }
    }
    return out;
}

void expectHas(const std::vector<glm::dvec3>& corners, const glm::dvec3& wanted,
               double tolerance = 1e-5) {
    const bool found = std::any_of(corners.begin(), corners.end(), [&](const glm::dvec3& c) {
        return glm::distance(c, wanted) < tolerance;
    });
    EXPECT_TRUE(found) << "no corner at " << wanted.x << ' ' << wanted.y << ' ' << wanted.z;
}

std::string reasonOf(const TileFile& file) {
    const auto content = decode(file.text());
    return content ? std::string("it opened") : content.error().reason;
}

} // namespace

TEST(I3dm, StandsWhereItsPositionsSay) {
    TileFile file = i3dmOf(2, markerGlb());
    file.features.add<float>("POSITION", {10, 20, 30, -40, 50, 60});
    const auto content = decode(file.text());
    const auto corners = cornersOf(content);
    EXPECT_EQ(content->facts.format, "i3dm");
    EXPECT_EQ(corners.size(), 6u);
    expectHas(corners, {11, 20, 30});
    expectHas(corners, {10, 20, 33});
    expectHas(corners, {-39, 50, 60});
    expectHas(corners, {-40, 52, 60});
}

TEST(I3dm, AddsRtcCenterInDouble) {
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {1, 2, 3});
    file.features.json["RTC_CENTER"] = {1215012.25, -4736313.125, 4081605.5};
    expectHas(cornersOf(decode(file.text())), {1215014.25, -4736311.125, 4081608.5});
}

TEST(I3dm, ReadsQuantisedPositions) {
    TileFile file = i3dmOf(2, markerGlb());
    file.features.add<std::uint16_t>("POSITION_QUANTIZED", {0, 0, 0, 65535, 32767, 13107});
    file.features.json["QUANTIZED_VOLUME_OFFSET"] = {100, 200, 300};
    file.features.json["QUANTIZED_VOLUME_SCALE"] = {10, 65535, 50};
    const auto corners = cornersOf(decode(file.text()));
    expectHas(corners, {101, 200, 300});
    expectHas(corners, {111, 200 + 32767, 310}, 0.01);
}

TEST(I3dm, IsTurnedByUpAndRight) {
    // Right is the instance's x, up its y, so forward is right × up.
    const std::vector<float> up{0, 0, 1}, right{0, 1, 0};
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {0, 0, 0});
    file.features.add("NORMAL_UP", up);
    file.features.add("NORMAL_RIGHT", right);
    const auto corners = cornersOf(decode(file.text()));
    expectHas(corners, {0, 1, 0});
    expectHas(corners, {0, 0, 2});
    expectHas(corners, {3, 0, 0});
}

TEST(I3dm, DirectionsThatAreNoneLeaveItUnturned) {
    TileFile file = i3dmOf(2, markerGlb());
    file.features.add<float>("POSITION", {0, 0, 0, 20, 0, 0});
    file.features.add<float>("NORMAL_UP", {0, 0, 0, 0, 0, 1});
    file.features.add<float>("NORMAL_RIGHT", {0, 1, 0, 0, 0, 1});
    const auto corners = cornersOf(decode(file.text()));
    expectHas(corners, {1, 0, 0});
    expectHas(corners, {20, 2, 0});
}

TEST(I3dm, ReadsPackedDirections) {
    // (0, 0, 1) and (0, 1, 0) in an octahedron of 0…65535.
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {0, 0, 0});
    file.features.add<std::uint16_t>("NORMAL_UP_OCT32P", {32768, 32768});
    file.features.add<std::uint16_t>("NORMAL_RIGHT_OCT32P", {32768, 65535});
    const auto corners = cornersOf(decode(file.text()));
    expectHas(corners, {0, 1, 0}, 1e-3);
    expectHas(corners, {0, 0, 2}, 1e-3);
    expectHas(corners, {3, 0, 0}, 1e-3);
}

TEST(I3dm, PackedDirectionsOfTheLowerHalfFold) {
    // (0, 0, -1) is a corner of the octahedron's square.
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {0, 0, 0});
    file.features.add<std::uint16_t>("NORMAL_UP_OCT32P", {65535, 65535});
    file.features.add<std::uint16_t>("NORMAL_RIGHT_OCT32P", {65535, 32768});
    expectHas(cornersOf(decode(file.text())), {0, 0, -2}, 1e-3);
}

TEST(I3dm, PackedDirectionsAreThoseOfTheSameOctahedronAsMeshes) {
    for (int i = 0; i < 400; ++i) {
        const double z = 1.0 - (2 * i + 1) / 400.0, around = 2.4 * i;
        const double r = std::sqrt(1.0 - z * z);
        const glm::dvec3 direction(r * std::cos(around), r * std::sin(around), z);
        const OctNormal packed = encodeOct(direction);
        const glm::dvec3 read =
            octNormal((packed.x / 32767.0 + 1.0) / 2.0, (packed.y / 32767.0 + 1.0) / 2.0);
        EXPECT_LT(glm::distance(read, direction), 1e-4) << i;
    }
}

TEST(I3dm, MirroredOpenTrianglesKeepTheirFace) {
    GlbBuilder builder;
    builder.triangles({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2});
    TileFile file = i3dmOf(1, builder.text());
    file.features.add<float>("POSITION", {0, 0, 0});
    file.features.add<float>("SCALE_NON_UNIFORM", {-1, 1, 1});
    const auto content = decode(file.text());
    ASSERT_TRUE(content);
    EXPECT_NEAR(decodeOct(content->meshes.at(0).faceNormals.at(0)).z, 1.0, 1e-4);
}

TEST(I3dm, ScalesEachAxisBothWays) {
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {5, 0, 0});
    file.features.add<float>("SCALE", {2});
    file.features.add<float>("SCALE_NON_UNIFORM", {1, 10, 100});
    const auto corners = cornersOf(decode(file.text()));
    expectHas(corners, {7, 0, 0});
    expectHas(corners, {5, 40, 0});
    expectHas(corners, {5, 0, 600});
}

TEST(I3dm, MirroredInstancesStayOutwardWound) {
    GlbBuilder builder;
    builder.triangles(boxCorners({0, 0, 0}, {1, 1, 1}), boxTriangles());
    TileFile file = i3dmOf(1, builder.text());
    file.features.add<float>("POSITION", {0, 0, 0});
    file.features.add<float>("SCALE_NON_UNIFORM", {-1, 1, 1});
    const auto content = decode(file.text());
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.closedTriangles, 12u);
    const Mesh& mesh = content->meshes.at(0);
    for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
        const glm::dvec3 a = vertex(mesh, mesh.indices[3 * t]);
        EXPECT_GT(glm::dot(decodeOct(mesh.faceNormals[t]), a - glm::dvec3(-0.5, 0.5, 0.5)), 0.0);
    }
}

TEST(I3dm, EastNorthUpIsThatOfEachInstancesPlace) {
    for (const Geodetic& place : {Geodetic{4.9, 52.37, 12.0}, Geodetic{-75.6, -40.04, 100.0}}) {
        const glm::vec3 p(ecefOf(place).xyz);
        TileFile file = i3dmOf(1, markerGlb());
        file.features.json["EAST_NORTH_UP"] = true;
        file.features.add<float>("POSITION", {p.x, p.y, p.z});
        const glm::dmat3 axes = ecefFromEnu(*geodeticFromEcef(Point<Ecef>{glm::dvec3(p)})).axes();
        const auto corners = cornersOf(decode(file.text()));
        expectHas(corners, glm::dvec3(p) + axes[0]);
        expectHas(corners, glm::dvec3(p) + axes[1] * 2.0);
        expectHas(corners, glm::dvec3(p) + axes[2] * 3.0);
    }
}

TEST(I3dm, EastNorthUpHoldsUnderTheTilesTransform) {
    // A tile whose axes are turned about the Earth's: up must still be up where the instance ends.
    TileFile file = i3dmOf(1, markerGlb());
    file.features.json["EAST_NORTH_UP"] = true;
    file.features.add<float>("POSITION", {3, 4, 5});
    DecodeOptions options = plain();
    const Geodetic place{139.7, 35.7, 40.0};
    options.ecefFromTile.matrix = ecefFromEnu(place).matrix;
    // The tile's x points north.
    const glm::dvec4 east = options.ecefFromTile.matrix[0], north = options.ecefFromTile.matrix[1];
    options.ecefFromTile.matrix[0] = north;
    options.ecefFromTile.matrix[1] = -east;
    const Point<Ecef> at = options.ecefFromTile(Point<Tile>{{3, 4, 5}});
    const glm::dmat3 axes = ecefFromEnu(*geodeticFromEcef(at)).axes();
    const auto corners = cornersOf(decode(file.text(), options));
    expectHas(corners, at.xyz + axes[0], 1e-5);
    expectHas(corners, at.xyz + axes[1] * 2.0, 1e-5);
    expectHas(corners, at.xyz + axes[2] * 3.0, 1e-5);
}

TEST(I3dm, TheModelsUpAxisIsTurnedBeforeItsInstance) {
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {10, 0, 0});
    DecodeOptions options;
    options.gltfUpAxis = UpAxis::Y;
    const auto corners = cornersOf(decode(file.text(), options));
    expectHas(corners, {11, 0, 0});
    expectHas(corners, {10, 0, 2});  // the model's y
    expectHas(corners, {10, -3, 0}); // its z
}

TEST(I3dm, FeaturesAreTheInstances) {
    TileFile file = i3dmOf(2, markerGlb());
    file.features.add<float>("POSITION", {0, 0, 0, 9, 0, 0});
    file.batchJson = R"({"name":["oak","elm"]})";
    const auto content = decode(file.text());
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_TRUE(content->features);
    EXPECT_EQ(content->features->rows(), 2u);
    const Mesh& mesh = content->meshes.at(0);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const std::uint32_t expected = vertex(mesh, i).x > 5 ? 1 : 0;
        EXPECT_EQ(mesh.features.at(i), expected);
    }
    EXPECT_EQ(std::get<std::string>(content->features->row(1).at(0).value), "elm");
}

TEST(I3dm, BatchIdsOfEveryTypeNameTheRows) {
    const auto check = [](auto id, const char* type) {
        TileFile file = i3dmOf(2, markerGlb());
        file.features.add<float>("POSITION", {0, 0, 0, 9, 0, 0});
        file.features.add("BATCH_ID", std::vector{decltype(id)(7), decltype(id)(3)});
        if (type) {
            file.features.json["BATCH_ID"]["componentType"] = type;
        }
        const auto content = decode(file.text());
        ASSERT_TRUE(content) << content.error().message();
        const Mesh& mesh = content->meshes.at(0);
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            EXPECT_EQ(mesh.features.at(i), vertex(mesh, i).x > 5 ? 3u : 7u);
        }
    };
    check(std::uint16_t(), nullptr);
    check(std::uint8_t(), "UNSIGNED_BYTE");
    check(std::uint16_t(), "UNSIGNED_SHORT");
    check(std::uint32_t(), "UNSIGNED_INT");
}

TEST(I3dm, ItsTableMayHaveRowsThatNoInstanceIsOf) {
    const auto warningsOf = [](bool hasIds) {
        TileFile file = i3dmOf(2, markerGlb());
        file.features.add<float>("POSITION", {0, 0, 0, 9, 0, 0});
        if (hasIds) {
            file.features.add<std::uint16_t>("BATCH_ID", {0, 1});
        }
        file.batchJson = R"({"name":["oak","elm","fir","yew"]})";
        const auto content = decode(file.text());
        EXPECT_TRUE(content);
        return content ? content->facts.warnings : std::vector<std::string>{"it failed"};
    };
    EXPECT_EQ(warningsOf(true), std::vector<std::string>{});
    EXPECT_EQ(warningsOf(false).size(), 1u) << "there, a row is an instance";
}

TEST(I3dm, ReadsItsModelFromAFileAndWhatThatNamesBesideIt) {
    GlbBuilder builder;
    builder.triangles({1, 0, 0, 0, 2, 0, 0, 0, 3}, {0, 1, 2});
    Json gltf = builder.root;
    gltf["buffers"] = Json::array({{{"byteLength", builder.bin.size()}, {"uri", "tree.bin"}}});
    TileFile file = i3dmOf(1, "models/a%20b/tree.gltf?v=1/2  ");
    file.gltfFormat = 0;
    file.features.add<float>("POSITION", {4, 0, 0});
    DecodeOptions options = plain();
    std::vector<std::string> asked;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        asked.push_back(uri);
        return bytesOf(asked.size() == 1 ? gltf.dump() : builder.bin);
    };
    expectHas(cornersOf(decode(file.text(), options)), {5, 0, 0});
    EXPECT_EQ(asked,
              (std::vector<std::string>{"models/a%20b/tree.gltf?v=1/2", "models/a%20b/tree.bin"}));
    EXPECT_NE(reasonOf(file).find("cannot be read from here"), std::string::npos);
}

TEST(I3dm, WhatIsMissingIsNamed) {
    TileFile file = i3dmOf(1, markerGlb());
    EXPECT_EQ(reasonOf(file), "i3dm without POSITION or POSITION_QUANTIZED");
    file.features.add<std::uint16_t>("POSITION_QUANTIZED", {1, 2, 3});
    EXPECT_EQ(reasonOf(file), "i3dm with POSITION_QUANTIZED, but without its volume");
    file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {1, 2, 3});
    file.features.add<float>("NORMAL_UP", {0, 1, 0});
    EXPECT_EQ(reasonOf(file), "i3dm with only one of NORMAL_UP and NORMAL_RIGHT");
    file.features.json.erase("INSTANCES_LENGTH");
    EXPECT_EQ(reasonOf(file), "i3dm without INSTANCES_LENGTH");
    file.gltfFormat = 2;
    EXPECT_NE(reasonOf(file).find("model of kind 2"), std::string::npos);
    file.version = 2;
    EXPECT_EQ(reasonOf(file), "i3dm of version 2; only 1 is supported");
}

TEST(I3dm, CountsBeyondTheBytesAreRefusedBeforeAnythingIsMade) {
    TileFile file = i3dmOf(4000000000u, markerGlb());
    file.features.add<float>("POSITION", {1, 2, 3});
    EXPECT_NE(reasonOf(file).find("memory"), std::string::npos);
    file.features.json["INSTANCES_LENGTH"] = 2;
    EXPECT_EQ(reasonOf(file), "i3dm: POSITION lies outside the feature table");
    file.features.json["POSITION"]["byteOffset"] = 18446744073709551615ull;
    EXPECT_EQ(reasonOf(file), "i3dm: POSITION lies outside the feature table");
    file.features.json["INSTANCES_LENGTH"] = -1;
    EXPECT_EQ(reasonOf(file), "i3dm: malformed INSTANCES_LENGTH");
}

TEST(I3dm, ManyInstancesOfALargeModelAreRefusedForMemory) {
    GlbBuilder builder;
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < 3000; ++i) {
        positions.insert(positions.end(), {float(i % 50), float(i / 50), float(i % 7)});
        indices.push_back(i);
    }
    builder.triangles(positions, indices);
    TileFile file = i3dmOf(50000, builder.text());
    file.features.add("POSITION", std::vector<float>(150000, 1.0f));
    EXPECT_NE(reasonOf(file).find("instances would need more memory"), std::string::npos);
}

TEST(I3dm, PlacesThatAreNoNumbersLeaveThoseInstancesOut) {
    TileFile file = i3dmOf(3, markerGlb());
    file.features.json["EAST_NORTH_UP"] = true;
    file.features.add<float>("POSITION", {NAN, 0, 0, INFINITY, 1, 1, 6378137, 0, 0});
    const auto content = decode(file.text());
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.triangles, 1u);
    EXPECT_EQ(content->facts.invalid, 2u);
}

TEST(I3dm, CutAtAnyLengthItFailsWithAReason) {
    TileFile file = i3dmOf(1, markerGlb());
    file.features.add<float>("POSITION", {1, 2, 3});
    file.features.add<float>("SCALE", {2});
    file.batchJson = R"({"a":[1]}   )";
    cutEverywhere(file.text(), [](const Result<TileContent>& content, std::size_t n) {
        ASSERT_FALSE(content) << n;
        EXPECT_EQ(content.error().reason.find('\n'), std::string::npos);
    });
}

} // namespace gnomon
