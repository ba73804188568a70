// Tiles on their way to the GPU and off it again: within the memory that was given, a little at a
// time in a window, and nothing left behind however often the camera jumps.
#include "tests/frame/small_scene.h"
#include "viewer/place/place.h"
#include "viewer/tile_cache.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include <malloc.h>

namespace gnomon {
namespace {

using namespace std::chrono_literals;
using test::softwareContext;

constexpr std::size_t kMegabyte = 1'000'000;

std::size_t residentBytes() {
    ::malloc_trim(0);
    std::ifstream statm("/proc/self/statm");
    std::size_t size = 0, resident = 0;
    statm >> size >> resident;
    return resident * 4096;
}

class Streaming : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new test::Folder;
        PlaceOptions options;
        options.folder = *folder_ / "place";
        options.buildings = 400;
        ASSERT_TRUE(writePlace(options));
    }
    static void TearDownTestSuite() {
        delete folder_;
        folder_ = nullptr;
    }

    void open(std::size_t memoryBytes, bool keepContents) {
        renderer_.reset();
        SceneOptions open;
        open.inputs = {*folder_ / "place/tileset.json"};
        open.loader.memoryBytes = memoryBytes;
        open.loader.workers = 2;
        scene_.emplace(test::mustOpen(open));
        options_.shadows.mapSize = 256;
        options_.keepContents = keepContents;
        options_.maximumScreenSpaceError = 4.0;
        renderer_ = std::move(FrameRenderer::create(softwareContext(), *scene_, options_)).value();
    }
    MemoryLedger& ledger() { return scene_->layers[0].tileset->ledger(); }

    FrameRequest request(const glm::dvec3& eye, const glm::dvec3& target, bool wait = true) const {
        FrameRequest request;
        request.camera = test::cameraFor(scene_->ecefFromAnchor, {eye, target, 45.0, 96, 54});
        request.sun = sunFromAngles(220, 40, scene_->anchor);
        request.deadline = std::chrono::steady_clock::now() + 1min;
        request.waitForTiles = wait;
        return request;
    }
    FrameRequest jump(std::uint32_t& random) const {
        const auto next = [&] { return double((random = random * 1664525u + 1013904223u) >> 8); };
        const double reach = scene_->radiusMetres * 0.7;
        const auto anywhere = [&] { return (next() / double(1u << 24) - 0.5) * 2.0 * reach; };
        const double x = anywhere(), y = anywhere();
        return request({x, y, 60}, {x + 15, y + 10, 0});
    }

    static inline test::Folder* folder_ = nullptr;
    std::optional<Scene> scene_;
    FrameOptions options_;
    std::unique_ptr<FrameRenderer> renderer_;
};

TEST_F(Streaming, ATileTakesOnTheGpuWhatItsContentSays) {
    open(2000 * kMegabyte, true);
    ASSERT_TRUE(renderer_->draw(request({0, 0, 150}, {200, 100, 0})));
    std::size_t looked = 0;
    for (const ResidentTile& tile : renderer_->residentTiles()) {
        std::vector<std::string> warnings;
        const render::GpuTile copy(*tile.content, warnings);
        EXPECT_EQ(render::GpuTile::bytesOf(*tile.content), copy.bytes());
        ++looked;
    }
    EXPECT_GT(looked, 5u);
    // And of a texture.
    TileContent painted;
    painted.images.push_back({5, 3, std::vector<std::uint8_t>(5 * 3 * 4)});
    for (int i = 0; i < 2; ++i) {
        painted.materials.emplace_back();
        painted.materials.back().image = 0;
    }
    std::vector<std::string> warnings;
    EXPECT_EQ(render::GpuTile::bytesOf(painted), render::GpuTile(painted, warnings).bytes());
}

