// Results on grids: rasters, NetCDF, and when their steps are.
#include "streaming/flood/flood.h"
#include "streaming/flood/flood_grid.h"
#include "streaming/flood/flood_times.h"
#include "streaming/flood/raster_flood.h"
#include "streaming/flood/water_surface.h"
#include "tests/streaming/flood_support.h"

#include <algorithm>
#include <cmath>

using namespace gnomon;
using namespace gnomon::test;

namespace {

bool anyHas(const std::vector<std::string>& lines, const std::string& part) {
    return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
        return line.find(part) != std::string::npos;
    });
}

double at(const std::string& text) {
    const Result<UtcTime> time = parseTime(text);
    EXPECT_TRUE(time) << text;
    return time->seconds;
}

std::vector<double> stepsOf(const std::vector<std::string>& names,
                            const FloodOptions& options = {}) {
    GridFlood saying;
    return stepsByName(names, options, saying).seconds;
}

} // namespace

TEST(FloodTimes, ComeFromDatesInNames) {
    GridFlood saying;
    const FloodSteps steps = stepsByName(
        {"depth_20210714T1200", "depth_20210714T1300", "depth_2021-07-14_15-30"}, {}, saying);
    EXPECT_TRUE(steps.absolute);
    EXPECT_EQ(steps.seconds, (std::vector{at("2021-07-14T12:00Z"), at("2021-07-14T13:00Z"),
                                          at("2021-07-14T15:30Z")}));
    EXPECT_TRUE(anyHas(saying.notes, "from its names"));
}

TEST(FloodTimes, AddDurationsToDatesThatAllNamesShare) {
    GridFlood saying;
    const FloodSteps steps = stepsByName(
        {"201208140700_Jakarta_200m_Sobek_6_hours", "201208140700_Jakarta_200m_Sobek_12_hours"}, {},
        saying);
    EXPECT_TRUE(steps.absolute);
    EXPECT_EQ(steps.seconds, (std::vector{at("2012-08-14T13:00Z"), at("2012-08-14T19:00Z")}));
}

TEST(FloodTimes, ComeFromDurationsButNotFromMetres) {
    EXPECT_EQ(stepsOf({"sobek_200m_6_hours", "sobek_200m_12_hours"}),
              (std::vector{21600.0, 43200.0}));
    EXPECT_EQ(stepsOf({"t000h", "t001h", "t010h"}), (std::vector{0.0, 3600.0, 36000.0}));
    EXPECT_EQ(stepsOf({"d_15min", "d_90min"}), (std::vector{900.0, 5400.0}));
}

TEST(FloodTimes, ComeFromNumbersTimesTheStepThatIsGiven) {
    FloodOptions options;
    options.stepSeconds = 600.0;
    options.start = UtcTime{1000.0};
    EXPECT_EQ(stepsOf({"h_07", "h_08", "h_10"}, options), (std::vector{1000.0, 1600.0, 2800.0}));
    EXPECT_EQ(stepsOf({"before", "after"}, options), (std::vector{1000.0, 1600.0}));
}

TEST(FloodTimes, OfNamesThatTellNothingAreAnHourApartAndSaidSo) {
    GridFlood saying;
    const FloodSteps steps = stepsByName({"low", "high"}, {}, saying);
    EXPECT_FALSE(steps.absolute);
    EXPECT_EQ(steps.seconds, (std::vector{0.0, 3600.0}));
    EXPECT_TRUE(anyHas(saying.notes, "an hour"));
}

TEST(FloodTimes, OutOfOrderArePutInOrderAndSaidSo) {
    GridFlood saying;
    const FloodSteps steps = stepsByName({"a_12h", "a_6h"}, {}, saying);
    EXPECT_EQ(steps.seconds, (std::vector{21600.0, 43200.0}));
    EXPECT_EQ(steps.source, (std::vector<std::size_t>{1, 0}));
    EXPECT_TRUE(anyHas(saying.notes, "in order"));
}

