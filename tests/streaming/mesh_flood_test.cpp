// Meshes written for the purpose: what is shown of them must follow from what was written.
#include "mesh_flood_support.h"

#include "geo/crs.h"
#include "streaming/flood/unstructured_time.h"
#include "streaming/flood/unstructured_topology.h"

#include <set>

namespace gnomon {

namespace {

class MeshFlood : public testing::Test {
  protected:
    Result<std::shared_ptr<const FloodData>> opened(const UgridSpec& spec,
                                                    const FloodOptions& options = {}) {
        // Another name each time: libraries share what they have open under one.
        const std::string path = folder_ / ("result" + std::to_string(files_++) + ".nc");
        writeUgrid(path, spec);
        EXPECT_TRUE(isUnstructuredFlood(path));
        return openUnstructuredFlood(path, options);
    }
    std::shared_ptr<const FloodData> open(const UgridSpec& spec, const FloodOptions& options = {}) {
        const auto data = opened(spec, options);
        if (!data)
            throw std::runtime_error(data.error().message());
        return *data;
    }
    TemporaryFolder folder_;
    int files_ = 0;
};

// East of the zone's central meridian UTM stretches: areas on the Earth differ by its square.
double utmArea(glm::dvec2 place) {
    const double offset = (place.x - 500000.0) / 6378137.0;
    const double scale = 0.9996 * (1.0 + 0.5 * offset * offset);
    return 1.0 / (scale * scale);
}

// Where a level is sloped, so that each value can be told from each other.
double slope(glm::dvec2 p, int step) {
    return 5.0 + step + 0.001 * (p.x - 290000.0) + 0.002 * (p.y - 5050000.0);
}

} // namespace

TEST_F(MeshFlood, FacesAreNodesAndTheRimCoversTheRest) {
    UgridSpec spec = gridSpec(6, 5, 50.0, true);
    spec.level = slope;
    const auto data = open(spec);
    EXPECT_EQ(data->crs, "EPSG:32633");
    EXPECT_EQ(data->kind(), WaterKind::Stage);
    EXPECT_EQ(data->geometry().lonLat.size(), spec.faces.size() + 22); // 2 (6 + 5) on the rim
    const auto values = data->values(1);
    ASSERT_TRUE(values);
    for (std::size_t f = 0; f < spec.faces.size(); ++f)
        EXPECT_NEAR((*values)[f], slope(middleOf(spec, f), 1), 1e-4) << f;
    const double area = 6 * 5 * 2500.0 * utmArea(spec.points[0]);
    const MeshSums sums = sumsOf(*data, 1);
    EXPECT_NEAR(sums.cellArea, area, area * 1e-5);
    EXPECT_NEAR(sums.triangleArea, area, area * 1e-5);
    EXPECT_EQ(sums.rim, 22u);
}

TEST_F(MeshFlood, RimNodesAreTheMeanOfTheWetFacesAroundThem) {
    UgridSpec spec = gridSpec(2, 1, 50.0, false);
    spec.level = [](glm::dvec2 p, int) { return p.x < 290050.0 ? 4.0 : std::nan(""); };
    spec.bed = ""; // so that only the fill value says what is dry
    auto data = open(spec);
    const auto values = data->values(0);
    ASSERT_TRUE(values);
    int wet = 0, dry = 0;
    for (std::size_t i = 2; i < values->size(); ++i) {
        wet += (*values)[i] == 4.0f;
        dry += std::isnan((*values)[i]);
    }
    EXPECT_EQ(wet, 4); // of the wet square's corners, two of which the dry one shares
    EXPECT_EQ(dry, 2);
}

TEST_F(MeshFlood, StartIndexZeroOneAndUnsaidGiveTheSameMesh) {
    std::vector<MeshSums> all;
    for (const int start : {0, 1})
        for (const bool said : {true, false})
            for (const int format : {NC_64BIT_OFFSET, NC_NETCDF4, NC_64BIT_DATA}) {
                UgridSpec spec = gridSpec(4, 3, 20.0, true);
                spec.level = slope;
                spec.startIndex = start;
                spec.saysStartIndex = said;
                spec.format = format;
                all.push_back(sumsOf(*open(spec), 0));
            }
    for (const MeshSums& sums : all) {
        EXPECT_DOUBLE_EQ(sums.volume, all[0].volume);
        EXPECT_DOUBLE_EQ(sums.triangleArea, all[0].triangleArea);
        EXPECT_GT(sums.volume, 0.0);
    }
}

TEST_F(MeshFlood, NodesStandForAThirdOfTheirTriangles) {
    UgridSpec spec = gridSpec(5, 4, 50.0, true);
    spec.onFaces = false;
    spec.level = slope;
    const auto data = open(spec);
    EXPECT_EQ(data->geometry().lonLat.size(), 30u);
    EXPECT_EQ(data->geometry().triangles.size(), 40u);
    const MeshSums sums = sumsOf(*data, 0);
    const double area = 20 * 2500.0 * utmArea(spec.points[0]);
    EXPECT_NEAR(sums.cellArea, area, area * 1e-5);
    // A plane over triangles: its mean is that of the middle, whatever way they are cut.
    EXPECT_NEAR(sums.volume, area * slope({290125.0, 5050100.0}, 0), area * 0.03);
    EXPECT_EQ(sums.rim, 0u);
}

TEST_F(MeshFlood, NeighboursOfTwoSizesMeetWithoutARim) {
    // One square of 100 m beside four of 50 m, the middle point not among the large one's corners.
    UgridSpec spec;
    spec.points = {{0, 0},    {100, 0},   {100, 100}, {0, 100},  {150, 0},  {150, 50},
                   {100, 50}, {150, 100}, {200, 0},   {200, 50}, {200, 100}};
    for (glm::dvec2& point : spec.points)
        point += glm::dvec2(290000.0, 5050000.0);
    spec.faces = {{0, 1, 2, 3}, {1, 4, 5, 6}, {6, 5, 7, 2}, {4, 8, 9, 5}, {5, 9, 10, 7}};
    const auto data = open(spec);
    const MeshSums sums = sumsOf(*data, 0);
    const double area = 20000.0 * utmArea(spec.points[0]);
    EXPECT_NEAR(sums.cellArea, area, area * 1e-5);
    EXPECT_NEAR(sums.triangleArea, area, area * 1e-5);
    EXPECT_EQ(sums.rim, 9u); // not the point in between, nor the fine ones' middle
}

TEST_F(MeshFlood, NoEdgeIsSharedByThreeTriangles) {
    UgridSpec spec = gridSpec(7, 7, 50.0, true);
    const auto data = open(spec);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& t : data->geometry().triangles)
        for (int i = 0; i < 3; ++i)
            ++edges[{t[std::size_t(i)], t[std::size_t((i + 1) % 3)]}];
    std::size_t open = 0;
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        open += !edges.contains({edge.second, edge.first});
    }
    EXPECT_EQ(open, 28u); // the outline, and no hole
}

