#include "viewer/place/surroundings.h"

#include "geo/crs.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

namespace gnomon::builtin {
namespace {

using nlohmann::json;

constexpr double kNoData = -9999.0;
constexpr double kReach = 1.5; // terrain reaches so many sides from the middle

// Hills begin at the place's rim and are full a side farther out; they are this share of a side
// high, so that at a low sun their shadows reach the place.
constexpr double kReliefPerSide = 0.09;
constexpr std::uint64_t kRidges = 0x51d6e5;

// The plain is 7 m above the river, so the flood comes over its banks and some streets far.
constexpr double kPeakMetres = 7.7;
constexpr double kFirstMetres = 0.15;
constexpr double kFallPerMetre = 0.006; // of the level, away from the river

constexpr double kWallFromBankMetres = 31.0; // behind the bank's crown
constexpr double kWallStepMetres = 8.0;
constexpr double kWallHalfLengthMetres = 200.0;
constexpr double kRoadGapMetres = 14.0;
constexpr double kWallHeightMetres = 1.4;

struct Grid {
    int side = 0; // pixels
    double step = 0, west = 0, north = 0;
};

// Pixel centres on a lattice that the place's rim lies on.
Grid gridFor(double halfSide, double step) {
    Grid grid;
    grid.step = step;
    grid.side = 2 * int(std::lround(halfSide / step)) + 1;
    grid.west = -(grid.side / 2) * step;
    grid.north = -grid.west;
    return grid;
}

std::string projectionAt(const Geodetic& at) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "+proj=ortho +lat_0=%.12f +lon_0=%.12f +datum=WGS84 +units=m +no_defs",
                  at.latitudeDegrees, at.longitudeDegrees);
    return text;
}

// Heights above the ellipsoid that put pixels at given heights above the frame's plane.
class FramePlane {
  public:
    static Result<FramePlane> create(const Geodetic& at) {
        Result<CrsToEcef> crs = CrsToEcef::create(projectionAt(at), Heights::Ellipsoidal);
        if (!crs)
            return crs.error();
        return FramePlane(at, std::move(*crs));
    }
    // `height` of a place in the frame; NaN comes through.
    Result<double> ellipsoidal(glm::dvec2 pixel,
                               const std::function<double(glm::dvec2)>& height) const {
        const Result<Geodetic> place = crs_.geodetic({pixel, 0.0});
        if (!place)
            return place.error();
        Geodetic there = *place;
        there.heightMetres = at_.heightMetres;
        // A step of height moves the pixel sideways by a thousandth of it: two rounds do.
        constexpr int kRounds = 3;
        for (int i = 0; i < kRounds; ++i) {
            const glm::dvec3 local = enuFromEcef_(ecefOf(there)).xyz;
            const double wanted = height(glm::dvec2(local));
            if (std::isnan(wanted))
                return wanted;
            there.heightMetres += wanted - local.z;
        }
        return there.heightMetres;
    }

  private:
    FramePlane(const Geodetic& at, CrsToEcef crs)
        : at_(at), crs_(std::move(crs)), enuFromEcef_(rigidInverse(ecefFromEnu(at))) {}
    Geodetic at_;
    CrsToEcef crs_;
    Transform<Enu, Ecef> enuFromEcef_;
};

struct GdalSilence {
    GdalSilence() { CPLPushErrorHandler(CPLQuietErrorHandler); }
    ~GdalSilence() { CPLPopErrorHandler(); }
};

// A band for each of `heights`.
Failure writeRaster(const std::string& path, const Geodetic& at, const Grid& grid,
                    std::span<const std::function<double(glm::dvec2)>> heights) {
    const Result<FramePlane> plane = FramePlane::create(at);
    if (!plane)
        return plane.error();
    const GdalSilence silence;
    GDALAllRegister();
    const auto unwritable = [&] { return Error{path, "cannot be written", ErrorKind::Output}; };
    const std::array<const char*, 5> options = {"TILED=YES", "COMPRESS=DEFLATE", "PREDICTOR=3",
                                                "NUM_THREADS=1", nullptr};
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    const GDALDatasetUniquePtr file(driver->Create(path.c_str(), grid.side, grid.side,
                                                   int(heights.size()), GDT_Float32,
                                                   const_cast<char**>(options.data())));
    if (!file)
        return unwritable();
    OGRSpatialReference reference;
    reference.importFromProj4(projectionAt(at).c_str());
    std::array<double, 6> transform = {grid.west - 0.5 * grid.step,  grid.step, 0.0,
                                       grid.north + 0.5 * grid.step, 0.0,       -grid.step};
    file->SetSpatialRef(&reference);
    file->SetGeoTransform(transform.data());
    std::vector<float> row(std::size_t(grid.side));
    for (int band = 0; band < int(heights.size()); ++band) {
        GDALRasterBand* into = file->GetRasterBand(band + 1);
        into->SetNoDataValue(kNoData);
        for (int y = 0; y < grid.side; ++y) {
            for (int x = 0; x < grid.side; ++x) {
                const auto height =
                    plane->ellipsoidal({grid.west + x * grid.step, grid.north - y * grid.step},
                                       heights[std::size_t(band)]);
                if (!height)
                    return height.error();
                row[std::size_t(x)] = float(std::isnan(*height) ? kNoData : *height);
            }
            if (into->RasterIO(GF_Write, 0, y, grid.side, 1, row.data(), grid.side, 1, GDT_Float32,
                               0, 0, nullptr) != CE_None)
                return unwritable();
        }
    }
    CPLErrorReset();
    file->FlushCache();
    return CPLGetLastErrorType() >= CE_Failure ? Failure(unwritable()) : std::nullopt;
}

