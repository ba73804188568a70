// How a cell of the plan is filled: streets, blocks, lots with buildings, trees, sheds.
#include "viewer/place/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

namespace gnomon::builtin {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = std::numbers::pi;
// Neighbours never touch: coincident walls would flicker, and would weld two solids into one.
constexpr double kGapMetres = 0.4;
constexpr double kInnerStreetHalf = 6.0;
constexpr double kAxisStreetHalf = 8.0;

glm::vec3 rgb(int r, int g, int b) {
    return glm::vec3(float(r), float(g), float(b)) / 255.0f;
}

glm::vec3 pick(Random& random, std::span<const glm::vec3> palette) {
    const glm::vec3 c = palette[std::size_t(random.pick(int(palette.size())))];
    return c * float(random.in(0.94, 1.04));
}

const std::array kPlaster{rgb(236, 226, 206), rgb(231, 212, 178), rgb(222, 198, 168),
                          rgb(240, 236, 226), rgb(214, 206, 192), rgb(226, 204, 190),
                          rgb(205, 214, 212), rgb(196, 152, 126), rgb(182, 128, 104)};
const std::array kStone{rgb(214, 212, 206), rgb(196, 200, 204), rgb(226, 222, 212),
                        rgb(180, 188, 196)};
const std::array kTiles{rgb(176, 92, 68), rgb(164, 84, 64),   rgb(186, 106, 78),
                        rgb(150, 80, 66), rgb(104, 108, 116), rgb(92, 96, 104)};
const std::array kFlatRoofs{rgb(168, 166, 162), rgb(150, 150, 150), rgb(186, 182, 174),
                            rgb(142, 158, 128)};

} // namespace

struct CellLayout {
    const Plan& plan;
    int ix, iy;
    Cell& cell;
    Random random;
    double remote; // 0 at the centre, 1 at the built-up edge

    CellLayout(const Plan& p, int x, int y, Cell& c)
        : plan(p), ix(x), iy(y), cell(c), random(hash(p.seed(), x, y, 30)),
          remote(glm::distance(c.rect.centre(), Plan::centre()) / p.radiusMetres()) {}

    void run();

  private:
    void country();
    void splitStreets(const Rect& net, bool axisStreet);
    void block(const Rect& rect);
    void perimeter(const Rect& rect, double depth);
    void row(const Rect& strip, bool alongX, int inward);
    void detachedHouses(const Rect& rect);
    void highRises(const Rect& rect);
    void corner(const Rect& rect, int sx, int sy, double a, double b, double depth, bool ell);
    Building house(const Rect& rect, bool streetAlongX, bool joined);
    void finish(Building b);
    void parkTrees();
    void riverTrees();
    void avenueTrees();
    void streetTrees();
    void squareTrees();
    void tree(glm::dvec2 at, double low, double high, TreeKind kind);
    void shelter();
    bool freeFor(glm::dvec2 at, double radius, double fromWalls) const;
    bool lineBetween(double from, double to, double& line, double half);
};

namespace {

double circumradius(const Building& b) {
    return std::hypot(b.half.x, b.half.y);
}

} // namespace

void CellLayout::finish(Building b) {
    // Too near the river or the diagonal avenue: left free.
    const double r = circumradius(b);
    if (plan.riverDistance(b.centre) < plan.riverHalfWidth() + 14 + r ||
        std::abs(plan.avenueDistance(b.centre)) < 11 + r)
        return;
    double low = 1e9, high = -1e9;
    for (const glm::dvec2 p : b.footprint()) {
        if (std::abs(plan.avenueDistance(p)) < 11)
            return;
        const double z = plan.ground(p);
        low = std::min(low, z);
        high = std::max(high, z);
    }
    b.baseMetres = onLattice(low - 1.5);
    b.groundMetres = high;
    b.eavesMetres += high;
    cell.buildings.push_back(std::move(b));
}