TEST_F(MeshFlood, DryIsWhatIsNotAboveTheBed) {
    UgridSpec spec = gridSpec(10, 1, 50.0, false);
    spec.ground = [](glm::dvec2 p) { return 0.01 * (p.x - 290000.0); };
    spec.level = [&](glm::dvec2 p, int) { return std::max(2.5, spec.ground(p)); };
    const MeshSums sums = sumsOf(*open(spec), 0);
    EXPECT_NEAR(sums.wetArea, 5 * 2500.0 * utmArea(spec.points[0]), 1.0);
    EXPECT_NEAR(sums.maxDepth, 2.25, 1e-5);
    // Depths of 2.25, 1.75 … 0.25 m.
    EXPECT_NEAR(sums.volume, 6.25 * 2500.0 * utmArea(spec.points[0]), 1.0);
}

TEST_F(MeshFlood, DepthsAloneHaveNoBed) {
    UgridSpec spec = gridSpec(3, 3, 50.0, false);
    spec.stage = spec.bed = "";
    spec.depth = "mesh2d_waterdepth";
    const auto data = open(spec);
    EXPECT_EQ(data->kind(), WaterKind::Depth);
    EXPECT_TRUE(data->geometry().bed.empty());
    EXPECT_NEAR(sumsOf(*data, 1).maxDepth, 3.0, 1e-6);
}

TEST_F(MeshFlood, TheBedIsBetweenLevelAndDepthWhereItIsNotGiven) {
    UgridSpec spec = gridSpec(3, 3, 50.0, false);
    spec.ground = [](glm::dvec2) { return -1.5; };
    spec.bed = "";
    spec.depth = "mesh2d_waterdepth";
    const auto data = open(spec);
    EXPECT_EQ(data->kind(), WaterKind::Stage);
    ASSERT_FALSE(data->geometry().bed.empty());
    EXPECT_NEAR(data->geometry().bed[0], -1.5, 1e-5);
    FloodOptions depths;
    depths.kind = WaterKind::Depth;
    EXPECT_NEAR(sumsOf(*open(spec, depths), 0).maxDepth, 3.5, 1e-5);
}

