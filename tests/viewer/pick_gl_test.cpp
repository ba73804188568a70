#include "viewer/pick.h"

#include "tests/frame/small_scene.h"
#include "tests/viewer/houses_support.h"

#include <gtest/gtest.h>

namespace gnomon {

using namespace test;

namespace {

const std::vector<House> kHouses = {
    {{-30, -5, 0}, {-20, 5, 10}, 1}, {{-5, -5, 0}, {5, 5, 14}, 0}, {{20, -5, 0}, {30, 5, 8}, -1}};

struct City {
    City() {
        folder.write("houses.b3dm", housesB3dm(kHouses, {"centre", "west"}));
        const Json tileset = {{"asset", {{"version", "1.0"}, {"gltfUpAxis", "Z"}}},
                              {"geometricError", 100},
                              {"root",
                               {{"boundingVolume", boxVolume({-40, -10, 0}, {40, 10, 20})},
                                {"geometricError", 0},
                                {"refine", "ADD"},
                                {"transform", transformAt(kHousesPlace)},
                                {"content", {{"uri", "houses.b3dm"}}}}}};
        SceneOptions open;
        open.inputs = {folder.write("tileset.json", tileset.dump())};
        scene = std::make_unique<Scene>(mustOpen(open));
        FrameOptions options;
        options.shadows.method = ShadowMethod::Off;
        options.groundAuto = false;
        options.groundHeightMetres = kHousesPlace.heightMetres;
        renderer = std::move(FrameRenderer::create(softwareContext(), *scene, options)).value();
    }
    Camera draw(const Look& look) {
        FrameRequest request;
        request.camera = cameraFor(ecefFromEnu(kHousesPlace), look);
        request.sun = sunFromAngles(140, 40, kHousesPlace);
        request.deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        const auto facts = renderer->draw(request);
        EXPECT_TRUE(facts && facts->complete);
        return request.camera;
    }

    Folder folder;
    std::unique_ptr<Scene> scene;
    std::unique_ptr<FrameRenderer> renderer;
};

// The house whose box holds a point, to a centimetre; none: it is the ground.
const House* houseAt(const glm::dvec3& p) {
    constexpr float kSlack = 0.01f;
    for (const House& house : kHouses) {
        if (glm::all(glm::greaterThan(glm::vec3(p), house.low - kSlack)) &&
            glm::all(glm::lessThan(glm::vec3(p), house.high + kSlack)) && p.z > kSlack) {
            return &house;
        }
    }
    return nullptr;
}

} // namespace

TEST(Pick, NamesTheHouseUnderEveryPixel) {
    City city;
    const Camera camera = city.draw({{-10, -80, 45}, {0, 0, 5}, 50.0, 160, 90});
    const Transform<Enu, Ecef> placeFromEcef = rigidInverse(ecefFromEnu(kHousesPlace));
    std::map<std::string, int> pixels;
    for (int y = 1; y < 90; y += 2) {
        for (int x = 1; x < 160; x += 2) {
            const auto picked = pick(*city.renderer, camera, x, y);
            if (!picked) {
                ++pixels["sky"];
                continue;
            }
            const glm::dvec3 p = placeFromEcef(picked->at).xyz;
            const House* house = houseAt(p);
            if (!house) {
                EXPECT_NEAR(geodeticOf(picked->at).heightMetres, kHousesPlace.heightMetres, 0.05);
                EXPECT_EQ(picked->tile, 0u);
                EXPECT_EQ(picked->feature, kNoFeature);
                EXPECT_TRUE(picked->properties.empty());
                ++pixels["ground"];
                continue;
            }
            EXPECT_NE(picked->tile, 0u);
            EXPECT_NE(city.renderer->tileNames()[picked->tile].find("houses.b3dm"),
                      std::string::npos);
            const std::uint32_t feature =
                house->feature < 0 ? kNoFeature : std::uint32_t(house->feature);
            ASSERT_EQ(picked->feature, feature) << x << ' ' << y;
            EXPECT_EQ(picked->id, feature == 0 ? "centre" : feature == 1 ? "west" : "");
            EXPECT_EQ(picked->properties.size(), feature == kNoFeature ? 0u : 1u);
            ++pixels[picked->id];
        }
    }
    for (const char* seen : {"ground", "centre", "west", ""}) {
        EXPECT_GT(pixels[seen], 20) << seen;
    }
}

TEST(Pick, TheSkyAndPixelsOutsideThePictureAreNothing) {
    City city;
    const Camera camera = city.draw({{0, -80, 5}, {0, 0, 40}, 45.0, 64, 48});
    EXPECT_FALSE(pick(*city.renderer, camera, 32, 1));
    EXPECT_TRUE(pick(*city.renderer, camera, 32, 47));
    EXPECT_FALSE(pick(*city.renderer, camera, -1, 10));
    EXPECT_FALSE(pick(*city.renderer, camera, 64, 10));
    EXPECT_FALSE(pick(*city.renderer, camera, 10, 48));
}

TEST(Pick, UnderWaterTheFeatureIsWhatLiesBelowIt) {
    auto content = test::decode(housesGlb({{{-5, -5, -5}, {5, 5, 5}, 4}}));
    ASSERT_TRUE(content);
    Camera camera;
    camera.position = {{0, 0, 50}}; // looks down
    const std::vector<ResidentTile> tiles = {
        {std::make_shared<const TileContent>(std::move(*content)), 7}};
    PixelFacts pixel{640.0, 360.0, 7, 40.0};
    const auto picked = pick(camera, pixel, tiles, glm::dmat3(1.0));
    ASSERT_TRUE(picked);
    EXPECT_NEAR(picked->at.xyz.z, 10.0, 1e-9) << "the water's";
    EXPECT_EQ(picked->feature, 4u);
    pixel.depthMetres = 70.0; // behind all there is
    EXPECT_EQ(pick(camera, pixel, tiles, glm::dmat3(1.0))->feature, kNoFeature);
    pixel.tile = 8; // not there any more
    EXPECT_EQ(pick(camera, pixel, tiles, glm::dmat3(1.0))->feature, kNoFeature);
}

} // namespace gnomon
