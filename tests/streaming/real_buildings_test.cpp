// Buildings of real cities (GNOMON_DATA), held against what others make of the same files.
#include "buildings_support.h"

#include "streaming/terrain/gdal_quiet.h"

#include <ogrsf_frmts.h>

#include <ctime>

namespace gnomon::test {
namespace {

// Of the processor, over all threads: the machine may be busy with other things.
double processorSeconds() {
    return double(std::clock()) / CLOCKS_PER_SEC;
}

std::unique_ptr<OGRCoordinateTransformation> transformation(OGRSpatialReference from, int to) {
    OGRSpatialReference target;
    target.importFromEPSG(to);
    from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    target.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return std::unique_ptr<OGRCoordinateTransformation>(
        OGRCreateCoordinateTransformation(&from, &target));
}

TEST(Jakarta, LinesUpWithOgrToACentimetre) {
    const std::string path = dataFolder() + "/flood-jakarta/jakarta_OSM_building.shp";
    NEEDS_DATA(path);
    const auto file = readFeatures(path, {});
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->features.size(), 22266u);
    const GDALDatasetUniquePtr data(GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR));
    ASSERT_TRUE(data);
    OGRLayer& layer = *data->GetLayer(0);
    OGRSpatialReference webMercator;
    webMercator.importFromEPSG(3857);
    const auto t = transformation(webMercator, 4326);
    std::size_t i = 0, vertices = 0;
    double worst = 0.0;
    for (const OGRFeatureUniquePtr& feature : layer) {
        const OGRLinearRing& ring = *feature->GetGeometryRef()->toPolygon()->getExteriorRing();
        const FeatureRing& ours = file->features[i++].parts[0][0];
        for (std::size_t k = 0; k < ours.size(); ++k, ++vertices) {
            double x = ring.getX(int(k)), y = ring.getY(int(k));
            ASSERT_TRUE(t->Transform(1, &x, &y));
            // And with the definition of web Mercator.
            constexpr double kDegrees = 180.0 / 3.14159265358979323846, kRadius = 6378137.0;
            const double latitude = kDegrees * std::atan(std::sinh(ring.getY(int(k)) / kRadius));
            ASSERT_NEAR(ours[k].y, latitude, 1e-8);
            ASSERT_NEAR(ours[k].x, kDegrees * ring.getX(int(k)) / kRadius, 1e-8);
            worst = std::max(worst, length(ecefOf({x, y, 0}) - ecefOf({ours[k].x, ours[k].y, 0})));
        }
    }
    EXPECT_GT(vertices, 150000u);
    EXPECT_LT(worst, 0.01);
    RecordProperty("worst_metres", std::to_string(worst));
}

TEST(Jakarta, OpensInTwoSecondsAsSolids) {
    const std::string path = dataFolder() + "/flood-jakarta/jakarta_OSM_building.shp";
    NEEDS_DATA(path);
    const double start = processorSeconds();
    const auto opened = Buildings::open(path, {}, flatGround(20.0));
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_LT(processorSeconds() - start, 2.0);
    const std::size_t size = (*opened)->size();
    EXPECT_GE(size, 22266u - 50u) << "all but those there twice";
    EXPECT_LT(size, 22266u);
    EXPECT_TRUE((*opened)->file().leftOut.empty());
    EXPECT_TRUE(says((*opened)->file().notes, "1794: its outline crosses itself; mended"));
    EXPECT_TRUE(says((*opened)->file().notes, "have no height: 6.0 m assumed"));
    const Measured m = measured(**opened);
    EXPECT_EQ(m.closed, m.triangles);
    EXPECT_EQ(m.features.size(), size);
    EXPECT_NEAR(m.highest, 26.0, 0.01);
    EXPECT_NEAR(m.lowest, 19.0, 0.01);
}

TEST(Delft, HasItsBuildingsWhereItsFileSays) {
    const std::string path = dataFolder() + "/city-delft/delft.city.json";
    NEEDS_DATA(path);
    const auto opened = Buildings::open(path, {}, nullptr);
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_EQ((*opened)->size(), 160u);
    EXPECT_EQ((*opened)->file().crs, "EPSG:7415");
    const Measured m = measured(**opened);
    EXPECT_EQ(m.closed, m.triangles) << "all its solids, their undersides added";
    EXPECT_EQ(m.features.size(), 160u);
    bool found = false;
    for (std::uint32_t i = 0; i < 160; ++i) {
        const BuildingFound b = (*opened)->building(i);
        found |= b.id == "b1105d28c-00ba-11e6-b420-2bdcc4ab5d7f";
        EXPECT_LT(b.groundMetres, b.topMetres);
    }
    EXPECT_TRUE(found);
}

