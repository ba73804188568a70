#include "streaming/flood/point_flood.h"

#include "geo/ellipsoid.h"
#include "streaming/flood/lower_case.h"
#include "streaming/flood/point_flood_table.h"
#include "streaming/flood/unstructured_place.h"
#include "streaming/terrain/ground_heights.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();

// The equations between points take the third power of their number; a table of more is no
// observation but somebody's result.
constexpr std::size_t kMostPoints = 1000;

// What is shown about a single point: nothing tells how far its level holds.
constexpr double kAloneMetres = 200.0;

// Places about a middle as metres east and north. Points of one flood are near enough to each other
// for that.
struct LocalPlane {
    glm::dvec2 middle{0.0}, metresPerDegree{1.0};

    glm::dvec2 metres(glm::dvec2 lonLat) const {
        return metresPerDegree *
               glm::dvec2(std::remainder(lonLat.x - middle.x, 360.0), lonLat.y - middle.y);
    }
    glm::dvec2 lonLat(glm::dvec2 metres) const {
        const glm::dvec2 p = middle + metres / metresPerDegree;
        return {std::remainder(p.x, 360.0), p.y};
    }

    static LocalPlane about(glm::dvec2 lonLat) {
        const auto axes = ecefFromEnu({lonLat.x, lonLat.y, 0.0}).axes();
        constexpr double kDegrees = 1e-3;
        const auto along = [&](glm::dvec2 way, const glm::dvec3& axis) {
            const auto end = [&](double sign) {
                return ecefOf({lonLat.x + sign * way.x, lonLat.y + sign * way.y, 0.0}).xyz;
            };
            return glm::dot(end(1.0) - end(-1.0), axis) / (2.0 * kDegrees);
        };
        return {lonLat, {along({kDegrees, 0.0}, axes[0]), along({0.0, kDegrees}, axes[1])}};
    }
};

// See the header.
class LevelSurface {
  public:
    LevelSurface(std::vector<glm::dvec2> places, const std::vector<double>& levels)
        : places_(std::move(places)), low_(*std::min_element(levels.begin(), levels.end())),
          high_(*std::max_element(levels.begin(), levels.end())) {
        solve(levels);
    }

    // Never above the highest that was seen, nor below the lowest.
    double at(glm::dvec2 p) const {
        double sum = shares_.back();
        for (std::size_t i = 0; i < places_.size(); ++i)
            sum += shares_[i] * glm::length(p - places_[i]);
        return std::clamp(sum, low_, high_);
    }

  private:
    // Gauss, with pivots: distances between different points leave one solution.
    void solve(const std::vector<double>& levels) {
        const std::size_t n = places_.size() + 1;
        std::vector<double> rows(n * (n + 1), 0.0);
        const auto at = [&](std::size_t r, std::size_t c) -> double& {
            return rows[r * (n + 1) + c];
        };
        for (std::size_t i = 0; i + 1 < n; ++i) {
            for (std::size_t j = 0; j + 1 < n; ++j)
                at(i, j) = glm::length(places_[i] - places_[j]);
            at(i, n - 1) = at(n - 1, i) = 1.0;
            at(i, n) = levels[i];
        }
        for (std::size_t k = 0; k < n; ++k) {
            std::size_t pivot = k;
            for (std::size_t r = k + 1; r < n; ++r)
                if (std::abs(at(r, k)) > std::abs(at(pivot, k)))
                    pivot = r;
            if (pivot != k)
                for (std::size_t c = k; c <= n; ++c)
                    std::swap(at(k, c), at(pivot, c));
            for (std::size_t r = k + 1; r < n; ++r) {
                const double share = at(r, k) / at(k, k);
                for (std::size_t c = k; share != 0.0 && c <= n; ++c)
                    at(r, c) -= share * at(k, c);
            }
        }
        shares_.assign(n, 0.0);
        for (std::size_t k = n; k-- > 0;) {
            double sum = at(k, n);
            for (std::size_t c = k + 1; c < n; ++c)
                sum -= at(k, c) * shares_[c];
            shares_[k] = sum / at(k, k);
        }
    }

    std::vector<glm::dvec2> places_;
    double low_, high_;
    std::vector<double> shares_; // a point, and the constant
};

