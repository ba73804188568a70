#include "streaming/terrain/terrain_data.h"
#include "tests/streaming/quantized_mesh_folders.h"

#include <ctime>

namespace gnomon {
namespace {

TEST(QuantizedMesh, VerticesLieWhereGeographicLibPutsThem) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf({{9, 530, 300}})));
    writeTiles(folder / "", {{9, 530, 300}});
    const auto terrain = opened(folder / "layer.json");
    const MadeTileset made = terrain->tiles({}, {});
    const auto content = made.maker->make("9/530/300", {});
    ASSERT_TRUE(content) << content.error().message();
    const auto tile = decodeQuantizedTile(fileBytes(folder / "9/530/300.terrain"), "t");
    const auto extent = extentOf({9, 530, 300}, false);
    std::vector<glm::dvec3> exact;
    for (std::size_t i = 0; i < tile->u.size(); ++i) {
        const glm::dvec2 at = lonLatOf({tile->u[i], tile->v[i]}, extent);
        exact.push_back(ecefOf({at.x, at.y, tile->heightMetres(tile->height[i])}).xyz);
    }
    std::size_t seen = 0;
    for (const Mesh& mesh : content->meshes) {
        const double rounding = std::sqrt(3.0) * mesh.radiusMetres * std::ldexp(1.0, -24);
        std::size_t skirts = 0;
        for (const glm::vec3& p : mesh.positions) {
            const glm::dvec3 at = mesh.origin.xyz + glm::dvec3(p);
            double nearest = 1e9;
            for (const glm::dvec3& e : exact)
                nearest = std::min(nearest, glm::length(e - at));
            seen += nearest <= rounding + 1e-8;
            skirts += nearest > rounding + 1e-8;
            ASSERT_LE(glm::length(glm::dvec3(p)), mesh.radiusMetres);
        }
        EXPECT_EQ(skirts, mesh.skirtTriangles ? 32u : 0u) << "only skirts lie elsewhere";
    }
    EXPECT_GE(seen, exact.size());
    EXPECT_EQ(content->facts.triangles, 128u);
    EXPECT_EQ(content->facts.format, "quantized-mesh");
}

TEST(QuantizedMesh, SkirtsHangOutwardFromAllFourSides) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf({{9, 530, 300}})));
    writeTiles(folder / "", {{9, 530, 300}});
    const auto content = opened(folder / "layer.json")->tiles({}, {}).maker->make("9/530/300", {});
    ASSERT_TRUE(content);
    std::uint32_t skirts = 0;
    for (const Mesh& mesh : content->meshes) {
        skirts += mesh.skirtTriangles;
        const glm::dvec3 up = ellipsoidNormal(mesh.origin).xyz;
        EXPECT_EQ(mesh.faceNormals.size(), mesh.triangles());
        EXPECT_EQ(mesh.closedTriangles, mesh.triangles() - mesh.skirtTriangles);
        for (std::uint32_t t = 0; t < mesh.triangles(); ++t) {
            glm::dvec3 p[3];
            for (std::size_t k = 0; k < 3; ++k)
                p[k] = glm::dvec3(mesh.positions[mesh.indices[3 * t + k]]);
            const glm::dvec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
            EXPECT_NEAR(glm::dot(normal, decodeOct(mesh.faceNormals[t])), 1.0, 1e-6);
            if (t < mesh.closedTriangles) {
                EXPECT_GT(glm::dot(normal, up), 0.9);
            } else {
                EXPECT_LT(std::abs(glm::dot(normal, up)), 0.1);
                // Away from the tile's middle, which is the one mesh's origin.
                EXPECT_GT(glm::dot(normal, p[0]), 0.0);
            }
        }
    }
    EXPECT_EQ(skirts, 4u * 8u * 2u);
}

TEST(QuantizedMesh, AMissingChildIsCutFromItsParentSoThatNoHoleIsSeen) {
    for (const bool packed : {false, true}) {
        const TemporaryFolder folder;
        PyramidSpec spec;
        spec.packed = packed;
        writeText(folder / "layer.json", layerText("\"available\":" + availableOf(kSparse)));
        writeTiles(folder / "", kSparse, spec);
        const Shown all = shown(opened(folder / "")->tiles({}, {}));
        EXPECT_TRUE(all.complete);
        EXPECT_TRUE(all.tileset->failures().empty());
        EXPECT_EQ(all.paths,
                  (std::vector<std::string>{"1/0/0", "1/0/1", "1/1/0", "1/1/1", "1/2/0", "1/3/0",
                                            "1/3/1", "2/4/2", "2/4/3", "2/5/2", "2/5/3"}));
        // One quarter, away from poles: cut and own tiles together cover what they should.
        std::vector<std::shared_ptr<const TileContent>> lower;
        const MadeTileset made = opened(folder / "")->tiles({}, {});
        for (const char* path : {"2/4/2", "2/5/2"}) {
            auto content = made.maker->make(path, {});
            ASSERT_TRUE(content);
            lower.push_back(std::make_shared<const TileContent>(std::move(*content)));
        }
        EXPECT_NEAR(squareDegrees(lower), 2 * 45.0 * 45.0, 1e-3);
        // A tile that none is cut from, deeper than any.
        EXPECT_TRUE(made.maker->make("9/530/300", {}));
        EXPECT_FALSE(made.maker->make("9/5300/300", {}));
        EXPECT_FALSE(made.maker->make("../1/2", {}));
    }
}

