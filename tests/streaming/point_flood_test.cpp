// Levels observed at points, and the water between them.
#include "streaming/flood/point_flood.h"
#include "streaming/flood/water_surface.h"
#include "streaming/terrain/terrain.h"
#include "tests/streaming/flood_support.h"

#include <algorithm>
#include <cmath>
#include <fstream>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// Metres east and north of a place near Newcastle, and heights by a function of them.
constexpr glm::dvec2 kPlace{151.74, -32.94};
glm::dvec2 metresOf(glm::dvec2 lonLat) {
    return {(lonLat.x - kPlace.x) * 111320.0 * std::cos(kPlace.y * 3.14159265358979 / 180.0),
            (lonLat.y - kPlace.y) * 110920.0};
}
glm::dvec2 lonLatOf(double x, double y) {
    return {kPlace.x + x / (111320.0 * std::cos(kPlace.y * 3.14159265358979 / 180.0)),
            kPlace.y + y / 110920.0};
}

class MadeGround : public GroundHeights {
  public:
    explicit MadeGround(std::function<double(glm::dvec2)> height) : height_(std::move(height)) {}
    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        for (std::size_t i = 0; i < lonLat.size(); ++i)
            heights[i] = height_(metresOf(lonLat[i]));
    }

  private:
    std::function<double(glm::dvec2)> height_;
};

struct Observed {
    double x = 0, y = 0, level = 0;
};
std::string table(const std::vector<Observed>& points) {
    std::string text = "lon,lat,id,stage\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
        const glm::dvec2 p = lonLatOf(points[i].x, points[i].y);
        std::array<char, 128> line{};
        std::snprintf(line.data(), line.size(), "%.10f,%.10f,P%zu,%.3f\n", p.x, p.y, i,
                      points[i].level);
        text += line.data();
    }
    return text;
}

Result<std::shared_ptr<WaterSurface>> surfaceOf(const std::string& path,
                                                const std::function<double(glm::dvec2)>& ground,
                                                const FloodOptions& options = {}) {
    const auto flood = openFlood({path}, options);
    if (!flood)
        return flood.error();
    return WaterSurface::create(*flood, std::make_shared<MadeGround>(ground), {});
}

bool isWet(const WaterSurface& surface, double x, double y) {
    const auto at = surface.at(0.0, lonLatOf(x, y));
    return at && at->has_value();
}

double levelAt(const WaterSurface& surface, double x, double y) {
    const auto at = surface.at(0.0, lonLatOf(x, y));
    return at && *at ? (*at)->levelMetres : std::nan("");
}

} // namespace

TEST(PointFlood, FallsStraightAlongItsPointsAndIsLevelBeyond) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.csv") << table({{0, 0, 10}, {100, 0, 9}, {200, 0, 6}});
    const auto surface = surfaceOf(folder / "gauges.csv", [](glm::dvec2) { return 0.0; });
    ASSERT_TRUE(surface) << surface.error().message();
    EXPECT_NEAR(levelAt(**surface, 0, 0), 10.0, 0.02);
    EXPECT_NEAR(levelAt(**surface, 50, 0), 9.5, 0.02);
    EXPECT_NEAR(levelAt(**surface, 100, 0), 9.0, 0.02);
    EXPECT_NEAR(levelAt(**surface, 150, 0), 7.5, 0.02);
    EXPECT_NEAR(levelAt(**surface, -60, 0), 10.0, 0.02);
    EXPECT_NEAR(levelAt(**surface, 260, 0), 6.0, 0.02);
    for (double y = -80; y <= 80; y += 20) // never beyond what was seen
        for (double x = -40; x <= 240; x += 20) {
            EXPECT_LE(levelAt(**surface, x, y), 10.0 + 1e-4);
            EXPECT_GE(levelAt(**surface, x, y), 6.0 - 1e-4);
        }
}

TEST(PointFlood, EndsAsFarFromItsPointsAsTheyAreFromEachOther) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.csv") << table({{0, 0, 10}, {100, 0, 9}, {150, 0, 9}});
    const auto surface = surfaceOf(folder / "gauges.csv", [](glm::dvec2) { return 0.0; });
    ASSERT_TRUE(surface);
    EXPECT_TRUE(isWet(**surface, -95, 0));
    EXPECT_FALSE(isWet(**surface, -105, 0));
    EXPECT_TRUE(isWet(**surface, 150, 95));
    EXPECT_FALSE(isWet(**surface, 150, 105));
}

