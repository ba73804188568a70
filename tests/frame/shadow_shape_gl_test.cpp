// Shadows fall where geometry says, held against rays in double.
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

Shapes tenMetreBox() {
    Shapes shapes;
    shapes.box({-5, -5, 0}, {5, 5, 10});
    return shapes;
}

ShadowSettings filtered(ShadowFilter filter, ShadowFit fit = ShadowFit::Stable) {
    ShadowSettings s;
    s.filter = filter;
    s.fit = fit;
    return s;
}

// From the sunlit side, the shadow's whole length in view.
Look alongTheShadow(double azimuth, double elevation) {
    const double length =
        std::min(10.0 / std::tan(std::max(elevation, 1.0) * kRadiansPerDegree), 200.0);
    const glm::dvec3 away = -enuDirection(azimuth, 0.0);
    const glm::dvec3 side(away.y, -away.x, 0.0);
    const double distance = 30.0 + 0.8 * length;
    return {0.5 * length * away + distance * 0.8 * side + glm::dvec3(0, 0, 0.7 * distance),
            0.5 * length * away};
}

} // namespace

TEST(Shadow, OfABoxFallsWhereGeometrySays) {
    for (const ShadowSettings& settings :
         {filtered(ShadowFilter::Pcss), filtered(ShadowFilter::Bilinear),
          filtered(ShadowFilter::Pcss, ShadowFit::Tight)}) {
        SmallScene scene(tenMetreBox(), {kCologne, true, settings});
        Compared all;
        for (const double elevation : {3.0, 30.0, 60.0, 85.0, 90.0})
            for (const double azimuth : {0.0, 77.0, 200.0}) {
                const Shot shot =
                    scene.draw(alongTheShadow(azimuth, elevation), azimuth, elevation);
                const Compared c = compare(shot, scene.rays(azimuth, elevation),
                                           {10.0, 2.0, settings.filter == ShadowFilter::Pcss});
                EXPECT_EQ(c.falseLit, 0u) << elevation << " " << azimuth;
                EXPECT_EQ(c.falseShadow, 0u) << elevation << " " << azimuth;
                EXPECT_EQ(c.falseAway, 0u);
                EXPECT_EQ(c.worstLit, 1.0) << elevation << " " << azimuth;
                EXPECT_EQ(c.worstDark, 0.0) << elevation << " " << azimuth;
                if (elevation < 80.0) {
                    EXPECT_GT(c.dark, 300u) << elevation;
                }
                EXPECT_LT(double(c.edge), 0.05 * double(c.compared()))
                    << elevation << " " << azimuth;
                all += c;
            }
        std::printf("[ measured ] lit %zu, dark %zu, edge %zu, turned away %zu\n", all.lit,
                    all.dark, all.edge, all.turnedAway);
    }
}

TEST(Shadow, OfManyShapesFallsWhereGeometrySays) {
    Shapes shapes = tenMetreBox();
    shapes.house({20, -6}, {30, 8}, 5, 9);
    shapes.dome({-20, 10}, 6);
    shapes.box({-30, -25, 0}, {30, -24.7, 4});                     // a wall
    shapes.quad({8, 14, 0}, {18, 14, 0}, {18, 14, 6}, {8, 14, 6}); // a sheet
    shapes.box({-12, 24, 5}, {12, 30, 5.5});                       // a plate in the air
    SmallScene scene(shapes);
    Compared all;
    for (const double elevation : {3.0, 15.0, 30.0, 60.0, 85.0})
        for (const double azimuth : {30.0, 150.0, 285.0})
            for (const Look& look : {Look{{-55, -60, 40}, {0, 0, 0}}, Look{{0, 45, 1.7}, {2, 0, 6}},
                                     Look{{0, 1, 140}, {0, 0, 0}}}) {
                const Compared c = compare(scene.draw(look, azimuth, elevation),
                                           scene.rays(azimuth, elevation), {10.0, 2.0, true});
                EXPECT_EQ(c.falseLit, 0u) << elevation << " " << azimuth << " " << look.eye.z;
                EXPECT_EQ(c.falseShadow, 0u) << elevation << " " << azimuth << " " << look.eye.z;
                EXPECT_EQ(c.falseAway, 0u);
                all += c;
            }
    EXPECT_GT(all.dark, 40000u);
    EXPECT_LT(double(all.edge), 0.1 * double(all.compared()));
    std::printf("[ measured ] lit %zu, dark %zu, edge %zu, worst lit %.4f, worst dark %.4f\n",
                all.lit, all.dark, all.edge, all.worstLit, all.worstDark);
}

TEST(Shadow, OfACasterOutsideThePictureFalls) {
    Shapes shapes;
    shapes.box({-3, -80, 0}, {3, -74, 60}); // behind the camera
    shapes.box({-1, 30, 0}, {1, 32, 2});    // something to look at
    SmallScene scene(shapes);
    const Look look{{0, -40, 12}, {0, 20, 0}};
    for (const double elevation : {20.0, 30.0}) {
        const Shot shot = scene.draw(look, 180, elevation);
        const Compared c = compare(shot, scene.rays(180, elevation), {60.0, 2.0, true});
        EXPECT_GT(c.dark, 1500u);
        EXPECT_EQ(c.falseLit, 0u);
        EXPECT_EQ(c.falseShadow, 0u);
    }
}

