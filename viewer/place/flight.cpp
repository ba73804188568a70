#include "viewer/place/flight.h"

#include "geo/camera.h"
#include "viewer/place/surroundings.h"

#include <glm/geometric.hpp>

#include <cmath>
#include <cstdio>

namespace gnomon::builtin {
namespace {

// Higher than any roof (offices: 16 storeys of 3.5 m on ground a few metres above the plain).
constexpr double kOverRoofsMetres = 80.0;
constexpr double kEyeMetres = 2.6; // above the street at the end
constexpr double kKeySeconds = 0.25;

} // namespace

std::vector<FlightKey> flight(const Plan& plan) {
    const double r = plan.radiusMetres();
    const bool large = r > 800;
    const double duration = large ? 10.0 : 5.0;
    const double endY = large ? -150.0 : -85.0;
    // Where it starts, seen from where it ends.
    const double back = large ? 1.02 * r : 1.9 * r + 200, high = large ? 0.5 * r : 0.75 * r + 160;
    const double aside = large ? -0.5 * r : -1.0 * r - 120;
    // Height falls with the distance to go as its power 1.5, so it glides out level; the way aside
    // is gone before the roofs are reached.
    const double onAxis = back * std::pow(kOverRoofsMetres / high, 1 / 1.5);
    const double endTarget = std::tan(13.0 / 180 * 3.14159265358979) * (Plan::centre().y - endY);
    std::vector<FlightKey> keys;
    for (int i = 0; i <= int(duration / kKeySeconds + 0.5); ++i) {
        FlightKey key;
        key.seconds = i * kKeySeconds;
        const double s = smoothstep(0, 1, (key.seconds + 0.6) / (duration + 0.6));
        const double s0 = smoothstep(0, 1, 0.6 / (duration + 0.6));
        const double toGo = back * std::pow((1 - s) / (1 - s0), 1.5);
        const glm::dvec2 p{Plan::axisX() + aside * smoothstep(onAxis, back, toGo), endY - toGo};
        const double street = plan.ground({Plan::axisX(), endY});
        const double above = high * std::pow(toGo / back, 1.5);
        const double lowest = std::max(street, plan.ground(p));
        key.position = {p, mix(street, lowest, smoothstep(0, 30, toGo)) + kEyeMetres + above};
        key.target = {Plan::centre(),
                      street + kEyeMetres + mix(endTarget, 12, smoothstep(0, back, toGo))};
        keys.push_back(key);
    }
    return keys;
}

nlohmann::json flightJson(const std::vector<FlightKey>& keys, const Geodetic& at) {
    const Transform<Ecef, Enu> ecefFromPlace = ecefFromEnu(at);
    nlohmann::json frames = nlohmann::json::array();
    double heading = 0;
    for (const FlightKey& key : keys) {
        const glm::dvec3 forward = glm::normalize(key.target - key.position);
        const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
        Camera camera;
        camera.position = ecefFromPlace(Point<Enu>{key.position});
        camera.forward = ecefFromPlace(Vector<Enu>{forward});
        camera.right = ecefFromPlace(Vector<Enu>{right});
        camera.up = cross(camera.right, camera.forward);
        const Orientation o = orientationOf(camera);
        const Geodetic g = geodeticOf(camera.position);
        // Without jumps by a whole turn.
        const double turns = frames.empty() ? 0 : std::round((heading - o.headingDegrees) / 360);
        heading = o.headingDegrees + 360 * turns;
        frames.push_back({{"t", key.seconds},
                          {"lon", g.longitudeDegrees},
                          {"lat", g.latitudeDegrees},
                          {"height", g.heightMetres},
                          {"heading", heading},
                          {"pitch", o.pitchDegrees},
                          {"roll", o.rollDegrees},
                          {"fov", kFlightFovDegrees}});
    }
    return {{"keyframes", frames}, {"interpolation", "smooth"}};
}

namespace {

// Of the longest day, by the sun: 16.0 is four hours past noon. Hours 12 to 24 only.
std::string atHour(const Geodetic& at, double hour) {
    const int minutes = int(std::lround((hour - at.longitudeDegrees / 15.0) * 60)); // 0 h … 36 h
    char text[64];
    std::snprintf(text, sizeof text, "2025-%02d-%02dT%02d:%02d:00Z",
                  at.latitudeDegrees < 0 ? 12 : 6, 21 + minutes / 1440, minutes / 60 % 24,
                  minutes % 60);
    return text;
}

constexpr double kFloodBegins = 14.5; // so it is at its height at dusk

} // namespace

std::string afternoon(const Geodetic& at) {
    return atHour(at, 16.0);
}
std::string floodBegins(const Geodetic& at) {
    return atHour(at, kFloodBegins);
}
std::string barrierAppears(const Geodetic& at) {
    return atHour(at, kFloodBegins + kBarrierHour);
}

} // namespace gnomon::builtin