TEST(FloodTimes, ThatAreTheSameLeaveTheSecondOut) {
    GridFlood saying;
    const FloodSteps steps = stepsByName({"a_6h", "b_6h", "a_12h"}, {}, saying);
    EXPECT_EQ(steps.seconds.size(), 2u);
    ASSERT_EQ(saying.leftOut.size(), 1u);
    EXPECT_NE(saying.leftOut[0].message().find("b_6h"), std::string::npos);
}

TEST(FloodTimes, WithStepsMissingAreSaidSo) {
    GridFlood saying;
    stepsByName({"h_1", "h_2", "h_3", "h_6", "h_7"}, {}, saying);
    EXPECT_TRUE(anyHas(saying.notes, "between h_3 and h_6 lie 3 h, not 1 h"));
}

TEST(FloodTimes, ThatAreNoNumbersAreLeftOut) {
    GridFlood saying;
    const FloodSteps steps =
        stepsByTime({0.0, std::nan(""), 10.0, INFINITY}, false, {"a", "b", "c", "d"}, {}, saying);
    EXPECT_EQ(steps.seconds, (std::vector{0.0, 10.0}));
    EXPECT_EQ(saying.leftOut.size(), 2u);
}

TEST(GridThinning, TakesAllPixelsOrEveryNthFromTheMiddleOfItsBlock) {
    EXPECT_EQ(GridThinning::of(1000, 1000).step, 1);
    const GridThinning thin = GridThinning::of(6000, 4000);
    EXPECT_EQ(thin.step, 3);
    EXPECT_EQ(thin.first, 1);
    EXPECT_EQ(thin.columns, 2000);
    EXPECT_LE(thin.nodes(), GridThinning::kMostNodes);
    EXPECT_LT(thin.first + (thin.columns - 1) * thin.step, 6000);
}

TEST(GridThinning, KnowsWhatIsTooLongAndNarrow) {
    EXPECT_TRUE(GridThinning::of(100, 2).fits(100, 2));
    EXPECT_TRUE(GridThinning::of(1'000'000, 2).fits(1'000'000, 2));
    EXPECT_FALSE(GridThinning::of(100'000'000, 2).fits(100'000'000, 2));
}

TEST(RasterFlood, OpensOneFileAsOneStep) {
    const TemporaryFolder folder;
    TiffSpec spec;
    spec.value = [](int column, int, int) { return column == 0 ? -9999.0 : 0.5 * column; };
    writeTiff(folder / "depth.tif", spec);
    const auto flood = openFlood({folder / "depth.tif"}, {});
    ASSERT_TRUE(flood) << flood.error().message();
    const FloodData& data = **flood;
    EXPECT_EQ(data.kind(), WaterKind::Depth);
    EXPECT_EQ(data.crs, "EPSG:32633");
    EXPECT_EQ(data.geometry().columns, 8);
    EXPECT_EQ(data.geometry().rows, 6);
    EXPECT_EQ(data.stepSeconds().size(), 1u);
    EXPECT_TRUE(anyHas(data.notes, "depth"));
    const auto values = data.values(0);
    ASSERT_TRUE(values);
    EXPECT_TRUE(std::isnan((*values)[0]));
    EXPECT_EQ((*values)[3], 1.5f);
    EXPECT_NEAR(data.geometry().cellArea[9], 100.0, 0.1);
    EXPECT_FALSE(data.values(1));
}

TEST(RasterFlood, PlacesNodesAtTheMiddlesOfPixels) {
    const TemporaryFolder folder;
    TiffSpec spec;
    spec.columns = 200;
    spec.rows = 150;
    writeTiff(folder / "depth.tif", spec);
    const auto flood = openFlood({folder / "depth.tif"}, {});
    ASSERT_TRUE(flood);
    const auto crs = CrsToEcef::create("EPSG:32633", Heights::Ellipsoidal);
    for (const auto& [column, row] : {std::pair(0, 0), {77, 93}, {199, 149}, {13, 140}}) {
        const auto there =
            crs->geodetic({290000.0 + 10.0 * (column + 0.5), 5050000.0 - 10.0 * (row + 0.5), 0.0});
        const glm::dvec2 got =
            (*flood)->geometry().lonLat[std::size_t(row) * 200 + std::size_t(column)];
        // A thousandth of a cell: a centimetre.
        EXPECT_NEAR(got.x, there->longitudeDegrees, 1.3e-7);
        EXPECT_NEAR(got.y, there->latitudeDegrees, 1e-7);
    }
}

