// Rasters as people have them: units, holes, oddities, several at once.
#include "streaming/terrain/raster.h"
#include "tests/streaming/terrain_support.h"

#include <thread>

using namespace gnomon;
using namespace gnomon::test;

namespace {

const Heights2d kSmall(5, 4, [](int x, int y) { return 10.0 * y + x; });

Raster openOrFail(const std::string& path, const RasterOptions& options = {}) {
    auto raster = Raster::open(path, options);
    EXPECT_TRUE(raster) << (raster ? "" : raster.error().message());
    return std::move(*raster);
}

} // namespace

TEST(Raster, ReadsWindowsRowByRow) {
    const Raster raster = openOrFail(writeRaster("windows", kSmall));
    EXPECT_EQ(*raster.read(1, 2, 3, 2), (std::vector<float>{21, 22, 23, 31, 32, 33}));
    EXPECT_EQ(raster.crsName(), "EPSG:25832");
    EXPECT_EQ(raster.at(0.5, 0.5), glm::dvec2(356000.5, 5699999.5));
    EXPECT_EQ(raster.pixelOf({356002.5, 5699998.5}), glm::dvec2(2.5, 1.5));
    EXPECT_TRUE(raster.rowsRunSouth());
}

TEST(Raster, TakesEveryNthPixelItself) {
    const Raster raster = openOrFail(writeRaster("steps", kSmall));
    std::vector<float> out(4);
    ASSERT_FALSE(raster.sampleInto(0, 1, 2, 2, 2, out));
    EXPECT_EQ(out, (std::vector<float>{10, 12, 30, 32}));
}

TEST(Raster, GivesMetresWhateverTheBandIsIn) {
    const std::array<std::pair<const char*, float>, 6> units{{{"m", 1.0f},
                                                              {"metre", 1.0f},
                                                              {"ft", 0.3048f},
                                                              {"us survey foot", 0.3048006f},
                                                              {"cm", 0.01f},
                                                              {"mm", 0.001f}}};
    for (const auto& [unit, metres] : units) {
        RasterLook look;
        look.unit = unit;
        const Raster raster = openOrFail(writeRaster("unit", kSmall, look));
        EXPECT_FLOAT_EQ((*raster.read(4, 3, 1, 1))[0], 34.0f * metres) << unit;
    }
    RasterLook look;
    look.unit = "degC";
    const auto wrong = Raster::open(writeRaster("unit", kSmall, look));
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message().find("'degC', not in a unit of length"), std::string::npos);
    RasterOptions any;
    any.anyUnit = true;
    EXPECT_TRUE(Raster::open("/vsimem/unit.tif", any));
}

TEST(Raster, AppliesScaleAndOffset) {
    RasterLook look;
    look.scale = 0.1;
    look.offset = 100.0;
    look.type = GDT_Int16;
    const Raster raster = openOrFail(writeRaster("scaled", kSmall, look));
    EXPECT_FLOAT_EQ((*raster.read(4, 3, 1, 1))[0], 103.4f);
}

TEST(Raster, KnowsNoDataFromItsValueFromNaNAndFromNumbersThatAreNoHeights) {
    Heights2d heights = kSmall;
    heights.values[0] = kNoHeight; // written as the file's -9999
    heights.values[1] = -3.4028235e38f;
    heights.values[2] = std::numeric_limits<float>::infinity();
    for (const GDALDataType type : {GDT_Float32, GDT_Float64}) {
        RasterLook look;
        look.type = type;
        const Raster raster = openOrFail(writeRaster("none", heights, look));
        const std::vector<float> row = *raster.read(0, 0, 5, 1);
        for (int i = 0; i < 3; ++i)
            EXPECT_TRUE(std::isnan(row[std::size_t(i)])) << i;
        EXPECT_EQ(row[3], 3.0f);
    }
}