TEST(PointFlood, KeepsOutOfHollowsThatNoWaterComesTo) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.csv") << table({{0, 0, 2}, {100, 0, 2}});
    // A valley along the x axis, a dyke, and as low ground behind it with a gap far off.
    const auto ground = [](glm::dvec2 p) {
        if (p.y < 20.0)
            return 0.0;
        return p.y < 30.0 ? 5.0 : 0.0;
    };
    const auto closed = surfaceOf(folder / "gauges.csv", ground);
    ASSERT_TRUE(closed);
    EXPECT_TRUE(isWet(**closed, 50, 0));
    EXPECT_FALSE(isWet(**closed, 50, 25));
    EXPECT_FALSE(isWet(**closed, 50, 50));
    const auto open = surfaceOf(folder / "gauges.csv", [&](glm::dvec2 p) {
        return std::abs(p.x - 80.0) < 5.0 ? 0.0 : ground(p);
    });
    ASSERT_TRUE(open);
    EXPECT_TRUE(isWet(**open, 50, 50));
}

TEST(PointFlood, IsDryWhereAPointLiesAboveItsLevelAndSaysSo) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.csv") << table({{0, 0, 2}, {100, 0, 2}, {150, 0, 1}});
    const auto surface =
        surfaceOf(folder / "gauges.csv", [](glm::dvec2 p) { return p.x > 130.0 ? 3.0 : 0.0; });
    ASSERT_TRUE(surface);
    EXPECT_FALSE(isWet(**surface, 150, 0));
    EXPECT_TRUE(isWet(**surface, 100, 0));
    const auto& notes = (*surface)->data().notes;
    EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
        return note.find("dry: P2") != std::string::npos;
    }));
    EXPECT_TRUE((*surface)->data().isInterpolated());
    EXPECT_TRUE((*(*surface)->at(0.0, lonLatOf(50, 0)))->interpolated);
}

TEST(PointFlood, AllUnderTheGroundIsOneClearLine) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.csv") << table({{0, 0, 2}, {100, 0, 2}});
    const auto surface = surfaceOf(folder / "gauges.csv", [](glm::dvec2) { return 30.0; });
    ASSERT_FALSE(surface);
    EXPECT_NE(surface.error().reason.find("above the ground"), std::string::npos);
    const auto nowhere = surfaceOf(folder / "gauges.csv", [](glm::dvec2) { return std::nan(""); });
    ASSERT_FALSE(nowhere);
    EXPECT_NE(nowhere.error().reason.find("no"), std::string::npos);
}

TEST(PointFlood, ReadsColumnsByNameOrAUniquePartOfIt) {
    const TemporaryFolder folder;
    std::ofstream(folder / "obs.csv")
        << "x, y, ID, stage (Draft), stage (Final), TUFLOW (Final)\r\n"
           "382373.5, 6354387.8, 4, 23.0, 23.01, 22.77\r\n"
           "382354.6, 6354365.2, 3, 23.1, , 23.11\r\n";
    FloodOptions options;
    options.crs = "EPSG:32756";
    const auto first = [&](const char* variable) {
        options.variable = variable;
        const auto flood = openFlood({folder / "obs.csv"}, options);
        return flood ? double((*(*flood)->values(0))[0]) : -1.0;
    };
    EXPECT_NEAR(first("stage (Final)"), 23.01, 1e-5);
    EXPECT_NEAR(first("Final"), 23.01, 1e-5); // that of a stage
    EXPECT_NEAR(first("draft"), 23.0, 1e-5);
    EXPECT_NEAR(first("TUFLOW"), 22.77, 1e-5);
    EXPECT_EQ(first("stage"), -1.0);
    EXPECT_EQ(first("nothing"), -1.0);
    options.variable = "stage (Final)";
    const auto flood = openFlood({folder / "obs.csv"}, options);
    EXPECT_EQ((*flood)->geometry().lonLat.size(), 1u); // the other has no number there
    options.crs = {};
    EXPECT_FALSE(openFlood({folder / "obs.csv"}, options));
}

TEST(PointFlood, ReadsGeoJson) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.geojson") << R"({"type":"FeatureCollection","features":[
{"type":"Feature","geometry":{"type":"Point","coordinates":[151.74,-32.94]},"properties":{"name":"A","water_level":2.5}},
{"type":"Feature","geometry":{"type":"Point","coordinates":[151.741,-32.94]},"properties":{"name":"B","water_level":2.0}},
{"type":"Feature","geometry":null,"properties":{"name":"C","water_level":1.0}}]})";
    const auto surface = surfaceOf(folder / "gauges.geojson", [](glm::dvec2) { return 0.0; });
    ASSERT_TRUE(surface) << surface.error().message();
    EXPECT_NEAR(levelAt(**surface, 0, 0), 2.5, 0.02);
}