TEST(RasterFlood, MakesStepsOfFilesAndLeavesOutThoseThatDoNotFit) {
    const TemporaryFolder folder;
    TiffSpec spec;
    std::vector<std::string> paths;
    for (const int hour : {6, 7, 8, 9, 10}) {
        TiffSpec step = spec;
        step.value = [hour](int, int, int) { return 0.1 * hour; };
        if (hour == 7)
            step.columns = 9;
        if (hour == 8)
            step.transform[0] += 1000.0;
        if (hour == 9)
            step.epsg = 32632;
        paths.push_back(folder / ("depth_" + std::to_string(hour) + "h.tif"));
        writeTiff(paths.back(), step);
    }
    paths.push_back(folder / "depth_11h.tif"); // does not exist
    const auto flood = openFlood(paths, {});
    ASSERT_TRUE(flood) << flood.error().message();
    EXPECT_EQ((*flood)->stepSeconds(), (std::vector{21600.0, 36000.0}));
    ASSERT_EQ((*flood)->leftOut.size(), 4u);
    EXPECT_NE((*flood)->leftOut[0].reason.find("9 x 6"), std::string::npos);
    EXPECT_NEAR((*(*flood)->values(1))[5], 1.0f, 1e-6f);
}

TEST(RasterFlood, TakesBandsAsSteps) {
    const TemporaryFolder folder;
    TiffSpec spec;
    spec.bands = 4;
    spec.value = [](int, int, int band) { return 0.25 * band; };
    writeTiff(folder / "rising.tif", spec);
    FloodOptions options;
    options.kind = WaterKind::Depth;
    options.start = UtcTime{at("2021-07-14T12:00Z")};
    options.stepSeconds = 900.0;
    const auto flood = openFlood({folder / "rising.tif"}, options);
    ASSERT_TRUE(flood) << flood.error().message();
    ASSERT_EQ((*flood)->stepSeconds().size(), 4u);
    EXPECT_TRUE((*flood)->stepsAreAbsolute());
    EXPECT_EQ((*flood)->stepSeconds()[3], at("2021-07-14T12:45Z"));
    EXPECT_EQ((*(*flood)->values(3))[0], 1.0f);
}

TEST(RasterFlood, TellsLevelsFromDepthsByTheirValues) {
    EXPECT_EQ(guessWaterKind({0.0f, 1.0f, 5.0f, kNaN}), WaterKind::Depth);
    EXPECT_EQ(guessWaterKind({48.0f, 180.0f}), WaterKind::Stage);
    EXPECT_EQ(guessWaterKind({-3.0f, -2.0f}), WaterKind::Stage);
    EXPECT_EQ(guessWaterKind({-9999.0f, 99999.0f, 1.0f}), WaterKind::Depth); // no data
}

TEST(RasterFlood, WithoutACoordinateSystemIsOneClearLine) {
    const TemporaryFolder folder;
    TiffSpec spec;
    spec.epsg = 0;
    writeTiff(folder / "depth.tif", spec);
    const auto flood = openFlood({folder / "depth.tif"}, {});
    ASSERT_FALSE(flood);
    EXPECT_NE(flood.error().reason.find("--crs"), std::string::npos);
    FloodOptions options;
    options.crs = "EPSG:32633";
    EXPECT_TRUE(openFlood({folder / "depth.tif"}, options));
    options.crs = "EPSG:99999999";
    EXPECT_FALSE(openFlood({folder / "depth.tif"}, options));
}

