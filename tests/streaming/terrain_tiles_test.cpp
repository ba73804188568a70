// The triangles of terrain's tiles: where they are, that they meet, what they leave out.
#include "geo/bounds.h"
#include "streaming/terrain/raster.h"
#include "tests/streaming/terrain_support.h"

#include <map>
#include <set>

using namespace gnomon;
using namespace gnomon::test;

namespace {

std::vector<std::string> pathsAt(const MadeTileset& made, int level) {
    std::vector<std::string> out;
    for (const MadeTile& tile : allTiles(made))
        if (idOf(tile.path).level == level)
            out.push_back(tile.path);
    return out;
}

int topOf(const MadeTileset& made) {
    return idOf(made.tiles.front().path).level;
}

using Key = std::array<std::int64_t, 3>;
// Places that are the same to a tenth of a millimetre, as far as a test of tiles can tell them from
// the next vertex.
Key keyOf(const glm::dvec3& p) {
    constexpr double kSame = 1e-4;
    return {std::llround(p.x / kSame), std::llround(p.y / kSame), std::llround(p.z / kSame)};
}

// Sides of triangles that no second triangle shares, by position to the last bit.
std::vector<std::array<glm::dvec3, 2>> openSides(const Triangles& triangles) {
    using Point = std::array<double, 3>;
    const auto point = [](const glm::dvec3& p) { return Point{p.x, p.y, p.z}; };
    std::map<std::pair<Point, Point>, int> count;
    for (const auto& t : triangles.all)
        for (std::size_t k = 0; k < 3; ++k) {
            Point a = point(t[k]), b = point(t[(k + 1) % 3]);
            ++count[a < b ? std::pair(a, b) : std::pair(b, a)];
        }
    std::vector<std::array<glm::dvec3, 2>> out;
    for (const auto& [side, n] : count) {
        EXPECT_LE(n, 2);
        if (n == 1)
            out.push_back({glm::dvec3(side.first[0], side.first[1], side.first[2]),
                           glm::dvec3(side.second[0], side.second[1], side.second[2])});
    }
    return out;
}

// Skirts apart: the upper side of each of their quads, and how far it hangs.
struct Skirt {
    glm::dvec3 a, b;
    double hangA, hangB;
};
std::vector<Skirt> skirtsOf(const TileContent& content) {
    std::vector<Skirt> out;
    for (const Mesh& mesh : content.meshes)
        for (std::uint32_t i = mesh.castingTriangles(); i + 1 < mesh.triangles(); i += 2) {
            const std::uint32_t* v = &mesh.indices[3 * std::size_t(i)];
            const glm::dvec3 a = vertexOf(mesh, v[0]).xyz, b = vertexOf(mesh, v[1]).xyz;
            out.push_back({a, b, glm::length(vertexOf(mesh, v[5]).xyz - a),
                           glm::length(vertexOf(mesh, v[2]).xyz - b)});
        }
    return out;
}

// Where a plumb line through `p` meets the triangles, as a height above p; none where it does not.
std::optional<double> plumb(const std::vector<std::array<glm::dvec3, 3>>& triangles,
                            const glm::dvec3& p, const glm::dvec3& up) {
    std::optional<double> best;
    for (const auto& t : triangles) {
        const glm::dvec3 a = t[0] - p, b = t[1] - p, c = t[2] - p;
        const double u = glm::dot(up, glm::cross(b, c)), v = glm::dot(up, glm::cross(c, a)),
                     w = glm::dot(up, glm::cross(a, b));
        const double sum = u + v + w;
        // A millimetre beyond a side counts: pixels lie on sides.
        const double slack = -1e-3 * std::sqrt(std::abs(sum));
        if (!(sum > 0.0) || u < slack || v < slack || w < slack)
            continue;
        const double at = glm::dot(up, (u * a + v * b + w * c) / sum);
        if (!best || std::abs(at) < std::abs(*best))
            best = at;
    }
    return best;
}

std::string nrw() {
    return (dataFolder() / "dem-nrw-1m-utm32/dom1_32_356_5699_1_nw_2020.tif").string();
}

class Above : public GroundHeights {
  public:
    Above(double west, double height) : west_(west), height_(height) {}
    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        for (std::size_t i = 0; i < lonLat.size(); ++i)
            heights[i] = lonLat[i].x >= west_ ? height_ : double(kNoHeight);
    }

  private:
    double west_, height_;
};

} // namespace