// The longest way between neighbours, when all are joined by as little as will do (Prim).
double longestGap(const std::vector<glm::dvec2>& places) {
    if (places.size() < 2)
        return kAloneMetres;
    std::vector<double> away(places.size(), kInfinity);
    std::vector<char> joined(places.size(), 0);
    std::size_t last = 0;
    double longest = 0.0;
    joined[0] = 1;
    for (std::size_t n = 1; n < places.size(); ++n) {
        std::size_t nearest = 0;
        double least = kInfinity;
        for (std::size_t i = 0; i < places.size(); ++i) {
            if (joined[i])
                continue;
            away[i] = std::min(away[i], glm::length(places[i] - places[last]));
            if (away[i] < least) {
                least = away[i];
                nearest = i;
            }
        }
        joined[nearest] = 1;
        last = nearest;
        longest = std::max(longest, least);
    }
    return longest;
}

std::string metresText(double metres) {
    return std::to_string(std::lround(metres)) + " m";
}

struct ObservedPoint {
    glm::dvec2 lonLat{0.0};
    double value = 0.0;
    std::string name;
};

// What on() gives: levels on a grid, none where there is no water.
class PointSurface final : public FloodData {
  public:
    const FloodGeometry& geometry() const override { return geometry_; }
    WaterKind kind() const override { return WaterKind::Stage; }
    const std::vector<double>& stepSeconds() const override { return seconds_; }
    bool stepsAreAbsolute() const override { return absolute_; }
    Result<std::vector<float>> values(std::size_t) const override { return levels_; }
    bool isInterpolated() const override { return true; }

    FloodGeometry geometry_;
    std::vector<float> levels_;
    std::vector<double> seconds_;
    bool absolute_ = false;
};

class PointFlood final : public FloodData {
  public:
    const FloodGeometry& geometry() const override { return geometry_; }
    WaterKind kind() const override { return kind_; }
    const std::vector<double>& stepSeconds() const override { return seconds_; }
    bool stepsAreAbsolute() const override { return absolute_; }
    Result<std::vector<float>> values(std::size_t) const override {
        std::vector<float> out;
        for (const ObservedPoint& point : points_)
            out.push_back(float(point.value));
        return out;
    }
    bool isInterpolated() const override { return true; }
    Result<std::shared_ptr<const FloodData>> on(const GroundHeights& ground) const override;

    FloodGeometry geometry_; // the points, each by itself
    std::vector<ObservedPoint> points_;
    WaterKind kind_ = WaterKind::Stage;
    std::vector<double> seconds_{0.0};
    bool absolute_ = false;
    LocalPlane plane_;
    double reachMetres_ = 0.0;
};

// A grid of nodes on a plane, and the ground below them.
struct GroundGrid {
    glm::dvec2 low{0.0};
    double spacing = 1.0;
    int columns = 0, rows = 0;
    std::vector<glm::dvec2> lonLat;
    std::vector<double> heights; // NaN: none

    glm::dvec2 place(int column, int row) const { return low + spacing * glm::dvec2(column, row); }
    std::size_t index(int column, int row) const {
        return std::size_t(row) * std::size_t(columns) + std::size_t(column);
    }

    void sample(const LocalPlane& plane, const GroundHeights& ground) {
        lonLat.clear();
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column)
                lonLat.push_back(plane.lonLat(place(column, row)));
        heights.resize(lonLat.size());
        ground.sample(lonLat, heights);
    }
};

// Over the part of [low, high] that has ground.
std::optional<GroundGrid> gridOverGround(const LocalPlane& plane, const GroundHeights& ground,
                                         glm::dvec2 low, glm::dvec2 high) {
    constexpr int kLook = 192;
    constexpr double kFinestMetres = 1.0, kMostNodes = 500'000.0;
    GroundGrid look;
    look.low = low;
    look.spacing = std::max(high.x - low.x, high.y - low.y) / kLook;
    look.columns = int(std::ceil((high.x - low.x) / look.spacing)) + 1;
    look.rows = int(std::ceil((high.y - low.y) / look.spacing)) + 1;
    look.sample(plane, ground);
    glm::dvec2 first(kInfinity), last(-kInfinity);
    for (int row = 0; row < look.rows; ++row)
        for (int column = 0; column < look.columns; ++column)
            if (std::isfinite(look.heights[look.index(column, row)])) {
                first = glm::min(first, look.place(column, row));
                last = glm::max(last, look.place(column, row));
            }
    if (!(first.x <= last.x))
        return std::nullopt;
    first = glm::max(first - look.spacing, low);
    last = glm::min(last + look.spacing, high);

    GroundGrid grid;
    grid.low = first;
    const glm::dvec2 size = last - first;
    grid.spacing = std::max(kFinestMetres, std::sqrt(size.x * size.y / kMostNodes));
    grid.columns = int(std::floor(size.x / grid.spacing)) + 1;
    grid.rows = int(std::floor(size.y / grid.spacing)) + 1;
    if (grid.columns < 2 || grid.rows < 2)
        return std::nullopt;
    grid.sample(plane, ground);
    return grid;
}

