#include "tests/streaming/drape_support.h"

#include "geo/ellipsoid.h"
#include "streaming/terrain/drape_grid.h"

#include <gdalwarper.h>

#include <cmath>
#include <cstring>
#include <thread>

namespace gnomon {
namespace {

// Waves of at least 40 pixels, other ones in each band.
double waves(int band, double column, double row) {
    return std::round(127.0 + 60.0 * std::sin(column / (11.0 + band)) +
                      60.0 * std::cos(row / (9.0 + 2 * band)));
}

std::shared_ptr<const Drape> opened(const std::string& path, const DrapeOptions& options = {},
                                    std::vector<std::string>* notes = nullptr) {
    std::vector<std::string> said;
    auto drape = openDrape(path, options, notes != nullptr ? *notes : said);
    EXPECT_TRUE(drape) << (drape ? "" : drape.error().message());
    return drape ? *drape : nullptr;
}

std::string refusal(const std::string& path, const DrapeOptions& options = {}) {
    std::vector<std::string> notes;
    const auto drape = openDrape(path, options, notes);
    return drape ? "was opened" : drape.error().message();
}

// The same texels by GDAL's own warp.
std::vector<std::vector<std::uint8_t>> warped(const std::string& path, const PaintedTile& tile,
                                              GDALResampleAlg how, int bands = 3) {
    const std::unique_ptr<GDALDataset> source(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER));
    const std::unique_ptr<GDALDataset> out(GetGDALDriverManager()->GetDriverByName("MEM")->Create(
        "", tile.across, tile.down, bands, GDT_Byte, nullptr));
    std::array<double, 6> place{tile.west, (tile.east - tile.west) / tile.across, 0, tile.north,
                                0,         (tile.south - tile.north) / tile.down};
    out->SetGeoTransform(place.data());
    const OGRSpatialReference crs = crsOf("EPSG:4326");
    out->SetSpatialRef(&crs);
    EXPECT_EQ(GDALReprojectImage(source.get(), nullptr, out.get(), nullptr, how, 0, 0.0, nullptr,
                                 nullptr, nullptr),
              CE_None);
    std::vector<std::vector<std::uint8_t>> read(std::size_t(bands),
                                                std::vector<std::uint8_t>(tile.rgba.size() / 4));
    for (int b = 0; b < bands; ++b)
        EXPECT_EQ(out->GetRasterBand(b + 1)->RasterIO(GF_Read, 0, 0, tile.across, tile.down,
                                                      read[std::size_t(b)].data(), tile.across,
                                                      tile.down, GDT_Byte, 0, 0, nullptr),
                  CE_None);
    return read;
}

int largestDifference(const PaintedTile& tile, const std::vector<std::vector<std::uint8_t>>& gdal) {
    int largest = 0;
    for (std::size_t k = 0; k < tile.rgba.size() / 4; ++k)
        for (std::size_t b = 0; b < gdal.size(); ++b)
            largest = std::max(largest, std::abs(int(tile.rgba[4 * k + b]) - int(gdal[b][k])));
    return largest;
}

// Inside the default picture, about its middle.
std::array<double, 4> middleOf(const Drape& drape, double share) {
    const auto e = drape.extent();
    const double x = 0.5 * (e[0] + e[2]), y = 0.5 * (e[1] + e[3]);
    return {x - 0.5 * share * (e[2] - e[0]), y - 0.5 * share * (e[3] - e[1]),
            x + 0.5 * share * (e[2] - e[0]), y + 0.5 * share * (e[3] - e[1])};
}

TEST(Drape, FineTexelsAreWithinALevelOfGdalsOwnWarp) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.value = waves;
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    for (const double share : {0.05, 0.4, 0.8}) { // texels finer than pixels, to about as large
        PaintedTile tile(middleOf(*drape, share), 200, 150);
        ASSERT_FALSE(tile.paintWith(*drape));
        EXPECT_LE(largestDifference(tile, warped(folder / "p.tif", tile, GRA_Bilinear)), 1)
            << share;
        for (std::size_t k = 3; k < tile.rgba.size(); k += 4)
            ASSERT_EQ(tile.rgba[k], 255);
    }
}

