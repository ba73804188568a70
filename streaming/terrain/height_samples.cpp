#include "streaming/terrain/height_samples.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <numeric>
#include <thread>

namespace gnomon {

namespace {

constexpr int kBlockCells = 256;
constexpr std::size_t kMostBlocks = 64; // 17 MB

// The overview that is just finer than `step`; 1 when there is none.
int factorFor(const Raster& raster, int step) {
    int best = 1;
    for (const int factor : raster.overviewFactors())
        best = factor <= step ? factor : best;
    return best;
}

// Heights at pixels, from an overview whose pixels are means of theirs.
Failure readByOverview(const Raster& raster, int factor, std::span<const int> columns,
                       std::span<const int> rows, std::span<float> out) {
    const glm::ivec2 size = raster.overviewSize(factor);
    const glm::dvec2 ratio(double(size.x) / raster.width(), double(size.y) / raster.height());
    const auto at = [](int pixel, double share, int most) {
        return std::clamp((pixel + 0.5) * share - 0.5, 0.0, double(most - 1));
    };
    const int x0 = int(at(columns.front(), ratio.x, size.x));
    const int x1 = std::min(int(at(columns.back(), ratio.x, size.x)) + 1, size.x - 1);
    std::size_t i = 0;
    for (const int row : rows) {
        const double y = at(row, ratio.y, size.y);
        const int y0 = std::min(int(y), size.y - 2);
        const Result<std::vector<float>> two = raster.readOverview(factor, x0, y0, x1 - x0 + 1, 2);
        if (!two)
            return two.error();
        const int width = x1 - x0 + 1;
        for (const int column : columns) {
            const double x = at(column, ratio.x, size.x);
            const int c = std::min(int(x), std::max(x1 - 1, x0)) - x0;
            const int right = std::min(c + 1, width - 1);
            const double u = x - x0 - c, v = y - y0;
            const double a = (*two)[std::size_t(c)], b = (*two)[std::size_t(right)];
            const double d = (*two)[std::size_t(width + c)], e = (*two)[std::size_t(width + right)];
            const double mean = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * e);
            // At the rim of what is known the nearest decides.
            const double nearest = v < 0.5 ? (u < 0.5 ? a : b) : (u < 0.5 ? d : e);
            out[i++] = float(std::isnan(mean) ? nearest : mean);
        }
    }
    return {};
}

Failure readPixels(const Raster& raster, std::span<const int> columns, std::span<const int> rows,
                   std::span<float> out) {
    const int first = columns.front(), width = columns.back() - first + 1;
    if (width == int(columns.size()) && rows.back() - rows.front() + 1 == int(rows.size()))
        return raster.readInto(first, rows.front(), width, int(rows.size()), out);
    std::vector<float> line(static_cast<std::size_t>(width));
    std::size_t i = 0;
    for (const int row : rows) {
        if (const Failure wrong = raster.readInto(first, row, width, 1, line))
            return wrong;
        for (const int column : columns)
            out[i++] = line[std::size_t(column - first)];
    }
    return {};
}

std::vector<int> positions(const LevelAxis& axis, int first, int count) {
    std::vector<int> out;
    for (int i = first; i < first + count; ++i)
        out.push_back(axis.position(i));
    return out;
}

// What threads that read rows tell the one that waits for them.
struct RowsShared {
    std::mutex mutex;
    std::condition_variable changed;
    int running = 0, rows = 0;
    Failure error;
};

void readRows(const Raster& raster, int factor, const std::vector<int>& across, CoarseHeights& out,
              int from, int to, RowsShared& shared) {
    constexpr int kRowsAtOnce = 16;
    Failure wrong;
    for (int row = from; row < to && !wrong; row += kRowsAtOnce) {
        const int count = std::min(kRowsAtOnce, to - row);
        const std::vector<int> down = positions(out.grid.down, row, count);
        const std::span<float> target =
            std::span(out.heights).subspan(std::size_t(row) * across.size());
        try {
            wrong = factor > 1 ? readByOverview(raster, factor, across, down, target)
                               : readPixels(raster, across, down, target);
        } catch (const std::bad_alloc&) {
            wrong = Error{"", "there is not enough memory to read the raster"};
        }
        const std::lock_guard lock(shared.mutex);
        shared.rows += count;
        if (shared.error)
            break;
        shared.error = wrong;
        shared.changed.notify_one();
    }
    const std::lock_guard lock(shared.mutex);
    --shared.running;
    shared.changed.notify_one();
}

double bilinear(const std::vector<float>& heights, int width, int column, int row, double u,
                double v) {
    const std::size_t i = std::size_t(row) * std::size_t(width) + std::size_t(column);
    double sum = 0.0;
    const auto add = [&](std::size_t at, double weight) {
        if (weight > 0.0) // what lies next to the last pixel may not be there
            sum += weight * double(heights[at]);
    };
    add(i, (1 - u) * (1 - v));
    add(i + 1, u * (1 - v));
    add(i + std::size_t(width), (1 - u) * v);
    add(i + std::size_t(width) + 1, u * v);
    return sum;
}

} // namespace

