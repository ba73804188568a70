// Results of ANUGA, HEC-RAS and TELEMAC as their users published them. The figures were taken from
// the files with GDAL and NumPy, in the coordinates of the files; skipped where the data is not.
#include "mesh_flood_support.h"

namespace gnomon {

namespace {

std::shared_ptr<const FloodData> open(const std::string& name, const FloodOptions& options) {
    const std::string path = meshData(name);
    EXPECT_TRUE(isUnstructuredFlood(path));
    const auto opened = openUnstructuredFlood(path, options);
    if (!opened) {
        ADD_FAILURE() << opened.error().message();
        return nullptr;
    }
    return *opened;
}

#define SKIP_WITHOUT(name)                                                                         \
    if (!std::filesystem::exists(meshData(name)))                                                  \
    GTEST_SKIP() << "no " << meshData(name)

const char* const kSww = "Small_catchment_testcase.sww";
const char* const kHecRas = "baldeagle_multi2d.hdf";
const char* const kSelafin = "telemac_example_res_fr.slf";

FloodOptions inCrs(const std::string& crs) {
    FloodOptions options;
    options.crs = crs;
    return options;
}

// UTM near its central meridian draws lengths by 0.9996: areas on the Earth are larger.
constexpr double kUtmArea = 1.0 / (0.9996 * 0.9996);

} // namespace

TEST(RealMeshFlood, AnugaWithoutAZoneAsksForItsCrs) {
    SKIP_WITHOUT(kSww);
    const auto opened = openUnstructuredFlood(meshData(kSww), {});
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().message().find(kSww), std::string::npos);
    EXPECT_NE(opened.error().message().find("--crs"), std::string::npos);
}

TEST(RealMeshFlood, AnugaHasTheMeansOfItsTriangles) {
    SKIP_WITHOUT(kSww);
    const auto data = open(kSww, inCrs("EPSG:32651"));
    ASSERT_TRUE(data);
    EXPECT_EQ(data->kind(), WaterKind::Stage);
    EXPECT_EQ(data->path, meshData(kSww));
    ASSERT_EQ(data->stepSeconds().size(), 7u);
    EXPECT_EQ(data->stepSeconds().back(), 21600.0);
    EXPECT_FALSE(data->stepsAreAbsolute());

    const MeshSums first = sumsOf(*data, 0), last = sumsOf(*data, 6);
    const FloodGeometry& geometry = data->geometry();
    EXPECT_EQ(geometry.lonLat.size() - first.rim, 6388u);
    EXPECT_NEAR(first.cellArea, 20524551.5 * kUtmArea, 20.0 * 60);
    EXPECT_NEAR(first.triangleArea / first.cellArea, 1.0, 2e-5);
    EXPECT_NEAR(first.volume, 4097491.2 * kUtmArea, 4.1e6 * 1e-4);
    EXPECT_NEAR(last.volume, 9189364.8 * kUtmArea, 9.2e6 * 1e-4);
    EXPECT_NEAR(last.wetArea, 14603908.0 * kUtmArea, 14.6e6 * 1e-4);
    EXPECT_NEAR(last.maxDepth, 9.24057, 1e-4);
    EXPECT_NEAR(last.lowest, -0.057955, 1e-4);
    EXPECT_NEAR(last.highest, 61.436214, 1e-4);
    const auto [low, high] = std::minmax_element(geometry.bed.begin(), geometry.bed.end());
    EXPECT_NEAR(*low, -2.0f, 1e-5f);
    EXPECT_NEAR(*high, 61.43f, 1e-5f);
}

TEST(RealMeshFlood, AnugaWeldsCornersAtOnePlaceAndKeepsTheVolume) {
    SKIP_WITHOUT(kSww);
    FloodOptions options = inCrs("EPSG:32651");
    options.variable = "stage";
    const auto data = open(kSww, options);
    ASSERT_TRUE(data);
    EXPECT_EQ(data->geometry().lonLat.size(), 3308u);
    EXPECT_EQ(data->geometry().triangles.size(), 6388u);
    // Its ground changes with time.
    EXPECT_EQ(data->kind(), WaterKind::Depth);
    EXPECT_NEAR(sumsOf(*data, 0).volume, 4097491.2 * kUtmArea, 4.1e6 * 1e-4);
    EXPECT_NEAR(sumsOf(*data, 6).volume, 9189986.3 * kUtmArea, 9.2e6 * 1e-4);
}