TEST_F(Streaming, ACaptureKeepsOneCopyOfEachTileOnly) {
    open(2000 * kMegabyte, true);
    const FrameRequest view = request({0, 0, 150}, {200, 100, 0});
    const auto both = renderer_->draw(view);
    ASSERT_TRUE(both && both->complete);
    const Picture with = renderer_->picture();
    EXPECT_GT(both->decodedBytes, kMegabyte);
    open(2000 * kMegabyte, false);
    const auto one = renderer_->draw(view);
    ASSERT_TRUE(one && one->complete);
    EXPECT_LT(double(one->decodedBytes), 0.1 * double(both->decodedBytes)); // the ground was sought
    EXPECT_EQ(one->gpuBytes, both->gpuBytes);
    EXPECT_EQ(one->tilesSelected, both->tilesSelected);
    EXPECT_LT(double(one->mostTileBytes), 0.8 * double(both->mostTileBytes));
    EXPECT_EQ(renderer_->picture().rgb, with.rgb);
}

TEST_F(Streaming, TeleportsLeaveNothingBehindAndStayWithinTheCap) {
    open(2000 * kMegabyte, false);
    std::uint32_t random = 7;
    for (int i = 0; i < 12; ++i) {
        const auto facts = renderer_->draw(jump(random));
        ASSERT_TRUE(facts && facts->complete);
    }
    const std::size_t all = ledger().held();
    open(all * 6 / 10, false);
    random = 7;
    std::size_t resident = 0;
    std::uint64_t loaded = 0;
    for (int i = 0; i < 60; ++i) {
        const auto facts = renderer_->draw(jump(random));
        ASSERT_TRUE(facts);
        EXPECT_TRUE(facts->complete);
        EXPECT_LE(ledger().most(), ledger().cap());
        EXPECT_EQ(ledger().held(MemoryLedger::Use::Decoding), 0u);
        loaded = facts->tilesLoaded;
        if (i == 20)
            resident = residentBytes();
    }
    EXPECT_GT(loaded, 150u) << "nothing had to go";
    EXPECT_LT(double(residentBytes()), double(resident) + 15e6);
    ledger().nextMoment();
    EXPECT_TRUE(ledger().makeRoom(ledger().cap() - ledger().held(MemoryLedger::Use::Other)));
    EXPECT_EQ(ledger().held(MemoryLedger::Use::Gpu), 0u);
}

TEST_F(Streaming, AViewThatDoesNotFitIsDrawnCoarserAndTheNextOneFineAgain) {
    open(2000 * kMegabyte, false);
    const FrameRequest near = request({0, 0, 40}, {40, 40, 0});
    const FrameRequest wide = request({0, -900, 700}, {0, 0, 0});
    const auto nearFacts = renderer_->draw(near);
    const auto wideFacts = renderer_->draw(wide);
    ASSERT_TRUE(nearFacts && wideFacts);
    const std::size_t needNear = nearFacts->gpuBytes;
    open(needNear + needNear / 4, false);
    for (int i = 0; i < 2; ++i) {
        const auto fine = renderer_->draw(near);
        ASSERT_TRUE(fine && fine->complete);
        EXPECT_EQ(fine->screenSpaceError, options_.maximumScreenSpaceError);
        options_.maximumScreenSpaceError = 0.05; // more than there is room for
        renderer_->setOptions(options_);
        const auto coarse = renderer_->draw(wide);
        ASSERT_TRUE(coarse);
        EXPECT_TRUE(coarse->complete);
        EXPECT_FALSE(coarse->overBudget);
        EXPECT_GT(coarse->screenSpaceError, 0.05);
        EXPECT_LE(ledger().most(), ledger().cap());
        options_.maximumScreenSpaceError = 4.0;
        renderer_->setOptions(options_);
    }
}

