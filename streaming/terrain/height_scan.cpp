#include "streaming/terrain/height_scan.h"

#include "streaming/terrain/height_error.h"

#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace gnomon {

namespace {

// What one band of rows may take of memory, in each thread.
constexpr std::int64_t kMostBandBytes = std::int64_t(32) << 20;

LevelTiles emptyTiles(glm::ivec2 first, glm::ivec2 count) {
    return {first, count, std::vector<TileHeights>(std::size_t(count.x) * std::size_t(count.y))};
}

// Per tile of level 0, what it adds to each level: written by one thread each.
struct Pieces {
    LevelTiles finest;
    std::vector<LevelTiles> errors; // from level 1; `low`, `high` unused

    Pieces(glm::ivec2 first, glm::ivec2 count, int exactLevels)
        : finest(emptyTiles(first, count)),
          errors(std::size_t(exactLevels), emptyTiles(first, count)) {}

    void look(const HeightWindow& window, const HeightLevels& levels, glm::ivec2 tile) {
        const HeightLevels::Span span = levels.span(0, tile);
        finest.at(tile) = heightsIn(window, span.first, span.last);
        // Without any data: only cells that are larger than the tile may cover it.
        const bool empty = !(finest.at(tile).high >= finest.at(tile).low);
        const bool complete = !empty && isComplete(window, span.first, span.last);
        for (std::size_t i = 0; i < errors.size(); ++i) {
            const int level = int(i) + 1;
            if (!empty || (1 << level) > kTileCells)
                addError(window, levels, level, span.first, span.last, complete,
                         errors[i].at(tile));
        }
    }

    // Levels that no band is high enough for: both surfaces lie between low and high.
    LevelTiles gather(int level, glm::ivec2 first, glm::ivec2 count) const {
        LevelTiles out = emptyTiles(first, count);
        const glm::ivec2 end = finest.first + finest.count;
        for (int y = finest.first.y; y < end.y; ++y)
            for (int x = finest.first.x; x < end.x; ++x) {
                TileHeights piece = finest.at({x, y});
                if (level > 0 && std::size_t(level) <= errors.size()) {
                    const TileHeights& more = errors[std::size_t(level - 1)].at({x, y});
                    piece.error = more.error;
                    piece.rim = more.rim;
                }
                out.at(glm::ivec2(x, y) / (1 << level)).add(piece);
            }
        for (TileHeights& tile : out.tiles) {
            if (level == 0 || !tile.surface)
                continue;
            if (std::size_t(level) > errors.size()) {
                tile.error = tile.high - tile.low;
                tile.rim = true;
            }
            // Sums of three heights in float, each rounded a few times.
            constexpr float kRoundings = 8.0f;
            tile.error += kRoundings * std::numeric_limits<float>::epsilon() *
                          std::max(std::abs(tile.low), std::abs(tile.high));
        }
        return out;
    }
};

int bandRows(const Raster& raster, const HeightLevels& levels) {
    const std::int64_t rowBytes = std::int64_t(levels.pixels.x) * 4;
    const std::int64_t most = std::max<std::int64_t>(kMostBandBytes / rowBytes, 1);
    const auto fits = int(std::bit_floor(std::uint64_t(std::min<std::int64_t>(most, 1 << 20))));
    const int useful = std::max(1 << levels.top(), kTileCells);
    const auto block = int(std::bit_ceil(unsigned(std::min(raster.blockSize().y, 1024))));
    return std::max({kTileCells, std::min(fits, useful), std::min(block, fits)});
}

// Rows of the raster for one thread, band by band.
class Scanner {
  public:
    Scanner(const Raster& raster, const HeightLevels& levels, int rows, HeightScan& out,
            Pieces& pieces)
        : raster_(raster), levels_(levels), rows_(rows), out_(out), pieces_(pieces),
          buffer_(std::size_t(rows + 1) * std::size_t(levels.pixels.x)) {}

    Failure band(int index) {
        const int first = index * rows_;
        const int last = std::min(first + rows_, levels_.pixels.y - 1);
        const std::size_t width = std::size_t(levels_.pixels.x);
        // The last row of the band before is this one's first.
        const bool follows = index == previous_ + 1 && previous_ >= 0;
        if (follows)
            std::copy_n(buffer_.begin() + std::ptrdiff_t(width) * rows_, width, buffer_.begin());
        const int from = follows ? first + 1 : first;
        const std::span<float> target =
            std::span(buffer_).subspan(std::size_t(from - first) * width);
        if (const Failure wrong =
                raster_.readInto(0, from, levels_.pixels.x, last - from + 1, target))
            return wrong;
        previous_ = index;
        const HeightWindow window{{0, first}, {levels_.pixels.x, last - first + 1}, buffer_.data()};
        for (int y = first / kTileCells; y * kTileCells < last; ++y)
            for (int x = 0; x < pieces_.finest.count.x; ++x)
                pieces_.look(window, levels_, {x, y});
        keep(window, first, last);
        return {};
    }
    std::uint64_t pixelsWithData = 0;