TEST(RealMeshFlood, HecRasMergesItsAreasInMetres) {
    SKIP_WITHOUT(kHecRas);
    const auto data = open(kHecRas, {});
    ASSERT_TRUE(data);
    ASSERT_EQ(data->stepSeconds().size(), 7u);
    EXPECT_TRUE(data->stepsAreAbsolute());
    EXPECT_EQ(formatUtc({data->stepSeconds()[0]}), "1999-01-01T12:00:00Z");
    EXPECT_EQ(formatUtc({data->stepSeconds()[6]}), "1999-01-04T12:00:00Z");

    constexpr double kFoot = 0.3048, kFoot3 = kFoot * kFoot * kFoot, kAcreFoot = 43560.0 * kFoot3;
    const MeshSums first = sumsOf(*data, 0), last = sumsOf(*data, 6);
    // 461 + 264 cells, of which 67 + 41 are the rim's dummies.
    EXPECT_EQ(data->geometry().lonLat.size() - first.rim, 617u);
    EXPECT_NEAR(first.cellArea, (15119333.0 + 9679455.0) * kFoot * kFoot, 2.3e6 * 1e-3);
    EXPECT_NEAR(first.volume, 6333.277 * kAcreFoot, 7.8e6 * 1e-3);
    EXPECT_NEAR(last.volume, (4925.269 + 10798.051) * kAcreFoot, 19.4e6 * 1e-3);
    // "Maximum Value of Data Set" of the water surface: the crest between these steps' levels.
    EXPECT_NEAR(sumsOf(*data, 4).maxDepth, 74.21315 * kFoot, 1e-3);
    EXPECT_NEAR(first.highest, 630.0 * kFoot, 1e-3);
    // What HEC-RAS itself counted as ending volume, 12794 acre-feet, is in the note.
    ASSERT_FALSE(data->notes.empty());
    EXPECT_NE(data->notes[0].find("1.578e+07"), std::string::npos) << data->notes[0];
    // Lock Haven, Pennsylvania.
    const glm::dvec2 place = data->geometry().lonLat[0];
    EXPECT_NEAR(place.x, -77.5, 0.3);
    EXPECT_NEAR(place.y, 41.1, 0.2);
}

TEST(RealMeshFlood, HecRasVelocitiesFitTheirFaces) {
    SKIP_WITHOUT(kHecRas);
    const auto data = open(kHecRas, {});
    ASSERT_TRUE(data);
    ASSERT_TRUE(data->hasVelocity());
    const auto at0 = data->velocities(0), at4 = data->velocities(4);
    ASSERT_TRUE(at0 && at4);
    float fastest = 0.0f;
    for (std::size_t i = 0; i < at4->size(); ++i) {
        EXPECT_LT(glm::length((*at0)[i]), 1e-6f); // nothing moves at the start
        fastest = std::max(fastest, glm::length((*at4)[i]));
    }
    // "Maximum Face Velocity": a cell's is of the size of its faces'.
    EXPECT_GT(fastest, 3.0f);
    EXPECT_LT(fastest, 8.0f);
}

TEST(RealMeshFlood, TelemacReadsItsFrenchNames) {
    SKIP_WITHOUT(kSelafin);
    const auto data = open(kSelafin, inCrs("EPSG:27563"));
    ASSERT_TRUE(data);
    EXPECT_EQ(data->kind(), WaterKind::Stage);
    EXPECT_EQ(data->geometry().lonLat.size(), 13541u);
    EXPECT_EQ(data->geometry().triangles.size(), 26000u);
    ASSERT_EQ(data->stepSeconds(), (std::vector<double>{0.0, 4000.0}));
    EXPECT_FALSE(data->stepsAreAbsolute()); // its date is TELEMAC's 1900
    const MeshSums first = sumsOf(*data, 0), last = sumsOf(*data, 1);
    EXPECT_NEAR(first.cellArea, 51854366.0, 51.9e6 * 2e-3); // Lambert's scale off its parallel
    EXPECT_NEAR(first.cellArea / first.triangleArea, 1.0, 2e-5);
    EXPECT_NEAR(first.volume / first.cellArea, 96754878.3 / 51854366.0, 1e-4);
    EXPECT_NEAR(last.volume / last.cellArea, 96827973.4 / 51854366.0, 1e-4);
    EXPECT_NEAR(first.maxDepth, 55.0, 1e-4);
    EXPECT_NEAR(last.maxDepth, 21.557735, 1e-4);
    EXPECT_NEAR(last.highest, 100.002281, 1e-4);
    const auto velocities = data->velocities(1);
    ASSERT_TRUE(velocities);
    float fastest = 0.0f;
    for (const glm::vec2 v : *velocities)
        fastest = std::max(fastest, glm::length(v));
    EXPECT_NEAR(fastest, 7.567356f, 1e-4f);
}

TEST(RealMeshFlood, HeightsAboveTheGeoidAndRaisedMoveBedAndLevelAlike) {
    SKIP_WITHOUT(kSww);
    const auto plain = open(kSww, inCrs("EPSG:32651"));
    FloodOptions options = inCrs("EPSG:32651");
    options.heights = Heights::Egm96;
    options.raiseMetres = 3.0;
    const auto lifted = open(kSww, options);
    ASSERT_TRUE(plain && lifted);
    const auto before = plain->values(6), after = lifted->values(6);
    ASSERT_TRUE(before && after);
    for (std::size_t i = 0; i < before->size(); i += 97) {
        const glm::dvec2 place = plain->geometry().lonLat[i];
        const auto geoid = egm96GeoidHeight(place.x, place.y);
        ASSERT_TRUE(geoid);
        EXPECT_NEAR(lifted->geometry().bed[i] - plain->geometry().bed[i], *geoid + 3.0, 1e-4);
        if (std::isfinite((*before)[i])) {
            EXPECT_NEAR((*after)[i] - (*before)[i], *geoid + 3.0, 1e-4);
        }
    }
    EXPECT_NEAR(sumsOf(*lifted, 6).volume, sumsOf(*plain, 6).volume, 100.0);
}

TEST(RealMeshFlood, TheWrongCrsIsSaidInOneLine) {
    SKIP_WITHOUT(kSelafin);
    for (const char* crs : {"EPSG:4326", "EPSG:999999", "nonsense"}) {
        const auto opened = openUnstructuredFlood(meshData(kSelafin), inCrs(crs));
        ASSERT_FALSE(opened) << crs;
        EXPECT_EQ(opened.error().message().find('\n'), std::string::npos);
    }
}

} // namespace gnomon