TEST(Raster, TellsWhichWayItsRowsRun) {
    RasterLook look;
    look.transform = {356000, 1, 0, 5699000, 0, 1};
    EXPECT_FALSE(openOrFail(writeRaster("southup", kSmall, look)).rowsRunSouth());
    look.transform = {356000, 0.6, 0.8, 5699000, 0.8, -0.6};
    const Raster turned = openOrFail(writeRaster("turned", kSmall, look));
    EXPECT_TRUE(turned.rowsRunSouth());
    const glm::dvec2 there = turned.pixelOf(turned.at(3.25, 1.75));
    EXPECT_NEAR(there.x, 3.25, 1e-9);
    EXPECT_NEAR(there.y, 1.75, 1e-9);
}

TEST(Raster, KnowsWhomToCreditAndItsOverviews) {
    RasterLook look;
    look.copyright = "Land NRW\n2020";
    look.overviews = true;
    const Raster raster = openOrFail(writeRaster("credit", roughHills(300, 200), look));
    EXPECT_EQ(raster.credits(), std::vector<std::string>{"Land NRW 2020"});
    EXPECT_EQ(raster.overviewFactors(), (std::vector<int>{2, 4, 8, 16}));
    EXPECT_EQ(raster.overviewSize(4), glm::ivec2(75, 50));
}

TEST(Raster, RefusesInOneLineWhatHoldsNoHeights) {
    const auto why = [](const std::string& path) {
        const auto raster = Raster::open(path);
        EXPECT_FALSE(raster) << path;
        const std::string line = raster ? "" : raster.error().message();
        EXPECT_EQ(line.find('\n'), std::string::npos);
        return line;
    };
    EXPECT_NE(why("/vsimem/nothing.tif").find("cannot be read as a raster"), std::string::npos);
    RasterLook look;
    look.bands = 3;
    EXPECT_NE(why(writeRaster("picture", kSmall, look)).find("has 3 bands"), std::string::npos);
    look.bands = 1;
    look.type = GDT_CFloat32;
    EXPECT_NE(why(writeRaster("complex", kSmall, look)).find("complex"), std::string::npos);
    look.type = GDT_Float32;
    look.transform = {0, 0, 0, 0, 0, 1};
    EXPECT_NE(why(writeRaster("flat", kSmall, look)).find("no width"), std::string::npos);
}

TEST(Raster, IsReadByManyThreadsAtOnce) {
    const Heights2d h = roughHills(600, 500);
    RasterLook look;
    look.tiled = true;
    const Raster raster = openOrFail(writeRaster("threads", h, look));
    std::vector<std::thread> threads;
    std::array<int, 4> wrong{};
    for (std::size_t t = 0; t < wrong.size(); ++t)
        threads.emplace_back([&, t] {
            std::mt19937 random{unsigned(t)};
            for (int i = 0; i < 200; ++i) {
                const int x = int(random() % 500), y = int(random() % 400);
                const auto values = raster.read(x, y, 50, 50);
                wrong[t] += !values || (*values)[51] != h.at(x + 1, y + 1);
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

TEST(Raster, OfSeveralVariablesTakesTheOneNamedOrTheOneThatIsGround) {
    const std::string path = (dataFolder() / "flood-sfincs-piave/sfincs_map.nc").string();
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "flood-sfincs-piave is not here";
    const Raster ground = openOrFail(path);
    ASSERT_EQ(ground.notes().size(), 1u);
    EXPECT_NE(ground.notes()[0].find("'zb' was taken for the ground"), std::string::npos);
    // Its pixels are placed one by one; they form a grid of 50 m.
    EXPECT_NEAR(glm::length(ground.at(1, 0) - ground.at(0, 0)), 50.0, 0.05);
    RasterOptions named;
    named.variable = "hmax";
    EXPECT_EQ(openOrFail(path, named).width(), 373);
    named.variable = "nosuch";
    const auto wrong = Raster::open(path, named);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message().find("no variable 'nosuch'; it has x, y"), std::string::npos);
}

TEST(Raster, UnderstandsAnOldEsriProjectionOfTheSouthernHemisphere) {
    const std::string path = (dataFolder() / "flood-merewether/topography1.asc").string();
    if (!std::filesystem::exists(path))
        GTEST_SKIP() << "flood-merewether is not here";
    const Raster raster = openOrFail(path);
    ASSERT_TRUE(raster.crs());
    EXPECT_EQ(raster.crsName(), "EPSG:32756");
}