TEST_F(MeshFlood, FeetBecomeMetres) {
    UgridSpec spec = gridSpec(3, 3, 50.0, false);
    spec.heightUnit = "ft";
    EXPECT_NEAR(sumsOf(*open(spec), 0).highest, 2.0 * 0.3048, 1e-6);
}

TEST_F(MeshFlood, VelocitiesTurnFromTheGridToEastAndNorth) {
    UgridSpec spec = gridSpec(3, 3, 50.0, false);
    spec.velocity = [](glm::dvec2, int) { return glm::dvec2(0.0, 2.0); };
    const auto data = open(spec);
    ASSERT_TRUE(data->hasVelocity());
    const auto velocities = data->velocities(0);
    ASSERT_TRUE(velocities);
    const glm::dvec2 place = data->geometry().lonLat[0];
    // Grid north lies by the convergence, longitude from 15° E times sine of latitude, east of
    // north; here, west of the meridian, it is negative.
    constexpr double kRadians = 3.14159265358979323846 / 180.0;
    const double convergence = (place.x - 15.0) * kRadians * std::sin(place.y * kRadians);
    EXPECT_LT(convergence, -0.03);
    for (const glm::vec2 v : *velocities) {
        EXPECT_NEAR(v.x, 2.0 * std::sin(convergence), 2e-4);
        EXPECT_NEAR(v.y, 2.0 * std::cos(convergence), 2e-4);
    }
}

TEST_F(MeshFlood, TimesAreReadAsTheFileCountsThem) {
    UgridSpec spec = gridSpec(2, 2, 50.0, false);
    auto data = open(spec);
    EXPECT_TRUE(data->stepsAreAbsolute());
    EXPECT_EQ(formatUtc({data->stepSeconds()[1]}), "2020-02-28T13:00:00Z");
    spec.timeUnit = "hours since 2020-2-28 6:0:0 +01:00";
    spec.times = {0.0, 24.0};
    EXPECT_EQ(formatUtc({open(spec)->stepSeconds()[1]}), "2020-02-29T05:00:00Z");
    spec.timeUnit = "hours";
    data = open(spec);
    EXPECT_FALSE(data->stepsAreAbsolute());
    EXPECT_EQ(data->stepSeconds()[1], 86400.0);
    FloodOptions options;
    options.start = *parseTime("2021-07-14T12:00Z");
    data = open(spec, options);
    EXPECT_TRUE(data->stepsAreAbsolute());
    EXPECT_EQ(formatUtc({data->stepSeconds()[1]}), "2021-07-15T12:00:00Z");
    spec.timeUnit = "";
    options.stepSeconds = 600.0;
    EXPECT_EQ(formatUtc({open(spec, options)->stepSeconds()[1]}), "2021-07-14T12:10:00Z");
}

TEST_F(MeshFlood, StepsOutOfOrderAreLeftOutAndTheRestIsShown) {
    UgridSpec spec = gridSpec(2, 2, 50.0, false);
    spec.steps = 5;
    spec.times = {0.0, 60.0, 30.0, std::nan(""), 120.0};
    const auto data = open(spec);
    ASSERT_EQ(data->stepSeconds().size(), 3u);
    EXPECT_EQ(data->leftOut.size(), 2u);
    const auto last = data->values(2);
    ASSERT_TRUE(last);
    EXPECT_FLOAT_EQ((*last)[0], 6.0f); // the fifth in the file
    EXPECT_FALSE(data->values(3));
}

