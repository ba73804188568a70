#include "tests/streaming/drape_support.h"

#include "geo/crs.h"
#include "streaming/terrain/drape_coverage.h"

#include <ogrsf_frmts.h>

#include <cmath>

namespace gnomon {
namespace {

using Ring = std::vector<glm::dvec2>;

std::string ringText(const Ring& ring) {
    std::string out = "[";
    for (std::size_t i = 0; i <= ring.size(); ++i) {
        char text[80];
        std::snprintf(text, sizeof text, "%s[%.9f,%.9f]", i ? "," : "", ring[i % ring.size()].x,
                      ring[i % ring.size()].y);
        out += text;
    }
    return out + "]";
}

std::string geoJson(const std::vector<std::vector<Ring>>& polygons) {
    std::string features;
    for (const auto& polygon : polygons) {
        std::string rings;
        for (const Ring& ring : polygon)
            rings += (rings.empty() ? "" : ",") + ringText(ring);
        features += std::string(features.empty() ? "" : ",") +
                    "{\"type\":\"Feature\",\"properties\":{},\"geometry\":{\"type\":\"Polygon\","
                    "\"coordinates\":[" +
                    rings + "]}}";
    }
    return "{\"type\":\"FeatureCollection\",\"features\":[" + features + "]}";
}

void writeText(const std::string& path, const std::string& text) {
    std::ofstream(path) << text;
}

std::shared_ptr<const Drape> opened(const std::string& path, const DrapeOptions& options = {},
                                    std::vector<std::string>* notes = nullptr) {
    std::vector<std::string> said;
    auto drape = openDrape(path, options, notes != nullptr ? *notes : said);
    EXPECT_TRUE(drape) << (drape ? "" : drape.error().message());
    return drape ? *drape : nullptr;
}

bool inside(const std::vector<std::vector<Ring>>& polygons, glm::dvec2 p) {
    for (const auto& polygon : polygons) {
        bool in = false;
        for (const Ring& ring : polygon)
            for (std::size_t i = 0; i < ring.size(); ++i) {
                const glm::dvec2 a = ring[i], b = ring[(i + 1) % ring.size()];
                if ((a.y > p.y) != (b.y > p.y) &&
                    p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y))
                    in = !in;
            }
        if (in)
            return true;
    }
    return false;
}

// By 16 looks a side into each texel.
double shareOf(const std::vector<std::vector<Ring>>& polygons, const PaintedTile& tile, int i,
               int j) {
    constexpr int kLooks = 16;
    int in = 0;
    const glm::dvec2 centre = tile.place(i, j);
    const glm::dvec2 size((tile.east - tile.west) / tile.across,
                          (tile.north - tile.south) / tile.down);
    for (int k = 0; k < kLooks * kLooks; ++k)
        in += inside(polygons, centre + size * (glm::dvec2(k % kLooks + 0.5, k / kLooks + 0.5) /
                                                    double(kLooks) -
                                                0.5));
    return double(in) / (kLooks * kLooks);
}

// A star with a hole, a slanted strip that runs out of the tile, and one wholly outside.
const std::vector<std::vector<Ring>> kShapes = {
    {{{7.001, 50.001},
      {7.006, 50.004},
      {7.009, 50.001},
      {7.007, 50.006},
      {7.009, 50.009},
      {7.005, 50.007},
      {7.001, 50.0088},
      {7.0035, 50.005}},
     {{7.004, 50.0048}, {7.0062, 50.0052}, {7.005, 50.0062}}},
    {{{6.99, 50.0093}, {7.02, 50.0099}, {7.02, 50.0101}, {6.99, 50.0095}}},
    {{{7.1, 50.1}, {7.2, 50.1}, {7.2, 50.2}}}};

TEST(DrapePolygons, CoverTexelsByTheExactShare) {
    const TemporaryFolder folder;
    writeText(folder / "p.geojson", geoJson(kShapes));
    DrapeOptions options;
    options.color = {200, 100, 50};
    const auto drape = opened(folder / "p.geojson", options);
    ASSERT_TRUE(drape);
    EXPECT_TRUE(std::isinf(drape->texelMetres()));
    for (const auto& [across, down] : {std::pair(64, 80), std::pair(17, 13)}) {
        PaintedTile tile({7.0, 50.0, 7.01, 50.01}, across, down);
        for (std::size_t k = 0; k < tile.rgba.size(); ++k)
            tile.rgba[k] = k % 4 == 3 ? 255 : 0;
        ASSERT_FALSE(tile.paintWith(*drape));
        double covered = 0.0, all = 0.0;
        for (int j = 0; j < down; ++j)
            for (int i = 0; i < across; ++i) {
                const double share = shareOf(kShapes, tile, i, j);
                // 16 looks a side miss an edge by up to half a look for each texel's height.
                ASSERT_NEAR(tile.texel(i, j)[0] / 200.0, share, 0.05) << i << " " << j;
                ASSERT_NEAR(tile.texel(i, j)[1] / 100.0, share, 0.06);
                ASSERT_EQ(int(tile.texel(i, j)[3]), 255);
                covered += tile.texel(i, j)[0] / 200.0;
                all += share;
            }
        EXPECT_NEAR(covered / all, 1.0, 0.003);
    }
}

TEST(DrapePolygons, ATileInAnyTurnIsPaintedRight) {
    const TemporaryFolder folder;
    writeText(folder / "p.geojson", geoJson(kShapes));
    const auto drape = opened(folder / "p.geojson");
    // Texels of a raster that stands at 30 degrees.
    std::vector<glm::dvec2> places;
    constexpr int kSide = 96;
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) {
            const glm::dvec2 local =
                (glm::dvec2(i, -j) / double(kSide) + glm::dvec2(-0.5, 0.5)) * 0.012;
            places.push_back({7.005 + 0.866 * local.x - 0.5 * local.y,
                              50.005 + 0.5 * local.x + 0.866 * local.y});
        }
    std::vector<std::uint8_t> rgba(4 * places.size(), 0);
    ASSERT_FALSE(drape->paint(places, kSide, rgba));
    int full = 0, empty = 0;
    for (std::size_t k = 0; k < places.size(); ++k) {
        // Only texels that no edge is near to are told apart by their middle alone.
        bool same = true;
        const bool in = inside(kShapes, places[k]);
        for (int n = 0; n < 8; ++n)
            same = same && inside(kShapes,
                                  places[k] + glm::dvec2(std::cos(n * 0.785), std::sin(n * 0.785)) *
                                                  0.00012) == in;
        if (!same)
            continue;
        ASSERT_NEAR(int(rgba[4 * k + 3]), in ? 255 : 0, 6) << k; // a tip of the star
        (in ? full : empty)++;
    }
    EXPECT_GT(full, 500);
    EXPECT_GT(empty, 2000);
}