TEST(RasterFlood, RaisesLevelsToTheEllipsoid) {
    const TemporaryFolder folder;
    TiffSpec spec;
    spec.value = [](int, int, int) { return 3.0; };
    writeTiff(folder / "stage.tif", spec);
    FloodOptions options;
    options.heights = Heights::Egm96;
    options.raiseMetres = 0.5;
    const auto flood = openFlood({folder / "stage.tif"}, options);
    ASSERT_TRUE(flood);
    EXPECT_EQ((*flood)->kind(), WaterKind::Stage);
    const glm::dvec2 place = (*flood)->geometry().lonLat[20];
    const auto geoid = egm96GeoidHeight(place.x, place.y);
    ASSERT_TRUE(geoid);
    EXPECT_NEAR((*(*flood)->values(0))[20], 3.5 + *geoid, 1e-3);
}

TEST(NetCdfFlood, ReadsLevelsBedTimesAndSystem) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.ground = [](int column, int row) { return 0.1 * column + row; };
    spec.level = [](int column, int row, int step) {
        return column == 2 && row == 1 ? std::nan("") : 5.0 + step;
    };
    writeGrid(folder / "map.nc", spec);
    const auto flood = openFlood({folder / "map.nc"}, {});
    ASSERT_TRUE(flood) << flood.error().message();
    const FloodData& data = **flood;
    EXPECT_EQ(data.kind(), WaterKind::Stage);
    EXPECT_EQ(data.crs, "EPSG:32633");
    EXPECT_TRUE(data.stepsAreAbsolute());
    EXPECT_EQ(data.stepSeconds(), (std::vector{at("2021-07-14T12:00Z"), at("2021-07-14T13:00Z"),
                                               at("2021-07-14T14:00Z")}));
    EXPECT_FLOAT_EQ(data.geometry().bed[8 * 2 + 3], 2.3f);
    const auto values = data.values(2);
    ASSERT_TRUE(values);
    EXPECT_EQ((*values)[8 * 2 + 3], 7.0f);
    EXPECT_TRUE(std::isnan((*values)[8 * 1 + 2]));
    EXPECT_TRUE(anyHas(data.notes, "'zs'"));
    EXPECT_TRUE(anyHas(data.notes, "'zb'"));
}

TEST(NetCdfFlood, TurnsVelocitiesFromTheGridsAxesToEastAndNorth) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.velocity = true;
    writeGrid(folder / "map.nc", spec);
    auto flood = openFlood({folder / "map.nc"}, {});
    ASSERT_TRUE(flood);
    const glm::vec2 along = (*(*flood)->velocities(2))[9];
    // Grid north is off by the longitude from the zone's middle times the sine of the latitude.
    const glm::dvec2 place = (*flood)->geometry().lonLat[9];
    const double turn =
        (place.x - 15.0) * std::sin(place.y * 3.14159265 / 180.0) * 3.14159265 / 180.0;
    EXPECT_NEAR(std::atan2(along.y, along.x), std::atan2(2.0, 1.0) - turn, 1e-3);
    EXPECT_NEAR(glm::length(along), std::sqrt(5.0f), 1e-5f);

    spec.eastNorth = true;
    writeGrid(folder / "true.nc", spec);
    flood = openFlood({folder / "true.nc"}, {});
    ASSERT_TRUE(flood);
    EXPECT_EQ((*(*flood)->velocities(2))[9], glm::vec2(1.0f, 2.0f));
}

TEST(NetCdfFlood, KnowsTheUnitsOfTime) {
    const TemporaryFolder folder;
    GridSpec spec;
    for (const auto& [unit, second] : {std::pair("seconds since 2020-01-01", 1.0),
                                       {"minutes since 2020-01-01 00:00", 60.0},
                                       {"hours since 2020-01-01T00:00:00Z", 3600.0},
                                       {"days since 2020-01-01 01:00 +1", 86400.0}}) {
        spec.timeUnit = unit;
        writeGrid(folder / "map.nc", spec);
        const auto flood = openFlood({folder / "map.nc"}, {});
        ASSERT_TRUE(flood) << unit;
        EXPECT_TRUE((*flood)->stepsAreAbsolute());
        EXPECT_EQ((*flood)->stepSeconds()[0], at("2020-01-01T00:00Z")) << unit;
        EXPECT_EQ((*flood)->stepSeconds()[1] - (*flood)->stepSeconds()[0], second) << unit;
    }
    spec.timeUnit = "s";
    writeGrid(folder / "map.nc", spec);
    const auto flood = openFlood({folder / "map.nc"}, {});
    ASSERT_TRUE(flood);
    EXPECT_FALSE((*flood)->stepsAreAbsolute());
}

