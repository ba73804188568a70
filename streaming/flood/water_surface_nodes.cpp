#include "streaming/flood/water_surface_nodes.h"

#include "geo/ellipsoid.h"
#include "streaming/flood/unstructured_place.h"

#include <limits>

namespace gnomon {

namespace {

// A mesh is some this many cells across: small enough to be culled, large enough to be drawn at
// once; but no farther than this, so that floats about its middle stay within a millimetre.
constexpr int kPatchCells = 128, kFewestCells = 16;
constexpr double kPatchMetres = 8192.0;

double turn(double from, double to) {
    return std::remainder(to - from, 360.0);
}

glm::dvec2 way(glm::dvec2 from, glm::dvec2 to) {
    return {turn(from.x, to.x), to.y - from.y};
}

} // namespace

WaterNodes::WaterNodes(const FloodGeometry& geometry) : geometry_(geometry) {
    if (geometry.columns > 1 && geometry.rows > 1) {
        columns_ = geometry.columns + 2;
        rows_ = geometry.rows + 2;
        size_ = std::size_t(columns_) * std::size_t(rows_);
        complete_ = std::all_of(geometry.lonLat.begin(), geometry.lonLat.end(),
                                [](glm::dvec2 p) { return std::isfinite(p.x); });
        findSense();
        makeGridPatches();
    } else {
        size_ = geometry.lonLat.size();
        triangles_ = geometry.triangles;
        makeMeshPatches();
    }
}

glm::dvec2 WaterNodes::lonLat(std::uint32_t node) const {
    if (columns_ == 0)
        return geometry_.lonLat[node];
    const int column = int(node % std::uint32_t(columns_)) - 1;
    const int row = int(node / std::uint32_t(columns_)) - 1;
    const auto at = [&](int c, int r) {
        return geometry_.lonLat[std::size_t(r) * std::size_t(geometry_.columns) + std::size_t(c)];
    };
    const int c = std::clamp(column, 0, geometry_.columns - 1);
    const int r = std::clamp(row, 0, geometry_.rows - 1);
    const glm::dvec2 here = at(c, r);
    if (c == column && r == row)
        return here;
    // Half a cell further along.
    glm::dvec2 out = here;
    if (c != column)
        out += 0.5 * way(at(column < c ? c + 1 : c - 1, r), here);
    if (r != row)
        out += 0.5 * way(at(c, row < r ? r + 1 : r - 1), here);
    return {std::remainder(out.x, 360.0), out.y};
}

double WaterNodes::cellArea(std::uint32_t node) const {
    if (columns_ == 0)
        return geometry_.cellArea[node];
    const int column = int(node % std::uint32_t(columns_)) - 1;
    const int row = int(node / std::uint32_t(columns_)) - 1;
    if (column < 0 || row < 0 || column >= geometry_.columns || row >= geometry_.rows)
        return 0.0;
    return geometry_
        .cellArea[std::size_t(row) * std::size_t(geometry_.columns) + std::size_t(column)];
}

void WaterNodes::findSense() {
    for (int row = 0; row + 1 < geometry_.rows; ++row)
        for (int column = 0; column + 1 < geometry_.columns; ++column) {
            const std::size_t a =
                std::size_t(row) * std::size_t(geometry_.columns) + std::size_t(column);
            const double area = areaOnEarth({geometry_.lonLat[a], geometry_.lonLat[a + 1],
                                             geometry_.lonLat[a + std::size_t(geometry_.columns)]});
            if (std::isfinite(area) && area != 0.0) {
                reversed_ = area > 0.0;
                return;
            }
        }
}

double WaterNodes::cellMetres() const {
    // The largest will do: grids are even or nearly so.
    const auto largest = std::max_element(geometry_.cellArea.begin(), geometry_.cellArea.end());
    return largest == geometry_.cellArea.end() ? 1.0 : std::sqrt(double(*largest));
}

void WaterNodes::makeGridPatches() {
    const int cells =
        std::clamp(int(kPatchMetres / std::max(cellMetres(), 1e-3)), kFewestCells, kPatchCells);
    for (int row = 0; row + 1 < rows_; row += cells)
        for (int column = 0; column + 1 < columns_; column += cells) {
            Patch patch;
            patch.low = {column, row};
            patch.high = {std::min(column + cells, columns_ - 1), std::min(row + cells, rows_ - 1)};
            measure(patch);
            patches_.push_back(patch);
        }
}

void WaterNodes::makeMeshPatches() {
    if (!triangles_.empty())
        split(0, triangles_.size());
}

// Halves the longer way until few enough are left.
void WaterNodes::split(std::size_t from, std::size_t to) {
    constexpr std::size_t kMost = 2 * std::size_t(kPatchCells) * kPatchCells;
    Patch patch;
    patch.first = from;
    patch.triangles = to - from;
    measure(patch);
    if (to - from <= kMost) {
        patches_.push_back(patch);
        return;
    }
    const double shrink = std::cos(patch.middle.y * kRadiansPerDegree);
    const int axis = patch.reach.x * shrink > patch.reach.y ? 0 : 1;
    const auto centre = [&](const NodeTriangle& t) {
        double sum = 0.0;
        for (const std::uint32_t node : t)
            sum += way(patch.middle, geometry_.lonLat[node])[axis];
        return sum;
    };
    const std::size_t middle = (from + to) / 2;
    const auto at = [&](std::size_t i) { return triangles_.begin() + std::ptrdiff_t(i); };
    std::nth_element(at(from), at(middle), at(to), [&](const auto& a, const auto& b) {
        return std::pair(centre(a), a) < std::pair(centre(b), b);
    });
    split(from, middle);
    split(middle, to);
}

void WaterNodes::measure(Patch& patch) const {
    bool any = false;
    glm::dvec2 start(0.0), low(0.0), high(0.0);
    const auto add = [&](glm::dvec2 p) {
        if (!std::isfinite(p.x))
            return;
        if (!any)
            start = p;
        any = true;
        const glm::dvec2 off = way(start, p);
        low = {std::min(low.x, off.x), std::min(low.y, off.y)};
        high = {std::max(high.x, off.x), std::max(high.y, off.y)};
    };
    if (columns_ > 0) {
        for (int row = patch.low.y; row <= patch.high.y; ++row)
            for (int column = patch.low.x; column <= patch.high.x; ++column)
                add(lonLat(std::uint32_t(row) * std::uint32_t(columns_) + std::uint32_t(column)));
    } else {
        for (std::size_t i = patch.first; i < patch.first + patch.triangles; ++i)
            for (const std::uint32_t node : triangles_[i])
                add(geometry_.lonLat[node]);
    }
    patch.middle = start + 0.5 * (low + high);
    patch.middle.x = std::remainder(patch.middle.x, 360.0);
    patch.reach = 0.5 * (high - low);
}

} // namespace gnomon