  private:
    // Counts, and copies what the coarse level takes. A row between two bands belongs to the first.
    void keep(const HeightWindow& window, int first, int last) {
        const LevelGrid& grid = out_.coarse.grid;
        const int samples = grid.across.samples();
        for (int y = first == 0 ? 0 : first + 1; y <= last; ++y) {
            const float* row = window.row(y);
            std::uint32_t count = 0;
            for (int x = 0; x < levels_.pixels.x; ++x)
                count += row[x] == row[x] ? 1 : 0;
            pixelsWithData += count;
            const bool isLast = y == levels_.pixels.y - 1;
            if (!isLast && y % grid.down.step != 0)
                continue;
            const int sample = isLast ? grid.down.cells() : y / grid.down.step;
            float* to = &out_.coarse.heights[std::size_t(sample) * std::size_t(samples)];
            for (int i = 0; i < samples; ++i)
                to[i] = row[grid.across.position(i)];
        }
    }

    const Raster& raster_;
    const HeightLevels& levels_;
    int rows_;
    HeightScan& out_;
    Pieces& pieces_;
    std::vector<float> buffer_;
    int previous_ = -2;
};

// Threads, and what they tell the one that waits.
struct Work {
    std::mutex mutex;
    std::condition_variable changed;
    int bandsDone = 0;
    unsigned running = 0;
    std::uint64_t pixelsWithData = 0;
    Failure error;
};

void runBands(const Raster& raster, const HeightLevels& levels, int rows, int from, int to,
              HeightScan& out, Pieces& pieces, Work& work) {
    Failure wrong;
    std::uint64_t data = 0;
    try {
        Scanner scanner(raster, levels, rows, out, pieces);
        for (int band = from; band < to && !wrong; ++band) {
            wrong = scanner.band(band);
            const std::lock_guard lock(work.mutex);
            ++work.bandsDone;
            if (work.error)
                break;
            work.changed.notify_one();
        }
        data = scanner.pixelsWithData;
    } catch (const std::exception& e) {
        wrong = Error{"the raster", std::string("cannot be read: ") + e.what()};
    }
    const std::lock_guard lock(work.mutex);
    work.pixelsWithData += data;
    if (wrong && !work.error)
        work.error = wrong;
    --work.running;
    work.changed.notify_one();
}

} // namespace

void TileHeights::add(const TileHeights& other) {
    low = std::min(low, other.low);
    high = std::max(high, other.high);
    error = std::max(error, other.error);
    rim = rim || other.rim;
    surface = surface || other.surface;
}

int coarseLevel(const HeightLevels& levels) {
    int level = 0;
    while (std::int64_t(levels.at(level).across.samples()) * levels.at(level).down.samples() >
           kMostCoarseSamples)
        ++level;
    return level;
}

Result<HeightScan> scanHeights(const Raster& raster, const HeightLevels& levels, unsigned threads,
                               const std::function<void(double)>& progress) {
    const int rows = bandRows(raster, levels);
    const int bands = (levels.pixels.y - 1 + rows - 1) / rows;
    const int top = levels.top();
    HeightScan out;
    out.coarse.level = coarseLevel(levels);
    out.coarse.grid = levels.at(out.coarse.level);
    out.coarse.heights.resize(std::size_t(out.coarse.grid.across.samples()) *
                              std::size_t(out.coarse.grid.down.samples()));
    Pieces pieces({0, 0}, levels.tiles(0), std::min(top, int(std::bit_width(unsigned(rows))) - 1));
    Work work;
    const int parts = std::clamp(int(threads), 1, bands);
    work.running = unsigned(parts);
    std::vector<std::thread> running;
    for (int i = 0; i < parts; ++i) {
        const auto from = [&](int part) { return int(std::int64_t(bands) * part / parts); };
        running.emplace_back(runBands, std::cref(raster), std::cref(levels), rows, from(i),
                             from(i + 1), std::ref(out), std::ref(pieces), std::ref(work));
    }
    for (bool done = false; !done;) {
        std::unique_lock lock(work.mutex);
        work.changed.wait_for(lock, std::chrono::milliseconds(100));
        done = work.running == 0;
        const double share = double(work.bandsDone) / bands;
        lock.unlock();
        if (progress)
            progress(share);
    }
    for (std::thread& thread : running)
        thread.join();
    if (work.error)
        return *work.error;
    out.pixelsWithData = work.pixelsWithData;
    for (int level = 0; level <= top; ++level)
        out.levels.push_back(pieces.gather(level, {0, 0}, levels.tiles(level)));
    return out;
}

HeightScan scanWindow(const HeightWindow& window, const HeightLevels& levels, int level) {
    const glm::ivec2 finestCount = (window.size - 2) / kTileCells + 1;
    const glm::ivec2 finestFirst = window.first / kTileCells;
    Pieces pieces(finestFirst, finestCount, level);
    for (int y = 0; y < finestCount.y; ++y)
        for (int x = 0; x < finestCount.x; ++x)
            pieces.look(window, levels, finestFirst + glm::ivec2(x, y));
    HeightScan out;
    for (int l = 0; l <= level; ++l) {
        const glm::ivec2 first = finestFirst / (1 << l);
        const glm::ivec2 last = (finestFirst + finestCount - 1) / (1 << l);
        out.levels.push_back(pieces.gather(l, first, last - first + 1));
    }
    return out;
}

Result<HeightScan> scanTile(const Raster& raster, const HeightLevels& levels, int level,
                            glm::ivec2 tile) {
    const HeightLevels::Span span = levels.span(level, tile);
    const glm::ivec2 size = span.last - span.first + 1;
    const Result<std::vector<float>> heights =
        raster.read(span.first.x, span.first.y, size.x, size.y);
    if (!heights)
        return heights.error();
    return scanWindow({span.first, size, heights->data()}, levels, level);
}

} // namespace gnomon
