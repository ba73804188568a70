#include "viewer/place/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

namespace gnomon::builtin {
namespace {

// What a cell of the plan holds on average; only sizes the river and the hills.
constexpr double kBuildingsACell = 27.0;
constexpr double kPlainMetres = 7.0; // the city's ground above the river's surface

enum Salt : std::uint64_t { kHills = 10, kPlain, kRank, kPark, kStreet };

} // namespace

double onLattice(double metres) {
    return std::floor(metres / kLatticeMetres + 0.5) * kLatticeMetres;
}

double valueNoise(std::uint64_t seed, double x, double y) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto ix = std::int64_t(fx), iy = std::int64_t(fy);
    const double tx = x - fx, ty = y - fy;
    const auto ease = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
    const double ex = ease(tx), ey = ease(ty);
    // One mixing is enough here, and noise is most of the work of painting the ground.
    const auto at = [&](int dx, int dy) {
        return unitOf(mix64(seed * 0xd6e8feb86659fd93ull +
                            std::uint64_t(ix + dx) * 0x9e3779b97f4a7c15ull +
                            std::uint64_t(iy + dy) * 0xc2b2ae3d27d4eb4full));
    };
    return mix(mix(at(0, 0), at(1, 0), ex), mix(at(0, 1), at(1, 1), ex), ey);
}

std::vector<glm::dvec2> Building::footprint(double grow) const {
    const glm::dvec2 h = half + glm::dvec2(grow);
    std::vector<glm::dvec2> local;
    if (notch.x > 0) {
        const glm::dvec2 n = half - notch + glm::dvec2(grow);
        local = {{-h.x, -h.y}, {h.x, -h.y}, {h.x, n.y}, {n.x, n.y}, {n.x, h.y}, {-h.x, h.y}};
        for (auto& p : local)
            p *= glm::dvec2(notchCorner);
        if (notchCorner.x * notchCorner.y < 0)
            std::reverse(local.begin(), local.end());
    } else {
        local = {{-h.x, -h.y}, {h.x, -h.y}, {h.x, h.y}, {-h.x, h.y}};
    }
    const double c = std::cos(headingRadians), s = std::sin(headingRadians);
    for (auto& p : local)
        p = centre + glm::dvec2(c * p.x - s * p.y, s * p.x + c * p.y);
    return local;
}

Plan::Plan(std::uint64_t seed, std::size_t buildings) : seed_(seed) {
    const double cellsNeeded = std::max(3.0, double(buildings) / kBuildingsACell);
    radius_ = kCellMetres * std::sqrt(cellsNeeded / std::numbers::pi);
    riverHalf_ = std::clamp(0.04 * radius_, 11.0, 32.0);
    riverSwing_ = std::clamp(0.12 * radius_, 18.0, 400.0);
    riverLength_ = std::clamp(2.2 * radius_, 420.0, 6000.0);
    hills_ = std::clamp(0.07 * radius_, 14.0, 160.0);
    bridgeCell_ = -1 - std::max(1, int(std::lround(0.3 * radius_ / kCellMetres)));
    bridgeY_ = (bridgeCell_ + 0.5) * kCellMetres;
    deck_ = kPlainMetres;
    levels_ = 2;
    while (cells() * kCellMetres < 2.3 * radius_ + kCellMetres)
        ++levels_;

    // Nearest cells first, with a ragged edge; the last takes what is left.
    for (;; ++levels_) {
        std::vector<std::tuple<double, int, int>> order;
        const int n = cells(), first = firstCell();
        for (int iy = first; iy < first + n; ++iy)
            for (int ix = first; ix < first + n; ++ix) {
                const glm::dvec2 middle = (glm::dvec2(ix, iy) + 0.5) * kCellMetres - centre();
                const double ragged = 0.8 + 0.4 * unitOf(hash(seed_, ix, iy, kRank));
                // The way of the flight is built up first.
                const double turn = onAxis(ix, iy) ? 0.0 : 1.0;
                order.emplace_back(std::hypot(middle.x, middle.y) * ragged * turn, ix, iy);
            }
        std::sort(order.begin(), order.end());
        // First all are open, so that cell() lays them out whole.
        quota_.assign(std::size_t(n) * n, kAllBuildings);
        std::vector<std::uint16_t> quota(quota_.size(), kCountryCell);
        std::size_t left = buildings;
        for (const auto& [distance, ix, iy] : order) {
            if (left == 0 && !onAxis(ix, iy))
                continue;
            const std::size_t here = cell(ix, iy).buildings.size();
            quota[indexOf(ix, iy)] = std::uint16_t(std::min(here, left));
            left -= std::min(here, left);
        }
        quota_ = std::move(quota);
        if (left == 0)
            break;
    }
}

std::size_t Plan::indexOf(int ix, int iy) const {
    return std::size_t(iy - firstCell()) * std::size_t(cells()) + std::size_t(ix - firstCell());
}

