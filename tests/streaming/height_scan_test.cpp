// What levels of detail lose, held against looking at every place there is.
#include "streaming/terrain/height_error.h"
#include "streaming/terrain/height_estimate.h"
#include "streaming/terrain/height_samples.h"
#include "tests/streaming/terrain_support.h"

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A level's surface, written down anew: NaN where it has no triangle.
double surfaceAt(const Heights2d& h, int step, double x, double y) {
    const auto cell = [&](double at, int most, int& low, int& high) {
        low = std::min(int(at) / step * step, (most - 1) / step * step);
        high = std::min(low + step, most);
    };
    int x0, x1, y0, y1;
    cell(x, h.width - 1, x0, x1);
    cell(y, h.height - 1, y0, y1);
    const double u = (x - x0) / (x1 - x0), v = (y - y0) / (y1 - y0);
    const double b = h.at(x1, y0), c = h.at(x0, y1);
    if (u + v <= 1.0)
        return h.at(x0, y0) * (1.0 - u - v) + b * u + c * v;
    return h.at(x1, y1) * (u + v - 1.0) + b * (1.0 - v) + c * (1.0 - u);
}

struct Found {
    double worst = 0.0;
    bool rim = false;
};

// Every pixel, and places between at random.
Found lookEverywhere(const Heights2d& h, int level, const HeightLevels::Span& span) {
    Found found;
    const auto look = [&](double x, double y) {
        const double fine = surfaceAt(h, 1, x, y), coarse = surfaceAt(h, 1 << level, x, y);
        if (std::isnan(fine) != std::isnan(coarse))
            found.rim = true;
        else if (!std::isnan(fine))
            found.worst = std::max(found.worst, std::abs(fine - coarse));
    };
    for (int y = span.first.y; y <= span.last.y; ++y)
        for (int x = span.first.x; x <= span.last.x; ++x)
            look(x, y);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    for (int i = 0; i < 20000; ++i)
        look(span.first.x + share(random) * (span.last.x - span.first.x),
             span.first.y + share(random) * (span.last.y - span.first.y));
    return found;
}

void expectBounds(const Heights2d& h, const std::string& path, unsigned threads) {
    const Result<Raster> raster = Raster::open(path);
    ASSERT_TRUE(raster) << raster.error().message();
    const HeightLevels levels{{h.width, h.height}};
    const auto scan = scanHeights(*raster, levels, threads, nullptr);
    ASSERT_TRUE(scan);
    ASSERT_EQ(int(scan->levels.size()), levels.top() + 1);
    for (int level = 0; level <= levels.top(); ++level) {
        const glm::ivec2 tiles = levels.tiles(level);
        for (int y = 0; y < tiles.y; ++y)
            for (int x = 0; x < tiles.x; ++x) {
                SCOPED_TRACE(std::to_string(level) + " " + std::to_string(x) + " " +
                             std::to_string(y));
                const TileHeights& told = scan->levels[std::size_t(level)].at({x, y});
                const Found found = lookEverywhere(h, level, levels.span(level, {x, y}));
                EXPECT_GE(double(told.error), found.worst);
                // And no larger than the differences are: a bound that is reached. Irregular
                // cells at the far edges reach theirs where the look at random may not.
                EXPECT_LE(double(told.error), found.worst * 1.02 + 0.002);
                EXPECT_TRUE(told.rim || !found.rim);
            }
    }
}

} // namespace

TEST(HeightLevels, EachLevelIsPartOfTheOneBelowAndReachesTheLastPixel) {
    for (const int pixels : {2, 3, 129, 130, 257, 1000, 1025}) {
        for (int step = 1; step < 2 * pixels; step *= 2) {
            const LevelAxis fine{pixels, step}, coarse{pixels, 2 * step};
            EXPECT_EQ(coarse.position(coarse.cells()), pixels - 1);
            EXPECT_EQ(coarse.position(0), 0);
            for (int i = 0; i + 1 < coarse.samples(); ++i) {
                EXPECT_LT(coarse.position(i), coarse.position(i + 1));
                EXPECT_EQ(coarse.position(i), fine.position(std::min(2 * i, fine.cells())));
            }
        }
    }
}