TEST(TerrainTiles, VerticesArePixelsCentresToACentimetreByGdalsOwnTransformation) {
    std::vector<RasterLook> looks(6);
    looks[1].epsg = 4326;
    looks[1].transform = {7, 1.0 / 3600, 0, 47, 0, -1.0 / 3600};
    looks[2].transform = {356000, 1, 0, 5699000, 0, 1};  // from the south
    looks[3].transform = {400000, 3, 4, 5800000, 4, -3}; // turned
    looks[4].epsg = 3035;
    looks[4].transform = {4300000, 25, 0, 3100000, 0, -25};
    looks[5].epsg = 3995;
    looks[5].transform = {-9000, 50, 0, 7000, 0, -50}; // the pole within
    const Heights2d h = roughHills(300, 200);
    for (const RasterLook& look : looks) {
        SCOPED_TRACE(look.epsg);
        const GdalPlaces gdal(look);
        const auto terrain = openTerrain(writeRaster("places", h, look));
        ASSERT_TRUE(terrain);
        const MadeTileset made = terrain->tiles({}, {});
        for (const int level : {0, 1}) {
            std::size_t count = 0;
            for (const std::string& path : pathsAt(made, level)) {
                std::set<Key> vertices;
                for (const Mesh& mesh : contentOf(made, path).meshes)
                    for (std::uint32_t i = 0; i < 3 * mesh.castingTriangles(); ++i) {
                        const Point<Ecef> p = vertexOf(mesh, mesh.indices[i]);
                        if (!vertices.insert(keyOf(p.xyz)).second)
                            continue;
                        const Geodetic place = geodeticOf(p);
                        const glm::dvec2 at =
                            glm::round(gdal.pixel({place.longitudeDegrees, place.latitudeDegrees}));
                        ASSERT_TRUE(at.x >= 0 && at.y >= 0 && at.x < h.width && at.y < h.height);
                        const Point<Ecef> expected =
                            gdal.ecef(at.x, at.y, double(h.at(int(at.x), int(at.y))));
                        ASSERT_LE(length(p - expected), 0.01) << at.x << " " << at.y;
                    }
                count += vertices.size();
            }
            if (level == 0) {
                EXPECT_GE(count, 300u * 200u);
            }
        }
    }
}

TEST(TerrainTiles, OfOneLevelMeetToTheLastBit) {
    std::vector<RasterLook> looks(3);
    looks[1].epsg = 4326;
    looks[1].transform = {7, 0.001, 0, 47, 0, -0.001};
    looks[2].transform = {400000, 3, 4, 5800000, -4, 3};
    const Heights2d h = roughHills(421, 300);
    for (const RasterLook& look : looks) {
        const GdalPlaces gdal(look);
        const auto terrain = openTerrain(writeRaster("meet", h, look));
        ASSERT_TRUE(terrain);
        const MadeTileset made = terrain->tiles({}, {});
        for (int level = 0; level <= topOf(made); ++level) {
            Triangles all;
            for (const std::string& path : pathsAt(made, level))
                all.add(contentOf(made, path));
            std::size_t inside = 0;
            for (const auto& side : openSides(all))
                for (const glm::dvec3& p : side) {
                    const Geodetic place = geodeticOf(Point<Ecef>{p});
                    const glm::dvec2 at =
                        gdal.pixel({place.longitudeDegrees, place.latitudeDegrees});
                    const double rim = std::min(std::min(at.x, h.width - 1 - at.x),
                                                std::min(at.y, h.height - 1 - at.y));
                    inside += std::abs(rim) > 0.01;
                }
            EXPECT_EQ(inside, 0u) << "level " << level;
        }
    }
}

TEST(TerrainTiles, StoredAlongAScenesAxesAreTheSamePlaces) {
    const auto terrain = openTerrain(writeRaster("axes", roughHills(300, 200)));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    DecodeOptions options;
    options.meshAxes = ecefFromEnu({7, 51, 0}).axes();
    const TileContent plain = contentOf(made, "0/1/0"), turned = contentOf(made, "0/1/0", options);
    ASSERT_EQ(plain.meshes.size(), turned.meshes.size());
    for (std::size_t m = 0; m < plain.meshes.size(); ++m) {
        const Mesh &a = plain.meshes[m], &b = turned.meshes[m];
        ASSERT_EQ(a.indices, b.indices);
        for (std::uint32_t v = 0; v < a.positions.size(); ++v) {
            EXPECT_LE(length(vertexOf(a, v) - vertexOf(b, v, *options.meshAxes)), 5e-5);
            EXPECT_LE(
                glm::length(decodeOct(a.normals[v]) - *options.meshAxes * decodeOct(b.normals[v])),
                2e-4);
        }
    }
}

