#include "streaming/terrain/height_error.h"

#include <cmath>

namespace gnomon {

namespace {

// A cell of a coarse level and its corners' heights: a b above, c d below. The diagonal runs from b
// to c.
struct Cell {
    int x0, y0, x1, y1;
    float a, b, c, d;

    bool upperThere() const { return !std::isnan(a + b + c); }
    bool lowerThere() const { return !std::isnan(b + c + d); }
};

Cell cellAt(const HeightWindow& window, int x0, int y0, int x1, int y1) {
    return {
        x0, y0, x1, y1, window.at(x0, y0), window.at(x1, y0), window.at(x0, y1), window.at(x1, y1)};
}

// Along a row at share `v` of the cell's height the surface is two straight pieces that meet at
// share 1 - v of its width.
struct RowLines {
    float start, slope;    // of the upper triangle, from x0
    float end, slopeToEnd; // of the lower one: end + slopeToEnd * (x - x1)
    double breakAt;        // column
};

RowLines linesOf(const Cell& cell, int y) {
    const float w = float(cell.x1 - cell.x0);
    const float v = float(y - cell.y0) / float(cell.y1 - cell.y0);
    RowLines lines;
    lines.start = cell.a + v * (cell.c - cell.a);
    lines.slope = (cell.b - cell.a) / w;
    lines.end = cell.b + v * (cell.d - cell.b);
    lines.slopeToEnd = (cell.d - cell.c) / w;
    lines.breakAt =
        cell.x0 + double(cell.x1 - cell.x0) * double(cell.y1 - y) / double(cell.y1 - cell.y0);
    return lines;
}

// Largest |heights - line| over columns [from, to); the line has `value` at `from`.
float largestOff(const float* heights, int from, int to, float value, float slope) {
    float most = 0.0f;
    const float* h = heights + from;
    const int n = to - from;
    for (int i = 0; i < n; ++i)
        most = std::max(most, std::abs(h[i] - (value + float(i) * slope)));
    return most;
}

// One row of complete cells, columns [from, to] of one cell.
float completeRow(const float* heights, const Cell& cell, int y, int from, int to) {
    const RowLines lines = linesOf(cell, y);
    const int split = std::min(std::max(int(std::ceil(lines.breakAt)), from), to + 1);
    const float upper = largestOff(heights, from, split,
                                   lines.start + lines.slope * float(from - cell.x0), lines.slope);
    const float lower =
        largestOff(heights, split, to + 1, lines.end + lines.slopeToEnd * float(split - cell.x1),
                   lines.slopeToEnd);
    return std::max(upper, lower);
}

void ragged(const float* heights, const Cell& cell, int y, int from, int to, TileHeights& out) {
    const RowLines lines = linesOf(cell, y);
    const bool upper = cell.upperThere(), lower = cell.lowerThere();
    for (int x = from; x <= to; ++x) {
        const bool inUpper = double(x) <= lines.breakAt;
        const bool there = inUpper ? upper : lower;
        if (there == std::isnan(heights[x])) {
            out.rim = true;
            continue;
        }
        if (!there)
            continue;
        const float surface = inUpper ? lines.start + lines.slope * float(x - cell.x0)
                                      : lines.end + lines.slopeToEnd * float(x - cell.x1);
        out.error = std::max(out.error, std::abs(heights[x] - surface));
    }
}

// The finest surface anywhere.
float fineAt(const HeightWindow& window, glm::ivec2 last, double x, double y) {
    const int x0 = std::min(int(std::floor(x)), last.x - 1);
    const int y0 = std::min(int(std::floor(y)), last.y - 1);
    const double u = x - x0, v = y - y0;
    const double b = window.at(x0 + 1, y0), c = window.at(x0, y0 + 1);
    if (u + v <= 1.0) {
        const double a = window.at(x0, y0);
        return float(a + u * (b - a) + v * (c - a));
    }
    const double d = window.at(x0 + 1, y0 + 1);
    return float(d + (1.0 - u) * (c - d) + (1.0 - v) * (b - d));
}

// Cells at the far edges may be no squares. Their diagonal then runs across the finest triangles,
// and the largest difference may lie where it crosses their sides.
void alongDiagonal(const HeightWindow& window, const Cell& cell, glm::ivec2 first, glm::ivec2 last,
                   TileHeights& out) {
    const int w = cell.x1 - cell.x0, h = cell.y1 - cell.y0;
    if (w == h || std::isnan(cell.b + cell.c))
        return;
    const auto look = [&](double t) {
        const double x = cell.x1 - t * w, y = cell.y0 + t * h;
        if (x < first.x || x > last.x || y < first.y || y > last.y)
            return;
        const float off = std::abs(fineAt(window, last, x, y) -
                                   float(double(cell.b) + t * (double(cell.c) - double(cell.b))));
        if (!std::isnan(off)) // else a rim, which pixels tell
            out.error = std::max(out.error, off);
    };
    for (int i = 0; i <= w; ++i)
        look(double(i) / w);
    for (int j = 0; j <= h; ++j)
        look(double(j) / h);
    for (int k = 0; k <= std::abs(h - w); ++k)
        look(double(k) / std::abs(h - w));
}

} // namespace

bool isComplete(const HeightWindow& window, glm::ivec2 first, glm::ivec2 last) {
    for (int y = first.y; y <= last.y; ++y) {
        const float* row = window.row(y);
        float sum = 0.0f; // heights are below 1e6, so that only NaN gives NaN
        for (int x = first.x; x <= last.x; ++x)
            sum += row[x];
        if (std::isnan(sum))
            return false;
    }
    return true;
}

TileHeights heightsIn(const HeightWindow& window, glm::ivec2 first, glm::ivec2 last) {
    TileHeights out;
    for (int y = first.y; y <= last.y; ++y) {
        const float* row = window.row(y);
        float low = out.low, high = out.high;
        for (int x = first.x; x <= last.x; ++x) { // comparisons with NaN are false
            low = row[x] < low ? row[x] : low;
            high = row[x] > high ? row[x] : high;
        }
        out.low = low;
        out.high = high;
    }
    for (int y = first.y; y < last.y && !out.surface; ++y) {
        const float *above = window.row(y), *below = window.row(y + 1);
        for (int x = first.x; x < last.x && !out.surface; ++x) {
            const float diagonal = above[x + 1] + below[x];
            out.surface = !std::isnan(diagonal + above[x]) || !std::isnan(diagonal + below[x + 1]);
        }
    }
    return out;
}

void addError(const HeightWindow& window, const HeightLevels& levels, int level, glm::ivec2 first,
              glm::ivec2 last, bool complete, TileHeights& out) {
    const int step = 1 << level;
    const int mostX = levels.pixels.x - 1, mostY = levels.pixels.y - 1;
    float most = 0.0f;
    for (int y = first.y; y <= last.y; ++y) {
        const float* row = window.row(y);
        // The row between two cells belongs to the upper one, so that no cell below is needed.
        const int y0 = (std::max(y - 1, first.y) / step) * step;
        const int y1 = std::min(y0 + step, mostY);
        for (int from = first.x; from < last.x;) {
            const int x0 = (from / step) * step, x1 = std::min(x0 + step, mostX);
            const int to = std::min(x1, last.x);
            const Cell cell = cellAt(window, x0, y0, x1, y1);
            // A cell larger than the tile has corners elsewhere.
            const bool whole =
                complete && (step <= kTileCells || (cell.upperThere() && cell.lowerThere()));
            if (whole)
                most = std::max(most, completeRow(row, cell, y, from, to));
            else
                ragged(row, cell, y, from, to, out);
            from = to;
        }
    }
    out.error = std::max(out.error, most);
    for (int y0 = (first.y / step) * step; y0 < last.y; y0 += step)
        for (int x0 = (first.x / step) * step; x0 < last.x; x0 += step)
            if (x0 + step > mostX || y0 + step > mostY)
                alongDiagonal(
                    window,
                    cellAt(window, x0, y0, std::min(x0 + step, mostX), std::min(y0 + step, mostY)),
                    first, last, out);
}

} // namespace gnomon
