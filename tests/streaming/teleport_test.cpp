// Jumps about a city for a long time: nothing may grow that does not come back, and the memory that
// was given is never passed, by whatever layer.
#include "tests/streaming/far_source.h"

#include <gtest/gtest.h>

#include <fstream>

#include <malloc.h>

namespace gnomon {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr int kSide = 24; // tiles along a side
constexpr double kTileMetres = 50.0;

std::string square(double x0, double y0, double half) {
    return R"("boundingVolume":{"box":[)" + number(x0 + half) + "," + number(y0 + half) + ",50," +
           number(half) + ",0,0, 0," + number(half) + ",0, 0,0,50]}";
}

// A quadtree of three levels that refine by replacing; sizes differ from tile to tile.
void addTiles(MemorySource& source, std::string& out, double x, double y, double size, int level) {
    const std::string uri =
        "c" + std::to_string(level) + "_" + std::to_string(int(x)) + "_" + std::to_string(int(y));
    source.files[uri + ".glb"] = glb(5 + unsigned(x * 7 + y * 13) % 60);
    std::string children;
    if (level < 3)
        for (const double dx : {0.0, 0.5})
            for (const double dy : {0.0, 0.5}) {
                if (!children.empty())
                    children += ",";
                addTiles(source, children, x + dx * size, y + dy * size, size / 2, level + 1);
            }
    out += tile(square(x, y, size / 2), level < 3 ? size / 4 : 0.0, uri + ".glb", children,
                level == 0 ? R"("refine":"REPLACE")" : "");
}

std::shared_ptr<MemorySource> quadtree() {
    auto source = std::make_shared<MemorySource>();
    std::string root;
    addTiles(*source, root, 0, 0, kSide * kTileMetres, 0);
    source->files["tileset.json"] = bytesOf(tileset(root));
    return source;
}

// Terrain that is made: a grid, all of one size.
struct Grid : ContentMaker {
    Result<TileContent> make(const std::string&, const DecodeOptions&) const override {
        TileContent content;
        Mesh& mesh = content.meshes.emplace_back();
        for (int i = 0; i < 64; ++i)
            mesh.positions.emplace_back(i % 8, i / 8, 0);
        mesh.normals.resize(64);
        content.materials.emplace_back();
        return content;
    }
    std::string describe(const std::string& path) const override { return path; }
};

MadeTileset grid() {
    MadeTileset made;
    made.maker = std::make_shared<Grid>();
    const auto boxAt = [](double x, double y, double half) {
        return BoundingVolume(OrientedBox{{{x, y, 0}}, glm::dmat3(half)});
    };
    const double middle = kSide * kTileMetres / 2;
    made.tiles.push_back(
        {kNoTile, Refine::Add, ContentKind::None, 1000.0, boxAt(middle, middle, middle), {}});
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            made.tiles.push_back(
                {0, Refine::Replace, ContentKind::Mesh, 0.0,
                 boxAt((x + 0.5) * kTileMetres, (y + 0.5) * kTileMetres, kTileMetres / 2),
                 std::to_string(x) + "_" + std::to_string(y)});
    return made;
}

View viewAt(double x, double y, double reach) {
    View view = viewFrom(x, y, 60);
    view.planes = {{{{1, 0, 0}}, {{x - reach, 0, 0}}},
                   {{{-1, 0, 0}}, {{x + reach, 0, 0}}},
                   {{{0, 1, 0}}, {{0, y - reach, 0}}},
                   {{{0, -1, 0}}, {{0, y + reach, 0}}}};
    return view;
}

std::size_t residentBytes() {
    ::malloc_trim(0);
    std::ifstream statm("/proc/self/statm");
    std::size_t size = 0, resident = 0;
    statm >> size >> resident;
    return resident * 4096;
}

// Copies that are only counted, as a GPU would hold them.
struct Copies {
    std::vector<std::map<TileIndex, std::size_t>> tiles;
    std::size_t bytes = 0, most = 0;
};
std::size_t copyBytes(const TileContent& content) {
    return content.bytes() * 3 / 4;
}

class Teleports : public ::testing::Test {
  protected:
    // Two layers of one ledger.
    void open(std::size_t capBytes, bool keepsDecoded) {
        LoaderOptions options;
        options.workers = 2;
        options.ledger = ledger_ = std::make_shared<MemoryLedger>(capBytes);
        city_ = std::move(*StreamedTileset::open(quadtree(), "tileset.json", {}, options));
        terrain_ = std::move(*StreamedTileset::ofMade(grid(), "terrain", options));
        both_ = {city_.get(), terrain_.get()};
        copies_.tiles.resize(2);
        for (std::size_t i = 0; i < 2; ++i) {
            both_[i]->setResidence({&copyBytes, keepsDecoded});
            both_[i]->onDrop([this, i](TileIndex tile) {
                const auto at = copies_.tiles[i].find(tile);
                if (at == copies_.tiles[i].end())
                    return;
                copies_.bytes -= at->second;
                copies_.tiles[i].erase(at);
            });
        }
    }
    void copy(std::size_t layer, TileIndex tile) {
        const auto content = both_[layer]->content(tile);
        if (!content || copies_.tiles[layer].contains(tile))
            return;
        copies_.bytes += copies_.tiles[layer][tile] = copyBytes(*content);
        copies_.most = std::max(copies_.most, copies_.bytes);
        both_[layer]->copied(tile);
    }
    SettledAll settleAt(const View& view, double error) {
        return settle(both_, {std::span(&view, 1),
                              {error, false},
                              soon(),
                              nullptr,
                              [this](std::size_t layer, TileIndex tile) { copy(layer, tile); }});
    }
    // One frame of a capture. The error it was drawn with.
    double jump(double x, double y, double reach) {
        const View view = viewAt(x, y, reach);
        double error = 2.0;
        SettledAll settled = settleAt(view, error);
        while (settled.overBudget && error < 1e6) {
            error *= 1.5;
            settled = settleAt(view, error);
        }
        EXPECT_TRUE(settled.complete);
        for (std::size_t i = 0; i < 2; ++i)
            for (const TileIndex tile : settled.selections[i].draw)
                EXPECT_TRUE(copies_.tiles[i].contains(tile));
        return error;
    }
    void expectTheBooksToBalance() {
        // What was being decoded when a view was given up comes in first.
        for (StreamedTileset* tileset : both_)
            while (!tileset->idle()) {
                tileset->wait(10ms);
                tileset->rest();
            }
        EXPECT_LE(ledger_->most(), ledger_->cap());
        EXPECT_EQ(ledger_->held(MemoryLedger::Use::Decoding), 0u);
        EXPECT_EQ(ledger_->held(MemoryLedger::Use::Decoded),
                  city_->decodedBytes() + terrain_->decodedBytes());
        EXPECT_EQ(ledger_->held(MemoryLedger::Use::Gpu), city_->gpuBytes() + terrain_->gpuBytes());
        EXPECT_GE(ledger_->held(MemoryLedger::Use::Gpu), copies_.bytes); // room is kept for some
    }
    std::uint64_t loaded() const { return city_->tilesLoaded() + terrain_->tilesLoaded(); }