TEST(PointFlood, ThatIsBrokenFailsInALine) {
    const TemporaryFolder folder;
    const auto fails = [&](const std::string& text, const std::string& name = "a.csv") {
        std::ofstream(folder / name, std::ios::binary) << text;
        const auto flood = openFlood({folder / name}, {});
        return !flood && flood.error().message().find('\n') == std::string::npos;
    };
    EXPECT_TRUE(fails("lon,lat,stage\n"));
    EXPECT_TRUE(fails("lon,lat,stage\nx,y,z\n"));
    EXPECT_TRUE(fails("lon,lat,stage\n151,1e999,2\n"));
    EXPECT_TRUE(fails("lon,lat,stage\n151,95,2\n"));
    EXPECT_TRUE(fails("lon,lat,colour\n151,9,2\n"));
    EXPECT_TRUE(fails(std::string("\0\0\0,\n", 5)));
    EXPECT_TRUE(fails("{\"type\":\"FeatureCollection\"", "a.geojson"));
    std::string many = "lon,lat,stage\n";
    for (int i = 0; i < 2000; ++i)
        many += std::to_string(151.0 + 1e-4 * i) + ",-32,1\n";
    EXPECT_TRUE(fails(many));
}

TEST(PointFlood, TakesTheMeanOfPointsAtOnePlace) {
    const TemporaryFolder folder;
    std::ofstream(folder / "gauges.csv") << table({{0, 0, 2}, {0, 0, 3}, {100, 0, 2.5}});
    const auto surface = surfaceOf(folder / "gauges.csv", [](glm::dvec2) { return 0.0; });
    ASSERT_TRUE(surface);
    EXPECT_NEAR(levelAt(**surface, 0, 0), 2.5, 1e-3);
}

// Published with the observations (Australian Rainfall and Runoff, project 15).
TEST(RealFlood, OfMerewetherHasItsPublishedDepths) {
    const auto folder = dataFolder() / "flood-merewether";
    GNOMON_NEEDS(folder / "topography1.asc");
    TerrainOptions terrain;
    terrain.crs = "EPSG:32756";
    const auto ground = Terrain::open((folder / "topography1.asc").string(), terrain);
    ASSERT_TRUE(ground) << ground.error().message();
    FloodOptions options;
    options.crs = "EPSG:32756";
    options.variable = "ARR Report Final";
    const auto flood =
        openFlood({(folder / "Observations" / "ObservationPoints.csv").string()}, options);
    ASSERT_TRUE(flood) << flood.error().message();
    const auto surface = WaterSurface::create(*flood, *ground, {});
    ASSERT_TRUE(surface) << surface.error().message();
    const auto crs = CrsToEcef::create("EPSG:32756", Heights::Ellipsoidal);
    const auto waterAt = [&](double x, double y) {
        const auto place = crs->geodetic({x, y, 0.0});
        return *(*surface)->at(0.0, {place->longitudeDegrees, place->latitudeDegrees});
    };
    struct Published {
        double x, y, stage, depth;
    };
    for (const Published& point :
         {Published{382424.399931652704254, 6354478.333491845987737, 19.98, 0.49},
          {382509.713526756153442, 6354548.220816057175398, 18.38, 0.69},
          {382354.610297574603464, 6354365.208338395692408, 23.14, 0.06},
          {382373.514531995810103, 6354387.837079666554928, 23.01, 0.44}}) {
        const auto water = waterAt(point.x, point.y);
        ASSERT_TRUE(water) << point.stage;
        EXPECT_NEAR(water->levelMetres, point.stage, 0.01);
        EXPECT_NEAR(water->depthMetres, point.depth, 0.02);
        EXPECT_TRUE(water->interpolated);
    }
    EXPECT_FALSE(waterAt(382339.416016335249878, 6354297.836651652120054));
    const auto totals = (*surface)->totals(0.0);
    EXPECT_NEAR(totals->shownAreaSquareMetres / totals->wetAreaSquareMetres, 1.0, 0.01);
    EXPECT_NEAR(totals->shownVolumeCubicMetres / totals->volumeCubicMetres, 1.0, 0.01);
}
