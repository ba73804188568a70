#include "streaming/flood/flood_grid.h"

#include "geo/crs.h"
#include "streaming/flood/unstructured_place.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Place {
    glm::dvec2 lonLat{kNaN};
    double lift = 0.0, turn = 0.0;

    bool exists() const { return std::isfinite(lonLat.x); }
};

// Towards `to`, over the antimeridian where that is shorter.
double turnTo(double from, double to, double full) {
    return std::remainder(to - from, full);
}

class Placer {
  public:
    Placer(CrsToEcef crs, const std::function<glm::dvec2(int, int)>& positions, glm::ivec2 size,
           GridPlaces& out)
        : crs_(std::move(crs)), positions_(positions), size_(size), out_(out) {}

    void eachNode() {
        for (int row = 0; row < size_.y; ++row)
            for (int column = 0; column < size_.x; ++column)
                put(column, row, exact(column, row));
    }

    // In blocks whose corners, middle and sides' middles are asked for.
    void evenly() {
        constexpr int kBlock = 64;
        for (int row = 0; row < size_.y; row += kBlock)
            for (int column = 0; column < size_.x; column += kBlock)
                block({column, row}, {std::min(column + kBlock, size_.x - 1),
                                      std::min(row + kBlock, size_.y - 1)});
    }

    const std::string& reason() const { return reason_; }

  private:
    Place exact(int column, int row) {
        const glm::dvec2 p = positions_(column, row);
        Place place;
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) {
            reason_ = "the file gives no position";
            return place;
        }
        const Result<Geodetic> found = crs_.geodetic({p.x, p.y, 0.0});
        if (!found) {
            reason_ = found.error().message();
            return place;
        }
        place.lonLat = {found->longitudeDegrees, found->latitudeDegrees};
        place.lift = found->heightMetres;
        // East of the x axis: from a step along it that is short beside the cell's own size.
        const glm::dvec2 beside = positions_(column > 0 ? column - 1 : column + 1, row);
        const double reach = 1e-2 * std::max(std::abs(beside.x - p.x), std::abs(beside.y - p.y));
        if (const auto along = crs_.geodetic({p.x + reach, p.y, 0.0}); along && reach > 0.0) {
            const double north = along->latitudeDegrees - place.lonLat.y;
            const double east = turnTo(place.lonLat.x, along->longitudeDegrees, 360.0) *
                                std::cos(place.lonLat.y * kRadiansPerDegree);
            place.turn = std::atan2(north, east);
        }
        return place;
    }

    void put(int column, int row, const Place& place) {
        const std::size_t i = std::size_t(row) * std::size_t(size_.x) + std::size_t(column);
        out_.lonLat[i] = place.lonLat;
        out_.lift[i] = float(place.lift);
        out_.eastOfX[i] = float(place.turn);
    }

    static Place between(const std::array<Place, 4>& corners, double u, double v) {
        const Place& o = corners[0];
        const std::array<double, 4> weights{(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
        Place sum{o.lonLat, 0.0, o.turn};
        for (std::size_t i = 0; i < corners.size(); ++i) {
            sum.lonLat.x += weights[i] * turnTo(o.lonLat.x, corners[i].lonLat.x, 360.0);
            sum.lonLat.y += weights[i] * (corners[i].lonLat.y - o.lonLat.y);
            sum.lift += weights[i] * corners[i].lift;
            sum.turn += weights[i] * turnTo(o.turn, corners[i].turn, 2.0 * std::numbers::pi);
        }
        sum.lonLat.x = std::remainder(sum.lonLat.x, 360.0);
        return sum;
    }

    bool isSmooth(glm::ivec2 low, glm::ivec2 high, const std::array<Place, 4>& corners) {
        if (!std::all_of(corners.begin(), corners.end(), [](const Place& p) { return p.exists(); }))
            return false;
        // A thousandth of a cell, as the diagonal tells its size.
        const glm::dvec2 across(turnTo(corners[0].lonLat.x, corners[3].lonLat.x, 360.0),
                                corners[3].lonLat.y - corners[0].lonLat.y);
        const glm::dvec2 cells = glm::dvec2(high - low);
        const double slack = 1e-3 * glm::length(across) / glm::length(cells);
        const glm::ivec2 middle = (low + high) / 2;
        for (const glm::ivec2 at : {middle,
                                    glm::ivec2(middle.x, low.y),
                                    {middle.x, high.y},
                                    glm::ivec2(low.x, middle.y),
                                    {high.x, middle.y}}) {
            const glm::dvec2 share = glm::dvec2(at - low) / cells;
            const Place guess = between(corners, share.x, share.y), there = exact(at.x, at.y);
            constexpr double kLiftMetres = 1e-3;
            if (!there.exists() ||
                std::abs(turnTo(guess.lonLat.x, there.lonLat.x, 360.0)) > slack ||
                std::abs(guess.lonLat.y - there.lonLat.y) > slack ||
                std::abs(guess.lift - there.lift) > kLiftMetres)
                return false;
        }
        return true;
    }

    void block(glm::ivec2 low, glm::ivec2 high) {
        constexpr int kSmallest = 4;
        const glm::ivec2 cells = high - low;
        if (cells.x > kSmallest && cells.y > kSmallest) {
            const std::array corners{exact(low.x, low.y), exact(high.x, low.y),
                                     exact(low.x, high.y), exact(high.x, high.y)};
            if (isSmooth(low, high, corners)) {
                for (int row = low.y; row <= high.y; ++row)
                    for (int column = low.x; column <= high.x; ++column)
                        put(column, row,
                            between(corners, double(column - low.x) / cells.x,
                                    double(row - low.y) / cells.y));
                return;
            }
            const glm::ivec2 middle = (low + high) / 2;
            block(low, middle);
            block({middle.x, low.y}, {high.x, middle.y});
            block({low.x, middle.y}, {middle.x, high.y});
            block(middle, high);
            return;
        }
        for (int row = low.y; row <= high.y; ++row)
            for (int column = low.x; column <= high.x; ++column)
                put(column, row, exact(column, row));
    }

    CrsToEcef crs_;
    const std::function<glm::dvec2(int, int)>& positions_;
    glm::ivec2 size_;
    GridPlaces& out_;
    std::string reason_;
};

// The parallelogram that half the way to the neighbours on both sides spans.
void measureCells(int columns, int rows, GridPlaces& places) {
    const auto at = [&](int column, int row) {
        return places.lonLat[std::size_t(row) * std::size_t(columns) + std::size_t(column)];
    };
    places.cellArea.reserve(places.lonLat.size());
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const glm::dvec2 here = at(column, row);
            const auto along = [&](bool down) {
                const int i = down ? row : column, last = (down ? rows : columns) - 1;
                const auto step = [&](int to) {
                    const glm::dvec2 p = down ? at(column, to) : at(to, row);
                    return std::isfinite(p.x) ? p : here;
                };
                const glm::dvec2 before = step(std::max(i - 1, 0));
                const glm::dvec2 after = step(std::min(i + 1, last));
                const double steps = (before != here ? 1.0 : 0.0) + (after != here ? 1.0 : 0.0);
                const glm::dvec2 way(turnTo(before.x, after.x, 360.0), after.y - before.y);
                return steps > 0.0 ? way / steps : glm::dvec2(0.0);
            };
            const double area =
                std::isfinite(here.x)
                    ? 2.0 * areaOnEarth({here, here + along(false), here + along(true)})
                    : 0.0;
            places.cellArea.push_back(float(std::abs(area)));
        }
}

} // namespace