TEST(HeightScan, TellsTheLargestDifferenceOfEveryTile) {
    const Heights2d h = roughHills(417, 300);
    expectBounds(h, writeRaster("rough", h), 2);
}

TEST(HeightScan, TellsItWhereCellsAtTheFarEdgesAreNoSquares) {
    for (const glm::ivec2 size :
         {glm::ivec2(259, 131), glm::ivec2(264, 270), glm::ivec2(131, 523)}) {
        const Heights2d h = roughHills(size.x, size.y, 3);
        expectBounds(h, writeRaster("edges", h), 3);
    }
}

TEST(HeightScan, LooksWhereTheDiagonalOfACellThatIsNoSquareCrossesThePixelsOwnTriangles) {
    // The last cell of level 2 is one pixel wide. Its diagonal is a ridge between two peaks, and
    // touches no pixel on the way.
    Heights2d h(130, 129, [](int, int) { return 0.0; });
    h.values[129] = 10.0f;
    h.values[std::size_t(4 * 130 + 128)] = 10.0f;
    const double off = std::abs(surfaceAt(h, 4, 128.5, 2.0) - surfaceAt(h, 1, 128.5, 2.0));
    ASSERT_GT(off, 9.9);
    const auto raster = Raster::open(writeRaster("ridge", h));
    ASSERT_TRUE(raster);
    const auto tile = scanTile(*raster, {{h.width, h.height}}, 2, {0, 0});
    ASSERT_TRUE(tile);
    EXPECT_GE(double(tile->levels[2].at({0, 0}).error), off);
    EXPECT_LT(double(tile->levels[2].at({0, 0}).error), 10.001);
}

TEST(HeightScan, TellsItAroundHolesAndNamesTheirRims) {
    Heights2d h = roughHills(390, 270, 5);
    for (int y = 0; y < h.height; ++y)
        for (int x = 0; x < h.width; ++x)
            if (std::hypot(x - 130, y - 120) < 60.0 || (x * 7 + y * 13) % 997 == 0 ||
                x > 300 + y / 4)
                h.values[std::size_t(y * h.width + x)] = kNoHeight;
    expectBounds(h, writeRaster("holes", h), 2);
}

TEST(HeightScan, SaysTheSameWithAnyNumberOfThreadsAndHoweverTheFileIsLaidOut) {
    const Heights2d h = roughHills(700, 1500, 9);
    const HeightLevels levels{{h.width, h.height}};
    std::vector<HeightScan> scans;
    for (const bool tiled : {false, true})
        for (const unsigned threads : {1u, 3u}) {
            const auto raster = Raster::open(writeRaster("layout", h, {.tiled = tiled}));
            ASSERT_TRUE(raster);
            auto scan = scanHeights(*raster, levels, threads, nullptr);
            ASSERT_TRUE(scan);
            scans.push_back(std::move(*scan));
        }
    for (const HeightScan& scan : scans) {
        EXPECT_EQ(scan.pixelsWithData, std::uint64_t(h.width) * std::uint64_t(h.height));
        EXPECT_EQ(scan.coarse.heights, scans[0].coarse.heights);
        for (std::size_t l = 0; l < scan.levels.size(); ++l)
            for (std::size_t i = 0; i < scan.levels[l].tiles.size(); ++i) {
                EXPECT_EQ(scan.levels[l].tiles[i].error, scans[0].levels[l].tiles[i].error);
                EXPECT_EQ(scan.levels[l].tiles[i].low, scans[0].levels[l].tiles[i].low);
            }
    }
}