TEST(TerrainTiles, AreAsADecodedTileIs) {
    RasterLook southUp;
    southUp.transform = {356000, 1, 0, 5699000, 0, 1};
    for (const RasterLook& look : {RasterLook{}, southUp}) {
        const auto terrain = openTerrain(writeRaster("decoded", roughHills(300, 200), look));
        ASSERT_TRUE(terrain);
        const MadeTileset made = terrain->tiles({}, {});
        for (const MadeTile& tile : made.tiles) {
            const TileContent content = contentOf(made, tile.path);
            std::uint64_t casting = 0;
            glm::dvec3 area(0.0);
            for (const Mesh& mesh : content.meshes) {
                casting += mesh.castingTriangles();
                ASSERT_EQ(mesh.faceNormals.size(), mesh.triangles());
                ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
                EXPECT_TRUE(mesh.uvs.empty());
                EXPECT_EQ(mesh.closedTriangles, 0u);
                const glm::dvec3 up = ellipsoidNormal(mesh.origin).xyz;
                for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
                    EXPECT_LE(distanceTo(BoundingVolume(mesh.box), vertexOf(mesh, v)), 1e-6);
                    EXPECT_LE(double(glm::length(mesh.positions[v])), mesh.radiusMetres + 1e-4);
                    EXPECT_GT(glm::dot(decodeOct(mesh.normals[v]), up), 0.0);
                }
                for (std::uint32_t i = 0; i < mesh.castingTriangles(); ++i) {
                    const std::uint32_t* v = &mesh.indices[3 * std::size_t(i)];
                    const glm::dvec3 a = vertexOf(mesh, v[0]).xyz;
                    const glm::dvec3 n =
                        glm::cross(vertexOf(mesh, v[1]).xyz - a, vertexOf(mesh, v[2]).xyz - a);
                    area += 0.5 * n;
                    ASSERT_GT(glm::dot(glm::normalize(n), decodeOct(mesh.faceNormals[i])), 0.9999);
                    ASSERT_GT(glm::dot(n, up), 0.0); // counter-clockwise from above
                }
            }
            EXPECT_EQ(content.facts.triangles, casting);
            EXPECT_LE(glm::length(area - content.facts.areaVector), 1e-3 * glm::length(area));
            EXPECT_EQ(content.facts.format, "terrain");
        }
    }
}

TEST(TerrainTiles, AreTheSameWhoeverMakesThem) {
    const std::string path = writeRaster("same", roughHills(300, 200));
    const auto one = openTerrain(path), other = openTerrain(path);
    ASSERT_TRUE(one && other);
    const TileContent a = contentOf(one->tiles({}, {}), "1/0/0");
    contentOf(other->tiles({}, {}), "0/0/0");
    const TileContent b = contentOf(other->tiles({}, {}), "1/0/0");
    ASSERT_EQ(a.meshes.size(), b.meshes.size());
    for (std::size_t m = 0; m < a.meshes.size(); ++m) {
        EXPECT_EQ(a.meshes[m].positions, b.meshes[m].positions);
        EXPECT_EQ(a.meshes[m].indices, b.meshes[m].indices);
        EXPECT_EQ(a.meshes[m].origin.xyz, b.meshes[m].origin.xyz);
    }
}

TEST(TerrainTiles, SurfaceIsNoFartherFromThePixelsThanTheirErrorSays) {
    if (!std::filesystem::exists(nrw()))
        GTEST_SKIP() << "dem-nrw-1m-utm32 is not here";
    const auto terrain = openTerrain(nrw());
    ASSERT_TRUE(terrain);
    const auto raster = Raster::open(nrw());
    ASSERT_TRUE(raster);
    const std::vector<float> all = *raster->read(0, 0, 1000, 1000);
    RasterLook look;
    const GdalPlaces gdal(look);
    const MadeTileset made = terrain->tiles({}, {});
    std::map<std::string, double> errors;
    for (const MadeTile& tile : made.tiles)
        errors[tile.path] = tile.geometricErrorMetres;
    std::mt19937 random(3);
    for (const std::string path : {"3/0/0", "2/1/0", "2/0/1", "1/2/3", "0/5/5"}) {
        const TileId id = idOf(path);
        Triangles triangles;
        triangles.add(contentOf(made, path));
        double worst = 0.0;
        const int side = 128 << id.level;
        for (int i = 0; i < 120; ++i) {
            const int x = std::min(id.x * side + int(random() % unsigned(side)), 999);
            const int y = std::min(id.y * side + int(random() % unsigned(side)), 999);
            const Point<Ecef> p = gdal.ecef(x, y, double(all[std::size_t(y * 1000 + x)]));
            const auto off = plumb(triangles.all, p.xyz, ellipsoidNormal(p).xyz);
            ASSERT_TRUE(off) << path << " has no ground at " << x << " " << y;
            worst = std::max(worst, std::abs(*off));
        }
        EXPECT_LE(worst, errors[path] + 1e-3) << path;
        if (id.level >= 2) {
            EXPECT_GT(worst, 0.05 * errors[path]) << path;
        }
    }
}