GridThinning GridThinning::of(int width, int height) {
    GridThinning thinning;
    const auto count = [&](int pixels) {
        return (pixels - thinning.first - 1) / thinning.step + 1;
    };
    do {
        thinning.first = (thinning.step - 1) / 2;
        thinning.columns = count(width);
        thinning.rows = count(height);
    } while (thinning.nodes() > kMostNodes && ++thinning.step > 0);
    return thinning;
}

std::string GridThinning::note(int width, int height) const {
    if (step == 1)
        return {};
    return "of its " + std::to_string(width) + " x " + std::to_string(height) + " pixels every " +
           std::to_string(step) + "th across and down is shown, " + std::to_string(columns) +
           " x " + std::to_string(rows);
}

Result<GridPlaces> placeGrid(const std::string& path, int columns, int rows,
                             const std::function<glm::dvec2(int, int)>& positions, bool even,
                             const std::string& crs, const FloodOptions& options) {
    Result<CrsToEcef> toEarth = CrsToEcef::create(crs, options.heights);
    if (!toEarth)
        return Error{path, toEarth.error().message()};
    const std::size_t nodes = std::size_t(columns) * std::size_t(rows);
    GridPlaces places;
    places.lonLat.resize(nodes);
    places.lift.resize(nodes);
    places.eastOfX.resize(nodes);
    Placer placer(std::move(*toEarth), positions, {columns, rows}, places);
    if (even)
        placer.evenly();
    else
        placer.eachNode();
    if (std::none_of(places.lonLat.begin(), places.lonLat.end(),
                     [](glm::dvec2 p) { return std::isfinite(p.x); }))
        return Error{path, "none of its pixels has a place on the Earth: " + placer.reason()};
    for (float& lift : places.lift)
        lift += float(options.raiseMetres);
    measureCells(columns, rows, places);
    return places;
}

} // namespace gnomon