TEST_F(MeshFlood, TheCrsIsFoundOrAskedFor) {
    UgridSpec spec = gridSpec(2, 2, 50.0, false);
    spec.crs = "0";
    auto failed = opened(spec);
    ASSERT_FALSE(failed);
    EXPECT_NE(failed.error().message().find("--crs"), std::string::npos);
    EXPECT_NE(failed.error().message().find("result0.nc"), std::string::npos);
    FloodOptions options;
    options.crs = "EPSG:25833";
    EXPECT_EQ(open(spec, options)->crs, "EPSG:25833");
    spec.crsAttribute = "epsg_code";
    spec.crs = "EPSG:3004";
    EXPECT_EQ(open(spec)->crs, "EPSG:3004");
    spec.crsAttribute = "crs_wkt";
    spec.crs = "PROJCS[\"here\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
               "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
               "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],PARAMETER["
               "\"central_meridian\",15],PARAMETER[\"scale_factor\",0.9996],PARAMETER[\"false_"
               "easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]";
    const auto there = open(spec)->geometry().lonLat[0];
    const auto utm = CrsToEcef::create("EPSG:32633", Heights::Ellipsoidal);
    const auto expected = utm->geodetic({290025.0, 5050025.0, 0.0});
    EXPECT_NEAR(there.x, expected->longitudeDegrees, 1e-9);
    EXPECT_NEAR(there.y, expected->latitudeDegrees, 1e-9);
}

TEST_F(MeshFlood, WhatIsMissingIsSaidWithWhatThereIs) {
    UgridSpec spec = gridSpec(2, 2, 50.0, false);
    spec.stage = "mesh2d_salinity";
    const auto unnamed = opened(spec);
    ASSERT_FALSE(unnamed);
    EXPECT_NE(unnamed.error().reason.find("mesh2d_salinity"), std::string::npos);
    FloodOptions options;
    options.variable = "nothing";
    const auto missing = opened(spec, options);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().reason.find("mesh2d_flowelem_bl"), std::string::npos);
    options.variable = "mesh2d_salinity";
    EXPECT_FALSE(opened(spec, options)); // a depth or a level?
    options.kind = WaterKind::Stage;
    EXPECT_TRUE(opened(spec, options));
}

TEST(MeshTopology, FacesWithSeveralCornersAreCoveredOnce) {
    // An L of six corners, which is not convex, and its neighbour.
    PolygonMesh mesh;
    mesh.points = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {2, 2}};
    const std::uint32_t bend[] = {0, 1, 2, 3, 4, 5}, square[] = {3, 2, 6, 4};
    mesh.addFace(bend, 6);
    mesh.addFace(square, 4);
    const NodeMesh nodes = nodesOf(mesh, ValuesAt::Points);
    double area = 0.0;
    for (const auto& t : nodes.triangles) {
        const glm::dvec2 a = nodes.positions[t[0]], b = nodes.positions[t[1]],
                         c = nodes.positions[t[2]];
        const double twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        EXPECT_GT(twice, 0.0);
        area += 0.5 * twice;
    }
    EXPECT_EQ(nodes.triangles.size(), 6u);
    EXPECT_DOUBLE_EQ(area, 4.0);
    const NodeMesh faces = nodesOf(mesh, ValuesAt::Faces);
    EXPECT_DOUBLE_EQ(faces.faceArea[0], 3.0);
    EXPECT_NEAR(faces.positions[0].x, 2.5 / 3.0, 1e-12);
}

TEST(MeshTimes, ReadsHecRasStampsAndRefusesWhatIsNone) {
    EXPECT_EQ(formatUtc({*hecTime("01Jan1999 12:00:00")}), "1999-01-01T12:00:00Z");
    EXPECT_EQ(formatUtc({*hecTime("29FEB2020 2400")}), "2020-03-01T00:00:00Z");
    EXPECT_EQ(formatUtc({*hecTime("31Dec2021 23:59:30:500")}), "2021-12-31T23:59:30Z");
    for (const char* text : {"", "1999-01-01", "32Jan1999 12:00:00", "01Foo1999 12:00", "01Jan1999",
                             "29Feb2021 00:00:00", "01Jan1999 25:00:00"})
        EXPECT_FALSE(hecTime(text)) << text;
}

TEST(MeshTimes, CalendarsThatNoClockKeepsStayRelative) {
    EXPECT_TRUE(cfTimes({0.0}, "days since 2000-01-01", "standard").absolute);
    for (const auto& [unit, calendar] :
         {std::pair{"days since 2000-01-01", "360_day"},
          std::pair{"days since 0000-00-00", "standard"}, std::pair{"days since 2000-13-01", ""},
          std::pair{"fortnights since 2000-01-01", ""}}) {
        const StepTimes times = cfTimes({0.0, 1.0}, unit, calendar);
        EXPECT_FALSE(times.absolute) << unit;
        EXPECT_FALSE(times.note.empty()) << unit;
    }
}

} // namespace gnomon
