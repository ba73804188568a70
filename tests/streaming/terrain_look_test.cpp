// What terrain looks like: its own colours, and what is painted on it.
#include "streaming/color_map.h"
#include "tests/streaming/terrain_support.h"

#include <map>

using namespace gnomon;
using namespace gnomon::test;

namespace {

std::uint8_t wave(double at) {
    return std::uint8_t(std::lround(127.5 + 127.5 * std::sin(at)));
}

// Waves over longitude and latitude, in the west of the raster only.
class Waves : public Drape {
  public:
    Waves(std::array<double, 4> box, double texel) : box_(box), texel_(texel) {}
    std::array<double, 4> extent() const override { return box_; }
    double texelMetres() const override { return texel_; }
    Failure paint(std::span<const glm::dvec2> lonLat, int width,
                  std::span<std::uint8_t> rgba) const override {
        EXPECT_EQ(lonLat.size() % std::size_t(width), 0u);
        EXPECT_EQ(rgba.size(), 4 * lonLat.size());
        for (std::size_t i = 0; i < lonLat.size(); ++i) {
            const glm::dvec2 p = lonLat[i];
            if (p.x < box_[0] || p.x > box_[2] || p.y < box_[1] || p.y > box_[3])
                continue;
            colorOf(p, &rgba[4 * i]);
        }
        return {};
    }
    static void colorOf(glm::dvec2 lonLat, std::uint8_t* out) {
        out[0] = wave(lonLat.x * 7e3);
        out[1] = wave(lonLat.y * 9e3);
        out[2] = 200;
        out[3] = 255;
    }

  private:
    std::array<double, 4> box_;
    double texel_;
};

class Broken : public Waves {
  public:
    using Waves::Waves;
    Failure paint(std::span<const glm::dvec2>, int, std::span<std::uint8_t>) const override {
        return Error{"picture.tif", "cannot be read"};
    }
};

const std::uint8_t* texel(const Image& image, int x, int y) {
    return &image.rgba[4 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x))];
}

} // namespace

TEST(TerrainLook, PlainIsOneColourLit) {
    const auto terrain = openTerrain(writeRaster("plain", roughHills(140, 60)));
    ASSERT_TRUE(terrain);
    const TileContent content = contentOf(terrain->tiles({}, {}), "0/0/0");
    ASSERT_EQ(content.materials.size(), 1u);
    EXPECT_FALSE(content.materials[0].unlit);
    EXPECT_EQ(content.materials[0].image, -1);
    EXPECT_NEAR(content.materials[0].baseColor.r, 0.233, 0.01);
}

TEST(TerrainLook, RampColoursByHeightBetweenTheRastersLowestAndHighest) {
    const Heights2d h(140, 60, [](int x, int y) { return 100.0 + x + 0.5 * y; });
    for (const TerrainLook look : {TerrainLook::Ramp, TerrainLook::RampUnlit}) {
        TerrainOptions options;
        options.look = look;
        options.raiseMetres = 1000.0; // moves the ground, not its colours
        const auto terrain = openTerrain(writeRaster("ramp", h), options);
        ASSERT_TRUE(terrain);
        const MadeTileset made = terrain->tiles({}, {});
        for (const char* path : {"1/0/0", "0/0/0"}) {
            const TileContent content = contentOf(made, path);
            ASSERT_EQ(content.images.size(), 1u);
            EXPECT_EQ(content.materials[0].unlit, look == TerrainLook::RampUnlit);
            EXPECT_EQ(content.materials[0].baseColor, glm::vec4(1.0f));
            for (const Mesh& mesh : content.meshes) {
                ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
                for (std::uint32_t v = 0; v < 3 * mesh.castingTriangles(); ++v) {
                    const std::uint32_t i = mesh.indices[v];
                    const double height = geodeticOf(vertexOf(mesh, i)).heightMetres - 1000.0;
                    const double share = (height - 100.0) / (139.0 + 29.5);
                    const int at = int(mesh.uvs[i].x * float(content.images[0].width));
                    const glm::vec3 expected = colorAt(ColorMap::Elevation, share);
                    for (int c = 0; c < 3; ++c)
                        ASSERT_NEAR(texel(content.images[0], at, 0)[c] / 255.0f, expected[c],
                                    0.02f);
                }
            }
        }
    }
}

TEST(TerrainLook, DrapesArePaintedWhereTheyAreAndTheGroundKeepsItsColourElsewhere) {
    const RasterLook look;
    const auto terrain = openTerrain(writeRaster("painted", roughHills(250, 120), look));
    ASSERT_TRUE(terrain);
    const GdalPlaces gdal(look);
    const auto box = terrain->facts().extent;
    const double middle = gdal.lonLat(60, 60).x;
    const auto drape =
        std::make_shared<Waves>(std::array{box[0] - 1, box[1] - 1, middle, box[3] + 1}, 0.5);
    const MadeTileset made = terrain->tiles({}, {drape});
    const TileContent content = contentOf(made, "0/0/0");
    ASSERT_EQ(content.images.size(), 1u);
    const Image& image = content.images[0];
    EXPECT_NEAR(image.width, 257, 1); // 128 m in texels of half a metre, both sides included
    EXPECT_EQ(content.materials[0].wrapS, Wrap::ClampToEdge);
    int painted = 0, plain = 0;
    for (const Mesh& mesh : content.meshes)
        for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
            const Geodetic place = geodeticOf(vertexOf(mesh, v));
            const int x = int(mesh.uvs[v].x * float(image.width));
            const int y = int(mesh.uvs[v].y * float(image.height));
            const std::uint8_t* told = texel(image, x, y);
            std::uint8_t expected[4];
            if (place.longitudeDegrees < middle - 1e-5) {
                Waves::colorOf({place.longitudeDegrees, place.latitudeDegrees}, expected);
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(told[c], expected[c], 3); // within half a texel
                ++painted;
            } else if (place.longitudeDegrees > middle + 1e-5) {
                EXPECT_NEAR(told[0], 0.52 * 255, 1);
                ++plain;
            }
            ASSERT_EQ(told[3], 255);
        }
    EXPECT_GT(painted, 1000);
    EXPECT_GT(plain, 1000);
}