TEST(Drape, CoarseTexelsAreAveragesOfThePixelsUnderThem) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.width = spec.height = 1024;
    spec.value = [](int b, double x, double y) { return waves(b, x / 8.0, y / 8.0); };
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    PaintedTile tile(middleOf(*drape, 0.8), 200, 200); // some 4 pixels a texel
    ASSERT_FALSE(tile.paintWith(*drape));
    EXPECT_LE(largestDifference(tile, warped(folder / "p.tif", tile, GRA_Average)), 2);
}

TEST(Drape, AChequerOfSinglePixelsSeenFromAfarIsGrey) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.width = spec.height = 512;
    spec.value = [](int, double x, double y) { return (int(x) + int(y)) % 2 ? 255.0 : 0.0; };
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    for (const int texels : {16, 40, 100, 130}) {
        PaintedTile tile(middleOf(*drape, 0.7), texels, texels);
        ASSERT_FALSE(tile.paintWith(*drape));
        for (std::size_t k = 0; k < tile.rgba.size(); k += 4)
            // An odd block has one pixel more of one kind: 1/2n² of it.
            ASSERT_NEAR(tile.rgba[k], 127.5, 255.0 / 18.0 + 1.0) << texels;
    }
}

TEST(Drape, OverviewsAreTakenWhereTheyAreFineEnoughAndOnlyThere) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.width = spec.height = 1024;
    spec.value = [](int, double, double) { return 50.0; };
    // The copies lie on purpose, so that the picture tells which of them was looked at.
    spec.finish = [](GDALDataset& data) {
        const int factors[] = {2, 4, 8};
        ASSERT_EQ(data.BuildOverviews("NEAREST", 3, factors, 0, nullptr, nullptr, nullptr),
                  CE_None);
        for (int b = 1; b <= 3; ++b)
            for (int i = 0; i < 3; ++i)
                data.GetRasterBand(b)->GetOverview(i)->Fill(100.0 + 50.0 * i);
    };
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    const auto seen = [&](int texels) {
        PaintedTile tile(middleOf(*drape, 0.5), texels, texels); // some 512 pixels
        EXPECT_FALSE(tile.paintWith(*drape));
        return int(*tile.texel(texels / 2, texels / 2));
    };
    EXPECT_EQ(seen(600), 50);
    EXPECT_EQ(seen(300), 50);
    EXPECT_EQ(seen(200), 100); // 2.6 pixels a texel across and, at 51 degrees north, so down
    EXPECT_EQ(seen(100), 150);
    EXPECT_EQ(seen(40), 200);
}

TEST(Drape, NodataAlphaAndMasksLeaveWhatIsBelow) {
    const TemporaryFolder folder;
    const auto hole = [](double x, double y) { return x > 64 && x < 192 && y > 64 && y < 192; };
    PictureSpec nodata;
    nodata.value = [&](int b, double x, double y) { return hole(x, y) ? 0.0 : 100.0 + b; };
    nodata.finish = [](GDALDataset& data) {
        for (int b = 1; b <= 3; ++b)
            data.GetRasterBand(b)->SetNoDataValue(0);
    };
    PictureSpec alpha;
    alpha.bands = 4;
    alpha.creation = {"ALPHA=YES"};
    alpha.value = [&](int b, double x, double y) {
        return b < 4 ? 100.0 + b : hole(x, y) ? 0.0 : 255.0;
    };
    PictureSpec mask;
    mask.value = [](int b, double, double) { return 100.0 + b; };
    mask.finish = [&](GDALDataset& data) {
        ASSERT_EQ(data.CreateMaskBand(GMF_PER_DATASET), CE_None);
        std::vector<std::uint8_t> all(256 * 256, 255);
        for (int y = 0; y < 256; ++y)
            for (int x = 0; x < 256; ++x)
                if (hole(x + 0.5, y + 0.5))
                    all[std::size_t(y * 256 + x)] = 0;
        ASSERT_EQ(data.GetRasterBand(1)->GetMaskBand()->RasterIO(
                      GF_Write, 0, 0, 256, 256, all.data(), 256, 256, GDT_Byte, 0, 0, nullptr),
                  CE_None);
    };
    int number = 0;
    for (const PictureSpec* spec : {&nodata, &alpha, &mask}) {
        const std::string path = folder / (std::to_string(number++) + ".tif");
        writePicture(path, *spec);
        const auto drape = opened(path);
        ASSERT_TRUE(drape);
        for (const int texels : {30, 200}) { // averaged, and not
            PaintedTile tile(middleOf(*drape, 0.9), texels, texels);
            std::fill(tile.rgba.begin(), tile.rgba.end(), std::uint8_t(7));
            ASSERT_FALSE(tile.paintWith(*drape));
            const std::uint8_t* in = tile.texel(texels / 2, texels / 2);
            EXPECT_EQ(int(in[0]), 7) << path;
            EXPECT_EQ(int(in[3]), 7) << path;
            const std::uint8_t* out = tile.texel(texels / 2, texels / 10);
            EXPECT_NEAR(int(out[0]), 101, 1) << path;
            EXPECT_NEAR(int(out[2]), 103, 1) << path;
            EXPECT_EQ(int(out[3]), 255) << path;
        }
    }
}

