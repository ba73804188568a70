// The place as gnomon's own reader sees it.
#include "geo/view.h"
#include "streaming/content.h"
#include "streaming/loader.h"
#include "viewer/place/flight.h"
#include "viewer/place/place.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <unistd.h>

namespace gnomon {
namespace {

namespace fs = std::filesystem;

class OpenedPlace : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = fs::temp_directory_path() / ("gnomon_opened_place_" + std::to_string(::getpid()));
        PlaceOptions options;
        options.folder = folder_.string();
        options.buildings = 60;
        const auto facts = writePlace(options);
        ASSERT_TRUE(facts) << facts.error().message();
        facts_ = *facts;
    }
    static void TearDownTestSuite() { fs::remove_all(folder_); }

    static inline fs::path folder_;
    static inline PlaceFacts facts_;
};

TEST_F(OpenedPlace, IsReadWholeAndItsSolidsAreClosed) {
    const auto source = fileSource(folder_.string());
    std::size_t tiles = 0;
    std::uint64_t leafTriangles = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "content")) {
        const std::string name = "content/" + entry.path().filename().string();
        const auto bytes = source->read(name);
        ASSERT_TRUE(bytes);
        const auto content = decodeContent(*bytes, name, {});
        ASSERT_TRUE(content) << content.error().message();
        EXPECT_EQ(content->facts.duplicates, 0u) << name;
        EXPECT_EQ(content->facts.degenerate, 0u) << name;
        EXPECT_EQ(content->facts.invalid, 0u) << name;
        EXPECT_TRUE(content->facts.warnings.empty())
            << name << ": " << content->facts.warnings.front();
        EXPECT_FALSE(content->meshes.empty());
        ++tiles;
        if (entry.path().filename().string().starts_with(std::to_string(facts_.levels - 1)))
            leafTriangles += content->facts.triangles;
    }
    EXPECT_EQ(tiles, facts_.tiles);
    EXPECT_GT(leafTriangles, 0u);
}

TEST_F(OpenedPlace, HasOpenTerrainAndShedsAndNothingElseOpen) {
    const auto source = fileSource(folder_.string());
    // The tower's tile: a terrain, no shed; all the rest is closed.
    const std::string leaf = std::to_string(facts_.levels - 1);
    const std::string name = "content/" + leaf + ".2.2.glb";
    const auto bytes = source->read(name);
    ASSERT_TRUE(bytes);
    const auto content = decodeContent(*bytes, name, {});
    ASSERT_TRUE(content) << content.error().message();
    const auto& facts = content->facts;
    constexpr std::uint64_t kTerrain = 2048;
    EXPECT_EQ(facts.triangles - facts.closedTriangles, kTerrain);
    EXPECT_EQ(facts.components - facts.closedComponents, 1u);
    EXPECT_GT(facts.closedComponents, 50u);
}

TEST_F(OpenedPlace, SettlesForTheFirstAndTheLastFrameOfItsFlight) {
    LoaderOptions options;
    options.workers = 1;
    auto opened = StreamedTileset::open(fileSource(folder_.string()), "tileset.json", {}, options);
    ASSERT_TRUE(opened) << opened.error().message();
    const builtin::Plan plan(1, 60);
    const auto keys = builtin::flight(plan);
    const auto ecefFromPlace = ecefFromEnu(PlaceOptions{}.at);
    for (const auto* key : {&keys.front(), &keys.back()}) {
        Camera camera;
        camera.position = ecefFromPlace(Point<Enu>{key->position});
        camera.forward = ecefFromPlace(Vector<Enu>{glm::normalize(key->target - key->position)});
        camera.right = normalize(cross(camera.forward, ecefFromPlace(Vector<Enu>{{0, 0, 1}})));
        camera.up = cross(camera.right, camera.forward);
        const std::array views{perspectiveView(camera)};
        const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
        const Settled settled = settle(**opened, views, {8.0}, deadline);
        EXPECT_TRUE(settled.complete);
        EXPECT_TRUE(settled.selection.failed.empty());
        EXPECT_GT(settled.selection.draw.size(), 2u);
    }
    EXPECT_TRUE((*opened)->failures().empty());
}

} // namespace
} // namespace gnomon