Building CellLayout::house(const Rect& rect, bool streetAlongX, bool joined) {
    Building b;
    b.centre = rect.centre();
    b.half = {rect.width() / 2, rect.height() / 2};
    const double nearness = std::clamp(1.0 - remote, 0.0, 1.0);
    const int storeys =
        joined ? 2 + int(random.unit() * 2.4 + 2.6 * nearness) : 1 + int(random.unit() * 1.9);
    b.storeyMetres = joined ? 3.2 : 2.8;
    b.eavesMetres = storeys * b.storeyMetres + 0.7;
    b.wallColor = pick(random, kPlaster);
    const double r = random.unit();
    const double narrow = std::min(b.half.x, b.half.y);
    if (joined && (storeys >= 6 || r < 0.22)) {
        b.roof = Roof::Flat;
        b.roofColor = pick(random, kFlatRoofs);
        b.roofBox = random.chance(0.5);
        return b;
    }
    b.roof = r < 0.3 && !joined ? Roof::Hip : r > 0.93 ? Roof::Shed : Roof::Gable;
    b.ridgeAlongX = joined ? streetAlongX : b.half.x >= b.half.y;
    const double run = b.ridgeAlongX ? b.half.y : b.half.x;
    b.roofMetres = b.roof == Roof::Shed  ? 0.35 * run
                   : b.roof == Roof::Hip ? narrow * random.in(0.6, 0.8)
                                         : run * random.in(0.65, 0.95);
    b.overhangMetres = b.roof != Roof::Shed && random.chance(0.6) ? random.in(0.3, 0.55) : 0.0;
    b.gableOverhangMetres = joined ? 0.1 : b.overhangMetres;
    b.chimney = b.roof != Roof::Shed && random.chance(0.7);
    b.roofColor = pick(random, kTiles);
    return b;
}

// A strip of houses side by side along a street; the courtyard is towards ±1 across it.
void CellLayout::row(const Rect& strip, bool alongX, int inward) {
    double at = alongX ? strip.west : strip.south;
    const double end = alongX ? strip.east : strip.north;
    while (end - at > 6.5) {
        double width = random.in(8.5, 15.5);
        if (end - at < width + 8)
            width = end - at < 17 ? end - at : (end - at) / 2;
        Rect lot = alongX ? Rect{at, strip.south, at + width - kGapMetres, strip.north}
                          : Rect{strip.west, at, strip.east, at + width - kGapMetres};
        const double back = random.in(0, 1.6); // not all are equally deep
        (alongX ? (inward > 0 ? lot.north : lot.south) : (inward > 0 ? lot.east : lot.west)) -=
            inward * back;
        if (!random.chance(0.04 + 0.1 * remote))
            finish(house(lot, alongX, true));
        at += width;
    }
}

void CellLayout::corner(const Rect& rect, int sx, int sy, double a, double b, double depth,
                        bool ell) {
    Rect r;
    const double h = ell ? b : depth;
    r.west = sx < 0 ? rect.west : rect.east - a;
    r.east = r.west + a;
    r.south = sy < 0 ? rect.south : rect.north - h;
    r.north = r.south + h;
    Building house_ = house(r, true, true);
    if (ell) {
        house_.notch = {a - depth, b - depth};
        house_.notchCorner = {-sx, -sy};
        house_.roof = Roof::Flat;
        house_.roofMetres = 0;
        house_.overhangMetres = house_.gableOverhangMetres = 0;
        house_.chimney = false;
        house_.roofColor = pick(random, kFlatRoofs);
    }
    finish(std::move(house_));
}

// Houses along all four sides of a block, around a courtyard; some corners are one L.
void CellLayout::perimeter(const Rect& rect, double depth) {
    double a[2][2], b[2][2]; // by corner: extent along x and y
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x) {
            const bool ell = random.chance(0.45);
            a[x][y] = depth + random.in(2.0, 5.0);
            b[x][y] = ell ? depth + random.in(2.0, 5.0) : depth;
            corner(rect, x ? 1 : -1, y ? 1 : -1, a[x][y], b[x][y], depth, ell);
        }
    const double g = kGapMetres;
    row({rect.west + a[0][0] + g, rect.south, rect.east - a[1][0], rect.south + depth}, true, 1);
    row({rect.west + a[0][1] + g, rect.north - depth, rect.east - a[1][1], rect.north}, true, -1);
    row({rect.west, rect.south + b[0][0] + g, rect.west + depth, rect.north - b[0][1]}, false, 1);
    row({rect.east - depth, rect.south + b[1][0] + g, rect.east, rect.north - b[1][1]}, false, -1);
}

