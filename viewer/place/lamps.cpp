#include "viewer/place/lamps.h"

#include <cmath>

namespace gnomon::builtin {
namespace {

constexpr double kSpacingMetres = 25.0; // some three and a half times the height, as is usual
constexpr double kStreetLampMetres = 7.0;
constexpr double kLanternMetres = 4.0;
constexpr double kFromTowerMetres = 30.0; // a lantern, north and east of the tower

} // namespace

std::vector<StreetLamp> streetLamps(const Plan& plan) {
    std::vector<StreetLamp> lamps;
    const double last = Plan::centre().y - 2.0 * kFromTowerMetres;
    const double first = plan.bridgeY() - plan.deckHalfLength() - kSpacingMetres;
    const int count = 1 + int(std::floor((last - first) / kSpacingMetres));
    for (int i = 0; i < count; ++i) {
        const glm::dvec2 p(Plan::axisX(), last - i * kSpacingMetres);
        const bool deck = std::abs(p.y - plan.bridgeY()) < plan.deckHalfLength();
        lamps.push_back({{p, deck ? plan.deckMetres() : plan.ground(p)}, kStreetLampMetres, false});
    }
    for (const double x : {-kFromTowerMetres, kFromTowerMetres})
        for (const double y : {-kFromTowerMetres, kFromTowerMetres}) {
            const glm::dvec2 p = Plan::centre() + glm::dvec2(x, y);
            lamps.push_back({{p, plan.ground(p)}, kLanternMetres, true});
        }
    return lamps;
}

nlohmann::json lampsJson(const std::vector<StreetLamp>& lamps, const Geodetic& at) {
    using nlohmann::json;
    const Transform<Ecef, Enu> ecefFromPlace = ecefFromEnu(at);
    json features = json::array();
    for (const StreetLamp& lamp : lamps) {
        const Geodetic foot = geodeticOf(ecefFromPlace(Point<Enu>{lamp.foot}));
        json properties{{"height", lamp.heightMetres},
                        {"facing", lamp.allRound ? "all" : "down"},
                        {"range", lamp.allRound ? 30.0 : 45.0}};
        // Warm white; on the street below as bright as an overcast day would leave it.
        const double power = lamp.allRound ? 25.0 : 80.0;
        properties["power"] = {power, 0.76 * power, 0.48 * power};
        features.push_back(
            {{"type", "Feature"},
             {"geometry",
              {{"type", "Point"},
               {"coordinates", {foot.longitudeDegrees, foot.latitudeDegrees, foot.heightMetres}}}},
             {"properties", properties}});
    }
    return {{"type", "FeatureCollection"}, {"features", features}};
}

} // namespace gnomon::builtin