Result<CoarseHeights> HeightSamples::readCoarse(const Raster& raster, const HeightLevels& levels,
                                                const std::function<void(double)>& progress) {
    CoarseHeights out;
    out.level = coarseLevel(levels);
    out.grid = levels.at(out.level);
    const int columns = out.grid.across.samples(), rows = out.grid.down.samples();
    out.heights.resize(std::size_t(columns) * std::size_t(rows));
    const int factor = factorFor(raster, out.grid.across.step);
    const std::vector<int> across = positions(out.grid.across, 0, columns);
    // Threads take a part each from top to bottom: compressed blocks are unpacked once.
    const int parts = std::clamp(int(std::thread::hardware_concurrency()), 1, rows);
    RowsShared shared;
    shared.running = parts;
    std::vector<std::thread> threads;
    const auto firstOf = [&](int part) { return int(std::int64_t(rows) * part / parts); };
    for (int part = 0; part < parts; ++part)
        threads.emplace_back([&, part] {
            readRows(raster, factor, across, out, firstOf(part), firstOf(part + 1), shared);
        });
    for (bool done = false; !done;) {
        std::unique_lock lock(shared.mutex);
        shared.changed.wait_for(lock, std::chrono::milliseconds(100));
        done = shared.running == 0;
        const double share = double(shared.rows) / rows;
        lock.unlock();
        if (progress)
            progress(share);
    }
    for (std::thread& thread : threads)
        thread.join();
    if (shared.error)
        return *shared.error;
    return out;
}

Failure HeightSamples::read(int level, glm::ivec2 first, glm::ivec2 count,
                            std::span<float> out) const {
    assert(out.size() >= std::size_t(count.x) * std::size_t(count.y));
    const LevelGrid grid = levels_.at(level);
    if (!coarse_.heights.empty() && level >= coarse_.level) {
        const int shift = level - coarse_.level;
        const auto index = [&](const LevelAxis& axis, const LevelAxis& coarse, int sample) {
            return sample >= axis.cells() ? coarse.cells() : sample << shift;
        };
        std::size_t i = 0;
        for (int y = first.y; y < first.y + count.y; ++y)
            for (int x = first.x; x < first.x + count.x; ++x)
                out[i++] = coarse_.at(index(grid.across, coarse_.grid.across, x),
                                      index(grid.down, coarse_.grid.down, y));
        return {};
    }
    const std::vector<int> across = positions(grid.across, first.x, count.x);
    const std::vector<int> down = positions(grid.down, first.y, count.y);
    const int factor = level >= overviewsFrom_ ? factorFor(raster_, grid.across.step) : 1;
    return factor > 1 ? readByOverview(raster_, factor, across, down, out)
                      : readPixels(raster_, across, down, out);
}

std::shared_ptr<const HeightSamples::Block> HeightSamples::block(int index) const {
    {
        const std::lock_guard lock(mutex_);
        if (const auto it = blockAt_.find(index); it != blockAt_.end()) {
            blocks_.splice(blocks_.begin(), blocks_, it->second);
            return it->second->second;
        }
    }
    auto made = std::make_shared<Block>();
    const int across = (levels_.pixels.x - 2) / kBlockCells + 1;
    made->first = glm::ivec2(index % across, index / across) * kBlockCells;
    made->size = glm::min(glm::ivec2(kBlockCells + 1), levels_.pixels - made->first);
    made->heights.resize(std::size_t(made->size.x) * std::size_t(made->size.y));
    if (raster_.readInto(made->first.x, made->first.y, made->size.x, made->size.y, made->heights))
        made->heights.clear();
    const std::lock_guard lock(mutex_);
    if (blockAt_.contains(index)) // another thread was faster
        return made;
    blocks_.emplace_front(index, made);
    blockAt_[index] = blocks_.begin();
    if (blocks_.size() > kMostBlocks) {
        blockAt_.erase(blocks_.back().first);
        blocks_.pop_back();
    }
    return made;
}

void HeightSamples::between(std::span<const glm::dvec2> pixels, std::span<double> out) const {
    struct Task {
        int block, column, row;
        double u, v;
        std::size_t index;
    };
    const bool inMemory = coarse_.level == 0 && !coarse_.heights.empty();
    const int blocksAcross = (levels_.pixels.x - 2) / kBlockCells + 1;
    // What is this near to a pixel's centre lies on it: what comes through PROJ and back does not
    // come back to the last bit.
    constexpr double kSnap = 1e-6;
    std::vector<Task> tasks;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        out[i] = std::numeric_limits<double>::quiet_NaN();
        glm::dvec2 p = pixels[i];
        const glm::dvec2 whole = glm::round(p);
        for (int axis = 0; axis < 2; ++axis)
            p[axis] = std::abs(p[axis] - whole[axis]) < kSnap ? whole[axis] : p[axis];
        if (!(p.x >= 0.0 && p.y >= 0.0 && p.x <= levels_.pixels.x - 1 &&
              p.y <= levels_.pixels.y - 1))
            continue;
        const int x = std::min(int(p.x), levels_.pixels.x - 2);
        const int y = std::min(int(p.y), levels_.pixels.y - 2);
        if (inMemory)
            out[i] = bilinear(coarse_.heights, levels_.pixels.x, x, y, p.x - x, p.y - y);
        else
            tasks.push_back(
                {(y / kBlockCells) * blocksAcross + x / kBlockCells, x, y, p.x - x, p.y - y, i});
    }
    std::sort(tasks.begin(), tasks.end(),
              [](const Task& a, const Task& b) { return a.block < b.block; });
    std::shared_ptr<const Block> current;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const Task& task = tasks[i];
        if (i == 0 || task.block != tasks[i - 1].block)
            current = block(task.block);
        if (!current->heights.empty())
            out[task.index] =
                bilinear(current->heights, current->size.x, task.column - current->first.x,
                         task.row - current->first.y, task.u, task.v);
    }
}

} // namespace gnomon