CellKind Plan::kind(int ix, int iy) const {
    const int last = firstCell() + cells() - 1;
    if (ix < firstCell() || iy < firstCell() || ix > last || iy > last ||
        quota_[indexOf(ix, iy)] == kCountryCell)
        return CellKind::Country;
    if (ix == 0 && iy == 0)
        return CellKind::Square;
    if (ix == 0 && iy == bridgeCell_)
        return CellKind::Bridge;
    const bool parkAtTheSquare = ix == -1 && (iy == 0 || (radius_ > 800 && iy == 1));
    if (parkAtTheSquare || (ix != 0 && unitOf(hash(seed_, ix, iy, kPark)) < 0.04))
        return CellKind::Park;
    return CellKind::Blocks;
}

bool Plan::detailed(int ix, int iy) const {
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (kind(ix + dx, iy + dy) != CellKind::Country)
                return true;
    return false;
}

double Plan::riverDistance(glm::dvec2 p) const {
    const double k = 2 * std::numbers::pi / riverLength_, x = p.x - axisX();
    // Both terms have no slope at the bridge, so it crosses at a right angle.
    const double y =
        bridgeY_ + riverSwing_ * (0.7 * (std::cos(k * x) - 1) + 0.3 * (std::cos(1.7 * k * x) - 1) +
                                  0.6 * smoothstep(0, riverLength_, x));
    const double slope = -riverSwing_ * k * (0.7 * std::sin(k * x) + 0.51 * std::sin(1.7 * k * x));
    return std::abs(p.y - y) / std::sqrt(1 + slope * slope);
}

double Plan::avenueDistance(glm::dvec2 p) const {
    constexpr double kFar = 1e9;
    // About 37°, as 3-4-5.
    const glm::dvec2 along{0.8, 0.6}, d = p - centre();
    const double s = d.x * along.x + d.y * along.y, across = d.y * along.x - d.x * along.y;
    if (std::abs(across) > kCellMetres || std::abs(s) < 95 || std::abs(s) > 0.9 * radius_ ||
        riverDistance(p) < riverHalf_ + 22)
        return kFar;
    return across;
}

double Plan::streetHalf(bool vertical, int line) const {
    const double r = unitOf(hash(seed_, line, vertical, kStreet));
    return line % 8 == 0 ? 11.0 : 7.5 + 2.5 * r;
}

double Plan::terrain(glm::dvec2 p) const {
    const double r = glm::distance(p, centre());
    const double rolling = valueNoise(seed_ + kPlain, p.x / 260, p.y / 260) - 0.5;
    const double wide = valueNoise(seed_ + kHills, p.x / (1.1 * radius_), p.y / (1.1 * radius_));
    const double small = valueNoise(seed_ + kHills + 7, p.x / 310, p.y / 310);
    const double d = riverDistance(p);
    double z = kPlainMetres + 3.0 * rolling;
    z += hills_ * smoothstep(0.75 * radius_, 1.9 * radius_, r) * (0.75 * wide + 0.35 * small) *
         smoothstep(riverHalf_ + 20, riverHalf_ + 20 + 0.5 * radius_, d);
    // The bridge's road and the tower's square are level.
    const double road =
        smoothstep(26, 8, std::abs(p.x - axisX())) *
        smoothstep(deckHalfLength() + 60, deckHalfLength() + 8, std::abs(p.y - bridgeY_));
    z = mix(z, kPlainMetres, road);
    z = mix(z, kPlainMetres + 0.5, smoothstep(90, 45, r));
    return z * smoothstep(riverHalf_, riverHalf_ + 28, d);
}

HeightRange Plan::heightRange() const {
    // Foundations 1.5 m below the river's surface and piers 3 m; the tower, or hills with trees.
    const double hills = kPlainMetres + 1.5 + 1.1 * hills_ + 17.0;
    return {-4.0, std::max(kPlainMetres + 1.0 + towerMetres(), hills)};
}

double Plan::gridHeight(std::int64_t i, std::int64_t j) const {
    return onLattice(terrain({double(i) * kGroundStepMetres, double(j) * kGroundStepMetres}));
}

double Plan::ground(glm::dvec2 p, double stepMetres) const {
    const auto steps = std::int64_t(stepMetres / kGroundStepMetres);
    const double fx = std::floor(p.x / stepMetres), fy = std::floor(p.y / stepMetres);
    const double tx = p.x / stepMetres - fx, ty = p.y / stepMetres - fy;
    const auto at = [&](int dx, int dy) {
        return gridHeight((std::int64_t(fx) + dx) * steps, (std::int64_t(fy) + dy) * steps);
    };
    const double sw = at(0, 0), ne = at(1, 1);
    if (tx > ty) {
        const double se = at(1, 0);
        return sw + tx * (se - sw) + ty * (ne - se);
    }
    const double nw = at(0, 1);
    return sw + ty * (nw - sw) + tx * (ne - nw);
}

double Plan::marginAt(Side side, int ix, int iy) const {
    const bool vertical = side == Side::West || side == Side::East;
    const int line = vertical ? ix + (side == Side::East) : iy + (side == Side::North);
    const int nx = ix + (side == Side::East) - (side == Side::West);
    const int ny = iy + (side == Side::North) - (side == Side::South);
    const bool city = kind(ix, iy) != CellKind::Country || kind(nx, ny) != CellKind::Country;
    if (city)
        return streetHalf(vertical, line);
    return line % 8 == 0 ? 4.5 : 0.0; // a country road
}

} // namespace gnomon::builtin
