// Places within a tile are interpolated: held against PROJ's own for every pixel, and against
// GDAL's transformation.
#include "streaming/terrain/terrain_place.h"
#include "tests/streaming/terrain_support.h"

using namespace gnomon;
using namespace gnomon::test;

namespace {

struct System {
    const char* name;
    RasterLook look;
};

std::vector<System> systems() {
    const auto look = [](int epsg, std::array<double, 6> transform) {
        RasterLook out;
        out.epsg = epsg;
        out.transform = transform;
        return out;
    };
    return {
        {"UTM, 1 m", look(25832, {356000, 1, 0, 5700000, 0, -1})},
        {"UTM, 100 m, far from its meridian", look(32632, {90000, 100, 0, 7700000, 0, -100})},
        {"degrees, 1 arc second", look(4326, {7, 1.0 / 3600, 0, 47, 0, -1.0 / 3600})},
        {"degrees, over the antimeridian",
         look(4326, {179.99, 1.0 / 3600, 0, -17, 0, -1.0 / 3600})},
        {"Lambert's equal areas, 25 m", look(3035, {4300000, 25, 0, 3100000, 0, -25})},
        {"stereographic, over the pole", look(3995, {-3000, 50, 0, 4000, 0, -50})},
        {"turned and from the south", look(25833, {400000, 3, 4, 5800000, -4, 3})},
        {"Gauss and Krüger: a datum of its own", look(31467, {3500000, 10, 0, 5500000, 0, -10})},
        {"Mercator of the web", look(3857, {800000, 30, 0, 6500000, 0, -30})},
    };
}

PixelLines tileLines() {
    PixelLines lines;
    for (int i = -1; i <= 129; ++i) {
        lines.columns.push_back(i + 200);
        lines.rows.push_back(i + 100);
    }
    return lines;
}

} // namespace

TEST(TerrainPlace, InterpolatedPlacesAreWithinTheirSlackOfProjsOwn) {
    for (const auto& [name, look] : systems()) {
        SCOPED_TRACE(name);
        const auto raster =
            Raster::open(writeRaster("place", Heights2d(4, 4, [](int, int) { return 1.0; }), look));
        ASSERT_TRUE(raster);
        const auto place = TerrainPlace::create(*raster, *raster->crs(), Heights::Ellipsoidal, 0.0);
        ASSERT_TRUE(place) << place.error().message();
        const PixelLines lines = tileLines();
        const std::vector<float> heights(lines.columns.size() * lines.rows.size(), 431.25f);
        const auto all = (*place)->at(lines, heights);
        ASSERT_TRUE(all);
        double worst = 0.0;
        for (std::size_t j = 0; j < lines.rows.size(); j += 7)
            for (std::size_t i = 0; i < lines.columns.size(); i += 5) {
                const PlacedPixel& told = (*all)[j * lines.columns.size() + i];
                const auto own = (*place)->at(glm::dvec2(lines.columns[i], lines.rows[j]), 431.25);
                ASSERT_TRUE(own);
                worst = std::max(worst, length(told.ecef() - own->ecef()));
                EXPECT_EQ(told.heightMetres, 431.25);
            }
        EXPECT_LE(worst, kPlaceSlackMetres);
    }
}

TEST(TerrainPlace, AgreesWithGdalToAMillimetre) {
    for (const auto& [name, look] : systems()) {
        SCOPED_TRACE(name);
        const GdalPlaces gdal(look);
        const auto raster =
            Raster::open(writeRaster("gdal", Heights2d(4, 4, [](int, int) { return 1.0; }), look));
        ASSERT_TRUE(raster);
        const auto place = TerrainPlace::create(*raster, *raster->crs(), Heights::Ellipsoidal, 5.0);
        ASSERT_TRUE(place);
        for (const glm::dvec2 pixel :
             {glm::dvec2(0, 0), glm::dvec2(250, 90), glm::dvec2(33, 512)}) {
            const auto own = (*place)->at(pixel, 100.0);
            ASSERT_TRUE(own);
            EXPECT_LE(length(own->ecef() - gdal.ecef(pixel.x, pixel.y, 105.0)), 1e-3);
            const std::array lonLat{own->lonLat()};
            std::array<glm::dvec2, 1> back;
            (*place)->pixelsOf(lonLat, back);
            EXPECT_NEAR(back[0].x, pixel.x, 1e-4);
            EXPECT_NEAR(back[0].y, pixel.y, 1e-4);
        }
    }
}

TEST(TerrainPlace, OnExactLinesIsProjsOwnToTheLastBit) {
    const auto raster =
        Raster::open(writeRaster("exact", Heights2d(4, 4, [](int, int) { return 1.0; })));
    ASSERT_TRUE(raster);
    const auto place = TerrainPlace::create(*raster, *raster->crs(), Heights::Ellipsoidal, 0.0);
    ASSERT_TRUE(place);
    PixelLines lines = tileLines();
    lines.exactColumn.assign(lines.columns.size(), false);
    lines.exactRow.assign(lines.rows.size(), false);
    lines.exactColumn[1] = true;
    const std::vector<float> heights(lines.columns.size() * lines.rows.size(), 10.0f);
    const auto all = (*place)->at(lines, heights);
    ASSERT_TRUE(all);
    for (std::size_t j = 0; j < lines.rows.size(); ++j) {
        const auto own = (*place)->at(glm::dvec2(lines.columns[1], lines.rows[j]), 10.0);
        EXPECT_EQ((*all)[j * lines.columns.size() + 1].up, own->up);
    }
}

TEST(TerrainPlace, AddsTheGeoidAtEveryPixelAndNotBetweenThem) {
    RasterLook look;
    look.epsg = 4326;
    look.transform = {7, 0.01, 0, 47, 0, -0.01}; // over several of the geoid's cells
    const auto raster =
        Raster::open(writeRaster("geoid", Heights2d(4, 4, [](int, int) { return 1.0; }), look));
    ASSERT_TRUE(raster);
    const auto place = TerrainPlace::create(*raster, *raster->crs(), Heights::Egm96, 1.5);
    ASSERT_TRUE(place);
    const PixelLines lines = tileLines();
    const std::vector<float> heights(lines.columns.size() * lines.rows.size(), 300.0f);
    const auto all = (*place)->at(lines, heights);
    ASSERT_TRUE(all);
    for (std::size_t i = 0; i < all->size(); i += 97) {
        const glm::dvec2 p = (*all)[i].lonLat();
        EXPECT_NEAR((*all)[i].heightMetres, 301.5 + *egm96GeoidHeight(p.x, p.y), 1e-6);
    }
}

TEST(TerrainPlace, LeavesHeightsToASystemThatHasItsOwn) {
    RasterLook look;
    look.epsg = 4979;
    look.transform = {7, 0.001, 0, 47, 0, -0.001};
    const auto raster =
        Raster::open(writeRaster("own", Heights2d(4, 4, [](int, int) { return 1.0; }), look));
    ASSERT_TRUE(raster);
    const auto place = TerrainPlace::create(*raster, *raster->crs(), Heights::Egm96, 0.0);
    ASSERT_TRUE(place);
    EXPECT_NEAR((*place)->at({1, 1}, 77.0)->heightMetres, 77.0, 1e-6);
}
