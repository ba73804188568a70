// Tiles asked for ahead come early and change nothing else: the same flight gives the same trees,
// the same tiles and the same errors, whatever came when.
#include "tests/streaming/far_source.h"

#include <gtest/gtest.h>

namespace gnomon {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr int kBlocks = 16;
constexpr double kBlockMetres = 100.0;

// A long street of external tilesets, each of four more known by their content only, with houses;
// some are broken, some missing.
std::shared_ptr<FarSource> street() {
    auto source = std::make_shared<FarSource>();
    std::string blocks;
    for (int i = 0; i < kBlocks; ++i) {
        const double x0 = i * kBlockMetres;
        const std::string block = "e" + std::to_string(i);
        blocks += (i ? "," : "") + tile(box(x0, x0 + kBlockMetres), 90, block + ".json");
        std::string parts;
        for (int k = 0; k < 4; ++k) {
            const std::string part = block + "p" + std::to_string(k);
            const double x = x0 + k * 25;
            parts += (k ? "," : "") + tile(box(x, x + 25), 40, part);
            std::string houses;
            for (int h = 0; h < 5; ++h) {
                const std::string house = part + "h" + std::to_string(h) + ".glb";
                houses += (h ? "," : "") + tile(box(x + 5 * h, x + 5 * h + 5), 0, house);
                if ((i * 20 + k * 5 + h) % 37 != 5)
                    source->files[house] = glb(unsigned(2 + (i + k + h) % 9));
            }
            if ((i + k) % 11 == 3)
                source->files[part] = bytesOf("rubbish");
            else if ((i + k) % 7 == 1)
                source->files[part] = glb(3);
            else
                source->files[part] =
                    bytesOf(tileset(tile(box(x, x + 25), 20, "", houses, R"("refine":"ADD")")));
        }
        if (i != 7)
            source->files[block + ".json"] = bytesOf(tileset(
                tile(box(x0, x0 + kBlockMetres), 80, block + ".glb", parts, R"("refine":"ADD")")));
        source->files[block + ".glb"] = glb(1);
    }
    source->files["tileset.json"] = bytesOf(
        tileset(tile(box(0, kBlocks * kBlockMetres), 1000, "", blocks, R"("refine":"REPLACE")")));
    return source;
}

// What is before the camera at a step of the flight.
View viewAt(int step) {
    const double x = 30.0 * step;
    View view = viewFrom(x + 75, 50, 600);
    view.planes = {{{{1, 0, 0}}, {{x, 0, 0}}}, {{{-1, 0, 0}}, {{x + 150, 0, 0}}}};
    return view;
}
constexpr int kSteps = 40;

struct Flown {
    std::string pictures; // all that one could depend on
    std::string trees;    // and the trees' own numbers
    double worstError = 0.0;
    std::size_t most = 0;
    std::uint64_t loaded = 0;
    std::size_t drawn = 0; // different tiles
};

struct Flight {
    std::shared_ptr<FarSource> source = street();
    LoaderOptions options;
    int ahead = 3;
    bool gpuOnly = false;
};

Flown fly(const Flight& flight) {
    LoaderOptions options = flight.options;
    options.firstWait = 1ms;
    auto opened = StreamedTileset::open(flight.source, "tileset.json", {}, options);
    if (!opened)
        return {};
    StreamedTileset& tileset = **opened;
    if (flight.gpuOnly)
        tileset.setResidence({[](const TileContent& c) { return c.bytes() / 2; }, false});
    StreamedTileset* const one = &tileset;
    Flown flown;
    std::set<TileIndex> drawn;
    for (int step = 0; step < kSteps; ++step) {
        const View view = viewAt(step);
        double error = 8.0;
        const auto settleAt = [&] {
            return settle(std::span(&one, 1),
                          {std::span(&view, 1),
                           {error, false},
                           soon(),
                           nullptr,
                           [&](std::size_t, TileIndex tile) { tileset.copied(tile); }});
        };
        SettledAll settled = settleAt();
        while (settled.overBudget && error < 1e7) {
            error *= 1.5;
            settled = settleAt();
        }
        EXPECT_TRUE(settled.complete) << "step " << step;
        flown.worstError = std::max(flown.worstError, error);
        std::vector<Selection> coming;
        for (int next = step + 1; next <= std::min(step + flight.ahead, kSteps - 1); ++next) {
            const View there = viewAt(next);
            coming.push_back(select(tileset.tree(), std::span(&there, 1), {error, false}));
        }
        tileset.requestAhead(coming);
        flown.pictures += "\n" + std::to_string(step) + " at " + number(error) + ":";
        for (const TileIndex i : settled.selections[0].drawDepthFirst) {
            flown.pictures += " " + tileset.tree().name(i);
            flown.trees += " " + std::to_string(i);
            drawn.insert(i);
        }
        flown.trees += " of " + std::to_string(tileset.tree().size()) + "\n";
    }
    std::set<std::string> failed;
    for (const FailedTile& of : tileset.failures()) {
        failed.insert(of.error.message());
        flown.trees += std::to_string(of.tile) + ": " + of.error.message() + "\n";
    }
    for (const std::string& message : failed)
        flown.pictures += "\n" + message;
    flown.most = tileset.ledger().most();
    flown.loaded = tileset.tilesLoaded();
    flown.drawn = drawn.size();
    EXPECT_LE(flown.most, tileset.ledger().cap());
    return flown;
}

// A flight that differs from run to run in all that must not matter.
Flight flightOf(int run) {
    Flight flight;
    flight.source->delay = std::chrono::microseconds(20 + 70 * (run % 4));
    flight.source->jitter = true;
    flight.source->seed = std::uint32_t(run * 7919);
    flight.source->atOnce = run % 3 == 0 ? 0u : unsigned(run * 5 % 23 + 1);
    flight.options.workers = 1 + unsigned(run % 5);
    return flight;
}

// The numbers of tiles depend on what was asked for ahead, the pictures on nothing.
void expectTheSame(const std::function<void(Flight&)>& change, Flown& last) {
    std::string pictures;
    for (const int ahead : {3, 0, 1}) {
        std::string trees;
        for (int run = 0; run < 5; ++run) {
            Flight flight = flightOf(run);
            flight.ahead = ahead;
            change(flight);
            last = fly(flight);
            if (run == 0)
                trees = last.trees;
            if (pictures.empty())
                pictures = last.pictures;
            ASSERT_EQ(last.trees, trees) << ahead << " ahead, run " << run;
            ASSERT_EQ(last.pictures, pictures) << ahead << " ahead, run " << run;
        }
    }
}

TEST(Prefetch, TheSameFlightGivesTheSameBytesWhateverTheTiming) {
    Flown flown;
    expectTheSame([](Flight&) {}, flown);
    EXPECT_NE(flown.pictures.find("e7.json: no such file"), std::string::npos);
    EXPECT_NE(flown.pictures.find("e1p2: neither"), std::string::npos);
}

TEST(Prefetch, AndWhateverFaultsThereAreOnTheWay) {
    Flown flown;
    expectTheSame(
        [](Flight& flight) {
            const int salt = int(flight.source->seed);
            if (salt > 0)
                flight.source->fault = [salt](const std::string& path,
                                              int n) -> std::optional<Error> {
                    const auto hash = std::hash<std::string>()(path + std::to_string(salt));
                    if (path != "tileset.json" && n <= int(hash % 12) - 8)
                        return Error{path, "busy", ErrorKind::Transient};
                    return std::nullopt;
                };
        },
        flown);
}

TEST(Prefetch, AndWhereverTheMemoryIsTooSmall) {
    for (const bool gpuOnly : {false, true}) {
        Flown flown;
        expectTheSame(
            [&](Flight& flight) {
                flight.gpuOnly = gpuOnly;
                flight.options.memoryBytes = gpuOnly ? 12'000 : 20'000;
            },
            flown);
        std::printf("worst error %g, at most %zu bytes, %d loaded\n", flown.worstError, flown.most,
                    int(flown.loaded));
        EXPECT_GT(flown.worstError, 8.0) << "it was never too small";
        EXPECT_NE(flown.pictures.find(" at 8:"), std::string::npos) << "it comes back down";
    }
}

TEST(Prefetch, LoadsNothingThatIsNotDrawn) {
    const Flown flown = fly({});
    EXPECT_GT(flown.drawn, 150u);
    EXPECT_LE(double(flown.loaded), 1.05 * double(flown.drawn));
}

TEST(Prefetch, ANextFrameIsThereWhenItIsAskedFor) {
    for (const int ahead : {0, 3}) {
        Flight flight;
        flight.source->delay = 5ms;
        auto opened = StreamedTileset::open(flight.source, "tileset.json", {}, {});
        StreamedTileset& tileset = **opened;
        std::chrono::steady_clock::duration waited{};
        for (int step = 0; step < 20; ++step) {
            const View view = viewAt(step);
            const auto begin = std::chrono::steady_clock::now();
            ASSERT_TRUE(settle(tileset, {&view, 1}, {8.0, false}, soon()).complete);
            waited += std::chrono::steady_clock::now() - begin;
            std::vector<Selection> coming;
            for (int next = step + 1; next <= step + ahead; ++next) {
                const View there = viewAt(next);
                coming.push_back(select(tileset.tree(), {&there, 1}, {8.0, false}));
            }
            tileset.requestAhead(coming);
            std::this_thread::sleep_for(30ms); // the frame is drawn
        }
        const double milliseconds = std::chrono::duration<double, std::milli>(waited).count();
        std::printf("ahead %d: waited %.0f ms for tiles in 20 frames\n", ahead, milliseconds);
        // Each frame without has two or three files to wait for, one after the other.
        if (ahead == 0)
            EXPECT_GT(milliseconds, 150.0);
        else
            EXPECT_LT(milliseconds, 90.0);
    }
}

TEST(Prefetch, NeverTakesTheRoomOfWhatIsUsedNow) {
    Flight flight;
    auto opened = StreamedTileset::open(flight.source, "tileset.json", {}, {});
    StreamedTileset& whole = **opened;
    const View here = viewAt(0), there = viewAt(20);
    ASSERT_TRUE(settle(whole, {&here, 1}, {8.0, false}, soon()).complete);
    LoaderOptions tight;
    tight.memoryBytes = whole.decodedBytes() + whole.decodedBytes() / 4;
    auto other = StreamedTileset::open(street(), "tileset.json", {}, tight);
    StreamedTileset& tileset = **other;
    // The trees grow over there first, so that there is much to be asked for ahead.
    ASSERT_FALSE(settle(tileset, {&there, 1}, {8.0, false}, soon()).selection.draw.empty());
    const Settled now = settle(tileset, {&here, 1}, {8.0, false}, soon());
    ASSERT_TRUE(now.complete);
    std::vector<Selection> coming;
    for (int step = 21; step < 26; ++step) {
        const View next = viewAt(step);
        coming.push_back(select(tileset.tree(), {&next, 1}, {8.0, false}));
    }
    tileset.requestAhead(coming);
    while (tileset.wait(1000ms))
        tileset.poll();
    for (const TileIndex tile : now.selection.draw)
        EXPECT_TRUE(tileset.content(tile));
    EXPECT_LE(tileset.ledger().most(), tight.memoryBytes);
    EXPECT_EQ(tileset.ledger().waitingBytes(), 0u);
}

} // namespace
} // namespace gnomon