TEST(Drape, GreyPaletteAndSixteenBitPicturesShowTheirColours) {
    const TemporaryFolder folder;
    PictureSpec grey;
    grey.bands = 1;
    grey.value = [](int, double, double) { return 77.0; };
    writePicture(folder / "grey.tif", grey);
    PictureSpec palette = grey;
    palette.value = [](int, double, double) { return 3.0; };
    palette.finish = [](GDALDataset& data) {
        GDALColorTable table;
        const GDALColorEntry entry{10, 20, 30, 255};
        table.SetColorEntry(3, &entry);
        data.GetRasterBand(1)->SetColorTable(&table);
    };
    writePicture(folder / "palette.tif", palette);
    PictureSpec deep; // 2000 to 6000 of 65535 used
    deep.type = GDT_UInt16;
    deep.value = [](int, double x, double) { return 2000.0 + x / 256.0 * 4000.0; };
    writePicture(folder / "deep.tif", deep);

    const auto colorAt = [&](const std::string& name, std::vector<std::string>& notes) {
        const auto drape = opened(folder / name, {}, &notes);
        PaintedTile tile(middleOf(*drape, 0.9), 101, 101);
        EXPECT_FALSE(tile.paintWith(*drape));
        const std::uint8_t* t = tile.texel(50, 50);
        return std::array<int, 4>{t[0], t[1], t[2], t[3]};
    };
    std::vector<std::string> notes;
    EXPECT_EQ(colorAt("grey.tif", notes), (std::array<int, 4>{77, 77, 77, 255}));
    EXPECT_EQ(colorAt("palette.tif", notes), (std::array<int, 4>{10, 20, 30, 255}));
    EXPECT_TRUE(notes.empty());
    EXPECT_NEAR(colorAt("deep.tif", notes)[0], 127, 4);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("16-bit"), std::string::npos);
}

TEST(Drape, WorldFilesPlaceJpegAndPngWithTheSystemGivenOrFoundBeside) {
    const TemporaryFolder folder;
    for (const std::string kind : {"PNG", "JPEG"}) {
        PictureSpec spec;
        spec.driver = kind;
        spec.crs.clear();
        spec.value = [](int b, double, double) { return 60.0 * b; };
        const std::string path = folder / (kind + "." + (kind == "PNG" ? "png" : "jpg"));
        writePicture(path, spec);
        EXPECT_NE(refusal(path).find("world file"), std::string::npos) << refusal(path);
        std::ofstream(folder / (kind + (kind == "PNG" ? ".wld" : ".jgw")))
            << "0.5\n0\n0\n-0.5\n356000.25\n5699999.75\n";
        EXPECT_NE(refusal(path).find("--crs"), std::string::npos) << refusal(path);
        DrapeOptions options;
        options.crs = "EPSG:25832";
        const auto drape = opened(path, options);
        ASSERT_TRUE(drape);
        EXPECT_NEAR(drape->texelMetres(), 0.5, 1e-3);
        PaintedTile tile(middleOf(*drape, 0.5), 50, 50);
        ASSERT_FALSE(tile.paintWith(*drape));
        EXPECT_NEAR(int(tile.texel(25, 25)[1]), 120, 2);
        char* wkt = nullptr;
        crsOf("EPSG:25832").exportToWkt(&wkt);
        std::ofstream(folder / (kind + ".prj")) << wkt;
        CPLFree(wkt);
        EXPECT_TRUE(opened(path));
        std::filesystem::remove(folder / (kind + ".prj"));
    }
}