TEST(QuantizedMesh, ACutTileHasItsParentsHeights) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf({{8, 265, 150}})));
    writeTiles(folder / "", {{8, 265, 150}});
    const auto terrain = opened(folder / "");
    const auto cut = terrain->tiles({}, {}).maker->make("11/2123/1206", {});
    ASSERT_TRUE(cut) << cut.error().message();
    const auto extent = extentOf({11, 2123, 1206}, false);
    std::size_t looked = 0;
    for (const Mesh& mesh : cut->meshes)
        for (std::size_t i = 0; i < 3 * (mesh.triangles() - mesh.skirtTriangles); ++i) {
            const Geodetic g =
                geodeticOf({mesh.origin.xyz + glm::dvec3(mesh.positions[mesh.indices[i]])});
            EXPECT_GE(g.longitudeDegrees, extent[0] - 1e-7);
            EXPECT_LE(g.longitudeDegrees, extent[2] + 1e-7);
            EXPECT_GE(g.latitudeDegrees, extent[1] - 1e-7);
            EXPECT_LE(g.latitudeDegrees, extent[3] + 1e-7);
            // A cut's vertices run along the ellipsoid between those of a triangle 10 km wide.
            EXPECT_NEAR(g.heightMetres, terrain->at({g.longitudeDegrees, g.latitudeDegrees}), 12.0);
            ++looked;
        }
    EXPECT_GT(looked, 5u);
}

TEST(QuantizedMesh, SamplesLieOnTheTrianglesOfTheDeepestTile) {
    const TemporaryFolder folder;
    const Tiles tiles = {{7, 130, 70},  {8, 260, 140}, {8, 261, 140},
                         {8, 260, 141}, {8, 261, 141}, {9, 521, 281}};
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf(tiles)));
    PyramidSpec spec;
    spec.change = [](const QuantizedPlace& place, PlainTile& tile) {
        tile.minHeight += 1000.0f * float(place.level); // to tell levels apart
        tile.maxHeight += 1000.0f * float(place.level);
    };
    writeTiles(folder / "", tiles, spec);
    const auto terrain = opened(folder / "");
    const auto deep = extentOf({9, 521, 281}, false), middle = extentOf({8, 261, 141}, false);
    const glm::dvec2 in(deep[0] + 0.3 * (deep[2] - deep[0]), deep[1] + 0.7 * (deep[3] - deep[1]));
    const glm::dvec2 out(middle[0] + 0.9 * (middle[2] - middle[0]),
                         middle[1] + 0.1 * (middle[3] - middle[1]));
    EXPECT_NEAR(terrain->at(in), hills(in.x, in.y) + 9000.0, 15.0);
    EXPECT_NEAR(terrain->at(out), hills(out.x, out.y) + 8000.0, 15.0);
    EXPECT_TRUE(std::isnan(terrain->at({in.x + 10.0, in.y})));
    EXPECT_TRUE(std::isnan(terrain->at({std::nan(""), in.y})));
    EXPECT_NEAR(terrain->at({in.x + 360.0, in.y}), terrain->at(in), 1e-6);
    // Against the drawn mesh: on each triangle's middle to a hundredth of a millimetre.
    const auto content = terrain->tiles({}, {}).maker->make("9/521/281", {});
    ASSERT_TRUE(content);
    for (const Mesh& mesh : content->meshes)
        for (std::size_t i = 0; i < 3 * (mesh.triangles() - mesh.skirtTriangles); i += 3) {
            glm::dvec3 p = mesh.origin.xyz;
            for (std::size_t k = 0; k < 3; ++k)
                p += glm::dvec3(mesh.positions[mesh.indices[i + k]]) / 3.0;
            const Geodetic g = geodeticOf({p});
            EXPECT_NEAR(terrain->at({g.longitudeDegrees, g.latitudeDegrees}), g.heightMetres,
                        mesh.radiusMetres * std::ldexp(1.0, -23));
        }
}

