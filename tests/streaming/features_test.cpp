#include "buildings_support.h"

#include "streaming/terrain/gdal_quiet.h"

#include <ogrsf_frmts.h>

namespace gnomon::test {
namespace {

// Two squares in UTM zone 32 with attributes, the second with a hole, as one layer of any kind.
void writeSquares(GDALDataset& data, const char* layerName, double z) {
    OGRSpatialReference utm;
    ASSERT_EQ(utm.importFromEPSG(25832), OGRERR_NONE);
    utm.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const bool flat = std::isnan(z);
    OGRLayer* layer = data.CreateLayer(layerName, &utm, flat ? wkbPolygon : wkbPolygon25D, nullptr);
    ASSERT_NE(layer, nullptr);
    OGRFieldDefn name("name", OFTString), height("height", OFTReal), levels("levels", OFTInteger);
    layer->CreateField(&name);
    layer->CreateField(&height);
    layer->CreateField(&levels);
    for (int i = 0; i < 2; ++i) {
        const OGRFeatureUniquePtr feature(OGRFeature::CreateFeature(layer->GetLayerDefn()));
        feature->SetField("name", i ? "Rathaus" : "Höhle");
        feature->SetField("height", 10.5 + i);
        if (i == 0)
            feature->SetField("levels", 3);
        const auto ring = [&](double x, double y, double size) {
            auto* out = new OGRLinearRing;
            for (const auto& [dx, dy] : {std::pair(0, 0), {0, 1}, {1, 1}, {1, 0}, {0, 0}}) {
                if (flat)
                    out->addPoint(x + dx * size, y + dy * size);
                else
                    out->addPoint(x + dx * size, y + dy * size, z);
            }
            return out;
        };
        OGRPolygon polygon;
        polygon.addRingDirectly(ring(400000.0 + 100.0 * i, 5600000.0, 20.0));
        if (i == 1)
            polygon.addRingDirectly(ring(400105.0, 5600005.0, 5.0));
        feature->SetGeometry(&polygon);
        ASSERT_EQ(layer->CreateFeature(feature.get()), OGRERR_NONE);
    }
}

std::string written(const Folder& folder, const char* driverName, const std::string& name,
                    double z = NAN) {
    registerGdalDrivers();
    const std::string path = folder.file(name);
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(driverName);
    EXPECT_NE(driver, nullptr);
    const GDALDatasetUniquePtr data(driver->Create(path.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    EXPECT_TRUE(data);
    if (data)
        writeSquares(*data, "squares", z);
    return path;
}

// Places of the squares' corners by PROJ through OGR.
glm::dvec2 lonLatOf(double east, double north, int epsg = 25832) {
    OGRSpatialReference from, to;
    from.importFromEPSG(epsg);
    to.importFromEPSG(4326);
    from.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> t(
        OGRCreateCoordinateTransformation(&from, &to));
    EXPECT_TRUE(t->Transform(1, &east, &north));
    return {east, north};
}

double metresApart(glm::dvec2 a, glm::dvec2 b) {
    return length(ecefOf({a.x, a.y, 0.0}) - ecefOf({b.x, b.y, 0.0}));
}

void expectSquares(const std::string& path, const std::string& format, const std::string& firstId) {
    const auto file = readFeatures(path, {});
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->format, format);
    EXPECT_EQ(file->crs, "EPSG:25832");
    EXPECT_TRUE(file->leftOut.empty());
    ASSERT_EQ(file->features.size(), 2u);
    const Feature &first = file->features[0], &second = file->features[1];
    EXPECT_EQ(first.id, firstId);
    EXPECT_EQ(first.shape, FeatureShape::Polygon);
    EXPECT_EQ(first.number("HEIGHT"), 10.5);
    EXPECT_EQ(first.number("levels"), 3.0);
    EXPECT_EQ(second.attribute("levels"), nullptr) << "a null is no value";
    ASSERT_NE(first.attribute("name"), nullptr);
    EXPECT_EQ(std::get<std::string>(*first.attribute("name")), "Höhle");
    ASSERT_EQ(first.parts.size(), 1u);
    ASSERT_EQ(second.parts.at(0).size(), 2u) << "the hole";
    ASSERT_EQ(first.parts[0][0].size(), 4u) << "the first vertex is not repeated";
    for (const glm::dvec3& p : first.parts[0][0])
        EXPECT_TRUE(std::isnan(p.z));
    double nearest = 1e9;
    for (const glm::dvec3& p : first.parts[0][0])
        nearest = std::min(nearest, metresApart(glm::dvec2(p), lonLatOf(400020.0, 5600020.0)));
    EXPECT_LT(nearest, 1e-3);
}

TEST(Features, AreReadFromGeoPackages) {
    const Folder folder;
    expectSquares(written(folder, "GPKG", "a.gpkg"), "GeoPackage", "1");
}

TEST(Features, AreReadFromShapefiles) {
    const Folder folder;
    const std::string path = written(folder, "ESRI Shapefile", "a.shp");
    expectSquares(path, "Shapefile", "0");
    // Without its index; nothing is written beside it.
    std::filesystem::remove(folder.file("a.shx"));
    expectSquares(path, "Shapefile", "0");
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.shx")));
    // Without attributes either.
    std::filesystem::remove(folder.file("a.dbf"));
    const auto bare = readFeatures(path, {});
    ASSERT_TRUE(bare) << bare.error().message();
    EXPECT_EQ(bare->features.size(), 2u);
    EXPECT_TRUE(bare->features[0].attributes.empty());
    EXPECT_TRUE(says(bare->notes, ".shx is missing"));
    // Without a system.
    std::filesystem::remove(folder.file("a.prj"));
    const auto nowhere = readFeatures(path, {});
    ASSERT_FALSE(nowhere);
    EXPECT_NE(nowhere.error().message().find("--crs EPSG:n"), std::string::npos);
    FeatureOptions options;
    options.crs = "EPSG:25832";
    EXPECT_TRUE(readFeatures(path, options));
    const auto part = readFeatures(folder.write("b.dbf", "xyz"), {});
    ASSERT_FALSE(part);
    EXPECT_NE(part.error().message().find("name its .shp"), std::string::npos);
}

TEST(Features, AreReadFromFlatGeobuf) {
    registerGdalDrivers();
    if (GetGDALDriverManager()->GetDriverByName("FlatGeobuf") == nullptr)
        GTEST_SKIP() << "GDAL has no FlatGeobuf";
    const Folder folder;
    const std::string path = written(folder, "FlatGeobuf", "a.fgb");
    const auto file = readFeatures(path, {});
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->features.size(), 2u); // in an order of its own
}

TEST(Features, AreReadFromAllLayersOfAGeoPackage) {
    const Folder folder;
    const std::string path = written(folder, "GPKG", "a.gpkg");
    {
        const GDALDatasetUniquePtr data(
            GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR | GDAL_OF_UPDATE));
        ASSERT_TRUE(data);
        writeSquares(*data, "more", 7.0);
        data->CreateLayer("no shapes", nullptr, wkbNone, nullptr);
    }
    const auto file = readFeatures(path, {});
    ASSERT_TRUE(file);
    EXPECT_EQ(file->features.size(), 4u);
    EXPECT_TRUE(std::isnan(file->features[0].parts[0][0][0].z));
    EXPECT_NEAR(file->features[3].parts[0][0][0].z, 7.0, 1e-9);
}

TEST(Features, HaveHeightsAsStated) {
    const Folder folder;
    const std::string path = written(folder, "GPKG", "a.gpkg", 7.0);
    FeatureOptions options;
    options.heights = Heights::Egm96;
    options.raiseMetres = 2.0;
    const auto file = readFeatures(path, options);
    ASSERT_TRUE(file);
    const glm::dvec3 p = file->features[0].parts[0][0][0];
    EXPECT_NEAR(p.z, 9.0 + *egm96GeoidHeight(p.x, p.y), 1e-6);
    // Exporters that must write a height write 0.
    const auto zero = readFeatures(written(folder, "GPKG", "b.gpkg", 0.0), {});
    ASSERT_TRUE(zero);
    EXPECT_TRUE(std::isnan(zero->features[0].parts[0][0][0].z));
    EXPECT_TRUE(says(zero->notes, "taken to be flat"));
}

TEST(Features, AreReadFromGeoJson) {
    const Folder folder;
    const auto file =
        readFeatures(folder.write("a.geojson", R"({"type":"FeatureCollection","features":[
        {"type":"Feature","id":"way/1","properties":{"height":"12 m","flat":true},"geometry":
         {"type":"MultiPolygon","coordinates":[[[[7,51],[7.001,51],[7.001,51.001],[7,51]]],
                                              [[[8,51],[8.001,51],[8.001,51.001],[8,51]]]]}},
        {"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[7,51,3]}},
        {"type":"Feature","properties":{},"geometry":
         {"type":"LineString","coordinates":[[7,51],[7.1,51]]}},
        {"type":"Feature","properties":{},"geometry":null},
        {"type":"Feature","properties":{},"geometry":{"type":"GeometryCollection","geometries":[
         {"type":"Point","coordinates":[7,51]},
         {"type":"LineString","coordinates":[[7,51],[7.1,51]]}]}}]})"),
                     {});
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->format, "GeoJSON");
    ASSERT_EQ(file->features.size(), 5u) << "a collection of two kinds is two features";
    EXPECT_EQ(file->features[0].id, "way/1");
    EXPECT_EQ(file->features[0].parts.size(), 2u);
    EXPECT_EQ(file->features[0].number("height"), std::nullopt) << "a unit is no number";
    EXPECT_EQ(std::get<bool>(*file->features[0].attribute("flat")), true);
    EXPECT_EQ(file->features[1].shape, FeatureShape::Point);
    EXPECT_DOUBLE_EQ(file->features[1].parts[0][0][0].z, 3.0);
    EXPECT_EQ(file->features[2].shape, FeatureShape::Line);
    EXPECT_EQ(file->features[2].parts[0][0].size(), 2u);
    EXPECT_TRUE(says(file->notes, "1 of its features have no shape"));
}