void CellLayout::detachedHouses(const Rect& rect) {
    const int nx = std::max(1, int(rect.width() / random.in(16, 21)));
    const int ny = std::max(1, int(rect.height() / random.in(17, 23)));
    const double w = rect.width() / nx, h = rect.height() / ny;
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i) {
            const glm::dvec2 middle{rect.west + (i + 0.5) * w, rect.south + (j + 0.5) * h};
            if (random.chance(0.08)) {
                tree(middle, 7, 12, TreeKind::Broad);
                continue;
            }
            const glm::dvec2 half{random.in(4.2, std::min(6.2, w / 2 - 2.4)),
                                  random.in(4.0, std::min(6.0, h / 2 - 2.6))};
            const glm::dvec2 c = middle + glm::dvec2(random.in(-0.6, 0.6), random.in(-0.8, 0.8));
            Building b =
                house({c.x - half.x, c.y - half.y, c.x + half.x, c.y + half.y}, true, false);
            b.headingRadians = random.in(-0.07, 0.07);
            finish(std::move(b));
            tree({middle.x + (random.chance(0.5) ? 0.42 : -0.42) * w, middle.y + 0.42 * h}, 4, 7.5,
                 random.chance(0.8) ? TreeKind::Broad : TreeKind::Conifer);
            if (random.chance(0.06))
                cell.sheds.push_back({{middle.x - 0.36 * w, middle.y - 0.38 * h},
                                      random.pick(4) * kPi / 2,
                                      {2.6, 1.9, 2.1}});
        }
}

void CellLayout::highRises(const Rect& rect) {
    const int n = rect.width() > 60 ? 2 : 1;
    for (int i = 0; i < n; ++i) {
        Building b;
        b.half = {random.in(8.5, 12.0), random.in(8.5, 14.0)};
        b.half.x = std::min(b.half.x, rect.width() / n / 2 - 4);
        b.half.y = std::min(b.half.y, rect.height() / 2 - 4);
        b.centre = {rect.west + rect.width() * (i + 0.5) / n, rect.centre().y};
        b.facade = Facade::Offices;
        b.storeyMetres = 3.5;
        b.eavesMetres = b.storeyMetres * int(random.in(8, 17)) + 1.0;
        b.wallColor = pick(random, kStone);
        b.roofColor = pick(random, kFlatRoofs);
        b.roofBox = true;
        finish(std::move(b));
    }
    for (int i = 0; i < 10; ++i)
        tree({random.in(rect.west, rect.east), random.in(rect.south, rect.north)}, 5, 9,
             TreeKind::Broad);
}

void CellLayout::block(const Rect& rect) {
    if (rect.width() < 16 || rect.height() < 16)
        return;
    const bool tall = remote < 0.32 && random.chance(0.2) && cell.rect.centre().x != Plan::axisX();
    const bool houses = remote + random.in(-0.14, 0.14) > 0.72;
    cell.blocks.push_back({rect, houses || tall || remote > 0.5});
    const double small = std::min(rect.width(), rect.height());
    if (houses)
        return detachedHouses(rect.inset(1.5));
    if (tall && small > 30)
        return highRises(rect);
    const Rect built = rect.inset(random.in(0.3, 1.0));
    const double depth = random.in(9.5, 12.0);
    if (small >= 2 * depth + 13) {
        perimeter(built, depth);
        const glm::dvec2 c = rect.centre();
        const glm::dvec2 yard = glm::dvec2(rect.width(), rect.height()) / 2.0 - depth - 3.5;
        for (int i = 0; i < 4; ++i)
            tree(c + yard * glm::dvec2(random.in(-1, 1), random.in(-1, 1)), 5, 10, TreeKind::Broad);
        if (random.chance(0.12))
            cell.sheds.push_back({c, random.pick(4) * kPi / 2, {4, 2.5, 2.3}});
    } else if (rect.width() >= rect.height()) {
        row({built.west, built.south, built.east, built.south + depth}, true, 1);
        if (rect.height() > 2 * depth + 5)
            row({built.west, built.north - depth, built.east, built.north}, true, -1);
    } else {
        row({built.west, built.south, built.west + depth, built.north}, false, 1);
        if (rect.width() > 2 * depth + 5)
            row({built.east - depth, built.south, built.east, built.north}, false, -1);
    }
}

bool CellLayout::lineBetween(double from, double to, double& line, double half) {
    if (to - from < 2 * (half + 24))
        return false;
    line = mix(from, to, random.in(0.4, 0.6));
    return true;
}

