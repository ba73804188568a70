#include "viewer/crs_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <mutex>

namespace gnomon {

namespace {

class CrsFrame : public CurvedFrame {
  public:
    CrsFrame(CrsToEcef crs, double raiseMetres) : crs_(std::move(crs)), raise_(0, 0, raiseMetres) {}

    Result<Point<Ecef>> place(const glm::dvec3& at) const override {
        const std::lock_guard lock(mutex_);
        return crs_(at + raise_);
    }
    Result<Transform<Ecef, Tile>> near(const glm::dvec3& at) const override {
        const std::lock_guard lock(mutex_);
        auto map = crs_.ecefFromCrsNear(at + raise_);
        if (!map)
            return map;
        glm::dmat4 raised(1.0);
        raised[3] = glm::dvec4(raise_, 1.0);
        return *map * Transform<Tile, Tile>{raised};
    }

  private:
    mutable std::mutex mutex_; // PROJ's objects belong to one thread at a time
    CrsToEcef crs_;
    glm::dvec3 raise_;
};

// The extent of a system's area of use in its own coordinates, rounded outwards to 10 km.
struct System {
    const char* code;
    double west, south, east, north;
};

// After the EPSG registry's areas of use. In the order of their sizes; the large ones hold most
// coordinates there are, so they come last.
constexpr std::array<System, 14> kSystems{{
    {"EPSG:3879", 25'440'000, 6'630'000, 25'580'000, 6'740'000}, // Helsinki
    {"EPSG:31370", 10'000, 20'000, 300'000, 250'000},            // Belgium
    {"EPSG:28992", 0, 300'000, 290'000, 630'000},                // the Netherlands
    {"EPSG:2056", 2'480'000, 1'070'000, 2'840'000, 1'300'000},   // Switzerland
    {"EPSG:4647", 32'200'000, 5'200'000, 32'970'000, 6'110'000}, // Germany, zone in the east
    {"EPSG:5514", -910'000, -1'350'000, -160'000, -930'000},     // Czechia and Slovakia
    {"EPSG:2180", 140'000, 120'000, 880'000, 910'000},           // Poland
    {"EPSG:27700", 0, 0, 700'000, 1'300'000},                    // Great Britain
    {"EPSG:2154", 90'000, 6'040'000, 1'250'000, 7'120'000},      // France
    {"EPSG:3006", 260'000, 6'090'000, 930'000, 7'700'000},       // Sweden
    {"EPSG:25832", 160'000, 4'200'000, 840'000, 7'000'000},      // Europe, 6 to 12 degrees east
    {"EPSG:25833", 160'000, 4'200'000, 840'000, 7'000'000},      // Europe, 12 to 18 degrees east
    {"EPSG:5070", -2'360'000, 260'000, 2'260'000, 3'180'000},    // the United States
    {"EPSG:3857", -20'037'509, -20'048'967, 20'037'509, 20'048'967},
}};

// France's nine zones: each has its own million of northing.
void addFrenchZone(const glm::dvec2& p, std::vector<std::string>& codes) {
    constexpr double kEast = 1'700'000, kNorth = 200'000, kStep = 1'000'000;
    constexpr double kReachEast = 600'000, kReachNorth = 170'000;
    const double zone = std::round((p.y - kNorth) / kStep);
    if (zone >= 1 && zone <= 9 && std::abs(p.x - kEast) <= kReachEast &&
        std::abs(p.y - kNorth - zone * kStep) <= kReachNorth)
        codes.push_back("EPSG:" + std::to_string(3941 + int(zone)));
}

} // namespace

std::shared_ptr<const CurvedFrame> crsFrame(CrsToEcef crs, double raiseMetres) {
    return std::make_shared<CrsFrame>(std::move(crs), raiseMetres);
}

std::vector<std::string> likelySystems(const glm::dvec2& eastNorth) {
    constexpr double kNearOriginMetres = 10'000; // then it is a frame of its own, rather
    constexpr std::size_t kMost = 5;
    std::vector<std::string> codes, out;
    if (!(glm::length(eastNorth) > kNearOriginMetres))
        return out;
    addFrenchZone(eastNorth, codes);
    for (const System& s : kSystems)
        if (eastNorth.x >= s.west && eastNorth.x <= s.east && eastNorth.y >= s.south &&
            eastNorth.y <= s.north)
            codes.emplace_back(s.code);
    for (const std::string& code : codes) {
        const auto crs = CrsToEcef::create(code, Heights::Ellipsoidal);
        const auto place = crs ? crs->geodetic({eastNorth, 0.0}) : Result<Geodetic>(Error{});
        if (!place || out.size() == kMost)
            continue;
        char text[64];
        std::snprintf(text, sizeof text, "%s (%.2f, %.2f)", code.c_str(), place->longitudeDegrees,
                      place->latitudeDegrees);
        out.emplace_back(text);
    }
    return out;
}

} // namespace gnomon
