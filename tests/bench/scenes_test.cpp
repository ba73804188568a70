#include "tests/bench/loaded_triangles.h"

#include "bench/scenes.h"

#include <map>
#include <memory>
#include <set>
#include <string>

using namespace gnomon;
using bench::BenchScene;
using bench::Probe;
using test::Loaded;

namespace {

constexpr double kNone = 1e300;

BenchScene open(const std::string& name, const std::optional<SunAngles>& sun = {}) {
    Result<BenchScene> scene = bench::openBenchScene(name, bench::kDefaultPlace, sun);
    EXPECT_TRUE(bool(scene)) << name << ": " << scene.error().message();
    return std::move(scene).value();
}

glm::dvec3 towards(const SunAngles& sun) {
    const double a = sun.azimuthDegrees * kRadiansPerDegree;
    const double e = sun.elevationDegrees * kRadiansPerDegree;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

// A scene under its own sun, opened and loaded once for all tests.
struct Opened {
    BenchScene scene;
    Loaded loaded;
};
Opened& opened(const std::string& name) {
    static std::map<std::string, std::unique_ptr<Opened>> all;
    std::unique_ptr<Opened>& one = all[name];
    if (!one) {
        one = std::make_unique<Opened>(Opened{open(name), {}});
        one->loaded = test::loadAll(one->scene.scene);
    }
    return *one;
}

double closedShare(const char* name) {
    const Loaded& loaded = opened(name).loaded;
    return double(loaded.closed) / double(loaded.triangles.size());
}

// Shares of the picture in which the camera's rays meet triangles, by a coarse grid of them.
double seenShare(const BenchScene& scene, const Loaded& loaded) {
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.scene.ecefFromAnchor);
    const Camera& c = scene.camera;
    const glm::dvec3 eye = anchorFromEcef(c.position).xyz;
    int hits = 0;
    constexpr int kAcross = 16, kDown = 9;
    for (int y = 0; y < kDown; ++y)
        for (int x = 0; x < kAcross; ++x) {
            const double u = (2.0 * x + 1.0) / kAcross - 1.0, v = 1.0 - (2.0 * y + 1.0) / kDown;
            const Vector<Ecef> d =
                c.forward + u * c.tanHalfWidth() * c.right + v * c.tanHalfHeight() * c.up;
            hits += test::firstHit(loaded.triangles, eye, glm::normalize(anchorFromEcef(d).xyz)) <
                    kNone;
        }
    return double(hits) / (kAcross * kDown);
}

bool inPicture(const BenchScene& scene, const glm::dvec3& p) {
    const Camera& c = scene.camera;
    const Vector<Ecef> d = scene.scene.ecefFromAnchor(Point<Enu>{p}) - c.position;
    const double depth = dot(d, c.forward);
    return depth > 0.0 && std::abs(dot(d, c.right)) < depth * c.tanHalfWidth() &&
           std::abs(dot(d, c.up)) < depth * c.tanHalfHeight();
}

// The whole sun is seen, none of it, or some.
enum class Light { Lit, Dark, Between };
Light lightAt(const Loaded& loaded, const glm::dvec3& p, const glm::dvec3& sun) {
    const glm::dvec3 side = glm::normalize(glm::cross(sun, glm::dvec3(0.3, 0.5, 0.8)));
    const glm::dvec3 up = glm::cross(side, sun);
    const double radius = std::tan(0.5 * kSunDiameterDegrees * kRadiansPerDegree);
    int lit = 0;
    constexpr int kRays = 16;
    for (int i = 0; i < kRays; ++i) {
        const double a = 2.0 * 3.14159265358979 * i / kRays;
        const glm::dvec3 to =
            glm::normalize(sun + radius * (std::cos(a) * side + std::sin(a) * up));
        lit += test::firstHit(loaded.triangles, p, to, 1e-6) == kNone;
    }
    return lit == kRays ? Light::Lit : lit == 0 ? Light::Dark : Light::Between;
}

void checkOnSurface(const Loaded& loaded, const Probe& probe) {
    for (const glm::dvec3& p : {probe.from, probe.to})
        EXPECT_NEAR(test::firstHit(loaded.triangles, p + glm::dvec3(0, 0, 0.02), {0, 0, -1}), 0.02,
                    2e-3);
}

void checkPenumbra(const Loaded& loaded, const Probe& probe, const glm::dvec3& sun) {
    const glm::dvec3 lift(0, 0, 1e-4), middle = 0.5 * (probe.from + probe.to);
    EXPECT_EQ(lightAt(loaded, probe.from + lift, sun), Light::Lit);
    EXPECT_EQ(lightAt(loaded, probe.to + lift, sun), Light::Dark);
    EXPECT_EQ(lightAt(loaded, middle + lift, sun), Light::Between);
    // A little into the shadow the ray to the sun's centre meets the blocker at the stated gap.
    const double width = probe.gapMetres * kSunDiameterDegrees * kRadiansPerDegree;
    const glm::dvec3 inside = middle + 0.2 * width * glm::normalize(probe.to - probe.from);
    const double gap = test::firstHit(loaded.triangles, inside + lift, sun, 1e-6);
    EXPECT_LT(gap, kNone);
    // It meets the blade's face, not the edge itself; the blade is 10 cm thick.
    EXPECT_NEAR(gap, probe.gapMetres, 0.02 * probe.gapMetres + 0.2);
    // Light comes back once and not again: no second shadow is near.
    EXPECT_EQ(lightAt(loaded, 1.2 * (probe.from - middle) + middle + lift, sun), Light::Lit);
}

void checkContact(const Loaded& loaded, const Probe& probe, const glm::dvec3& sun) {
    // Dark from the foot on, to the end.
    for (const double t : {0.003, 0.02, 0.1, 0.5, 1.0})
        EXPECT_EQ(lightAt(loaded, glm::mix(probe.from, probe.to, t) + glm::dvec3(0, 0, 1e-4), sun),
                  Light::Dark)
            << t;
    // Behind the foot stands the occluder.
    const glm::dvec3 back = glm::normalize(probe.from - probe.to);
    EXPECT_LT(
        test::firstHit(loaded.triangles, probe.from - 0.05 * back + glm::dvec3(0, 0, 0.01), back),
        0.051);
}

std::size_t checkProbes(const BenchScene& scene, const Loaded& loaded) {
    for (const Probe& probe : scene.probes) {
        checkOnSurface(loaded, probe);
        if (probe.kind == Probe::Kind::Penumbra)
            checkPenumbra(loaded, probe, towards(scene.sun));
        else
            checkContact(loaded, probe, towards(scene.sun));
    }
    return scene.probes.size();
}

} // namespace

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, OpensStandsAtItsPlaceAndFillsItsPicture) {
    auto& [scene, loaded] = opened(GetParam());
    EXPECT_TRUE(scene.scene.problems.empty());
    const Geodetic& anchor = scene.scene.anchor;
    EXPECT_NEAR(anchor.longitudeDegrees, bench::kDefaultPlace.longitudeDegrees, 1e-9);
    EXPECT_NEAR(anchor.latitudeDegrees, bench::kDefaultPlace.latitudeDegrees, 1e-9);
    EXPECT_NEAR(anchor.heightMetres, bench::kDefaultPlace.heightMetres, 1e-6);

    EXPECT_TRUE(scene.scene.layers[0].tileset->failures().empty());
    for (const auto& content : loaded.contents) {
        EXPECT_TRUE(content->facts.warnings.empty());
        EXPECT_EQ(content->facts.duplicates, 0u);
        EXPECT_EQ(content->facts.degenerate, 0u);
    }
    EXPECT_GT(loaded.triangles.size(), 30u);
    EXPECT_GT(seenShare(scene, loaded), 0.3);
    EXPECT_EQ(scene.camera.widthPixels, 1280);
    EXPECT_EQ(scene.camera.heightPixels, 720);
    EXPECT_FALSE(scene.frame.groundAuto);
}

