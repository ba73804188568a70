#include "streaming/terrain/terrain_place.h"

#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// First eccentricity squared.
constexpr double kE2 = 1.0 - (kPolarRadiusMetres / kEquatorialRadiusMetres) *
                                 (kPolarRadiusMetres / kEquatorialRadiusMetres);

glm::dvec3 normalOf(const Geodetic& place) {
    const double lambda = place.longitudeDegrees * kRadiansPerDegree;
    const double phi = place.latitudeDegrees * kRadiansPerDegree;
    return {std::cos(phi) * std::cos(lambda), std::cos(phi) * std::sin(lambda), std::sin(phi)};
}

constexpr std::size_t kNodes = 6;
using Weights = std::array<double, kNodes>;

// Chebyshev nodes on [low, high] and, for a place between, what each node's value counts.
struct Axis {
    double low, high;

    double node(std::size_t i) const {
        const double x = std::cos((double(i) + 0.5) * std::numbers::pi / double(kNodes));
        return 0.5 * (low + high) + 0.5 * (high - low) * x;
    }
    // Barycentric (Berrut & Trefethen, "Barycentric Lagrange interpolation", 2004).
    Weights weights(double at) const {
        Weights w{};
        double sum = 0.0;
        for (std::size_t i = 0; i < kNodes; ++i) {
            const double distance = at - node(i);
            if (distance == 0.0) {
                w.fill(0.0);
                w[i] = 1.0;
                return w;
            }
            const double angle = (double(i) + 0.5) * std::numbers::pi / double(kNodes);
            w[i] = (i % 2 == 0 ? 1.0 : -1.0) * std::sin(angle) / distance;
            sum += w[i];
        }
        for (double& v : w)
            v /= sum;
        return w;
    }
};

using NodeRow = std::array<glm::dvec3, kNodes>;
using Nodes = std::array<NodeRow, kNodes>; // by row, then column

NodeRow alongRow(const Nodes& nodes, const Weights& row) {
    NodeRow out{};
    for (std::size_t j = 0; j < kNodes; ++j)
        for (std::size_t i = 0; i < kNodes; ++i)
            out[i] += row[j] * nodes[j][i];
    return out;
}

glm::dvec3 alongColumn(const NodeRow& nodes, const Weights& column) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < kNodes; ++i)
        sum += column[i] * nodes[i];
    return glm::normalize(sum);
}

} // namespace

Point<Ecef> PlacedPixel::ecefAt(double metres) const {
    const double n = kEquatorialRadiusMetres / std::sqrt(1.0 - kE2 * up.z * up.z);
    return {{(n + metres) * up.x, (n + metres) * up.y, (n * (1.0 - kE2) + metres) * up.z}};
}

glm::dvec2 PlacedPixel::lonLat() const {
    return glm::dvec2(std::atan2(up.y, up.x), std::atan2(up.z, std::hypot(up.x, up.y))) /
           kRadiansPerDegree;
}