TEST_F(Streaming, WithNoRoomForTheCoarsestThereIsNoPicture) {
    open(100'000, false);
    const auto facts = renderer_->draw(request({0, 0, 150}, {200, 100, 0}));
    ASSERT_TRUE(facts);
    EXPECT_TRUE(facts->overBudget);
    EXPECT_FALSE(facts->complete);
}

TEST_F(Streaming, AWindowComesToTheSamePictureALittleAtATime) {
    open(2000 * kMegabyte, true);
    const glm::dvec3 eye(0, 0, 150), target(200, 100, 0);
    ASSERT_TRUE(renderer_->draw(request(eye, target)));
    const Picture whole = renderer_->picture();
    open(2000 * kMegabyte, true);
    const auto first = renderer_->draw(request(eye, target, false));
    ASSERT_TRUE(first);
    EXPECT_FALSE(first->complete);
    int frames = 1;
    for (bool complete = false; !complete && frames < 2000; ++frames) {
        const auto facts = renderer_->draw(request(eye, target, false));
        ASSERT_TRUE(facts);
        complete = facts->complete;
        std::this_thread::sleep_for(1ms);
    }
    EXPECT_LT(frames, 2000);
    EXPECT_EQ(renderer_->picture().rgb, whole.rgb);
}

TEST_F(Streaming, UploadsAreSpreadOverFrames) {
    open(2000 * kMegabyte, true);
    StreamedTileset& tileset = *scene_->layers[0].tileset;
    const FrameRequest view = request({0, 0, 150}, {200, 100, 0});
    const View camera = perspectiveView(view.camera);
    const Settled settled = settle(tileset, {&camera, 1}, {4.0, false}, view.deadline);
    ASSERT_TRUE(settled.complete);
    const std::vector<Selection> selections{settled.selection};
    const std::size_t tiles = settled.selection.draw.size();
    ASSERT_GT(tiles, 5u);
    TileCache cache(*scene_);
    std::size_t frames = 0, before = 0;
    do {
        (void)cache.items(selections, 0us); // no time at all: a little a frame
        ASSERT_LE(cache.tiles(), before + 1);
        before = cache.tiles();
        ++frames;
    } while (cache.leftOut() && frames < 10000);
    EXPECT_EQ(cache.tiles(), tiles);
    EXPECT_GT(frames, tiles) << "no tile came in parts";
    std::size_t bytes = 0;
    for (const TileIndex tile : settled.selection.draw)
        bytes += render::GpuTile::bytesOf(*tileset.content(tile));
    EXPECT_EQ(cache.gpuBytes(), bytes);
    tileset.release(settled.selection.draw.front());
    EXPECT_EQ(cache.tiles(), tiles - 1);
}

TEST_F(Streaming, AWindowThatCannotHoldItsViewGetsCoarserAndFinerAgain) {
    open(2000 * kMegabyte, true);
    const auto whole = renderer_->draw(request({0, 0, 40}, {40, 40, 0}));
    ASSERT_TRUE(whole);
    open(2 * (whole->decodedBytes + whole->gpuBytes), true);
    options_.maximumScreenSpaceError = 0.5;
    renderer_->setOptions(options_);
    const auto drawUntil = [&](const glm::dvec3& eye, const glm::dvec3& target,
                               const auto& isDone) {
        for (int frame = 0; frame < 500; ++frame) {
            const auto facts = renderer_->draw(request(eye, target, false));
            if (!facts || ledger().most() > ledger().cap())
                return false;
            if (frame % 50 == 0)
                std::printf("%d: sse %g complete %d sel %u loaded %d held %zu cap %zu wait %zu\n",
                            frame, facts->screenSpaceError, facts->complete, facts->tilesSelected,
                            int(facts->tilesLoaded), ledger().held(), ledger().cap(),
                            ledger().waitingBytes());
            if (isDone(*facts))
                return true;
            std::this_thread::sleep_for(1ms);
        }
        return false;
    };
    EXPECT_TRUE(drawUntil({0, -500, 300}, {0, 0, 0}, [](const FrameFacts& facts) {
        return facts.complete && facts.screenSpaceError > 0.5;
    })) << "it never came to rest within the memory";
    EXPECT_TRUE(drawUntil({0, 0, 4000}, {0, 1, 9000}, [](const FrameFacts& facts) {
        return facts.complete && facts.screenSpaceError == 0.5;
    })) << "it stays coarse where it need not";
}

} // namespace
} // namespace gnomon
