#include "streaming/terrain/drape_coverage.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon {

namespace {

// Texels between places that are kept: over a whole hemisphere of 512 texels the map between is
// then off by a fifth of a texel, over a city by nothing.
constexpr int kNodeTexels = 16;

std::vector<int> nodes(int count) {
    const int gaps = std::max(1, (count - 1 + kNodeTexels - 1) / kNodeTexels);
    std::vector<int> at;
    for (int i = 0; i <= gaps; ++i)
        at.push_back(int(std::int64_t(i) * (count - 1) / gaps));
    return at;
}

glm::dvec3 onSphere(glm::dvec2 lonLat) {
    const glm::dvec2 r = lonLat * (std::numbers::pi / 180.0);
    return {std::cos(r.y) * std::cos(r.x), std::cos(r.y) * std::sin(r.x), std::sin(r.y)};
}

// One side of the clipping rectangle (Sutherland and Hodgman, 1974): keep where inside > 0.
template <class Inside>
std::vector<glm::dvec2> clipped(const std::vector<glm::dvec2>& ring, const Inside& inside) {
    std::vector<glm::dvec2> out;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 a = ring[i], b = ring[(i + 1) % ring.size()];
        const double da = inside(a), db = inside(b);
        if (da >= 0.0)
            out.push_back(a);
        if ((da < 0.0) != (db < 0.0))
            out.push_back(a + (b - a) * (da / (da - db)));
    }
    return out;
}

} // namespace

TexelPlane::TexelPlane(std::span<const glm::dvec2> lonLat, int width)
    : columnsAt_(nodes(width)), rowsAt_(nodes(int(lonLat.size()) / width)) {
    const auto place = [&](int column, int row) {
        return lonLat[std::size_t(row) * std::size_t(width) + std::size_t(column)];
    };
    const glm::dvec2 middle = place(columnsAt_[columnsAt_.size() / 2], rowsAt_[rowsAt_.size() / 2]);
    const double lon = middle.x * (std::numbers::pi / 180.0);
    up_ = onSphere(middle);
    east_ = {-std::sin(lon), std::cos(lon), 0.0};
    north_ = glm::cross(up_, east_);
    for (const int row : rowsAt_)
        for (const int column : columnsAt_)
            nodes_.push_back(onPlane(onSphere(place(column, row))));
    low_ = high_ = nodes_[0];
    for (const glm::dvec2& p : nodes_) {
        low_ = glm::min(low_, p);
        high_ = glm::max(high_, p);
    }
    const glm::dvec2 margin = (high_ - low_) * 0.05;
    low_ -= margin;
    high_ += margin;
}

glm::dvec2 TexelPlane::onPlane(const glm::dvec3& p) const {
    constexpr double kNearAntipode = 1e-6;
    return glm::dvec2(glm::dot(p, east_), glm::dot(p, north_)) /
           std::max(1.0 + glm::dot(p, up_), kNearAntipode);
}

// Newton's steps in the grid's own cells, continued beyond its border.
glm::dvec2 TexelPlane::texel(glm::dvec2 plane, glm::dvec2 guess) const {
    constexpr int kMostSteps = 12;
    constexpr double kClose = 1e-4; // texels
    glm::dvec2 at = guess;
    const auto cell = [](const std::vector<int>& nodes, double x) {
        const auto next = std::upper_bound(nodes.begin(), nodes.end(), x);
        return std::size_t(std::clamp<std::ptrdiff_t>(next - nodes.begin() - 1, 0,
                                                      std::ptrdiff_t(nodes.size()) - 2));
    };
    for (int step = 0; step < kMostSteps; ++step) {
        const std::size_t i = cell(columnsAt_, at.x), j = cell(rowsAt_, at.y);
        const double across = columnsAt_[i + 1] - columnsAt_[i];
        const double down = rowsAt_[j + 1] - rowsAt_[j];
        const double s = (at.x - columnsAt_[i]) / across, t = (at.y - rowsAt_[j]) / down;
        const glm::dvec2* n = &nodes_[j * columnsAt_.size() + i];
        const glm::dvec2 a = n[0], b = n[1], c = n[columnsAt_.size()], d = n[columnsAt_.size() + 1];
        const glm::dvec2 alongS = ((1 - t) * (b - a) + t * (d - c)) / across;
        const glm::dvec2 alongT = ((1 - s) * (c - a) + s * (d - b)) / down;
        const glm::dvec2 off =
            plane - ((1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d));
        const double area = alongS.x * alongT.y - alongS.y * alongT.x;
        if (!(std::abs(area) > 0.0))
            break; // a pole: the last place is as good as any
        const glm::dvec2 move((off.x * alongT.y - off.y * alongT.x) / area,
                              (alongS.x * off.y - alongS.y * off.x) / area);
        at += move;
        if (glm::dot(move, move) < kClose * kClose)
            break;
    }
    // Beyond the border by more than the tile's own size nothing is told apart.
    const glm::dvec2 size(columnsAt_.back(), rowsAt_.back());
    return std::isfinite(at.x + at.y) ? glm::clamp(at, -size, 2.0 * size) : guess;
}