// Keeps the levels that water can come to from `seeds`, over sides and corners.
void keepConnected(const GroundGrid& grid, std::vector<std::size_t> seeds,
                   std::vector<float>& levels) {
    std::vector<char> reached(levels.size(), 0);
    for (const std::size_t seed : seeds)
        reached[seed] = 1;
    while (!seeds.empty()) {
        const std::size_t at = seeds.back();
        seeds.pop_back();
        const int row = int(at / std::size_t(grid.columns));
        const int column = int(at % std::size_t(grid.columns));
        for (int r = std::max(row - 1, 0); r <= std::min(row + 1, grid.rows - 1); ++r)
            for (int c = std::max(column - 1, 0); c <= std::min(column + 1, grid.columns - 1);
                 ++c) {
                const std::size_t i = grid.index(c, r);
                if (reached[i] || !std::isfinite(levels[i]))
                    continue;
                reached[i] = 1;
                seeds.push_back(i);
            }
    }
    for (std::size_t i = 0; i < levels.size(); ++i)
        if (!reached[i])
            levels[i] = kNoData;
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t kMost = 8;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
        text += (i > 0 ? ", " : "") + names[i];
    return text + (names.size() > kMost ? ", …" : "");
}

Result<std::shared_ptr<const FloodData>> PointFlood::on(const GroundHeights& ground) const {
    auto made = std::make_shared<PointSurface>();
    made->path = path;
    made->crs = crs;
    made->notes = notes;
    made->credits = credits;
    made->leftOut = leftOut;
    made->seconds_ = seconds_;
    made->absolute_ = absolute_;

    std::vector<glm::dvec2> places, wetPlaces;
    std::vector<double> levels;
    std::vector<std::string> dry, off;
    for (const ObservedPoint& point : points_) {
        const double height = ground.at(point.lonLat);
        const double level = kind_ == WaterKind::Depth ? point.value + height : point.value;
        if (!std::isfinite(height))
            off.push_back(point.name);
        else if (level > height)
            wetPlaces.push_back(plane_.metres(point.lonLat));
        else
            dry.push_back(point.name);
        if (std::isfinite(level)) {
            places.push_back(plane_.metres(point.lonLat));
            levels.push_back(level);
        }
    }
    if (!off.empty())
        made->notes.push_back("no ground is known at these of its points: " + listed(off));
    if (!dry.empty())
        made->notes.push_back("the ground is above the level at these of its points, and dry: " +
                              listed(dry));
    if (wetPlaces.empty())
        return Error{path, off.size() == points_.size()
                               ? "lies nowhere where there is ground"
                               : "no level at its " + std::to_string(points_.size()) +
                                     " points is above the ground there; are its heights of "
                                     "another kind than the ground's (--heights)?"};

    glm::dvec2 low(kInfinity), high(-kInfinity);
    for (const glm::dvec2 p : places) {
        low = glm::min(low, p - reachMetres_);
        high = glm::max(high, p + reachMetres_);
    }
    const auto grid = gridOverGround(plane_, ground, low, high);
    if (!grid)
        return Error{path, "lies nowhere where there is ground"};
    const LevelSurface surface(places, levels);
    made->levels_.assign(grid->lonLat.size(), kNoData);
    for (int row = 0; row < grid->rows; ++row)
        for (int column = 0; column < grid->columns; ++column) {
            const std::size_t i = grid->index(column, row);
            const glm::dvec2 p = grid->place(column, row);
            const bool near = std::any_of(places.begin(), places.end(), [&](glm::dvec2 q) {
                return glm::dot(p - q, p - q) <= reachMetres_ * reachMetres_;
            });
            if (!near || !std::isfinite(grid->heights[i]))
                continue;
            if (const double level = surface.at(p); level > grid->heights[i])
                made->levels_[i] = float(level);
        }
    // Water stands at a point when it does at one of the nodes about it.
    std::vector<std::size_t> seeds;
    for (const glm::dvec2 p : wetPlaces) {
        const glm::dvec2 cell = (p - grid->low) / grid->spacing;
        constexpr int kAbout = 2;
        for (int r = int(cell.y) - kAbout + 1; r <= int(cell.y) + kAbout; ++r)
            for (int c = int(cell.x) - kAbout + 1; c <= int(cell.x) + kAbout; ++c)
                if (r >= 0 && c >= 0 && r < grid->rows && c < grid->columns &&
                    std::isfinite(made->levels_[grid->index(c, r)]))
                    seeds.push_back(grid->index(c, r));
    }
    keepConnected(*grid, std::move(seeds), made->levels_);

    made->geometry_.columns = grid->columns;
    made->geometry_.rows = grid->rows;
    made->geometry_.lonLat = grid->lonLat;
    made->geometry_.bed.assign(grid->heights.begin(), grid->heights.end());
    made->geometry_.cellArea.assign(grid->lonLat.size(), float(grid->spacing * grid->spacing));
    return std::shared_ptr<const FloodData>(std::move(made));
}