TEST(DrapePolygons, WhatCrossesItselfIsMadeValidAndSaid) {
    const TemporaryFolder folder;
    const Ring bow = {{7.001, 50.001}, {7.009, 50.009}, {7.009, 50.001}, {7.001, 50.009}};
    writeText(folder / "p.geojson", geoJson({{bow}}));
    std::vector<std::string> notes;
    const auto drape = opened(folder / "p.geojson", {}, &notes);
    ASSERT_TRUE(drape);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("was made valid (Self-intersection"), std::string::npos) << notes[0];
    PaintedTile tile({7.0, 50.0, 7.01, 50.01}, 50, 50);
    ASSERT_FALSE(tile.paintWith(*drape));
    EXPECT_EQ(int(tile.texel(10, 25)[3]), 255) << "both wings";
    EXPECT_EQ(int(tile.texel(40, 25)[3]), 255);
    EXPECT_EQ(int(tile.texel(25, 10)[3]), 0);
    EXPECT_EQ(int(tile.texel(25, 40)[3]), 0);
}

TEST(DrapePolygons, OverTheAntimeridianAndRoundThePole) {
    const TemporaryFolder folder;
    writeText(
        folder / "a.geojson",
        geoJson({{{{179.99, -17.01}, {-179.99, -17.01}, {-179.99, -16.99}, {179.99, -16.99}}}}));
    const auto over = opened(folder / "a.geojson");
    ASSERT_TRUE(over);
    EXPECT_GT(over->extent()[0], over->extent()[2]);
    std::vector<glm::dvec2> places;
    for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i)
            places.push_back(
                {std::remainder(180.0 + 0.001 * (i - 19.5), 360.0), -17.0 + 0.001 * (19.5 - j)});
    std::vector<std::uint8_t> rgba(4 * places.size(), 0);
    ASSERT_FALSE(over->paint(places, 40, rgba));
    for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i)
            ASSERT_EQ(int(rgba[std::size_t(4 * (40 * j + i) + 3)]),
                      i >= 10 && i < 30 && j >= 10 && j < 30 ? 255 : 0)
                << i << " " << j;

    // A disc about the pole, on a tile of a polar raster, where longitudes run round it.
    Ring disc;
    for (int k = 0; k < 360; ++k)
        disc.push_back({k - 180.0 + 0.5, 89.9});
    std::vector<glm::dvec3> ring;
    for (const glm::dvec2& p : disc) {
        const double lon = p.x * 0.017453292519943295, lat = p.y * 0.017453292519943295;
        ring.push_back(
            {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)});
    }
    places.clear();
    constexpr int kSide = 64;
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) {
            const double x = (i - 31.5) * 0.005, y = (31.5 - j) * 0.005; // degrees from the pole
            places.push_back({std::atan2(y, x) / 0.017453292519943295, 90.0 - std::hypot(x, y)});
        }
    const TexelPlane plane(places, kSide);
    Coverage coverage(kSide, kSide);
    coverage.add(plane.texels(ring));
    double sum = 0.0;
    for (const float share : coverage.shares())
        sum += double(share);
    EXPECT_NEAR(sum, 3.14159265 * 20.0 * 20.0, 2.0);
}