TEST(Shadow, OfACasterInATileThatThePictureNeverSeesFalls) {
    Shapes seen, unseen;
    seen.box({-1, 30, 0}, {1, 32, 2});
    unseen.box({-3, -80, 0}, {3, -74, 60});
    Folder folder;
    folder.write("seen.glb", seen.glb());
    folder.write("unseen.glb", unseen.glb());
    const Transform<Ecef, Enu> at = ecefFromEnu(kCologne);
    Json transform;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            transform.push_back(at.matrix[c][r]);
    const auto tile = [](const char* uri, const std::vector<double>& box) {
        return Json{
            {"boundingVolume", {{"box", box}}}, {"geometricError", 0}, {"content", {{"uri", uri}}}};
    };
    const Json tileset = {
        {"asset", {{"version", "1.1"}}},
        {"geometricError", 500},
        {"root",
         {{"transform", transform},
          {"refine", "ADD"},
          {"geometricError", 200},
          {"boundingVolume", {{"box", {0, 0, 40, 100, 0, 0, 0, 100, 0, 0, 0, 40}}}},
          {"children",
           {tile("seen.glb", {0, 31, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1}),
            tile("unseen.glb", {0, -77, 30, 3, 0, 0, 0, 3, 0, 0, 0, 30})}}}}};
    SceneOptions open;
    open.inputs = {folder.write("tileset.json", tileset.dump())};
    Scene scene = mustOpen(open);
    FrameOptions options;
    options.groundAuto = false;
    options.groundHeightMetres = kCologne.heightMetres;
    auto renderer = FrameRenderer::create(softwareContext(), scene, options);
    FrameRequest request;
    request.camera = cameraFor(at, {{0, -40, 12}, {0, 20, 0}});
    request.sun = sunFromAngles(180, 30, kCologne);
    request.deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    const auto facts = (*renderer)->draw(request);
    ASSERT_TRUE(facts);
    EXPECT_TRUE(facts->complete);
    EXPECT_EQ(facts->tilesSelected, 2u);
    const Shot shot = shotOf(**renderer, at, request, *facts);
    std::vector<Triangle> triangles = seen.triangles();
    for (const Triangle& t : unseen.triangles())
        triangles.push_back(t);
    const Compared c = compare(shot, {triangles, enuDirection(180, 30)}, {60.0, 2.0, true});
    EXPECT_GT(c.dark, 1500u);
    EXPECT_EQ(c.falseLit, 0u);
    EXPECT_EQ(c.falseShadow, 0u);
}

// Seen from the dark side, close by: how far from the wall its shadow begins.
TEST(Shadow, IsAttachedAtTheFootOfAWall) {
    Shapes shapes;
    shapes.box({-20, 0, 0}, {20, 0.3, 4});
    shapes.quad({-20, 30, 0}, {20, 30, 0}, {20, 30, 4}, {-20, 30, 4}); // a sheet, open
    SmallScene scene(shapes);
    for (const double foot : {0.3, 30.0})
        for (const double elevation : {10.0, 30.0, 60.0, 80.0})
            for (const double azimuth : {180.0, 140.0})
                for (const double away : {2.0, 8.0}) {
                    const Shot shot = scene.draw({{0, foot + away, 0.8 * away}, {0, foot, 0}},
                                                 azimuth, elevation);
                    const double reach = 4.0 / std::tan(elevation * kRadiansPerDegree) *
                                         std::abs(std::cos(azimuth * kRadiansPerDegree));
                    double detached = 0.0, texel = 0.0;
                    int pixels = 0;
                    for (std::size_t i = 0; i < shot.position.size(); ++i) {
                        const glm::dvec3& p = shot.position[i];
                        // Ground in shadow by geometry, well before the shadow's far and side ends.
                        if (shot.sky(i) || p.z > 2e-3 || p.y < foot || p.y > foot + 0.5 * reach ||
                            std::abs(p.x) > 10.0)
                            continue;
                        ++pixels;
                        texel = std::max(texel, shot.texel(i));
                        if (shot.visibility[i] >= 0.5f)
                            detached = std::max(detached, p.y - foot);
                    }
                    EXPECT_GT(pixels, 200) << elevation << " " << away;
                    EXPECT_LE(detached, std::max(0.03, 2.0 * texel))
                        << foot << " " << elevation << " " << azimuth << " " << away;
                }
}

TEST(Shadow, FallsWhereGeometrySaysFromAMetreAndFromAHundredKilometresUp) {
    Shapes near, far;
    near.box({-5, -5, 0}, {5, 5, 10});
    far.box({-1000, -1000, 0}, {1000, 1000, 2000});
    struct Case {
        Shapes& shapes;
        Look look;
        double topMetres;
    };
    for (const Case& c : {Case{near, {{-18, -22, 1}, {0, 0, 2}}, 10.0},
                          Case{far, {{-20e3, -25e3, 100e3}, {0, 0, 0}, 8.0}, 2000.0}}) {
        SmallScene scene(c.shapes);
        Compared all;
        for (const double elevation : {0.5, 3.0, 30.0, 60.0, 85.0, 90.0}) {
            const Compared one = compare(scene.draw(c.look, 30.0, elevation),
                                         scene.rays(30.0, elevation), {c.topMetres, 2.0, true});
            EXPECT_EQ(one.falseLit, 0u) << c.look.eye.z << " " << elevation;
            EXPECT_EQ(one.falseShadow, 0u) << c.look.eye.z << " " << elevation;
            EXPECT_EQ(one.falseAway, 0u) << c.look.eye.z << " " << elevation;
            all += one;
        }
        std::printf("[ measured ] from %.0f m: lit %zu, dark %zu, edge %zu\n", c.look.eye.z,
                    all.lit, all.dark, all.edge);
        EXPECT_GT(all.lit, 20000u);
        EXPECT_GT(all.dark, 500u);
    }
}
