// b3dm, placing on the Earth and cutting into meshes.
#include "glb_builder.h"

#include "geo/ellipsoid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gnomon {

using namespace test;

namespace {

GlbBuilder triangle() {
    GlbBuilder builder;
    builder.triangles({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2});
    return builder;
}

glm::dvec3 firstCorner(const Result<TileContent>& content) {
    const Mesh& mesh = content.value().meshes.at(0);
    return vertex(mesh, mesh.indices[0]);
}

// A grid of squares in the plane z = 0.
GlbBuilder grid(int side, float spacing) {
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    for (int y = 0; y <= side; ++y) {
        for (int x = 0; x <= side; ++x) {
            positions.insert(positions.end(), {float(x) * spacing, float(y) * spacing, 0.0f});
            if (x < side && y < side) {
                const auto i = std::uint32_t(y * (side + 1) + x), up = i + std::uint32_t(side) + 1;
                indices.insert(indices.end(), {i, i + 1, up, up, i + 1, up + 1});
            }
        }
    }
    GlbBuilder builder;
    builder.triangles(positions, indices);
    return builder;
}

} // namespace

TEST(B3dm, GivesItsTablesAndItsGeometry) {
    GlbBuilder builder = triangle();
    const std::string table = R"({"name":["a","b"]})";
    const auto content =
        decode(b3dmOf(builder.text(), R"({"BATCH_LENGTH":2,"RTC_CENTER":[1000000.5,2,3]})", table));
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_EQ(content->facts.format, "b3dm");
    ASSERT_TRUE(content->features);
    ASSERT_EQ(content->features->rows(), 2u);
    EXPECT_EQ(content->features->row(1)[0].value, PropertyValue("b"));
    EXPECT_LT(glm::distance(firstCorner(content), glm::dvec3(1000000.5, 2, 3)), 1e-6);
}

TEST(B3dm, ReadsAnRtcCenterKeptInBinary) {
    const float center[3] = {64.0f, 128.0f, -256.0f};
    const std::string binary(reinterpret_cast<const char*>(center), sizeof center);
    const std::string feature = R"({"BATCH_LENGTH":0,"RTC_CENTER":{"byteOffset":0}})";
    auto content = decode(b3dmOf(triangle().text(), feature, "", binary));
    ASSERT_TRUE(content) << content.error().message();
    EXPECT_LT(glm::distance(firstCorner(content), glm::dvec3(64, 128, -256)), 1e-6);
    content = decode(b3dmOf(triangle().text(), feature, "", binary.substr(0, 8)));
    ASSERT_FALSE(content);
    EXPECT_NE(content.error().reason.find("RTC_CENTER"), std::string::npos);
}

TEST(B3dm, TheGlbInsideNeedNotBeAligned) {
    for (int shift = 0; shift < 8; ++shift) {
        const auto content = decode(b3dmOf(
            triangle().text(), R"({"BATCH_LENGTH":0})" + std::string(std::size_t(shift), ' ')));
        EXPECT_TRUE(content) << shift;
    }
}

TEST(B3dm, OldHeadersOf20And24BytesAreKnownByWhatFollows) {
    const std::string glb = triangle().text(), table = R"({"id":[1]} )";
    for (const bool withTable : {true, false}) {
        const std::string json = withTable ? table : "";
        std::string first = "b3dm"; // version, length, batch length, batch table length
        put(first, 1);
        put(first, std::uint32_t(20 + json.size() + glb.size()));
        put(first, 1);
        put(first, std::uint32_t(json.size()));
        auto content = decode(first + json + glb);
        ASSERT_TRUE(content) << content.error().message();
        EXPECT_EQ(content->facts.triangles, 1u);
        ASSERT_TRUE(content->features);
        ASSERT_EQ(content->features->row(0).size(), withTable ? 1u : 0u);
        if (withTable) {
            EXPECT_EQ(content->features->row(0)[0].value, PropertyValue(std::int64_t(1)));
        }

        std::string second = "b3dm"; // then batch table JSON, binary, batch length
        put(second, 1);
        put(second, std::uint32_t(24 + json.size() + 8 + glb.size()));
        put(second, std::uint32_t(json.size()));
        put(second, withTable ? 8 : 0);
        put(second, 1);
        content = decode(second + json + (withTable ? std::string(8, '\1') : "") + glb +
                         (withTable ? "" : std::string(8, '\0')));
        ASSERT_TRUE(content) << content.error().message();
        EXPECT_EQ(content->facts.triangles, 1u);
        ASSERT_TRUE(content->features);
        ASSERT_EQ(content->features->row(0).size(), withTable ? 1u : 0u);
        if (withTable) {
            EXPECT_EQ(content->features->row(0)[0].value, PropertyValue(std::int64_t(1)));
        }
    }
}

TEST(B3dm, LengthsThatDisagreeAreNamed) {
    const std::string good = b3dmOf(triangle().text(), R"({"BATCH_LENGTH":0})");
    ASSERT_TRUE(decode(good));
    EXPECT_TRUE(decode(good + "trailing"));
    std::string longer = good;
    longer[8] = char(longer[8] + 1);
    ASSERT_FALSE(decode(longer));
    EXPECT_NE(decode(longer).error().reason.find("bytes"), std::string::npos);
    std::string tables = good;
    tables[14] = 1; // a feature table of 65 kB more
    EXPECT_FALSE(decode(tables));
    EXPECT_FALSE(decode(b3dmOf("")));
    EXPECT_FALSE(decode(b3dmOf("http://example/a.glb")));
}