TEST(DrapePolygons, GeoPackagesAndShapefilesBringTheirSystem) {
    GDALAllRegister();
    const TemporaryFolder folder;
    for (const auto& [driver, name] :
         {std::pair("GPKG", "p.gpkg"), std::pair("ESRI Shapefile", "p.shp")}) {
        const std::string path = folder / name;
        {
            const std::unique_ptr<GDALDataset> data(
                GetGDALDriverManager()->GetDriverByName(driver)->Create(path.c_str(), 0, 0, 0,
                                                                        GDT_Unknown, nullptr));
            ASSERT_TRUE(data);
            const OGRSpatialReference crs = crsOf("EPSG:25832");
            OGRLayer* layer =
                data->CreateLayer("p", const_cast<OGRSpatialReference*>(&crs), wkbPolygon, nullptr);
            ASSERT_NE(layer, nullptr);
            OGRLinearRing ring;
            for (const auto& [x, y] :
                 {std::pair(356000.0, 5700000.0), std::pair(356100.0, 5700000.0),
                  std::pair(356100.0, 5700050.0), std::pair(356000.0, 5700050.0),
                  std::pair(356000.0, 5700000.0)})
                ring.addPoint(x, y);
            OGRPolygon polygon;
            polygon.addRing(&ring);
            OGRFeature feature(layer->GetLayerDefn());
            feature.SetGeometry(&polygon);
            ASSERT_EQ(layer->CreateFeature(&feature), OGRERR_NONE);
        }
        const auto drape = opened(path);
        ASSERT_TRUE(drape) << name;
        const auto crs = CrsToEcef::create("EPSG:25832", Heights::Ellipsoidal);
        ASSERT_TRUE(crs);
        const auto middle = crs->geodetic({356050.0, 5700025.0, 0.0});
        const auto e = drape->extent();
        EXPECT_NEAR(0.5 * (e[0] + e[2]), middle->longitudeDegrees, 1e-6);
        EXPECT_NEAR(0.5 * (e[1] + e[3]), middle->latitudeDegrees, 1e-6);
        EXPECT_NEAR((e[3] - e[1]) * 111200.0, 50.0, 5.0);
    }
}

TEST(DrapePolygons, ARoadOfPlainVerticesIsPaintedWhereItLies) {
    const char* data = std::getenv("GNOMON_DATA");
    const std::string path =
        (data != nullptr ? std::string(data) : std::string(GNOMON_SOURCE_DIR) + "/../shared/data") +
        "/flood-merewether/Road/RoadPolygon.csv";
    std::ifstream in(path);
    if (!in)
        GTEST_SKIP() << "no " << path;
    Ring ring;
    char comma = 0;
    for (glm::dvec2 p; in >> p.x >> comma >> p.y;)
        ring.push_back(p);
    double area = 0.0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const glm::dvec2 a = ring[i] - ring[0], b = ring[(i + 1) % ring.size()] - ring[0];
        area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    std::vector<std::string> notes;
    EXPECT_FALSE(openDrape(path, {}, notes)) << "it names no system";
    DrapeOptions options;
    options.crs = "EPSG:32756";
    const auto drape = opened(path, options);
    ASSERT_TRUE(drape);
    // On a tile of that system, half a metre a texel: the painted area is the polygon's.
    const auto crs = CrsToEcef::create("EPSG:32756", Heights::Ellipsoidal);
    ASSERT_TRUE(crs);
    constexpr int kAcross = 820, kDown = 900;
    std::vector<glm::dvec2> places;
    for (int j = 0; j < kDown; ++j)
        for (int i = 0; i < kAcross; ++i) {
            const auto g = crs->geodetic({382205.0 + 0.5 * i, 6354660.0 - 0.5 * j, 0.0});
            places.push_back({g->longitudeDegrees, g->latitudeDegrees});
        }
    std::vector<std::uint8_t> rgba(4 * places.size(), 0);
    ASSERT_FALSE(drape->paint(places, kAcross, rgba));
    double painted = 0.0;
    for (std::size_t k = 3; k < rgba.size(); k += 4)
        painted += 0.25 * rgba[k] / 255.0;
    EXPECT_NEAR(painted / std::abs(area), 1.0, 0.002);
}

TEST(DrapePolygons, FilesWithoutPolygonsAreRefused) {
    const TemporaryFolder folder;
    writeText(folder / "points.geojson",
              "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"properties\":"
              "{},\"geometry\":{\"type\":\"Point\",\"coordinates\":[7,50]}}]}");
    std::vector<std::string> notes;
    const auto points = openDrape(folder / "points.geojson", {}, notes);
    ASSERT_FALSE(points);
    EXPECT_NE(points.error().message().find("no polygon"), std::string::npos);
    EXPECT_TRUE(notes.empty());
    writeText(folder / "broken.geojson", "{\"type\":\"FeatureCollection\",\"features\":[{");
    EXPECT_FALSE(openDrape(folder / "broken.geojson", {}, notes));
}

} // namespace
} // namespace gnomon
