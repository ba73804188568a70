#include "tests/bench/loaded_triangles.h"
#include "tests/viewer/files.h"

#include "streaming/terrain/raster.h"
#include "viewer/input.h"

#include <gtest/gtest.h>

using namespace gnomon;

namespace {

const char* const kBottrop = "dem-nrw-1m-utm32/dom1_32_356_5699_1_nw_2020.tif";

// Columns of 10 m from 356000 E, rows of 10 m down from 5700000 N.
std::string grid(int columns, int rows, const std::string& values) {
    return "ncols " + std::to_string(columns) + "\nnrows " + std::to_string(rows) +
           "\nxllcorner 356000\nyllcorner " + std::to_string(5700000 - 10LL * rows) +
           "\ncellsize 10\nNODATA_value -9999\n" + values;
}

Result<Scene> openRaster(const std::string& path, const std::string& crs = "EPSG:25832") {
    SceneOptions options;
    options.inputs = {path};
    if (!crs.empty())
        options.crs = crs;
    return openScene(options);
}

void expectOneLine(const Error& error) {
    EXPECT_FALSE(error.reason.empty());
    EXPECT_EQ(error.message().find('\n'), std::string::npos);
    EXPECT_LT(error.message().size(), 600u);
}

} // namespace

TEST(TerrainScene, HeightsAboveTheSeaAreRaisedByTheGeoid) {
    const test::Folder folder;
    const std::string path = folder.write("a.asc", grid(2, 2, "5 5\n5 5\n"));
    SceneOptions options;
    options.inputs = {path};
    options.crs = "EPSG:25832";
    options.heights = Heights::Egm96;
    const Result<Scene> sea = openScene(options);
    const Result<Scene> ellipsoid = openRaster(path);
    ASSERT_TRUE(sea && ellipsoid);
    // EGM96 there: 45.74 m (echo "51.43 6.93 0" | cs2cs EPSG:4326+5773 EPSG:4979).
    EXPECT_NEAR(sea->anchor.heightMetres - ellipsoid->anchor.heightMetres, 45.74, 0.02);
    EXPECT_NEAR(ellipsoid->anchor.heightMetres, 5.0, 1e-3);
}

TEST(TerrainScene, WhereThereIsNoDataThereIsAHole) {
    const test::Folder folder;
    // One corner without data takes a triangle with it, the middle all six around it.
    Result<Scene> corner =
        openRaster(folder.write("corner.asc", grid(3, 3, "-9999 1 1\n1 1 1\n1 1 1\n")));
    ASSERT_TRUE(bool(corner)) << corner.error().message();
    EXPECT_EQ(test::loadAll(*corner).triangles.size(), 7u);
    Result<Scene> middle =
        openRaster(folder.write("middle.asc", grid(3, 3, "1 1 1\n1 -9999 1\n1 1 1\n")));
    ASSERT_TRUE(bool(middle)) << middle.error().message();
    const test::Loaded loaded = test::loadAll(*middle);
    EXPECT_EQ(loaded.triangles.size(), 2u);
    EXPECT_EQ(test::firstHit(loaded.triangles, {0, 0, 50}, {0, 0, -1}), 1e300);
    for (const test::Triangle& t : loaded.triangles)
        for (const glm::dvec3& p : t)
            EXPECT_NEAR(p.z, 0.0, 1e-3); // no -9999 anywhere
    const Result<Scene> none = openRaster(folder.write("none.asc", grid(2, 2,
                                                                        "-9999 -9999\n"
                                                                        "-9999 -9999\n")));
    ASSERT_FALSE(bool(none));
    EXPECT_NE(none.error().message().find("no data"), std::string::npos);
}