TEST(TerrainTiles, LeaveOutWhatHasNoDataAndNothingElse) {
    Heights2d h = roughHills(300, 200);
    for (int y = 60; y < 150; ++y)
        for (int x = 100; x < 180; ++x)
            h.values[std::size_t(y * h.width + x)] = kNoHeight;
    h.values[std::size_t(20 * h.width + 20)] = kNoHeight;
    std::size_t expected = 0;
    for (int y = 0; y + 1 < h.height; ++y)
        for (int x = 0; x + 1 < h.width; ++x) {
            const float diagonal = h.at(x + 1, y) + h.at(x, y + 1);
            expected += !std::isnan(diagonal + h.at(x, y));
            expected += !std::isnan(diagonal + h.at(x + 1, y + 1));
        }
    const auto terrain = openTerrain(writeRaster("hole", h));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    Triangles all;
    for (const std::string& path : pathsAt(made, 0))
        all.add(contentOf(made, path));
    EXPECT_EQ(all.all.size(), expected);
    // The hole's rim is moved by coarse cells: they are refined away as soon as that shows.
    for (const MadeTile& tile : made.tiles)
        if (idOf(tile.path).level == 1) {
            EXPECT_GE(tile.geometricErrorMetres, 1.99) << tile.path;
        }
}

TEST(TerrainTiles, SkirtsHangWhereTilesMeetAndNowhereElse) {
    Heights2d h = roughHills(385, 257);
    for (int y = 0; y < 60; ++y)
        for (int x = 110; x < 150; ++x)
            h.values[std::size_t(y * h.width + x)] = kNoHeight;
    const RasterLook look;
    const GdalPlaces gdal(look);
    const auto terrain = openTerrain(writeRaster("skirts", h, look));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    std::size_t count = 0;
    for (const std::string& path : pathsAt(made, 0)) {
        const TileContent content = contentOf(made, path);
        for (const Skirt& skirt : skirtsOf(content)) {
            ++count;
            for (const glm::dvec3& p : {skirt.a, skirt.b}) {
                const Geodetic place = geodeticOf(Point<Ecef>{p});
                const glm::dvec2 at =
                    glm::round(gdal.pixel({place.longitudeDegrees, place.latitudeDegrees}));
                // On a line between tiles that is not the raster's end.
                const bool down = std::fmod(at.x, 128.0) == 0.0 && at.x > 0 && at.x < 384;
                const bool across = std::fmod(at.y, 128.0) == 0.0 && at.y > 0 && at.y < 256;
                EXPECT_TRUE(down || across) << at.x << " " << at.y;
            }
            EXPECT_GT(skirt.hangA, 0.0);
            EXPECT_LT(skirt.hangA, 60.0);
        }
    }
    // Two lines down of 256 cells and one across of 384, from either side; the hole takes 60 of one
    // and a rim of one.
    EXPECT_NEAR(double(count), 2.0 * (256 + 196 + 384), 8.0);
}

TEST(TerrainTiles, SkirtsReachDownToTheCoarserTileNextToThem) {
    const Heights2d h = roughHills(513, 513);
    const auto terrain = openTerrain(writeRaster("reach", h));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    // 0/1/1 beside 1/1/0, along column 256.
    Triangles coarse;
    coarse.add(contentOf(made, "1/1/0"));
    const TileContent fine = contentOf(made, "0/1/1");
    int met = 0;
    for (const Skirt& skirt : skirtsOf(fine)) {
        const glm::dvec3 up = ellipsoidNormal(Point<Ecef>{skirt.a}).xyz;
        if (const auto off = plumb(coarse.all, skirt.a, up)) {
            EXPECT_LE(-*off, skirt.hangA + 1e-6);
            ++met;
        }
    }
    EXPECT_GT(met, 100);
}