TEST(QuantizedMesh, HeightsAboveTheGeoidAndRaisedOnesAreBroughtToTheEllipsoid) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf({{12, 4240, 3160}})));
    writeTiles(folder / "", {{12, 4240, 3160}});
    TerrainOptions options;
    options.heights = Heights::Egm96;
    options.raiseMetres = 3.0;
    const auto e = extentOf({12, 4240, 3160}, false);
    const glm::dvec2 p(0.5 * (e[0] + e[2]), 0.5 * (e[1] + e[3]));
    const auto plain = opened(folder / ""), raised = opened(folder / "", options);
    EXPECT_NEAR(raised->at(p) - plain->at(p), *egm96GeoidHeight(p.x, p.y) + 3.0, 0.02);
    EXPECT_NEAR(raised->facts().minHeightMetres - plain->facts().minHeightMetres,
                *egm96GeoidHeight(p.x, p.y) + 3.0, 1.0);
}

TEST(QuantizedMesh, ItMakesRoomForGroundAboveIt) {
    const TemporaryFolder folder;
    const QuantizedPlace place{13, 8480, 6320};
    writeText(folder / "layer.json",
              layerText("\"available\":" + availableOf({{place.level, place.x, place.y}})));
    PyramidSpec flat;
    flat.height = [](double, double) { return 100.0; };
    writeTiles(folder / "", {{place.level, place.x, place.y}}, flat);
    const auto e = extentOf(place, false);
    // Its middle ninth, ten metres higher.
    struct Middle : GroundHeights {
        std::array<double, 4> e;
        void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
            for (std::size_t i = 0; i < lonLat.size(); ++i) {
                const double x = (lonLat[i].x - e[0]) / (e[2] - e[0]);
                const double y = (lonLat[i].y - e[1]) / (e[3] - e[1]);
                const bool in = x > 1.0 / 3 && x < 2.0 / 3 && y > 1.0 / 3 && y < 2.0 / 3;
                heights[i] = in ? 110.0 : std::nan("");
            }
        }
    };
    auto middle = std::make_shared<Middle>();
    middle->e = e;
    const auto terrain = opened(folder / "");
    const MadeTileset made = terrain->tiles({middle}, {});
    auto content = made.maker->make(nameOf(place), {});
    ASSERT_TRUE(content);
    const double whole = (e[2] - e[0]) * (e[3] - e[1]);
    std::vector<std::shared_ptr<const TileContent>> one{
        std::make_shared<const TileContent>(std::move(*content))};
    // Cells of a 64th that touch its rim stay.
    EXPECT_NEAR(squareDegrees(one) / whole, 8.0 / 9.0, 4.0 / 3.0 * 1.5 / 64.0);
    EXPECT_GT(squareDegrees(one) / whole, 8.0 / 9.0);
    for (const Mesh& mesh : one[0]->meshes)
        for (const std::uint32_t i : std::span(mesh.indices).first(3 * mesh.closedTriangles)) {
            const double h =
                geodeticOf({mesh.origin.xyz + glm::dvec3(mesh.positions[i])}).heightMetres;
            EXPECT_TRUE(std::abs(h - 100.0) < 0.01 || std::abs(h - 110.0) < 0.01) << h;
        }
    // It is cut finer and finer where the other ground begins, and not where it lies alone.
    EXPECT_GT(made.tiles.size(), 20u);
    EXPECT_GT(made.tiles[0].geometricErrorMetres, 1.0);
    // What lies wholly under the other is drawn no more, and what is far from it is not cut.
    const auto under = made.maker->make(nameOf(place.child(3).child(0).child(0)), {});
    ASSERT_TRUE(under);
    EXPECT_TRUE(under->meshes.empty());
    const auto elsewhere = groundWithin(middle, {{{1, 1}, {2, 1}, {2, 2}}});
    const MadeTileset apart = terrain->tiles({elsewhere}, {});
    EXPECT_EQ(apart.tiles.size(), 1u);
    const auto uncut = apart.maker->make(nameOf(place), {});
    ASSERT_TRUE(uncut);
    EXPECT_EQ(uncut->facts.triangles, 128u);
}