TEST(NetCdfFlood, OfSystemZeroNeedsOneAndSaysSoInOneLine) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.epsg = 0;
    writeGrid(folder / "map.nc", spec);
    const auto flood = openFlood({folder / "map.nc"}, {});
    ASSERT_FALSE(flood);
    EXPECT_NE(flood.error().reason.find("EPSG:0"), std::string::npos);
    EXPECT_NE(flood.error().reason.find("--crs"), std::string::npos);
    EXPECT_EQ(flood.error().message().find('\n'), std::string::npos);
    FloodOptions options;
    options.crs = "EPSG:32633";
    EXPECT_TRUE(openFlood({folder / "map.nc"}, options));
}

TEST(NetCdfFlood, TakesTheVariableThatIsNamed) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.depth = "h";
    writeGrid(folder / "map.nc", spec);
    FloodOptions options;
    options.variable = "h";
    const auto depth = openFlood({folder / "map.nc"}, options);
    ASSERT_TRUE(depth);
    EXPECT_EQ((*depth)->kind(), WaterKind::Depth);
    options.variable = "nothing";
    const auto none = openFlood({folder / "map.nc"}, options);
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().reason.find("zs"), std::string::npos);
    options.variable = {};
    options.kind = WaterKind::Depth;
    const auto asked = openFlood({folder / "map.nc"}, options);
    ASSERT_TRUE(asked);
    EXPECT_EQ((*asked)->kind(), WaterKind::Depth);
}

TEST(NetCdfFlood, DoesNotTakeAVariableThatWasNeverWritten) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.depth = "h";
    spec.level = [](int, int, int) { return std::nan(""); };
    writeGrid(folder / "map.nc", spec);
    const auto flood = openFlood({folder / "map.nc"}, {});
    ASSERT_FALSE(flood);
    EXPECT_NE(flood.error().reason.find("no water"), std::string::npos);
}

TEST(NetCdfFlood, PlacesCurvedGridsNodeByNode) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.eachPlace = true;
    spec.bend = 30.0;
    writeGrid(folder / "map.nc", spec);
    const auto flood = openFlood({folder / "map.nc"}, {});
    ASSERT_TRUE(flood) << flood.error().message();
    const auto crs = CrsToEcef::create("EPSG:32633", Heights::Ellipsoidal);
    const auto there =
        crs->geodetic({290040.0, 5050020.0 + 30.0 * std::sin(3.14159265 * 4 / 7), 0.0});
    EXPECT_NEAR((*flood)->geometry().lonLat[8 * 2 + 4].y, there->latitudeDegrees, 1e-10);
}

TEST(NetCdfFlood, JoinsFilesByTheirTimes) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.steps = 2;
    writeGrid(folder / "b.nc", spec);
    spec.times = {-2.0, -1.0};
    writeGrid(folder / "a.nc", spec);
    spec.columns = 5;
    writeGrid(folder / "c.nc", spec);
    const auto flood = openFlood({folder / "b.nc", folder / "a.nc", folder / "c.nc"}, {});
    ASSERT_TRUE(flood) << flood.error().message();
    EXPECT_EQ((*flood)->stepSeconds().size(), 4u);
    EXPECT_EQ((*flood)->stepSeconds().front(), at("2021-07-14T10:00Z"));
    EXPECT_EQ((*flood)->leftOut.size(), 1u);
    EXPECT_TRUE(anyHas((*flood)->notes, "in order"));
}