TEST(Features, ThatStandUprightAreSurfaces) {
    const Folder folder;
    const auto file = readFeatures(folder.write("a.geojson", R"({"type":"Feature","properties":{},
        "geometry":{"type":"MultiPolygon","coordinates":[
        [[[7,51,0],[7.001,51,0],[7.001,51,9],[7,51,9],[7,51,0]]],
        [[[7,51,9],[7.001,51,9],[7.001,51.001,9],[7,51,9]]]]}})"),
                                   {});
    ASSERT_TRUE(file);
    EXPECT_EQ(file->features[0].shape, FeatureShape::Surface);
}

TEST(Features, InNoSystemOrAWrongOneAreOneLine) {
    const Folder folder;
    const std::string utm = folder.write("utm.geojson", R"({"type":"Feature","properties":{},
        "geometry":{"type":"Polygon","coordinates":
        [[[400000,5600000],[400020,5600000],[400020,5600020],[400000,5600000]]]}})");
    const auto wrong = readFeatures(utm, {});
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message().find("none of its 1 features lies where EPSG:4326"),
              std::string::npos)
        << wrong.error().message();
    // Degrees are GeoJSON's own idea, so what is given counts when they cannot be.
    FeatureOptions options;
    options.crs = "EPSG:25832";
    const auto given = readFeatures(utm, options);
    ASSERT_TRUE(given);
    EXPECT_LT(
        metresApart(glm::dvec2(given->features[0].parts[0][0][0]), lonLatOf(400000.0, 5600000.0)),
        1e-3);
    EXPECT_TRUE(says(given->notes, "no degrees"));
    // What a file names itself stays.
    const auto named = readFeatures(
        folder.write("named.geojson", R"({"type":"FeatureCollection","crs":{"type":"name",
        "properties":{"name":"urn:ogc:def:crs:EPSG::32633"}},"features":[{"type":"Feature",
        "properties":{},"geometry":{"type":"Point","coordinates":[400000,5600000]}}]})"),
        options);
    ASSERT_TRUE(named);
    EXPECT_EQ(named->crs, "EPSG:32633");
    EXPECT_LT(metresApart(glm::dvec2(named->features[0].parts[0][0][0]),
                          lonLatOf(400000.0, 5600000.0, 32633)),
              1e-3);
    options.crs = "EPSG:banana";
    const auto unknown = readFeatures(utm, options);
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().subject, "--crs");
    EXPECT_EQ(unknown.error().kind, ErrorKind::Usage);
}