// One of the idle CRS objects, or a new one.
class TerrainPlace::Lease {
  public:
    explicit Lease(const TerrainPlace& owner) : owner_(owner) {
        {
            const std::lock_guard lock(owner.mutex_);
            if (!owner.idle_.empty()) {
                crs_ = std::move(owner.idle_.back());
                owner.idle_.pop_back();
            }
        }
        if (crs_)
            return;
        Result<CrsToEcef> made = CrsToEcef::create(owner.crs_, Heights::Ellipsoidal);
        if (made)
            crs_ = std::make_unique<CrsToEcef>(std::move(*made));
        else
            error = made.error();
    }
    ~Lease() {
        if (crs_) {
            const std::lock_guard lock(owner_.mutex_);
            owner_.idle_.push_back(std::move(crs_));
        }
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    const CrsToEcef& operator*() const { return *crs_; }

    Failure error;

  private:
    const TerrainPlace& owner_;
    std::unique_ptr<CrsToEcef> crs_;
};

Result<std::unique_ptr<const TerrainPlace>> TerrainPlace::create(const Raster& raster,
                                                                 const std::string& crs,
                                                                 Heights heights,
                                                                 double raiseMetres) {
    std::unique_ptr<TerrainPlace> place(new TerrainPlace(raster, crs, heights, raiseMetres));
    {
        const Lease lease(*place);
        if (lease.error)
            return *lease.error;
        place->ownHeights_ = (*lease).hasOwnHeights();
        const glm::dvec2 middle = raster.at(0.5 * raster.width(), 0.5 * raster.height());
        const Result<Geodetic> once = (*lease).geodetic({middle, 0.0});
        const Result<Geodetic> again = (*lease).geodetic({middle + glm::dvec2(360.0, 0.0), 0.0});
        constexpr double kSame = 1e-12;
        place->periodic_ = once && again && glm::length(normalOf(*once) - normalOf(*again)) < kSame;
    }
    return std::unique_ptr<const TerrainPlace>(std::move(place));
}

Result<PlacedPixel> TerrainPlace::exact(const CrsToEcef& crs, glm::dvec2 pixel,
                                        double height) const {
    const glm::dvec2 east = raster_.at(pixel.x + 0.5, pixel.y + 0.5);
    const Result<Geodetic> place = crs.geodetic({east, height});
    if (!place)
        return place.error();
    double up = place->heightMetres + raise_;
    if (!ownHeights_ && heights_ == Heights::Egm96) {
        const Result<double> geoid =
            egm96GeoidHeight(place->longitudeDegrees, place->latitudeDegrees);
        if (!geoid)
            return geoid.error();
        up += *geoid;
    }
    return PlacedPixel{normalOf(*place), up};
}

Result<PlacedPixel> TerrainPlace::at(glm::dvec2 pixel, double height) const {
    const Lease lease(*this);
    if (lease.error)
        return *lease.error;
    return exact(*lease, pixel, height);
}

// Fills in the normals; false where six nodes an axis do not tell them well enough.
bool TerrainPlace::interpolate(const CrsToEcef& crs, const PixelLines& lines,
                               std::vector<PlacedPixel>& out) const {
    const Axis across{lines.columns.front(), lines.columns.back()};
    const Axis down{lines.rows.front(), lines.rows.back()};
    const auto normalAt = [&](double column, double row) -> Result<glm::dvec3> {
        const Result<Geodetic> place = crs.geodetic({raster_.at(column + 0.5, row + 0.5), 0.0});
        if (!place)
            return place.error();
        return normalOf(*place);
    };
    Nodes nodes;
    for (std::size_t j = 0; j < kNodes; ++j)
        for (std::size_t i = 0; i < kNodes; ++i) {
            const Result<glm::dvec3> n = normalAt(across.node(i), down.node(j));
            if (!n)
                return false;
            nodes[j][i] = *n;
        }
    // Interpolation is worst at the ends and about the middle between nodes.
    constexpr std::array kChecks = {0.0, 0.11, 0.37, 0.5, 0.75, 1.0};
    for (const double v : kChecks)
        for (const double u : kChecks) {
            const double column = across.low + u * (across.high - across.low);
            const double row = down.low + v * (down.high - down.low);
            const Result<glm::dvec3> n = normalAt(column, row);
            const glm::dvec3 guess =
                alongColumn(alongRow(nodes, down.weights(row)), across.weights(column));
            // Between the checks it may be a little worse than at them.
            constexpr double kHalf = 0.5;
            if (!n || glm::length(guess - *n) * kEquatorialRadiusMetres > kHalf * kPlaceSlackMetres)
                return false;
        }
    std::vector<Weights> columns;
    for (const double column : lines.columns)
        columns.push_back(across.weights(column));
    std::size_t at = 0;
    for (const double row : lines.rows) {
        const NodeRow nodeRow = alongRow(nodes, down.weights(row));
        for (const Weights& column : columns)
            out[at++].up = alongColumn(nodeRow, column);
    }
    return true;
}

Failure TerrainPlace::placeHeights(std::span<const float> heights,
                                   std::vector<PlacedPixel>& out) const {
    const bool geoid = heights_ == Heights::Egm96;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const double height = heights.empty() ? 0.0 : double(heights[i]);
        out[i].heightMetres = height + raise_;
        if (!geoid || std::isnan(height))
            continue;
        const glm::dvec2 lonLat = out[i].lonLat();
        const Result<double> above = egm96GeoidHeight(lonLat.x, lonLat.y);
        if (!above)
            return above.error();
        out[i].heightMetres += *above;
    }
    return {};
}

Result<std::vector<PlacedPixel>> TerrainPlace::at(const PixelLines& lines,
                                                  std::span<const float> heights) const {
    const std::size_t width = lines.columns.size();
    std::vector<PlacedPixel> out(width * lines.rows.size());
    assert(heights.empty() || heights.size() == out.size());
    const Lease lease(*this);
    if (lease.error)
        return *lease.error;
    const bool guessed = !ownHeights_ && interpolate(*lease, lines, out);
    if (guessed)
        if (const Failure wrong = placeHeights(heights, out))
            return *wrong;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const std::size_t column = i % width, row = i / width;
        const bool exactly = !guessed ||
                             (!lines.exactColumn.empty() && lines.exactColumn[column]) ||
                             (!lines.exactRow.empty() && lines.exactRow[row]);
        if (!exactly)
            continue;
        const float height = heights.empty() ? 0.0f : heights[i];
        const Result<PlacedPixel> place = exact(*lease, {lines.columns[column], lines.rows[row]},
                                                std::isnan(height) ? 0.0 : double(height));
        if (!place && !std::isnan(height))
            return place.error();
        if (place)
            out[i] = *place;
        if (std::isnan(height))
            out[i].heightMetres = kNaN;
    }
    return out;
}

void TerrainPlace::pixelsOf(std::span<const glm::dvec2> lonLat, std::span<glm::dvec2> out) const {
    const Lease lease(*this);
    if (lease.error) {
        std::fill(out.begin(), out.end(), glm::dvec2(kNaN));
        return;
    }
    (*lease).eastNorth(lonLat, out);
    const double middle = raster_.at(0.5 * raster_.width(), 0.5 * raster_.height()).x;
    for (glm::dvec2& p : out) {
        if (periodic_)
            p.x = middle + std::remainder(p.x - middle, 360.0);
        p = raster_.pixelOf(p) - 0.5;
    }
}

void TerrainPlace::heightsAt(std::span<const glm::dvec2> lonLat, std::span<const glm::dvec2> pixels,
                             std::span<double> heights) const {
    if (!ownHeights_) {
        for (std::size_t i = 0; i < heights.size(); ++i) {
            if (std::isnan(heights[i]))
                continue;
            heights[i] += raise_;
            if (heights_ != Heights::Egm96)
                continue;
            const Result<double> geoid = egm96GeoidHeight(lonLat[i].x, lonLat[i].y);
            heights[i] = geoid ? heights[i] + *geoid : kNaN;
        }
        return;
    }
    const Lease lease(*this);
    for (std::size_t i = 0; i < heights.size(); ++i) {
        if (std::isnan(heights[i]))
            continue;
        const Result<PlacedPixel> place =
            lease.error ? Result<PlacedPixel>(*lease.error) : exact(*lease, pixels[i], heights[i]);
        heights[i] = place ? place->heightMetres : kNaN;
    }
}

} // namespace gnomon