TEST(QuantizedMesh, PicturesArePaintedOnItAndMakeItFiner) {
    const TemporaryFolder folder;
    const QuantizedPlace place{13, 8480, 6320};
    writeText(folder / "layer.json",
              layerText("\"available\":" + availableOf({{place.level, place.x, place.y}})));
    writeTiles(folder / "", {{place.level, place.x, place.y}});
    const auto e = extentOf(place, false);
    PictureSpec picture; // the western half, half a metre a pixel, red growing eastward
    picture.crs = "EPSG:4326";
    picture.width = 512;
    picture.height = 1024;
    picture.place = {e[0], 0.5 * (e[2] - e[0]) / 512, 0, e[3], 0, (e[1] - e[3]) / 1024};
    picture.value = [](int b, double x, double y) { return b == 1 ? x / 2 : b == 2 ? y / 4 : 9; };
    writePicture(folder / "p.tif", picture);
    std::vector<std::string> notes;
    const auto drape = openDrape(folder / "p.tif", {}, notes);
    ASSERT_TRUE(drape);
    const auto terrain = opened(folder / "");
    const MadeTileset made = terrain->tiles({}, {*drape});
    const auto content = made.maker->make(nameOf(place), {});
    ASSERT_TRUE(content);
    ASSERT_EQ(content->images.size(), 1u);
    EXPECT_EQ(content->materials[0].image, 0);
    const Image& image = content->images[0];
    // At each vertex of the western half the texel tells its place.
    std::size_t looked = 0;
    for (const Mesh& mesh : content->meshes) {
        ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            const Geodetic g = geodeticOf({mesh.origin.xyz + glm::dvec3(mesh.positions[i])});
            const double x = (g.longitudeDegrees - e[0]) / (e[2] - e[0]);
            const double y = (e[3] - g.latitudeDegrees) / (e[3] - e[1]);
            const int column = int(mesh.uvs[i].x * float(image.width));
            const int row = int(mesh.uvs[i].y * float(image.height));
            const std::uint8_t* t =
                &image.rgba[std::size_t(4 * (std::min(row, image.height - 1) * image.width +
                                             std::min(column, image.width - 1)))];
            if (x < 0.49) {
                EXPECT_NEAR(t[0], std::min(512.0 * 2 * x / 2, 255.0), 2.0);
                EXPECT_NEAR(t[1], std::min(1024.0 * y / 4, 255.0), 2.0);
                ++looked;
            } else if (x > 0.51) {
                EXPECT_EQ(t[2], int(std::lround(double(kTerrainColor.b) * 255.0)))
                    << "its own colour";
            }
        }
    }
    EXPECT_GT(looked, 30u);
    // Twice as fine a picture asks for finer tiles than there are.
    picture.width = 1024;
    picture.height = 2048;
    picture.place[1] /= 2;
    picture.place[5] /= 2;
    writePicture(folder / "q.tif", picture);
    const auto fine = openDrape(folder / "q.tif", {}, notes);
    ASSERT_TRUE(fine);
    const Shown all = shown(terrain->tiles({}, {*fine}));
    EXPECT_TRUE(all.complete);
    EXPECT_GT(all.paths.size(), 8u);
    EXPECT_LT(all.paths.size(), 30u);
}

TEST(QuantizedMesh, TheSamePathGivesTheSameBytes) {
    const TemporaryFolder folder;
    writeText(folder / "layer.json", layerText("\"available\":" + availableOf(kSparse)));
    writeTiles(folder / "", kSparse);
    const MadeTileset made = opened(folder / "")->tiles({}, {});
    DecodeOptions options;
    options.meshAxes = ecefFromEnu({10, 50, 0}).axes();
    for (const char* path : {"1/2/1", "2/4/3"}) {
        const auto a = made.maker->make(path, options), b = made.maker->make(path, options);
        ASSERT_TRUE(a && b);
        ASSERT_EQ(a->meshes.size(), b->meshes.size());
        for (std::size_t m = 0; m < a->meshes.size(); ++m) {
            EXPECT_EQ(a->meshes[m].positions, b->meshes[m].positions);
            EXPECT_EQ(a->meshes[m].indices, b->meshes[m].indices);
        }
        // Turned, but the same place.
        const auto plain = made.maker->make(path, {});
        ASSERT_TRUE(plain);
        EXPECT_NEAR(glm::length(a->meshes[0].box.centre.xyz - plain->meshes[0].box.centre.xyz) /
                        a->meshes[0].radiusMetres,
                    0.0, 0.1);
    }
}

TEST(QuantizedMesh, ALargeTileIsMadeInAFewMilliseconds) {
    const Bytes bytes = fileBytes(qmeshData("tile.32bitIndices.terrain"));
    if (bytes.empty())
        GTEST_SKIP() << "no " << qmeshData("tile.32bitIndices.terrain");
    const auto terrain = opened(qmeshData("tile.32bitIndices.terrain"));
    ASSERT_TRUE(terrain);
    const MadeTileset made = terrain->tiles({}, {});
    std::vector<double> times;
    for (int round = 0; round < 9; ++round) {
        timespec start{}, end{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &start);
        const auto content = made.maker->make("15/19297/23803", {});
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
        ASSERT_TRUE(content);
        ASSERT_EQ(content->facts.triangles + content->facts.degenerate, 131103u);
        times.push_back(double(end.tv_sec - start.tv_sec) * 1e3 +
                        double(end.tv_nsec - start.tv_nsec) * 1e-6);
    }
    std::sort(times.begin(), times.end());
    RecordProperty("median_ms", std::to_string(times[times.size() / 2]));
    // Some 12 ms with optimisation; sanitizers and busy machines take their share.
    EXPECT_LT(times[times.size() / 2], 320.0) << "slower than what it is to beat by far";
}

} // namespace
} // namespace gnomon