std::vector<glm::dvec2> TexelPlane::texels(std::span<const glm::dvec3> ring) const {
    std::vector<glm::dvec2> points;
    for (const glm::dvec3& p : ring)
        points.push_back(onPlane(p));
    points = clipped(points, [&](glm::dvec2 p) { return p.x - low_.x; });
    points = clipped(points, [&](glm::dvec2 p) { return high_.x - p.x; });
    points = clipped(points, [&](glm::dvec2 p) { return p.y - low_.y; });
    points = clipped(points, [&](glm::dvec2 p) { return high_.y - p.y; });
    glm::dvec2 at(0.5 * columnsAt_.back(), 0.5 * rowsAt_.back());
    for (glm::dvec2& p : points) {
        at = texel(p, at);
        p = at + 0.5; // from the texels' centres to their corners
    }
    return points;
}

Coverage::Coverage(int width, int height)
    : width_(width), height_(height), steps_(std::size_t(width + 2) * std::size_t(height), 0.0f) {}

void Coverage::add(std::span<const glm::dvec2> ring) {
    for (std::size_t i = 0; i < ring.size(); ++i)
        addEdge(ring[i], ring[(i + 1) % ring.size()]);
}

// Row by row: an edge changes the cover of all texels to its right by the part of the row it runs
// over, and that of the texels it runs through by the area to its right.
void Coverage::addEdge(glm::dvec2 a, glm::dvec2 b) {
    if (a.y == b.y)
        return;
    const float sense = a.y < b.y ? 1.0f : -1.0f;
    if (a.y > b.y)
        std::swap(a, b);
    const double slope = (b.x - a.x) / (b.y - a.y);
    const int first = std::max(0, int(std::floor(a.y)));
    const int end = std::min(height_, int(std::ceil(b.y)));
    for (int row = first; row < end; ++row) {
        const double top = std::max(a.y, double(row)), bottom = std::min(b.y, row + 1.0);
        const double high = bottom - top;
        if (!(high > 0.0))
            continue;
        // Left of the texture counts from its border on, right of it not at all.
        const auto within = [&](double x) { return std::clamp(x, 0.0, double(width_)); };
        double x0 = a.x + slope * (top - a.y), x1 = a.x + slope * (bottom - a.y);
        if (x0 > x1)
            std::swap(x0, x1);
        float* const steps = &steps_[std::size_t(row) * std::size_t(width_ + 2)];
        // The parts beyond either border, then the part inside, texel by texel.
        const double wide = x1 - x0;
        const auto part = [&](double from, double to) {
            return wide > 0.0 ? high * (to - from) / wide : 0.0;
        };
        const double inside0 = within(x0), inside1 = within(x1);
        const double left =
            wide > 0.0 ? part(std::min(x0, 0.0), std::min(x1, 0.0)) : (x0 < 0.0 ? high : 0.0);
        steps[0] += sense * float(left);
        if (wide > 0.0 ? !(inside1 > inside0) : !(x0 >= 0.0 && x0 < width_))
            continue;
        const int last = std::min(int(std::floor(inside1)), width_ - 1);
        for (int column = std::min(int(std::floor(inside0)), width_ - 1); column <= last;
             ++column) {
            const double from = std::max(inside0, double(column));
            const double to = std::min(inside1, column + 1.0);
            const double share = wide > 0.0 ? part(from, to) : high;
            const double rightOf = column + 1.0 - 0.5 * (from + to); // of the texel's width
            steps[column] += sense * float(share * rightOf);
            steps[column + 1] += sense * float(share * (1.0 - rightOf));
        }
    }
}

std::vector<float> Coverage::shares() const {
    std::vector<float> out;
    out.reserve(std::size_t(width_) * std::size_t(height_));
    for (int row = 0; row < height_; ++row) {
        float cover = 0.0f;
        const float* const steps = &steps_[std::size_t(row) * std::size_t(width_ + 2)];
        for (int column = 0; column < width_; ++column) {
            cover += steps[column];
            // What remains of sums that cancel is no cover.
            constexpr float kNoise = 1e-4f;
            const float share = std::abs(cover);
            out.push_back(share < kNoise ? 0.0f : std::min(share, 1.0f));
        }
    }
    return out;
}

} // namespace gnomon