TEST(Drape, WhatIsNoPictureIsRefusedInALineThatSaysWhy) {
    const TemporaryFolder folder;
    PictureSpec heights;
    heights.bands = 1;
    heights.type = GDT_Float32;
    heights.value = [](int, double x, double) { return 100.0 + x; };
    writePicture(folder / "heights.tif", heights);
    EXPECT_NE(refusal(folder / "heights.tif").find("looks like heights"), std::string::npos);
    PictureSpec noCrs;
    noCrs.crs.clear();
    noCrs.value = waves;
    writePicture(folder / "nocrs.tif", noCrs);
    EXPECT_NE(refusal(folder / "nocrs.tif").find("--crs"), std::string::npos);
    DrapeOptions wrong;
    wrong.crs = "EPSG:999999";
    EXPECT_NE(refusal(folder / "nocrs.tif", wrong).find("EPSG:999999"), std::string::npos);
    wrong.crs = "EPSG:4326"; // metres taken for degrees
    EXPECT_NE(refusal(folder / "nocrs.tif", wrong).find("nowhere on the Earth"), std::string::npos);
    std::ofstream(folder / "text.tif") << "no picture at all";
    for (const std::string& line :
         {refusal(folder / "text.tif"), refusal(folder / "none.tif"), refusal(folder / "x\ny.tif")})
        EXPECT_NE(line, "was opened");
}

TEST(Drape, AFileCutShortFailsWhenItIsPaintedOrBefore) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.value = waves;
    writePicture(folder / "p.tif", spec);
    const auto size = std::filesystem::file_size(folder / "p.tif");
    std::filesystem::resize_file(folder / "p.tif", size / 2);
    std::vector<std::string> notes;
    const auto drape = openDrape(folder / "p.tif", {}, notes);
    if (drape) {
        PaintedTile tile(middleOf(**drape, 0.9), 100, 100);
        const Failure wrong = tile.paintWith(**drape);
        ASSERT_TRUE(wrong);
        EXPECT_EQ(wrong->message().find('\n'), std::string::npos);
    }
}

TEST(Drape, TexelsOutsideOfThePictureAreLeftAlone) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.value = [](int, double, double) { return 200.0; };
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    PaintedTile tile(middleOf(*drape, 3.0), 90, 90);
    ASSERT_FALSE(tile.paintWith(*drape));
    EXPECT_EQ(int(tile.texel(45, 45)[0]), 200);
    for (int k = 0; k < 90; ++k)
        for (const std::uint8_t* t : {tile.texel(k, 0), tile.texel(0, k), tile.texel(k, 89)})
            EXPECT_EQ(int(t[3]), 0);
}

TEST(Drape, LongitudesUpTo360MeetThoseOfTheTile) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.width = 360;
    spec.height = 180;
    spec.crs = "EPSG:4326";
    spec.place = {0, 1, 0, 90, 0, -1};
    spec.value = [](int, double x, double) { return x < 180 ? 50.0 : 150.0; };
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    PaintedTile tile({-180, -80, 180, 80}, 180, 90);
    ASSERT_FALSE(tile.paintWith(*drape));
    EXPECT_EQ(int(tile.texel(40, 45)[0]), 150);
    EXPECT_EQ(int(tile.texel(140, 45)[0]), 50);
}

TEST(Drape, ATileOverTheAntimeridianIsPaintedWhole) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.crs = "EPSG:3832";                            // a Mercator about 150 degrees east
    spec.place = {3330000, 100, 0, -1900000, 0, -100}; // about 180 degrees, Fiji
    spec.value = [](int, double, double) { return 90.0; };
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    const auto e = drape->extent();
    EXPECT_GT(e[0], e[2]) << "crosses the antimeridian";
    // As a tile of a raster of that system would give its places.
    std::vector<glm::dvec2> places;
    for (int j = 0; j < 64; ++j)
        for (int i = 0; i < 64; ++i)
            places.push_back({std::remainder(180.0 + 0.001 * (i - 32), 360.0), -17.0 - 0.001 * j});
    std::vector<std::uint8_t> rgba(4 * places.size(), 0);
    ASSERT_FALSE(drape->paint(places, 64, rgba));
    for (std::size_t k = 0; k < places.size(); ++k)
        ASSERT_EQ(int(rgba[4 * k]), 90) << k;
}

