#include "viewer/overlay_facts.h"

#include "tests/frame/fake_water.h"
#include "tests/viewer/files.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;

namespace {

constexpr Geodetic kPlace{6.96, 50.94, 50.0};

// As high as a function of the metres north of kPlace says.
class Slope : public GroundHeights {
  public:
    explicit Slope(std::function<double(double)> height) : height_(std::move(height)) {}
    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        constexpr double kMetresPerDegree = 111250.0; // of latitude, there
        for (std::size_t i = 0; i < lonLat.size(); ++i)
            heights[i] = height_((lonLat[i].y - kPlace.latitudeDegrees) * kMetresPerDegree);
    }

  private:
    std::function<double(double)> height_;
};

Scene sceneAt(std::shared_ptr<const GroundHeights> ground) {
    Scene scene;
    scene.anchor = kPlace;
    scene.ecefFromAnchor = ecefFromEnu(kPlace);
    scene.groundHeights = std::move(ground);
    return scene;
}

WaterLayer water(const Scene& scene, const std::string& uri, test::FakeWater::Shape shape = {}) {
    WaterLayer layer;
    layer.uri = uri;
    layer.surface = std::make_shared<test::FakeWater>(scene.ecefFromAnchor, std::move(shape));
    return layer;
}

} // namespace

TEST(GroundAtCentre, IsWhereTheAxisMeetsTheTerrain) {
    const std::vector<std::function<double(double)>> grounds{
        [](double) { return 50.0; }, [](double) { return -20.0; },
        [](double north) { return 50.0 + 0.35 * north; },
        [](double north) { return 50.0 - 0.3 * north; },
        [](double north) { return 60.0 + 8.0 * std::sin(north / 40.0); }};
    for (const auto& ground : grounds)
        for (const Orientation& orientation :
             {Orientation{0, -89, 0}, {0, -45, 0}, {180, -30, 0}, {60, -25, 10}}) {
            const Scene scene = sceneAt(std::make_shared<Slope>(ground));
            Camera camera;
            place(camera, {6.96, 50.94, 450.0}, orientation);
            const auto at = groundAtCentre(camera, scene, {});
            ASSERT_TRUE(at) << orientation.pitchDegrees;
            const glm::dvec3 to = at->xyz - camera.position.xyz;
            const double distance = glm::length(to);
            EXPECT_NEAR(glm::dot(to, camera.forward.xyz), distance, 1e-6 * distance);
            const Geodetic found = geodeticOf(*at);
            const double height =
                scene.groundHeights->at({found.longitudeDegrees, found.latitudeDegrees});
            EXPECT_NEAR(found.heightMetres, height, 1e-4 * distance) << orientation.pitchDegrees;
        }
}

TEST(GroundAtCentre, IsOnTheFlatGroundWhereNoTerrainIs) {
    const Scene bare = sceneAt(nullptr);
    const Scene hole = sceneAt(std::make_shared<Slope>([](double) { return double(NAN); }));
    Camera camera;
    place(camera, {6.96, 50.94, 450.0}, {0, -60, 0});
    for (const Scene* scene : {&bare, &hole}) {
        EXPECT_NEAR(geodeticOf(*groundAtCentre(camera, *scene, {})).heightMetres, 50.0, 0.1);
        EXPECT_NEAR(geodeticOf(*groundAtCentre(camera, *scene, 20.0)).heightMetres, 20.0, 0.1);
    }
}

TEST(GroundAtCentre, IsNoneWhenTheCameraLooksPastTheEarth) {
    const Scene scene = sceneAt(nullptr);
    Camera camera;
    for (const double pitch : {0.0, 20.0, 90.0}) {
        place(camera, {6.96, 50.94, 450.0}, {0, pitch, 0});
        EXPECT_FALSE(groundAtCentre(camera, scene, {})) << pitch;
    }
}