TEST_P(EveryScene, TellsTheSameToWhoOpensItAsAnyOther) {
    const BenchScene scene = open(GetParam(), SunAngles{123, 7});
    EXPECT_EQ(scene.sun.azimuthDegrees, 123);
    ASSERT_TRUE(scene.scene.sun && scene.scene.camera && scene.scene.ground);
    EXPECT_EQ(scene.scene.sun->elevationDegrees, 7);
    EXPECT_EQ(scene.scene.ground->heightMetres, scene.frame.groundHeightMetres);
    Camera camera;
    place(camera, scene.scene.camera->position, scene.scene.camera->orientation);
    EXPECT_LT(length(camera.position - scene.camera.position), 1e-6);
    EXPECT_LT(length(camera.forward - scene.camera.forward), 1e-9);
    EXPECT_LT(length(camera.up - scene.camera.up), 1e-9);
}

namespace {

std::vector<std::string> madeScenes() {
    std::vector<std::string> names;
    for (const bench::SceneDescription& scene : bench::sceneDescriptions())
        if (std::string(scene.name) != "place")
            names.push_back(scene.name);
    return names;
}

std::string testName(const testing::TestParamInfo<std::string>& info) {
    std::string name = info.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, testing::ValuesIn(madeScenes()), testName);

TEST(Scenes, AreAllThereUnderTheirNames) {
    std::set<std::string> names;
    for (const bench::SceneDescription& scene : bench::sceneDescriptions()) {
        names.insert(scene.name);
        EXPECT_EQ(std::string(scene.about).find('\n'), std::string::npos);
    }
    const std::set<std::string> wanted{
        "l-shape",     "double-torus",  "factory",      "floor-wall-spheres",
        "table-floor", "wall-near-eye", "lamp-room",    "ceiling-lamp",
        "house-row",   "bridge",        "trees",        "shed",
        "tower",       "ridge",         "contact-wall", "place"};
    EXPECT_EQ(names, wanted);
}

TEST(Scenes, AnUnknownNameIsAUsageErrorThatNamesThem) {
    const Result<BenchScene> scene = bench::openBenchScene("teapot");
    ASSERT_FALSE(bool(scene));
    EXPECT_EQ(scene.error().kind, ErrorKind::Usage);
    EXPECT_NE(scene.error().message().find("double-torus"), std::string::npos);
    EXPECT_EQ(scene.error().message().find('\n'), std::string::npos);
}

TEST(Scenes, ThePlaceOpensWithoutItsFolder) {
    auto& [scene, loaded] = opened("place");

    EXPECT_GT(loaded.triangles.size(), 100000u);
    EXPECT_TRUE(scene.scene.layers[0].tileset->failures().empty());
    EXPECT_GT(seenShare(scene, loaded), 0.3);
}

TEST(Scenes, SolidsAreClosedAndSheetsAreOpen) {
    for (const char* name :
         {"l-shape", "double-torus", "floor-wall-spheres", "table-floor", "wall-near-eye",
          "lamp-room", "ceiling-lamp", "house-row", "bridge", "tower"})
        EXPECT_EQ(closedShare(name), 1.0) << name;
    EXPECT_GT(closedShare("factory"), 0.9); // and its sheets
    EXPECT_LT(closedShare("factory"), 1.0);
    EXPECT_GT(closedShare("trees"), 0.9);
    EXPECT_LT(closedShare("trees"), 1.0);
}

TEST(Scenes, OnlyThePostsOfTheShedsAreClosed) {
    auto& [scene, loaded] = opened("shed");

    // A closed pipe of 10 sides has 36 triangles; there are six posts.
    EXPECT_EQ(loaded.closed, 6u * 36u);
    EXPECT_GT(loaded.triangles.size() - loaded.closed, 100u);
}

TEST(Scenes, AmongTheContactWallsOneLacksItsUndersideAndOneIsASheet) {
    auto& [scene, loaded] = opened("contact-wall");

    EXPECT_EQ(loaded.closed, 5u * 12u); // the floor and four boxes
    EXPECT_EQ(loaded.triangles.size() - loaded.closed, 10u + 2u);
}

TEST(Scenes, TheDoubleTorusHasTwoHoles) {
    auto& [scene, loaded] = opened("double-torus");

    std::set<std::array<double, 3>> vertices;
    std::uint64_t faces = 0;
    for (const auto& triangle : loaded.triangles) {
        if (triangle[0].z < 0.11 && triangle[1].z < 0.11 && triangle[2].z < 0.11)
            continue; // the floor
        ++faces;
        for (const glm::dvec3& p : triangle) // to 0.1 mm: meshes have origins of their own
            vertices.insert({std::round(p.x * 1e4), std::round(p.y * 1e4), std::round(p.z * 1e4)});
    }
    EXPECT_GT(faces, 20000u);
    // Euler: V - E + F = 2 - 2 g, and E = 1.5 F where all is closed.
    const auto euler = std::int64_t(vertices.size()) - std::int64_t(faces / 2);
    EXPECT_EQ(euler, 2 - 2 * 2);
}

TEST(Scenes, LeavesAreCutOutOfTheirPicture) {
    auto& [scene, loaded] = opened("trees");

    std::size_t leaves = 0;
    for (const auto& content : loaded.contents)
        for (const Mesh& mesh : content->meshes) {
            const Material& material = content->materials[std::size_t(mesh.material)];
            if (!material.alphaTest)
                continue;
            leaves += mesh.triangles();
            ASSERT_GE(material.image, 0);
            ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
            const Image& image = content->images[std::size_t(material.image)];
            std::size_t solid = 0;
            for (std::size_t i = 3; i < image.rgba.size(); i += 4)
                solid += image.rgba[i] >= 128;
            const double share = double(solid) / (double(image.width) * image.height);
            EXPECT_GT(share, 0.2);
            EXPECT_LT(share, 0.7);
        }
    EXPECT_GT(leaves, 50u);
}

TEST(Scenes, LampsHangFreeInTheirRooms) {
    for (const char* name : {"lamp-room", "ceiling-lamp"}) {
        auto& [scene, loaded] = opened(name);
        ASSERT_EQ(scene.scene.lamps.size(), 1u) << name;
        EXPECT_LT(scene.sun.elevationDegrees, -5.0);
        EXPECT_TRUE(scene.probes.empty());
        const Lamp& lamp = scene.scene.lamps[0];
        EXPECT_NEAR(length(lamp.facing), name == std::string("ceiling-lamp") ? 1.0 : 0.0, 1e-12);

        const glm::dvec3 at = rigidInverse(scene.scene.ecefFromAnchor)(lamp.position).xyz;
        // Walls all round within its range, nothing nearer than its own housing, but for the
        // ceiling that it hangs from.
        for (int i = 0; i < 400; ++i) {
            const double z = -1.0 + (i + 0.5) / 200.0, a = 2.399963 * i;
            const double across = std::sqrt(1.0 - z * z);
            const double d = test::firstHit(loaded.triangles, at,
                                            {across * std::cos(a), across * std::sin(a), z});
            EXPECT_LT(d, lamp.rangeMetres);
            EXPECT_GE(d, lamp.nearMetres - 1e-9);
        }
    }
}

TEST(Scenes, TheTowersProbesHaveTheGapsTheyName) {
    auto& [scene, loaded] = opened("tower");
    ASSERT_EQ(checkProbes(scene, loaded), 12u);
    const double gaps[] = {5, 10, 20, 50, 100, 200};
    for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(scene.probes[2 * i].gapMetres, gaps[i], 1e-3);
        for (const std::size_t k : {2 * i, 2 * i + 1}) {
            EXPECT_TRUE(inPicture(scene, scene.probes[k].from)) << k;
            EXPECT_TRUE(inPicture(scene, scene.probes[k].to)) << k;
        }
    }
}