TEST(Features, OutOfTheWorldAreLeftOutByName) {
    const Folder folder;
    std::string features;
    for (int i = 0; i < 40; ++i)
        features += R"({"type":"Feature","id":"far)" + std::to_string(i) +
                    R"(","properties":{},"geometry":{"type":"Point","coordinates":[7,123]}},)";
    for (int i = 0; i < 50; ++i)
        features += R"({"type":"Feature","properties":{},
                       "geometry":{"type":"Point","coordinates":[7,51]}},)";
    features.pop_back();
    const auto file = readFeatures(
        folder.write("a.geojson", R"({"type":"FeatureCollection","features":[)" + features + "]}"),
        {});
    ASSERT_TRUE(file);
    EXPECT_EQ(file->features.size(), 50u);
    EXPECT_TRUE(says(file->leftOut, "far0: has coordinates that EPSG:4326 has no place for"));
    EXPECT_EQ(file->leftOut.size(), 21u);
    EXPECT_TRUE(says(file->leftOut, "and 20 more"));
}

TEST(Features, AreReadFromFoldersOfPolygonsInText) {
    const Folder folder;
    folder.write("b.csv", "400000,5600000\n400020,5600000\n400020,5600020\n400000,5600000\n");
    folder.write("a.csv", "\xef\xbb\xbfx;y\r\n400000,5;5600000,0\r\n400020;5600000\r\n400020;"
                          "5600020\r\n\r\n");
    folder.write("c.csv", "400000 5600000 12.5\n400020  5600000 12.5\n400020 5600020 12.5\n");
    folder.write("d.csv", "400000,5600000\n400020,5600000\n");
    folder.write("e.csv", "400000,5600000\nhere,there\n");
    FeatureOptions options;
    options.crs = "EPSG:25832";
    const auto file = readFeatures(folder.path(), options);
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->format, "CSV");
    ASSERT_EQ(file->features.size(), 3u);
    EXPECT_EQ(file->features[0].id, "a");
    EXPECT_EQ(file->features[1].parts[0][0].size(), 3u);
    EXPECT_LT(
        metresApart(glm::dvec2(file->features[0].parts[0][0][0]), lonLatOf(400000.5, 5600000.0)),
        1e-3);
    EXPECT_NEAR(file->features[2].parts[0][0][0].z, 12.5, 1e-9);
    EXPECT_TRUE(says(file->leftOut, "d.csv: is no polygon: it has 2 vertices"));
    EXPECT_TRUE(says(file->leftOut, "e.csv: line 2 ('here,there') is no x and y"));
    folder.write("f.geojson", "{}");
    const auto mixed = readFeatures(folder.path(), options);
    ASSERT_FALSE(mixed);
    EXPECT_NE(mixed.error().message().find("several kinds"), std::string::npos);
}