TEST(Delft, FillsTheExtentThatItsFileStates) {
    // One building, so that its extent is the file's: in RD New and NAP.
    const std::string path = dataFolder() + "/city-delft/delft_1b.city.json";
    NEEDS_DATA(path);
    const auto file = readFeatures(path, {});
    ASSERT_TRUE(file) << file.error().message();
    OGRSpatialReference wgs84;
    wgs84.importFromEPSG(4326);
    const auto toRd = transformation(wgs84, 28992);
    glm::dvec3 low(1e9), high(-1e9);
    for (const FeaturePart& part : file->features.at(0).parts)
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring) {
                double x = p.x, y = p.y;
                ASSERT_TRUE(toRd->Transform(1, &x, &y));
                // Without the Dutch geoid's grid EGM96 stands in for it.
                const glm::dvec3 rd(x, y, p.z - *egm96GeoidHeight(p.x, p.y));
                low = glm::min(low, rd);
                high = glm::max(high, rd);
            }
    const bool standIn = says(file->notes, "taken as above EGM96");
    if (standIn) {
        EXPECT_TRUE(says(file->notes, "nl_nsgi_nlgeo2018.tif"));
    }
    const double slack = standIn ? 0.002 : 1.0; // of heights
    const glm::dvec3 statedLow(84983.297, 447463.655, -0.1), statedHigh(85056.513, 447507.046, 6.0);
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(low[axis], statedLow[axis], axis == 2 ? slack : 0.01);
        EXPECT_NEAR(high[axis], statedHigh[axis], axis == 2 ? slack : 0.01);
    }
}

TEST(Rotterdam, HasItsRoofsAndWalls) {
    const std::string path = dataFolder() + "/city-delft/rotterdam/rotterdam_subset.json";
    NEEDS_DATA(path);
    EXPECT_FALSE(Buildings::open(path, {}, nullptr)) << "it names no system";
    BuildingOptions options;
    options.source.crs = "EPSG:7415";
    const auto opened = Buildings::open(path, options, nullptr);
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_EQ((*opened)->size(), 16u);
    const Measured m = measured(**opened);
    EXPECT_EQ(m.features.size(), 16u);
    EXPECT_GT(m.triangles, 600u);
    // 18.3 m high over a geoid at 43.6 m.
    EXPECT_NEAR(m.highest - m.lowest, 18.293, 0.05);
    // A place in the middle of a roof.
    const auto content = (*opened)->tiles();
    std::size_t hits = 0;
    for (std::uint32_t i = 0; i < 16; ++i)
        hits += (*opened)->building(i).topMetres > 50.0;
    EXPECT_GT(hits, 10u);
}

TEST(Merewether, IsAFolderOfHouses) {
    const std::string path = dataFolder() + "/flood-merewether/houses";
    NEEDS_DATA(path);
    EXPECT_FALSE(Buildings::open(path, {}, nullptr)) << "it names no system";
    BuildingOptions options;
    options.source.crs = "EPSG:32756";
    const auto opened = Buildings::open(path, options, flatGround(60.0));
    ASSERT_TRUE(opened) << opened.error().message();
    EXPECT_EQ((*opened)->size(), 59u);
    EXPECT_TRUE(says((*opened)->file().notes, "house032_033: smaller outlines cover it wholly"));
    const Measured m = measured(**opened);
    EXPECT_EQ(m.closed, m.triangles);
    // In house 33, by its vertices' middle.
    const auto crs = CrsToEcef::create("EPSG:32756", Heights::Ellipsoidal);
    const auto place = crs->geodetic({382502.0, 6354518.0, 0.0});
    const auto house = (*opened)->at({place->longitudeDegrees, place->latitudeDegrees});
    ASSERT_TRUE(house);
    EXPECT_EQ(house->id, "house033");
}

TEST(CityGml, IsNamedWithWhatToDo) {
    const std::string path = dataFolder() + "/city-delft/delft-citygml2.xml";
    NEEDS_DATA(path);
    const auto opened = Buildings::open(path, {}, nullptr);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().message().find("citygml-tools"), std::string::npos);
}

} // namespace
} // namespace gnomon::test
