#include "streaming/flood/unstructured_place.h"

#include "geo/crs.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// WGS 84.
constexpr double kEquatorMetres = 6378137.0;
constexpr double kEccentricity2 = 0.00669437999014;
constexpr double kRadians = 3.14159265358979323846 / 180.0;

// Metres a degree to the east and to the north.
glm::dvec2 metresPerDegree(double latitude) {
    const double s = std::sin(latitude * kRadians);
    const double w2 = 1.0 - kEccentricity2 * s * s;
    const double prime = kEquatorMetres / std::sqrt(w2);
    const double meridian = prime * (1.0 - kEccentricity2) / w2;
    return kRadians * glm::dvec2(prime * std::cos(latitude * kRadians), meridian);
}

glm::dvec2 metresBetween(glm::dvec2 from, glm::dvec2 to) {
    return metresPerDegree(0.5 * (from.y + to.y)) *
           glm::dvec2(std::remainder(to.x - from.x, 360.0), to.y - from.y);
}

// The turn of a projection's axes changes so slowly over a mesh that a few places tell it all.
class GridTurn {
  public:
    GridTurn(const CrsToEcef& crs, std::span<const glm::dvec2> positions) {
        low_ = high_ = positions.front();
        for (const glm::dvec2 p : positions) {
            low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
            high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
        }
        const glm::dvec2 size = high_ - low_;
        const double reach = 1e-3 * std::max(size.x, size.y);
        for (int row = 0; row <= kCells; ++row)
            for (int column = 0; column <= kCells; ++column) {
                const glm::dvec2 at = low_ + size * glm::dvec2(column, row) / double(kCells);
                turns_.push_back(turnAt(crs, at, reach));
            }
    }

    double at(glm::dvec2 p) const {
        const glm::dvec2 size = high_ - low_;
        const auto part = [](double from, double extent, double v) {
            return extent > 0.0 ? std::clamp((v - from) / extent * kCells, 0.0, double(kCells))
                                : 0.0;
        };
        const double x = part(low_.x, size.x, p.x), y = part(low_.y, size.y, p.y);
        const int column = std::min(int(x), kCells - 1), row = std::min(int(y), kCells - 1);
        const double u = x - column, v = y - row;
        const auto turn = [&](int c, int r) { return turns_[std::size_t(r * (kCells + 1) + c)]; };
        return (1 - v) * ((1 - u) * turn(column, row) + u * turn(column + 1, row)) +
               v * ((1 - u) * turn(column, row + 1) + u * turn(column + 1, row + 1));
    }

  private:
    static constexpr int kCells = 8;

    static double turnAt(const CrsToEcef& crs, glm::dvec2 at, double reach) {
        const auto here = crs.geodetic({at.x, at.y, 0.0});
        const auto there = crs.geodetic({at.x + reach, at.y, 0.0});
        if (!here || !there) // a corner outside what the projection can do; the nodes are inside
            return 0.0;
        const glm::dvec2 d = metresBetween({here->longitudeDegrees, here->latitudeDegrees},
                                           {there->longitudeDegrees, there->latitudeDegrees});
        return std::atan2(d.y, d.x);
    }

    glm::dvec2 low_, high_;
    std::vector<double> turns_;
};

} // namespace

double areaOnEarth(const std::array<glm::dvec2, 3>& lonLat) {
    // One scale for both sides, that of the middle: the error is of the second order in the
    // triangle's size over the Earth's.
    const glm::dvec2 scale = metresPerDegree((lonLat[0].y + lonLat[1].y + lonLat[2].y) / 3.0);
    const auto from0 = [&](int i) {
        return scale * glm::dvec2(std::remainder(lonLat[i].x - lonLat[0].x, 360.0),
                                  lonLat[i].y - lonLat[0].y);
    };
    const glm::dvec2 a = from0(1), b = from0(2);
    return 0.5 * (a.x * b.y - a.y * b.x);
}

Result<PlacedNodes> placeNodes(const std::string& path, std::span<const glm::dvec2> positions,
                               const std::string& crs, const FloodOptions& options) {
    const auto toEarth = CrsToEcef::create(crs, options.heights);
    if (!toEarth)
        return Error{path, toEarth.error().message()};
    PlacedNodes placed;
    std::size_t nowhere = 0;
    std::string reason;
    for (const glm::dvec2 p : positions) {
        const auto place = toEarth->geodetic({p.x, p.y, 0.0});
        if (!place) {
            ++nowhere;
            reason = place.error().message();
            continue;
        }
        placed.lonLat.emplace_back(place->longitudeDegrees, place->latitudeDegrees);
        placed.liftMetres.push_back(float(place->heightMetres + options.raiseMetres));
    }
    if (nowhere != 0)
        return Error{path, std::to_string(nowhere) + " of its " + std::to_string(positions.size()) +
                               " nodes have no place on the Earth: " + reason};
    const GridTurn turn(*toEarth, positions);
    for (const glm::dvec2 p : positions)
        placed.eastOfX.push_back(float(turn.at(p)));
    return placed;
}

} // namespace gnomon