json lonLat(const Geodetic& at, glm::dvec2 p) {
    const Geodetic g = geodeticOf(ecefFromEnu(at)(Point<Enu>{{p, 0.0}}));
    return {g.longitudeDegrees, g.latitudeDegrees};
}

json feature(const char* type, json coordinates, json properties) {
    return {{"type", "Feature"},
            {"geometry", {{"type", type}, {"coordinates", std::move(coordinates)}}},
            {"properties", std::move(properties)}};
}

// How far north of the river's middle a place behind the bank is, at this x.
double behindBank(const Plan& plan, double x) {
    const double wanted = plan.riverHalfWidth() + kWallFromBankMetres;
    double low = plan.bridgeY() - 2.0 * wanted, high = plan.bridgeY() + 4.0 * wanted;
    // From the river's middle northwards the distance to it grows.
    for (double y = low; y < high; y += 0.5 * plan.riverHalfWidth())
        if (plan.riverDistance({x, y}) < plan.riverDistance({x, low}))
            low = y;
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        (plan.riverDistance({x, middle}) < wanted ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace

double surroundingHeight(const Plan& plan, glm::dvec2 p) {
    const double side = plan.sideMetres();
    const glm::dvec2 beyond = glm::max(glm::abs(p) - glm::dvec2(0.5 * side), glm::dvec2(0.0));
    const double out = glm::length(beyond);
    double z = plan.terrain(p);
    if (out <= 0.0)
        return z;
    // Ridges: noise folded at its middle.
    const auto ridge = [&](double length, std::uint64_t salt) {
        const double n = valueNoise(plan.seed() + kRidges + salt, p.x / length, p.y / length);
        return 1.0 - std::abs(2.0 * n - 1.0);
    };
    const double relief =
        0.6 * ridge(0.55 * side, 0) + 0.3 * ridge(0.23 * side, 1) + 0.1 * ridge(0.08 * side, 2);
    const double valley = smoothstep(plan.riverHalfWidth() + 30.0,
                                     plan.riverHalfWidth() + 0.35 * side, plan.riverDistance(p));
    return z + kReliefPerSide * side * smoothstep(0.0, side, out) * relief * relief *
                   mix(0.15, 1.0, valley);
}

double floodLevel(const Plan& plan, glm::dvec2 p, double hours) {
    const double away = std::max(plan.riverDistance(p) - plan.riverHalfWidth(), 0.0);
    const double level = mix(kFirstMetres, kPeakMetres, smoothstep(0.0, kFloodHours, hours));
    return level - kFallPerMetre * away;
}

Failure writeTerrain(const Plan& plan, const Geodetic& at, const std::string& path) {
    const double side = plan.sideMetres();
    constexpr double kFinest = 8.0, kPixelsASide = 256.0;
    const double step = std::exp2(std::floor(std::log2(std::max(side / kPixelsASide, kFinest))));
    const std::array<std::function<double(glm::dvec2)>, 1> ground = {
        [&](glm::dvec2 p) { return surroundingHeight(plan, p); }};
    return writeRaster(path, at, gridFor(kReach * side, step), ground);
}

Failure writeFlood(const Plan& plan, const Geodetic& at, const std::string& path) {
    const double side = plan.sideMetres();
    constexpr double kMostPixels = 1024.0;
    const double step =
        std::exp2(std::floor(std::log2(std::max(side / kMostPixels, kGroundStepMetres))));
    std::vector<std::function<double(glm::dvec2)>> levels;
    for (int hour = 0; hour <= kFloodHours; ++hour)
        levels.emplace_back([&plan, hour](glm::dvec2 p) {
            const double level = floodLevel(plan, p, hour);
            return level > surroundingHeight(plan, p) ? level
                                                      : std::numeric_limits<double>::quiet_NaN();
        });
    return writeRaster(path, at, gridFor(0.5 * side, step), levels);
}

json holeJson(const Plan& plan, const Geodetic& at) {
    // A little wider, so that pixels on the rim are in it for certain.
    const double half = 0.5 * plan.sideMetres() + 0.25;
    json ring = json::array();
    for (const glm::dvec2 corner : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1),
                                    glm::dvec2(-1, 1), glm::dvec2(-1, -1)})
        ring.push_back(lonLat(at, half * corner));
    return {{"type", "FeatureCollection"},
            {"features", json::array({feature("Polygon", json::array({ring}), json::object())})}};
}

json barriersJson(const Plan& plan, const Geodetic& at) {
    json features = json::array();
    for (const double side : {-1.0, 1.0}) {
        json line = json::array();
        for (double x = kRoadGapMetres; x <= kWallHalfLengthMetres; x += kWallStepMetres) {
            const double east = Plan::axisX() + side * x;
            line.push_back(lonLat(at, {east, behindBank(plan, east)}));
        }
        features.push_back(
            feature("LineString", line, {{"height", kWallHeightMetres}, {"width", 0.6}}));
    }
    return {{"type", "FeatureCollection"}, {"features", features}};
}

} // namespace gnomon::builtin