    std::shared_ptr<MemoryLedger> ledger_;
    std::unique_ptr<StreamedTileset> city_, terrain_;
    std::vector<StreamedTileset*> both_;
    Copies copies_;
};

TEST_F(Teleports, TenThousandLeaveNothingBehind) {
    open(200'000, false);
    std::uint32_t random = 1;
    const auto next = [&] { return (random = random * 1664525u + 1013904223u) >> 8; };
    const auto teleport = [&] {
        const double x = next() % unsigned(kSide * kTileMetres);
        const double y = next() % unsigned(kSide * kTileMetres);
        return jump(x, y, 50.0 + next() % 50);
    };
    for (int i = 0; i < 500; ++i)
        teleport();
    expectTheBooksToBalance();
    const std::size_t resident = residentBytes();
    std::size_t mostTiles = 0;
    for (int i = 0; i < 10'000; ++i) {
        EXPECT_EQ(teleport(), 2.0);
        mostTiles = std::max(mostTiles, copies_.tiles[0].size() + copies_.tiles[1].size());
        if (i % 500 == 0)
            expectTheBooksToBalance();
        if (HasFailure())
            break;
    }
    const std::size_t after = residentBytes();
    std::printf("%llu tiles loaded, at most %zu live, %zu of %zu bytes; resident %.1f MB, then "
                "%.1f MB\n",
                static_cast<unsigned long long>(loaded()), mostTiles, ledger_->most(),
                ledger_->cap(), double(resident) / 1e6, double(after) / 1e6);
    EXPECT_GT(loaded(), 50'000u) << "the memory was not small";
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) // they keep what was freed
    EXPECT_LT(double(after), double(resident) + 2e6);
#endif
    expectTheBooksToBalance();
    // Back to nothing.
    ledger_->nextMoment();
    EXPECT_TRUE(ledger_->makeRoom(ledger_->cap()));
    EXPECT_EQ(ledger_->held(), 0u);
    EXPECT_EQ(copies_.bytes, 0u);
    EXPECT_TRUE(city_->idle() && terrain_->idle());
}

TEST_F(Teleports, TheLayersShareOneCap) {
    open(400'000, true);
    // The terrain alone may have it all; then the city takes it.
    const View everywhere = viewAt(600, 600, 600);
    StreamedTileset* const terrain = terrain_.get();
    (void)settle(std::span(&terrain, 1), {std::span(&everywhere, 1), {2.0, false}, soon()});
    EXPECT_GT(ledger_->held(), ledger_->cap() / 2);
    EXPECT_EQ(city_->decodedBytes(), 0u);
    jump(300, 300, 100);
    EXPECT_GT(city_->decodedBytes(), 0u);
    EXPECT_LE(ledger_->most(), ledger_->cap());
}

TEST_F(Teleports, TheErrorGoesUpWhereAViewDoesNotFitAndComesDownAgain) {
    open(10'000'000, false);
    jump(600, 600, 500);
    const std::size_t terrain = terrain_->gpuBytes(), city = city_->gpuBytes();
    copies_ = {};
    city_.reset();
    terrain_.reset();
    open(terrain + city / 2, false); // the terrain has no coarser tiles
    const double near = jump(600, 600, 60);
    const double wide = jump(600, 600, 500);
    const double again = jump(600, 600, 60);
    const double wideAgain = jump(600, 600, 500);
    EXPECT_EQ(near, 2.0);
    EXPECT_GT(wide, 2.0);
    EXPECT_LT(wide, 1e3);
    EXPECT_EQ(again, 2.0);
    EXPECT_EQ(wideAgain, wide) << "the same whatever was drawn before";
    expectTheBooksToBalance();
}

TEST_F(Teleports, WhatDoesNotFitAtAllIsSaidAndNothingPassesTheCap) {
    open(3'000, false);
    const View view = viewAt(600, 600, 500);
    const SettledAll settled = settleAt(view, 1e6);
    EXPECT_TRUE(settled.overBudget);
    EXPECT_FALSE(settled.complete);
    EXPECT_LE(ledger_->most(), ledger_->cap());
}

TEST_F(Teleports, AWindowStaysWithinTheCapToo) {
    open(150'000, true);
    std::uint32_t random = 1;
    const auto next = [&] { return (random = random * 1664525u + 1013904223u) >> 8; };
    for (int i = 0; i < 300; ++i) {
        const View view =
            viewAt(next() % 1200, next() % 1200, i % 10 == 9 ? 500.0 : 60.0 + next() % 100);
        for (int frame = 0; frame < 5; ++frame) {
            ledger_->nextMoment();
            for (std::size_t layer = 0; layer < 2; ++layer) {
                StreamedTileset& tileset = *both_[layer];
                tileset.poll();
                const Selection selection =
                    select(tileset.tree(), std::span(&view, 1), {2.0, true});
                tileset.use(selection.draw);
                for (const TileIndex tile : selection.draw)
                    copy(layer, tile);
                tileset.request(selection.load);
            }
            both_[0]->wait(2ms);
        }
        ASSERT_LE(ledger_->most(), ledger_->cap());
    }
    for (StreamedTileset* tileset : both_) {
        tileset->request({});
        while (tileset->wait(1000ms))
            tileset->poll();
    }
    EXPECT_EQ(ledger_->held(MemoryLedger::Use::Decoding), 0u);
    EXPECT_GE(ledger_->held(MemoryLedger::Use::Gpu), copies_.bytes);
}

TEST_F(Teleports, QuittingBetweenLeavesTheLedgerEmpty) {
    for (int i = 0; i < 50; ++i) {
        open(150'000, i % 2 == 0);
        const View view = viewAt(10 * i, 600, 200);
        for (StreamedTileset* tileset : both_) {
            const Selection selection = select(tileset->tree(), std::span(&view, 1), {2.0, false});
            tileset->request(selection.load);
        }
        if (i % 3)
            std::this_thread::sleep_for(std::chrono::microseconds(i * 40));
        city_.reset();
        terrain_.reset();
        ASSERT_EQ(ledger_->held(), 0u);
    }
}

} // namespace
} // namespace gnomon