TEST(Content, OtherFormatsAreRefusedByName) {
    for (const char* magic : {"i3dm", "pnts", "cmpt"}) {
        const auto content = decode(magic + std::string(40, '\0'));
        ASSERT_FALSE(content);
        EXPECT_NE(content.error().reason.find(magic), std::string::npos);
    }
    EXPECT_FALSE(decode(std::string()));
    EXPECT_FALSE(decode("hello"));
    std::string old = triangle().text();
    old[4] = 1;
    ASSERT_FALSE(decode(old));
    EXPECT_NE(decode(old).error().reason.find("version 1"), std::string::npos);
}

TEST(Content, FarFromTheOriginNoPrecisionIsLost) {
    DecodeOptions options = plain();
    const Geodetic cologne{6.96, 50.94, 60.0};
    options.ecefFromTile.matrix = ecefFromEnu(cologne).matrix;
    GlbBuilder builder;
    builder.triangles(boxCorners({10, 20, 0}, {13, 24, 9}), boxTriangles());
    const auto content = decode(builder, options);
    ASSERT_TRUE(content) << content.error().message();
    const Mesh& mesh = content->meshes.at(0);
    const Transform<Enu, Ecef> enuFromEcef = rigidInverse(ecefFromEnu(cologne));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::dvec3 p = enuFromEcef(Point<Ecef>{vertex(mesh, i)}).xyz;
        EXPECT_LT(std::min(std::abs(p.x - 10), std::abs(p.x - 13)), 1e-6);
        EXPECT_LT(std::min(std::abs(p.y - 20), std::abs(p.y - 24)), 1e-6);
        EXPECT_LT(std::min(std::abs(p.z - 0), std::abs(p.z - 9)), 1e-6);
    }
    EXPECT_LT(mesh.radiusMetres, 5.2);
    // The box lies along east, north and up, and is as tight as its three sides.
    EXPECT_NEAR(glm::length(mesh.box.halfAxes[0]), 1.5, 1e-4);
    EXPECT_NEAR(glm::length(mesh.box.halfAxes[1]), 2.0, 1e-4);
    EXPECT_NEAR(glm::length(mesh.box.halfAxes[2]), 4.5, 1e-4);
    EXPECT_NEAR(content->facts.areaVector.z, 0.0, 1e-9);
}

TEST(Content, ASmallTileIsOneMeshForEachMaterial) {
    GlbBuilder builder = grid(8, 30.0f);
    builder.root["materials"] = Json::array({Json::object(), Json::object()});
    Json second = builder.root["meshes"][0]["primitives"][0];
    second["material"] = 1;
    second["attributes"]["POSITION"] =
        builder.floats(boxCorners({0, 0, 1}, {200, 200, 30}), "VEC3");
    second["indices"] = builder.indices(boxTriangles());
    builder.root["meshes"][0]["primitives"].push_back(second);
    const auto content = decode(builder);
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_EQ(content->meshes.size(), 2u);
    EXPECT_EQ(content->meshes[0].closedTriangles, 0u);
    EXPECT_EQ(content->meshes[1].closedTriangles, 12u);
}

TEST(Content, ALargeTileIsCutAndNothingIsLost) {
    const auto content = decode(grid(200, 10.0f)); // 2 km
    ASSERT_TRUE(content);
    EXPECT_EQ(content->facts.triangles, 80000u);
    EXPECT_EQ(content->meshes.size(), 64u);
    double area = 0.0;
    for (const Mesh& mesh : content->meshes) {
        EXPECT_LT(mesh.radiusMetres, 200.0);
        ASSERT_EQ(mesh.faceNormals.size(), mesh.triangles());
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
        for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
            const glm::vec3 a = mesh.positions[mesh.indices[i]];
            area += 0.5 * glm::length(glm::cross(mesh.positions[mesh.indices[i + 1]] - a,
                                                 mesh.positions[mesh.indices[i + 2]] - a));
        }
        for (const glm::vec3& p : mesh.positions) { // inside the box, to rounding
            const glm::dvec3 d = mesh.origin.xyz + glm::dvec3(p) - mesh.box.centre.xyz;
            for (int axis = 0; axis < 3; ++axis) {
                const double half = glm::length(mesh.box.halfAxes[axis]);
                EXPECT_LE(std::abs(d[axis]), half + 1e-6);
            }
        }
    }
    EXPECT_NEAR(area, 4e6, 1.0);
    EXPECT_NEAR(content->facts.areaVector.z, 4e6, 1e-3);
}

TEST(Content, ClosedTrianglesComeFirst) {
    GlbBuilder builder;
    builder.triangles({50, 0, 0, 51, 0, 0, 50, 1, 0}, {0, 1, 2});
    builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    const auto content = decode(builder);
    ASSERT_TRUE(content);
    const Mesh& mesh = content->meshes.at(0);
    EXPECT_EQ(mesh.closedTriangles, 12u);
    EXPECT_EQ(mesh.triangles(), 13u);
    EXPECT_GT(vertex(mesh, mesh.indices[36]).x, 49.0);
}

TEST(Content, DecodesToTheSameBytesEveryTime) {
    const GlbBuilder builder = grid(60, 20.0f);
    const auto a = decode(builder), b = decode(builder);
    ASSERT_TRUE(a);
    ASSERT_EQ(a->meshes.size(), b->meshes.size());
    for (std::size_t i = 0; i < a->meshes.size(); ++i) {
        EXPECT_EQ(a->meshes[i].positions, b->meshes[i].positions);
        EXPECT_EQ(a->meshes[i].indices, b->meshes[i].indices);
        EXPECT_EQ(a->meshes[i].origin.xyz, b->meshes[i].origin.xyz);
    }
}

} // namespace gnomon