void CellLayout::splitStreets(const Rect& net, bool axisStreet) {
    double x = kNone, y = kNone;
    double half = kInnerStreetHalf;
    if (axisStreet) {
        x = Plan::axisX();
        half = kAxisStreetHalf;
    } else if (random.chance(0.72)) {
        lineBetween(net.west, net.east, x, half);
    }
    if (!axisStreet && random.chance(0.72))
        lineBetween(net.south, net.north, y, kInnerStreetHalf);
    const bool vertical = !std::isnan(x), horizontal = !std::isnan(y);
    if (vertical)
        cell.innerLines.push_back({x, kNone});
    if (horizontal)
        cell.innerLines.push_back({kNone, y});
    const auto columns = [&](double south, double north) {
        if (!vertical)
            return block({net.west, south, net.east, north});
        block({net.west, south, x - half, north});
        block({x + half, south, net.east, north});
    };
    if (!horizontal)
        return columns(net.south, net.north);
    columns(net.south, y - kInnerStreetHalf);
    columns(y + kInnerStreetHalf, net.north);
}

bool CellLayout::freeFor(glm::dvec2 at, double radius, double fromWalls) const {
    const Rect inside = cell.rect.inset(radius + 0.4);
    if (!inside.contains(at))
        return false;
    if (plan.riverDistance(at) < plan.riverHalfWidth() + 6 ||
        std::abs(plan.avenueDistance(at)) < 8.5)
        return false;
    for (const Building& b : cell.buildings) {
        const glm::dvec2 d = at - b.centre;
        const double c = std::cos(b.headingRadians), s = std::sin(b.headingRadians);
        const glm::dvec2 q = glm::abs(glm::dvec2(c * d.x + s * d.y, -s * d.x + c * d.y)) - b.half;
        if (std::max(q.x, q.y) < fromWalls)
            return false;
    }
    return true;
}

void CellLayout::tree(glm::dvec2 at, double low, double high, TreeKind kind) {
    Tree t;
    t.heightMetres = random.in(low, high);
    t.headingRadians = random.in(0, 2 * kPi);
    t.kind = kind;
    t.at = at;
    const double crown = 0.42 * t.heightMetres;
    if (freeFor(at, crown, std::min(crown, 2.8)))
        cell.trees.push_back(t);
}

void CellLayout::parkTrees() {
    for (int i = 0; i < 90; ++i) {
        const glm::dvec2 p{random.in(cell.rect.west, cell.rect.east),
                           random.in(cell.rect.south, cell.rect.north)};
        const glm::dvec2 d = glm::abs(p - cell.rect.centre());
        // Paths along both diagonals and a round lawn in the middle stay free.
        if (!cell.blocks[0].rect.inset(2).contains(p) || std::abs(d.x - d.y) < 4.5 ||
            glm::length(d) < 19)
            continue;
        const double r = random.unit();
        tree(p, 7, 15, r < 0.8 ? TreeKind::Broad : r < 0.9 ? TreeKind::Conifer : TreeKind::Poplar);
    }
    cell.sheds.push_back({cell.rect.centre() + glm::dvec2(0, 21), kPi, {7, 4, 3.0}});
}

void CellLayout::squareTrees() {
    for (int ring = 0; ring < 2; ++ring)
        for (int i = 0; i < 28; ++i) {
            const double t = (i - 13.5) * 3.6, d = 44.0 - 7.0 * ring;
            if (std::abs(t) > d - 3 || std::abs(t) < 9)
                continue;
            const glm::dvec2 c = cell.rect.centre();
            if (i % 2)
                continue;
            tree(c + glm::dvec2(t, d), 7, 8.5, TreeKind::Broad);
            tree(c + glm::dvec2(d, t), 7, 8.5, TreeKind::Broad);
            tree(c + glm::dvec2(-d, t), 7, 8.5, TreeKind::Broad);
            tree(c + glm::dvec2(t, -d), 7, 8.5, TreeKind::Broad);
        }
}

void CellLayout::riverTrees() {
    for (int i = 0; i < 60; ++i) {
        const glm::dvec2 p{random.in(cell.rect.west, cell.rect.east),
                           random.in(cell.rect.south, cell.rect.north)};
        const double d = plan.riverDistance(p) - plan.riverHalfWidth();
        if (d > 13 && d < 19 && std::abs(p.x - Plan::axisX()) > 12)
            tree(p, 8, 15, random.chance(0.7) ? TreeKind::Poplar : TreeKind::Broad);
    }
}