// Points at one place: their mean.
std::vector<ObservedPoint> merged(std::vector<ObservedPoint> points, const LocalPlane& plane,
                                  std::vector<std::string>& notes) {
    constexpr double kSameMetres = 0.01;
    std::vector<ObservedPoint> out;
    std::vector<int> counts;
    for (ObservedPoint& point : points) {
        const glm::dvec2 at = plane.metres(point.lonLat);
        std::size_t i = 0;
        while (i < out.size() && glm::length(plane.metres(out[i].lonLat) - at) > kSameMetres)
            ++i;
        if (i == out.size()) {
            out.push_back(std::move(point));
            counts.push_back(1);
            continue;
        }
        out[i].value = (out[i].value * counts[i] + point.value) / (counts[i] + 1);
        ++counts[i];
    }
    if (out.size() < points.size())
        notes.push_back(std::to_string(points.size() - out.size()) +
                        " of its points lie where another does: their mean is taken");
    return out;
}

} // namespace

bool isPointFlood(const std::string& path) {
    return looksLikeLevelTable(path);
}

Result<std::shared_ptr<const FloodData>> openPointFlood(const std::string& path,
                                                        const FloodOptions& options) {
    Result<LevelTable> table = readLevelTable(path, options);
    if (!table)
        return table.error();
    if (table->points.size() > kMostPoints)
        return Error{path, "has " + std::to_string(table->points.size()) +
                               " points; levels are interpolated between " +
                               std::to_string(kMostPoints) + " at most"};
    const std::optional<std::string> crs = table->crs ? table->crs : options.crs;
    if (!crs)
        return Error{path, "does not say which coordinates it uses: give its coordinate reference "
                           "system with --crs EPSG:n"};
    auto flood = std::make_shared<PointFlood>();
    flood->path = path;
    flood->crs = *crs;
    flood->notes = std::move(table->notes);
    const bool depth = lower(table->column).find("depth") != std::string::npos;
    flood->kind_ = options.kind.value_or(depth ? WaterKind::Depth : WaterKind::Stage);

    std::vector<glm::dvec2> positions;
    for (const LevelPoint& point : table->points)
        positions.push_back(point.position);
    const Result<PlacedNodes> placed = placeNodes(path, positions, *crs, options);
    if (!placed)
        return placed.error();
    flood->plane_ = LocalPlane::about(placed->lonLat.front());
    std::vector<ObservedPoint> points;
    for (std::size_t i = 0; i < table->points.size(); ++i) {
        const double lift = flood->kind_ == WaterKind::Stage ? placed->liftMetres[i] : 0.0f;
        points.push_back(
            {placed->lonLat[i], table->points[i].value + lift, std::move(table->points[i].name)});
    }
    flood->points_ = merged(std::move(points), flood->plane_, flood->notes);
    std::vector<glm::dvec2> places;
    for (const ObservedPoint& point : flood->points_) {
        flood->geometry_.lonLat.push_back(point.lonLat);
        places.push_back(flood->plane_.metres(point.lonLat));
    }
    flood->geometry_.cellArea.assign(places.size(), 0.0f);
    flood->reachMetres_ = longestGap(places);
    flood->notes.push_back(
        "the water between its " + std::to_string(places.size()) +
        " points is interpolated, and shown as far as " + metresText(flood->reachMetres_) +
        " from them, where it is above the ground and joined to a point that stands in water");
    if (options.start) {
        flood->seconds_ = {options.start->seconds};
        flood->absolute_ = true;
    }
    return std::shared_ptr<const FloodData>(std::move(flood));
}

} // namespace gnomon