TEST(Scenes, TheTowersProbesFollowTheSun) {
    for (const SunAngles sun : {SunAngles{180, 30}, SunAngles{165, 65}, SunAngles{5, 40}}) {
        BenchScene scene = open("tower", sun);
        EXPECT_GE(checkProbes(scene, test::loadAll(scene.scene)), 2u)
            << sun.azimuthDegrees << ", " << sun.elevationDegrees;
    }
    EXPECT_TRUE(open("tower", SunAngles{180, -5}).probes.empty());
}

TEST(Scenes, ContactProbesLieInTheShadowFromTheFootOn) {
    for (const std::optional<SunAngles>& sun :
         {std::optional<SunAngles>(), std::optional(SunAngles{150, 15}),
          std::optional(SunAngles{10, 60})}) {
        BenchScene scene = open("contact-wall", sun);
        ASSERT_EQ(checkProbes(scene, test::loadAll(scene.scene)), 6u);
        for (const Probe& probe : scene.probes) {
            EXPECT_EQ(probe.kind, Probe::Kind::Contact);
            EXPECT_TRUE(sun || (inPicture(scene, probe.from) && inPicture(scene, probe.to)));
        }
    }
}

TEST(Scenes, ProbesOfTheOtherScenesHold) {
    for (const char* name : {"l-shape", "table-floor"}) {
        SCOPED_TRACE(name);
        const auto& [scene, loaded] = opened(name);
        EXPECT_GE(checkProbes(scene, loaded), name == std::string("l-shape") ? 1u : 2u);
        for (const Probe& probe : scene.probes)
            EXPECT_TRUE(inPicture(scene, 0.5 * (probe.from + probe.to)));
    }
}

TEST(Scenes, TheRidgesShadowEndsAmongTheHouses) {
    auto& [scene, loaded] = opened("ridge");
    const glm::dvec3 sun = towards(scene.sun);
    int lit = 0, dark = 0;
    for (int i = 0; i < 40; ++i) { // along the villages, high enough to see over the houses
        const glm::dvec3 p(-500.0 + 150.0 * i, 40.0 * ((i * 7) % 11 - 5), 60.0);
        const double hit = test::firstHit(loaded.triangles, p, sun);
        lit += hit == kNone;
        if (hit < kNone) {
            ++dark;
            EXPECT_GT(hit, 8000.0); // the blocker is many kilometres away
        }
    }
    EXPECT_GT(lit, 8);
    EXPECT_GT(dark, 8);
}