// Two rows along the diagonal avenue.
void CellLayout::avenueTrees() {
    for (double s = -plan.radiusMetres(); s < plan.radiusMetres(); s += 9)
        for (const double side : {-9.6, 9.6}) {
            const glm::dvec2 p =
                Plan::centre() + s * glm::dvec2(0.8, 0.6) + side * glm::dvec2(-0.6, 0.8);
            if (!cell.rect.contains(p) || std::abs(plan.avenueDistance(p)) > 10)
                continue;
            for (const Block& b : cell.blocks)
                if (b.rect.contains(p))
                    tree(p, 6.5, 9, TreeKind::Broad);
        }
}

// Along the pavements of some sides of a block.
void CellLayout::streetTrees() {
    for (const Block& b : std::vector<Block>(cell.blocks)) {
        const double out = 1.3; // on the pavement, between the kerb and the walls
        if (random.chance(0.45))
            for (double x = b.rect.west + 4; x < b.rect.east - 3; x += 8.5) {
                tree({x, b.rect.south - out}, 5, 6.2, TreeKind::Broad);
                tree({x + 2, b.rect.north + out}, 5, 6.2, TreeKind::Broad);
            }
        const auto column = [&](double x) {
            // The street of the flight has more of them than others.
            const bool axis = std::abs(x - Plan::axisX()) < kAxisStreetHalf;
            if (random.chance(axis ? 0.8 : 0.3))
                for (double y = b.rect.south + 4; y < b.rect.north - 3; y += axis ? 13.0 : 8.5)
                    tree({x, y}, 5, 6.2, TreeKind::Broad);
        };
        column(b.rect.west - out);
        column(b.rect.east + out);
    }
}

void CellLayout::shelter() {
    if (cell.blocks.empty() || !random.chance(0.35))
        return;
    const Rect& r = cell.blocks[std::size_t(random.pick(int(cell.blocks.size())))].rect;
    const glm::dvec2 p{r.centre().x, r.south - 1.1};
    if (freeFor(p, 2.5, 1.0))
        cell.sheds.push_back({p, 0, {3.6, 1.3, 2.4}});
}

void CellLayout::country() {
    cell.blocks.push_back({cell.rect, true});
    // Woods where the noise is high, single trees elsewhere.
    for (int i = 0; i < 110; ++i) {
        const glm::dvec2 p{random.in(cell.rect.west, cell.rect.east),
                           random.in(cell.rect.south, cell.rect.north)};
        const double wood = valueNoise(plan.seed() + 50, p.x / 190, p.y / 190);
        if (wood > 0.62 || random.chance(0.02))
            tree(p, 8, 16, wood > 0.8 ? TreeKind::Conifer : TreeKind::Broad);
    }
}

void CellLayout::run() {
    Rect net = cell.rect;
    net.west += plan.marginAt(Side::West, ix, iy);
    net.east -= plan.marginAt(Side::East, ix, iy);
    net.south += plan.marginAt(Side::South, ix, iy);
    net.north -= plan.marginAt(Side::North, ix, iy);
    switch (cell.kind) {
    case CellKind::Country:
        country();
        cell.blocks[0].rect = net;
        break;
    case CellKind::Park:
        cell.blocks.push_back({net, true});
        parkTrees();
        break;
    case CellKind::Square:
        cell.blocks.push_back({net, false});
        squareTrees();
        break;
    case CellKind::Bridge:
        splitStreets(net, true);
        break;
    case CellKind::Blocks:
        splitStreets(net, plan.onAxis(ix, iy));
        break;
    }
    if (cell.kind == CellKind::Blocks || cell.kind == CellKind::Bridge) {
        avenueTrees();
        streetTrees();
        shelter();
    }
    riverTrees();
}

Cell Plan::cell(int ix, int iy) const {
    Cell cell;
    cell.kind = kind(ix, iy);
    cell.rect = {ix * kCellMetres, iy * kCellMetres, (ix + 1) * kCellMetres,
                 (iy + 1) * kCellMetres};
    CellLayout(*this, ix, iy, cell).run();
    const std::uint16_t quota = quota_[indexOf(ix, iy)];
    if (cell.buildings.size() > quota && quota < kAllBuildings)
        cell.buildings.resize(quota);
    return cell;
}

} // namespace gnomon::builtin
