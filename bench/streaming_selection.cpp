#include "bench/streaming_selection.h"

#include "streaming/selection.h"

#include <algorithm>

#include <time.h>

namespace gnomon::bench {
namespace {

constexpr int kWarmUpRuns = 2;

} // namespace

double threadMicroseconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) * 1e6 + double(now.tv_nsec) * 1e-3;
}

double median(std::vector<double> values) {
    if (values.empty())
        return 0.0;
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

Result<std::vector<SelectionRow>> measureSelection(std::size_t tiles, VolumeKind kind, int runs) {
    const Result<TileTree> tree = cityTree(tiles, kind);
    if (!tree)
        return tree.error();
    std::vector<SelectionRow> rows;
    for (const FrameViews& frame : cityViews(*tree)) {
        SelectOptions options;
        options.maximumScreenSpaceError = frame.maximumScreenSpaceError;
        SelectionRow row{tree->size(), kind, frame.name, 0, 0, 0.0};
        std::vector<double> times;
        for (int run = -kWarmUpRuns; run < runs; ++run) {
            const double start = threadMicroseconds();
            const Selection selection = select(*tree, frame.views, options);
            const double took = threadMicroseconds() - start;
            row.visited = selection.visited;
            row.drawn = selection.draw.size();
            if (run >= 0)
                times.push_back(took);
        }
        row.frameMicroseconds = median(std::move(times));
        rows.push_back(std::move(row));
    }
    return rows;
}

} // namespace gnomon::bench