TEST(Drape, ExtentHoldsAllOfAPictureRoundThePole) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.crs = "EPSG:3995"; // polar stereographic
    spec.place = {-128000, 1000, 0, 128000, 0, -1000};
    spec.value = [](int, double, double) { return 90.0; };
    writePicture(folder / "p.tif", spec);
    const auto e = opened(folder / "p.tif")->extent();
    EXPECT_EQ(e[0], -180.0);
    EXPECT_EQ(e[2], 180.0);
    EXPECT_EQ(e[3], 90.0);
    EXPECT_NEAR(e[1], 88.4, 0.1);
}

TEST(Drape, ManyThreadsPaintTheSame) {
    const TemporaryFolder folder;
    PictureSpec spec;
    spec.value = waves;
    spec.creation = {"COMPRESS=DEFLATE", "TILED=YES"};
    writePicture(folder / "p.tif", spec);
    const auto drape = opened(folder / "p.tif");
    PaintedTile alone(middleOf(*drape, 0.8), 150, 150);
    ASSERT_FALSE(alone.paintWith(*drape));
    std::vector<PaintedTile> tiles(8, PaintedTile(middleOf(*drape, 0.8), 150, 150));
    std::vector<std::thread> threads;
    for (PaintedTile& tile : tiles)
        threads.emplace_back([&] {
            for (int round = 0; round < 5; ++round)
                tile.paintWith(*drape);
        });
    for (std::thread& thread : threads)
        thread.join();
    for (const PaintedTile& tile : tiles)
        EXPECT_EQ(tile.rgba, alone.rgba);
}

// Where the map bends, tears, or is not there at all.
TEST(MappedTexels, AreOffByLessThanAQuarterOfATexel) {
    const auto bent = [](glm::dvec2 p) {
        if (p.x > 0.72 && p.y > 0.31)
            return glm::dvec2(std::nan(""));
        const double torn = p.x + 0.3 * p.y > 0.5 ? 400.0 : 0.0;
        return glm::dvec2(300.0 * p.x * p.x + torn, 200.0 * std::sin(1.5 * p.y) + 20.0 * p.x);
    };
    for (const auto& [across, down] : {std::pair(257, 193), std::pair(2, 2), std::pair(1, 1),
                                       std::pair(3, 40), std::pair(17, 18), std::pair(1, 33)}) {
        std::vector<glm::dvec2> texels;
        for (int j = 0; j < down; ++j)
            for (int i = 0; i < across; ++i)
                texels.push_back({(i + 0.5) / across, (j + 0.5) / down});
        std::size_t asked = 0;
        const auto mapped = mappedTexels(
            texels, across,
            [&](std::vector<glm::dvec2>& places) {
                asked += places.size();
                for (glm::dvec2& p : places)
                    p = bent(p);
            },
            1e-9);
        double worst = 0.0;
        for (std::size_t k = 0; k < texels.size(); ++k) {
            const glm::dvec2 exact = bent(texels[k]);
            ASSERT_EQ(std::isnan(exact.x), std::isnan(mapped[k].x)) << k;
            if (std::isnan(exact.x))
                continue;
            // To the next texel where the map is smooth.
            const glm::dvec2 next(600.0 * texels[k].x / across, 20.0 / across);
            const double downStep = 300.0 * std::cos(1.5 * texels[k].y) / down;
            const double step = std::min(std::hypot(next.x, next.y), downStep);
            const glm::dvec2 off = mapped[k] - exact;
            worst = std::max(worst, std::hypot(off.x, off.y) / step);
        }
        EXPECT_LT(worst, 0.25) << across << "x" << down;
        if (across > 200) {
            EXPECT_LT(asked, texels.size()) << "few were asked for";
        }
    }
}

} // namespace
} // namespace gnomon