TEST(Features, ArePointsWhereATextHasMoreColumnsThanCoordinates) {
    const Folder folder;
    const auto file = readFeatures(
        folder.write("trees.csv",
                     "ID,lat,lon,height,species\n7,51.5,7.25,12.5,\"Quercus, robur\"\n"),
        {});
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->features.size(), 1u);
    const Feature& tree = file->features[0];
    EXPECT_EQ(tree.shape, FeatureShape::Point);
    EXPECT_EQ(tree.id, "7");
    EXPECT_DOUBLE_EQ(tree.parts[0][0][0].x, 7.25);
    EXPECT_DOUBLE_EQ(tree.parts[0][0][0].y, 51.5);
    EXPECT_EQ(tree.number("height"), 12.5);
    EXPECT_EQ(std::get<std::string>(*tree.attribute("species")), "Quercus, robur");
}

TEST(Features, ThatCannotBeOpenedAreNamedWithWhatToDo) {
    const Folder folder;
    const auto reason = [&](const std::string& name, const std::string& bytes) {
        const auto file = readFeatures(folder.write(name, bytes), {});
        EXPECT_FALSE(file);
        return file ? "" : file.error().message();
    };
    EXPECT_NE(reason("a.gml", "<?xml version='1.0'?><CityModel xmlns='http://citygml'>")
                  .find("convert it with citygml-tools to CityJSON"),
              std::string::npos);
    EXPECT_NE(reason("a.kml", "<kml></kml>").find("ogr2ogr"), std::string::npos);
    EXPECT_NE(reason("a.zip", "PK\x03\x04").find("unpack"), std::string::npos);
    EXPECT_NE(reason("empty.geojson", " \n").find("is empty"), std::string::npos);
    EXPECT_NE(reason("a.bin", "\x01\x02\x03").find("nothing that GDAL reads"), std::string::npos);
    EXPECT_NE(reason("none.geojson", R"({"type":"FeatureCollection","features":[]})")
                  .find("holds nothing with a shape"),
              std::string::npos);
    EXPECT_FALSE(readFeatures(folder.file("nowhere.shp"), {}));
    EXPECT_FALSE(readFeatures("/vsicurl/http://localhost/a.geojson", {}));
}

TEST(Features, CutShortOrTurnedToNoiseNeverBringTheReaderDown) {
    const Folder folder;
    for (const auto& [driver, name] :
         {std::pair("GPKG", "a.gpkg"), {"ESRI Shapefile", "b.shp"}, {"GeoJSON", "c.geojson"}}) {
        const std::string path = written(folder, driver, name);
        std::ifstream in(path, std::ios::binary);
        const std::string whole{std::istreambuf_iterator<char>(in), {}};
        std::uint32_t seed = 1;
        const std::size_t step = whole.size() / 40 + 1;
        for (std::size_t cut = 0; cut < whole.size(); cut += step) {
            folder.write(name, whole.substr(0, cut));
            if (const auto file = readFeatures(path, {}); !file) {
                EXPECT_EQ(file.error().message().find('\n'), std::string::npos);
            }
            std::string noise = whole;
            for (int i = 0; i < 8; ++i) {
                seed = seed * 1664525u + 1013904223u;
                noise[seed % noise.size()] = char(seed >> 24);
            }
            folder.write(name, noise);
            if (const auto file = readFeatures(path, {}); file) {
                (void)Buildings::of(*file, path, {}, flatGround(10.0));
            }
        }
    }
}

} // namespace
} // namespace gnomon::test