TEST(TerrainTiles, SkirtsAreShadedAsTheGroundAtTheirTop) {
    const auto terrain = openTerrain(writeRaster("shade", roughHills(300, 200)));
    ASSERT_TRUE(terrain);
    const TileContent content = contentOf(terrain->tiles({}, {}), "0/1/0");
    for (const Mesh& mesh : content.meshes) {
        ASSERT_GT(mesh.skirtTriangles, 0u);
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> sides;
        for (std::uint32_t i = 0; i < mesh.castingTriangles(); ++i)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t a = mesh.indices[3 * i + k],
                                    b = mesh.indices[3 * i + (k + 1) % 3];
                sides[{std::min(a, b), std::max(a, b)}] = i;
            }
        for (std::uint32_t i = mesh.castingTriangles(); i < mesh.triangles(); i += 2) {
            const std::uint32_t* v = &mesh.indices[3 * std::size_t(i)];
            const auto at = sides.find({std::min(v[0], v[1]), std::max(v[0], v[1])});
            ASSERT_NE(at, sides.end());
            EXPECT_EQ(mesh.faceNormals[i].x, mesh.faceNormals[at->second].x);
            EXPECT_EQ(mesh.faceNormals[i].y, mesh.faceNormals[at->second].y);
            EXPECT_EQ(mesh.normals[v[0]].x, mesh.normals[v[5]].x);
        }
    }
}

TEST(TerrainTiles, MakeRoomForGroundAboveAndRiseToMeetIt) {
    const Heights2d h = roughHills(300, 200);
    const RasterLook look;
    const GdalPlaces gdal(look);
    const auto terrain = openTerrain(writeRaster("above", h, look));
    ASSERT_TRUE(terrain);
    const double west = gdal.lonLat(149.5, 100).x; // from about column 150 on
    const MadeTileset made = terrain->tiles({std::make_shared<Above>(west, 400.0)}, {});
    Triangles all;
    for (const std::string& path : pathsAt(made, 0))
        all.add(contentOf(made, path));
    std::size_t raised = 0;
    for (const auto& t : all.all) {
        int covered = 0;
        for (const glm::dvec3& p : t) {
            const Geodetic place = geodeticOf(Point<Ecef>{p});
            const bool over = place.longitudeDegrees >= west;
            covered += over;
            EXPECT_EQ(over, std::abs(place.heightMetres - 400.0) < 1e-3);
        }
        EXPECT_LT(covered, 3);
        raised += covered > 0;
    }
    EXPECT_GT(raised, 350u); // a strip of two triangles a row
    EXPECT_NEAR(double(all.all.size()), 2.0 * 150 * 199, 1000.0);
    for (const MadeTile& tile : made.tiles)
        for (const Mesh& mesh : contentOf(made, tile.path).meshes)
            for (std::uint32_t i = 0; i < 3 * mesh.castingTriangles(); ++i)
                ASSERT_LE(distanceTo(tile.volume, vertexOf(mesh, mesh.indices[i])), 1e-3);
}

TEST(TerrainTiles, OfTwoRastersTheFinerLiesInTheCoarserWithoutAGap) {
    RasterLook coarse, fine;
    coarse.transform = {356000, 10, 0, 5700000, 0, -10};
    fine.transform = {356400, 1, 0, 5699500, 0, -1};
    const auto lower = openTerrain(writeRaster(
        "coarse", Heights2d(200, 150, [](int x, int y) { return 50.0 + 0.1 * x * y / 10; }),
        coarse));
    const auto upper = openTerrain(writeRaster("fine", roughHills(300, 260), fine));
    ASSERT_TRUE(lower && upper);
    const MadeTileset made = lower->tiles({upper}, {});
    Triangles all;
    for (const std::string& path : pathsAt(made, 0))
        all.add(contentOf(made, path));
    // Wherever the upper one has no ground, the lower one has.
    const GdalPlaces gdal(coarse);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> x(1.0, 198.0), y(1.0, 148.0);
    int looked = 0;
    for (int i = 0; i < 300; ++i) {
        const glm::dvec2 at(x(random), y(random));
        const glm::dvec2 place = gdal.lonLat(at.x, at.y);
        if (!std::isnan(upper->at(place)))
            continue;
        const Point<Ecef> p = ecefOf({place.x, place.y, lower->at(place)});
        EXPECT_TRUE(plumb(all.all, p.xyz, ellipsoidNormal(p).xyz)) << at.x << " " << at.y;
        ++looked;
    }
    EXPECT_GT(looked, 200);
}
