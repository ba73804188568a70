// Decoding what others published. Skipped, by name, where the data is not there.
#include "glb_builder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>

namespace gnomon {

using namespace test;

namespace {

struct Sum {
    std::uint64_t tiles = 0, triangles = 0, duplicates = 0, degenerate = 0, invalid = 0, closed = 0;
    std::uint64_t withFeatures = 0;
    double seconds = 0.0;
};

std::vector<std::string> filesIn(const std::string& folder, const std::string& ending) {
    std::vector<std::string> out;
    std::error_code error;
    for (const auto& entry :
         std::filesystem::directory_iterator(dataFolder() + "/" + folder, error)) {
        if (entry.path().extension() == ending) {
            out.push_back(folder + "/" + entry.path().filename().string());
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

Sum decodeAll(const std::vector<std::string>& files, const DecodeOptions& options) {
    Sum sum;
    for (const std::string& file : files) {
        const Bytes bytes = bytesOf(*readData(file));
        const auto start = std::chrono::steady_clock::now();
        const auto content = decodeContent(bytes, file, options);
        sum.seconds +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        EXPECT_TRUE(content) << content.error().message();
        if (!content) {
            continue;
        }
        ++sum.tiles;
        sum.triangles += content->facts.triangles;
        sum.duplicates += content->facts.duplicates;
        sum.degenerate += content->facts.degenerate;
        sum.invalid += content->facts.invalid;
        sum.closed += content->facts.closedTriangles;
        for (const Mesh& mesh : content->meshes) {
            sum.withFeatures += !mesh.features.empty();
        }
    }
    return sum;
}

} // namespace

TEST(RealContent, AmsterdamStoresEveryTriangleTwice) {
    const auto files = filesIn("tiles-amsterdam-b3dm/tiles", ".b3dm");
    if (files.empty()) {
        GTEST_SKIP() << "tiles-amsterdam-b3dm is not here";
    }
    const Sum sum = decodeAll(files, {});
    EXPECT_EQ(sum.tiles, 10u);
    EXPECT_EQ(sum.triangles, 17433u);
    EXPECT_EQ(sum.duplicates, 17669u); // a few even more than twice
    EXPECT_EQ(sum.invalid, 0u);
    EXPECT_LT(sum.closed, 16u); // buildings without floors
    EXPECT_GT(sum.withFeatures, 0u);
    EXPECT_LT(sum.seconds, 2.0); // 0.03 s, unless a sanitizer is looking
}

TEST(RealContent, DelawareIsDracoThroughout) {
    const auto files = filesIn("tiles-delaware-implicit/content", ".b3dm");
    if (files.empty()) {
        GTEST_SKIP() << "tiles-delaware-implicit is not here";
    }
    const Sum sum = decodeAll(files, {});
    EXPECT_EQ(sum.tiles, 59u);
    EXPECT_EQ(sum.triangles, 438462u);
    EXPECT_EQ(sum.invalid, 0u);
}

TEST(RealContent, MarsIsTexturedTerrainWhoseAreaTellsThatYIsUp) {
    const auto file = readData("tiles-mars-terrain-replace/root.b3dm");
    if (!file) {
        GTEST_SKIP() << "tiles-mars-terrain-replace is not here";
    }
    const auto content = decode(*file); // its tileset says z up, which is not so
    ASSERT_TRUE(content) << content.error().message();
    ASSERT_EQ(content->images.size(), 1u);
    EXPECT_EQ(content->images[0].width, 256);
    EXPECT_EQ(content->facts.closedTriangles, 0u);
    const glm::dvec3 up = glm::normalize(content->facts.areaVector);
    EXPECT_GT(up.y, 0.99);
    ASSERT_FALSE(content->meshes.empty());
    EXPECT_EQ(content->meshes[0].uvs.size(), content->meshes[0].positions.size());
}

TEST(RealContent, ReadsTheSamplesOfEveryCompression) {
    const auto decodeFile = [](const std::string& folder, const std::string& name) {
        DecodeOptions options;
        options.readUri = [&](const std::string& uri) -> Result<Bytes> {
            const auto file = readData(folder + uri);
            return file ? Result<Bytes>(bytesOf(*file)) : Result<Bytes>(Error{uri, "not there"});
        };
        return decode(*readData(folder + name), options);
    };
    if (!readData("gltf-cesium-native/DucksMeshopt/Duck.glb")) {
        GTEST_SKIP() << "gltf-cesium-native is not here";
    }
    auto truck = decodeFile("gltf-cesium-native/DracoCompressed/", "CesiumMilkTruck.gltf");
    ASSERT_TRUE(truck) << truck.error().message();
    EXPECT_EQ(truck->facts.triangles, 3624u);
    EXPECT_EQ(truck->images.at(0).width, 2048);
    auto webp = decodeFile("gltf-cesium-native/BoxTexturedWebp/", "BoxTexturedWebp.gltf");
    ASSERT_TRUE(webp) << webp.error().message();
    EXPECT_EQ(webp->images.at(0).width, 256);
    EXPECT_EQ(webp->facts.closedTriangles, 12u);
    auto duck = decodeFile("gltf-cesium-native/DucksMeshopt/", "Duck.glb");
    ASSERT_TRUE(duck) << duck.error().message();
    EXPECT_EQ(duck->facts.closedTriangles, 4212u);
}

} // namespace gnomon