TEST(HeightScan, OfOneTileSaysWhatTheScanOfAllSays) {
    const Heights2d h = roughHills(1100, 900, 2);
    const HeightLevels levels{{h.width, h.height}};
    const auto raster = Raster::open(writeRaster("one", h));
    ASSERT_TRUE(raster);
    const auto all = scanHeights(*raster, levels, 2, nullptr);
    ASSERT_TRUE(all);
    const auto one = scanTile(*raster, levels, 2, {1, 1});
    ASSERT_TRUE(one);
    ASSERT_EQ(one->levels.size(), 3u);
    int compared = 0;
    for (std::size_t level = 0; level < 3; ++level) {
        const LevelTiles& tiles = one->levels[level];
        for (int y = tiles.first.y; y < tiles.first.y + tiles.count.y; ++y)
            for (int x = tiles.first.x; x < tiles.first.x + tiles.count.x; ++x, ++compared) {
                EXPECT_EQ(tiles.at({x, y}).error, all->levels[level].at({x, y}).error);
                EXPECT_EQ(tiles.at({x, y}).high, all->levels[level].at({x, y}).high);
            }
    }
    EXPECT_EQ(compared, 1 + 4 + 16);
}

TEST(HeightSamples, AreThePixelsOfTheirLevelFromMemoryAndFromTheFile) {
    const Heights2d h = roughHills(1000, 777, 4);
    const auto raster = Raster::open(writeRaster("samples", h));
    ASSERT_TRUE(raster);
    const HeightLevels levels{{h.width, h.height}};
    // Kept from level 2 up; below, the file is read.
    CoarseHeights coarse;
    coarse.level = 2;
    coarse.grid = levels.at(2);
    for (int y = 0; y < coarse.grid.down.samples(); ++y)
        for (int x = 0; x < coarse.grid.across.samples(); ++x)
            coarse.heights.push_back(
                h.at(coarse.grid.across.position(x), coarse.grid.down.position(y)));
    const HeightSamples samples(*raster, levels, std::move(coarse), 100);
    for (int level = 0; level <= levels.top(); ++level) {
        const LevelGrid grid = levels.at(level);
        const glm::ivec2 first = glm::ivec2(grid.across.samples(), grid.down.samples()) / 2;
        const glm::ivec2 count(grid.across.samples() - first.x, grid.down.samples() - first.y);
        std::vector<float> out(std::size_t(count.x * count.y));
        ASSERT_FALSE(samples.read(level, first, count, out));
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                ASSERT_EQ(out[std::size_t(y * count.x + x)],
                          h.at(grid.across.position(first.x + x), grid.down.position(first.y + y)))
                    << level;
    }
}

TEST(HeightEstimate, OfARasterNotReadComesNearWhatAScanFinds) {
    const Heights2d h(4200, 2300, [](int x, int y) {
        return 100.0 + 20.0 * std::sin(0.005 * x) * std::cos(0.004 * y) +
               2.0 * std::sin(0.07 * x + 0.05 * y);
    });
    const std::string path = writeRaster("large", h, {.overviews = true});
    const auto raster = Raster::open(path);
    ASSERT_TRUE(raster);
    const HeightLevels levels{{h.width, h.height}};
    const auto scan = scanHeights(*raster, levels, 2, nullptr);
    const auto coarse = HeightSamples::readCoarse(*raster, levels, nullptr);
    ASSERT_TRUE(scan && coarse);
    const auto estimate = estimateHeights(*raster, levels, *coarse);
    ASSERT_TRUE(estimate);
    for (int level = kWholeTileLevel; level <= levels.top(); ++level)
        for (std::size_t i = 0; i < scan->levels[std::size_t(level)].tiles.size(); ++i) {
            const TileHeights& truth = scan->levels[std::size_t(level)].tiles[i];
            const TileHeights& guess = estimate->levels[std::size_t(level)].tiles[i];
            EXPECT_TRUE(guess.surface);
            EXPECT_GT(double(guess.error), 0.5 * double(truth.error));
            EXPECT_LT(double(guess.error), 3.0 * double(truth.error) + 0.1);
            EXPECT_NEAR(double(guess.low), double(truth.low), 3.0);
        }
    EXPECT_EQ(estimate->dataShare, 1.0);
}