TEST(TerrainLook, TexturesOfTilesSideBySideAgreeOnTheirCommonLine) {
    const RasterLook look;
    const auto terrain = openTerrain(writeRaster("seams", roughHills(257, 257), look));
    ASSERT_TRUE(terrain);
    const auto box = terrain->facts().extent;
    const auto drape =
        std::make_shared<Waves>(std::array{box[0] - 1, box[1] - 1, box[2] + 1, box[3] + 1}, 0.5);
    const MadeTileset made = terrain->tiles({}, {drape});
    const Image left = contentOf(made, "0/0/0").images.at(0),
                right = contentOf(made, "0/1/0").images.at(0),
                below = contentOf(made, "0/0/1").images.at(0);
    ASSERT_EQ(left.height, right.height);
    ASSERT_EQ(left.width, below.width);
    for (int i = 0; i < left.height; ++i)
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(texel(left, left.width - 1, i)[c], texel(right, 0, i)[c], 1);
            EXPECT_NEAR(texel(left, i, left.height - 1)[c], texel(below, i, 0)[c], 1);
        }
}

TEST(TerrainLook, FinerDrapesMakeTheTreeDeeperWhereTheyAre) {
    RasterLook look;
    look.transform = {356000, 20, 0, 5700000, 0, -20}; // tiles of 2560 m
    const auto terrain = openTerrain(writeRaster("deep", roughHills(300, 200), look));
    ASSERT_TRUE(terrain);
    const GdalPlaces gdal(look);
    const glm::dvec2 corner = gdal.lonLat(0, 60), other = gdal.lonLat(100, 0);
    const auto drape = std::make_shared<Waves>(
        std::array{corner.x + 0.001, corner.y + 0.001, other.x, other.y - 0.001}, 0.5);
    const MadeTileset made = terrain->tiles({}, {drape});
    std::map<int, double> error;
    std::size_t east = 0;
    Triangles whole, parts;
    for (const MadeTile& tile : allTiles(made)) {
        const TileId id = idOf(tile.path);
        error[id.level] = std::max(error[id.level], tile.geometricErrorMetres);
        east += id.level < 0 && id.x >= (2 << -id.level);
    }
    // 2560 m / 1024 = 2.5 m a texel, 1.25 m, 0.63 m: near enough to half a metre.
    EXPECT_EQ(error.begin()->first, -2);
    EXPECT_EQ(error[-2], 0.0);
    EXPECT_NEAR(error[-1], 1.25, 0.01);
    EXPECT_NEAR(error[0], 2.5, 0.01);
    EXPECT_EQ(east, 0u);
    // The parts are the whole's own triangles.
    whole.add(contentOf(made, "0/0/0"));
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            parts.add(contentOf(made, "-2/" + std::to_string(x) + "/" + std::to_string(y)));
    EXPECT_EQ(whole.all.size(), parts.all.size());
}

TEST(TerrainLook, ManyFineTexturesAreToldWhereTheyAreAskedFor) {
    RasterLook look;
    look.transform = {356000, 50, 0, 5700000, 0, -50};
    const auto terrain = openTerrain(writeRaster("many", roughHills(600, 600), look));
    ASSERT_TRUE(terrain);
    const auto drape = std::make_shared<Waves>(terrain->facts().extent, 0.1);
    const MadeTileset made = terrain->tiles({}, {drape});
    EXPECT_LT(made.tiles.size(), 100u);
    EXPECT_TRUE(TileTree::ofTiles("many", made.tiles));
    const auto below = made.maker->below("0/1/1");
    ASSERT_TRUE(below);
    EXPECT_TRUE(TileTree::ofTiles("below", *below));
    EXPECT_EQ(below->front().content, ContentKind::None);
    EXPECT_EQ(idOf(below->back().path).level, -6); // 6400 m / 64 / 1024 = 0.1 m
    for (const MadeTile& tile : *below)
        EXPECT_LE(tile.geometricErrorMetres, below->front().geometricErrorMetres);
}

TEST(TerrainLook, ADrapeThatCannotBeReadIsTheTilesErrorInOneLine) {
    const auto terrain = openTerrain(writeRaster("broken", roughHills(100, 60)));
    ASSERT_TRUE(terrain);
    const auto drape = std::make_shared<Broken>(terrain->facts().extent, 1.0);
    const auto content = terrain->tiles({}, {drape}).maker->make("0/0/0", {});
    ASSERT_FALSE(content);
    EXPECT_EQ(content.error().message(), "picture.tif: cannot be read");
}