TEST(TerrainScene, RowsMayRunNorthwardsAndStillFaceUp) {
    const test::Folder folder;
    // GDAL writes no such ASCII grid; a world file turns one round.
    folder.write("a.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
    const Result<Raster> raster = Raster::open(folder / "a.asc");
    ASSERT_TRUE(bool(raster));
    EXPECT_EQ(raster->at(0, 0), glm::dvec2(0, 2)); // the upper left corner
    EXPECT_EQ(raster->at(2, 2), glm::dvec2(2, 0));
    const auto values = raster->read(1, 0, 1, 2);
    ASSERT_TRUE(bool(values));
    EXPECT_EQ(*values, (std::vector<float>{2, 4}));
}

TEST(TerrainScene, ARasterThatDoesNotSayWhereItIsAsksForIt) {
    const test::Folder folder;
    const std::string path = folder.write("a.asc", grid(2, 2, "1 2\n3 4\n"));
    const Result<Scene> scene = openRaster(path, "");
    ASSERT_FALSE(bool(scene));
    EXPECT_NE(scene.error().message().find("--crs"), std::string::npos);
    expectOneLine(scene.error());
    // Coordinates that the system has no place for.
    const Result<Scene> wrong = openRaster(path, "EPSG:4326");
    ASSERT_FALSE(bool(wrong));
    expectOneLine(wrong.error());
}

TEST(TerrainScene, HostileFilesGiveOneLine) {
    using namespace std::string_literals;
    const test::Folder folder;
    const std::pair<const char*, std::string> files[] = {
        {"head.tif", "II*\0\x08\0\0\0"s},
        {"noise.tif", "II*\0\xff\xff\xff\x7f"s + std::string(300, '\x5a')},
        {"big.tif", "II+\0\x08\0\0\0\xff\xff\xff\xff\xff\xff\xff\x7f"s},
        {"huge.asc", grid(2000000000, 2000000000, "1")},
        {"negative.asc", grid(-3, 4, "1 2 3")},
        {"words.asc", "ncols a\nnrows b\n"},
        {"nowhere.asc", "ncols 2\nnrows 2\nxllcorner nan\nyllcorner inf\ncellsize 1\n1 2\n3 4\n"},
        {"flat.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2\n3 4\n"},
        {"line.asc", grid(5, 1, "1 2 3 4 5\n")},
        {"netcdf.nc", "CDF\1\0\0\0\0"s},
        {"hdf.nc", "\x89HDF\r\n\x1a\n"s + std::string(64, '\0')},
    };
    for (const auto& [name, bytes] : files) {
        const Result<Scene> scene = openRaster(folder.write(name, bytes));
        ASSERT_FALSE(bool(scene)) << name;
        expectOneLine(scene.error());
        EXPECT_NE(scene.error().message().find(name), std::string::npos);
    }
    // What leads on to other files is not followed.
    const std::string path = folder.write("a.asc", grid(2, 2, "1 2\n3 4\n"));
    const std::string vrt = folder.write(
        "a.vrt", "<VRTDataset rasterXSize=\"2\" "
                 "rasterYSize=\"2\"><SRS>EPSG:25832</SRS><GeoTransform>356000, 10, 0, 5700000, 0, "
                 "-10</GeoTransform><VRTRasterBand "
                 "dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename>" +
                     path + "</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>");
    EXPECT_FALSE(bool(Raster::open(vrt)));
    EXPECT_FALSE(bool(openRaster(vrt)));
}

TEST(TerrainScene, ACutFileIsAnErrorNotAHole) {
    GNOMON_NEEDS_DATA(kBottrop);
    const test::Folder folder;
    const std::string whole = test::contentsOf(test::data(kBottrop));
    std::string cut = whole;
    const std::size_t from = cut.size() / 2; // the strips behind this are gone
    cut.resize(from);
    const Result<Scene> scene = openRaster(folder.write("cut.tif", cut));
    if (!scene)
        expectOneLine(scene.error());
    EXPECT_FALSE(bool(scene));
}

TEST(TerrainScene, NothingIsWrittenBesideTheInput) {
    const test::Folder folder;
    const Result<Scene> scene = openRaster(folder.write("a.asc", grid(2, 2, "1 2\n3 4\n")));
    EXPECT_TRUE(bool(scene));
    EXPECT_EQ(folder.files(), 1u);
}