TEST(OverlayFacts, HaveALegendForEveryWaterThatIsColouredByNumber) {
    Scene scene = sceneAt(nullptr);
    scene.waters.push_back(water(scene, "a/flood.nc"));
    scene.waters.push_back(water(scene, "b/river.nc"));
    scene.waters.back().look.colors = WaterColors::Speed;
    scene.waters.push_back(water(scene, "c/sea.nc"));
    scene.waters.back().look.colors = WaterColors::Natural;
    const std::vector<Legend> legends = overlayFactsOf(scene).legends;
    ASSERT_EQ(legends.size(), 2u);
    EXPECT_EQ(legends[0], (Legend{"Water depth", "m", 0, 4, ColorMap::Depth, false, false}));
    EXPECT_EQ(legends[1], (Legend{"Water speed", "m/s", 0, 2, ColorMap::Speed, false, false}));
}

TEST(OverlayFacts, SayWhenTheLastColourStandsForMore) {
    Scene scene = sceneAt(nullptr);
    scene.waters.push_back(water(scene, "flood.nc"));
    scene.waters.back().look.most = 2.5; // the deepest is 4
    EXPECT_TRUE(overlayFactsOf(scene).legends[0].beyond);
    scene.waters.back().look.most = 5.0;
    EXPECT_FALSE(overlayFactsOf(scene).legends[0].beyond);
}

TEST(OverlayFacts, HaveOneLegendForLayersThatAgreeAndNameThoseThatDoNot) {
    Scene scene = sceneAt(nullptr);
    scene.waters.push_back(water(scene, "a/flood.nc"));
    scene.waters.push_back(water(scene, "b/flood.nc"));
    ASSERT_EQ(overlayFactsOf(scene).legends.size(), 1u);
    scene.waters.push_back(water(scene, "c/river.nc"));
    scene.waters.back().look.most = 9.0;
    const std::vector<Legend> legends = overlayFactsOf(scene).legends;
    ASSERT_EQ(legends.size(), 2u);
    EXPECT_EQ(legends[0].title, "Water depth, flood.nc");
    EXPECT_EQ(legends[1].title, "Water depth, river.nc");
}

TEST(OverlayFacts, HaveTheTimesOfAFloodOfSeveralSteps) {
    Scene scene = sceneAt(nullptr);
    EXPECT_FALSE(overlayFactsOf(scene).flood);
    scene.waters.push_back(water(scene, "flood.nc"));
    const auto flood = overlayFactsOf(scene).flood;
    ASSERT_TRUE(flood);
    EXPECT_EQ(flood->first.seconds, 0.0);
    EXPECT_EQ(flood->last.seconds, 120.0);
}

TEST(OverlayFacts, TellTheTimeByTheZoneThatWasWrittenNearestToTheUser) {
    const test::Folder folder;
    Scene scene = sceneAt(nullptr);
    scene.time = *parseTime("2021-07-14T16:00Z");
    PictureOptions options;
    const auto zone = [&] {
        OverlayFacts facts;
        setMoment(facts, scene, Shots::create(options)->at(0.0, scene), {});
        EXPECT_TRUE(facts.time);
        return facts.timeZone;
    };
    options.camera = FixedCamera{{6.96, 50.94, 400}, {0, -90, 0}};
    EXPECT_EQ(zone(), std::nullopt);
    scene.timeZone = "Europe/Berlin";
    EXPECT_EQ(zone(), "Europe/Berlin");
    options.camera = CameraFile{folder.write("p.json", R"({"keyframes":[
        {"t":0,"lon":6.96,"lat":50.94,"height":300,"heading":0,"pitch":0,"time":"2021-07-14T16:00Z"},
        {"t":9,"lon":6.96,"lat":50.94,"height":300,"heading":0,"pitch":0,"time":"2021-07-14T20:00+02:00"}]})")};
    EXPECT_EQ(zone(), "+02:00");
    options.timeZone = "America/Chicago";
    EXPECT_EQ(zone(), "America/Chicago");
}