TEST(NetCdfFlood, ThatIsCutOrTornFailsInALine) {
    const TemporaryFolder folder;
    writeGrid(folder / "map.nc", {});
    std::string bytes;
    {
        std::ifstream file(folder / "map.nc", std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(file), {});
    }
    for (std::size_t keep : {bytes.size() / 8, bytes.size() / 2, bytes.size() - 64}) {
        std::ofstream(folder / "cut.nc", std::ios::binary)
            .write(bytes.data(), std::streamsize(keep));
        const auto flood = openFlood({folder / "cut.nc"}, {});
        if (!flood)
            EXPECT_EQ(flood.error().message().find('\n'), std::string::npos);
        else
            for (std::size_t i = 0; i < (*flood)->stepSeconds().size(); ++i)
                (void)(*flood)->values(i);
    }
    std::ofstream(folder / "text.tif") << "no raster";
    EXPECT_FALSE(openFlood({folder / "text.tif"}, {}));
    EXPECT_FALSE(openFlood({folder / "missing.tif"}, {}));
    EXPECT_FALSE(openFlood({}, {}));
}

TEST(NetCdfFlood, WithAnyByteChangedNeverCrashes) {
    const TemporaryFolder folder;
    GridSpec spec;
    spec.depth = "h";
    spec.velocity = true;
    writeGrid(folder / "map.nc", spec);
    std::string bytes;
    {
        std::ifstream file(folder / "map.nc", std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(file), {});
    }
    std::uint32_t state = 7;
    const auto random = [&](std::size_t below) {
        state = state * 1664525u + 1013904223u;
        return std::size_t(state >> 8) % below;
    };
    FloodOptions options;
    options.crs = "EPSG:32633";
    for (int round = 0; round < 150; ++round) {
        std::string torn = bytes;
        for (int k = 0; k < 3; ++k) // mostly in the header
            torn[random(round % 3 == 0 ? torn.size() : 1600)] = char(random(256));
        std::ofstream(folder / "torn.nc", std::ios::binary) << torn;
        const auto flood = openFlood({folder / "torn.nc"}, options);
        if (!flood) {
            EXPECT_EQ(flood.error().message().find('\n'), std::string::npos);
            continue;
        }
        const auto surface = WaterSurface::create(*flood, nullptr, {});
        if (!surface)
            continue;
        for (const double seconds : (*flood)->stepSeconds())
            (void)(*surface)->meshes(seconds, glm::dmat3(1.0));
    }
}

TEST(RealFlood, OfPiaveHasTheWetCellsOfItsFile) {
    const auto path = dataFolder() / "flood-sfincs-piave" / "sfincs_map.nc";
    GNOMON_NEEDS(path);
    EXPECT_FALSE(openFlood({path.string()}, {}));
    FloodOptions options;
    options.crs = "EPSG:32633";
    const auto flood = openFlood({path.string()}, options);
    ASSERT_TRUE(flood) << flood.error().message();
    const FloodData& data = **flood;
    ASSERT_EQ(data.stepSeconds().size(), 25u);
    EXPECT_EQ(data.stepSeconds().front(), at("2021-01-01T00:00Z"));
    EXPECT_EQ(data.stepSeconds().back(), at("2021-01-02T00:00Z"));
    const auto wetCells = [&](std::size_t step) {
        const auto values = data.values(step);
        int wet = 0;
        for (std::size_t i = 0; i < values->size(); ++i)
            wet += (*values)[i] - data.geometry().bed[i] > 0.05f;
        return wet;
    };
    // As the file itself says, counted by another program.
    EXPECT_EQ(wetCells(0), 5416);
    EXPECT_EQ(wetCells(24), 10511);
}

TEST(RealFlood, OfJakartaIsTwoStepsSixHoursApart) {
    const auto folder = dataFolder() / "flood-jakarta";
    GNOMON_NEEDS(folder / "sobek_200m_6_hours.tif");
    const auto flood = openFlood({(folder / "sobek_200m_6_hours.tif").string(),
                                  (folder / "sobek_200m_12_hours.tif").string()},
                                 {});
    ASSERT_TRUE(flood) << flood.error().message();
    EXPECT_EQ((*flood)->stepSeconds(), (std::vector{21600.0, 43200.0}));
    EXPECT_EQ((*flood)->kind(), WaterKind::Depth);
    EXPECT_EQ((*flood)->crs, "EPSG:23834");
}
