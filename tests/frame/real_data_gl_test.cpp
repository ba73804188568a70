// Real tiles from disk to the picture, held against rays through the very triangles that were
// drawn.
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

struct RealView {
    double longitude, latitude, height, heading, pitch;
    double azimuth, elevation;
};

// All triangles of the tiles that are loaded, in the anchor's frame.
std::vector<Triangle> residentTriangles(const Scene& scene) {
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.ecefFromAnchor);
    std::vector<Triangle> out;
    for (const Layer& layer : scene.layers)
        for (TileIndex tile = 0; tile < layer.tileset->tree().size(); ++tile)
            if (const auto content = layer.tileset->content(tile))
                for (const Mesh& mesh : content->meshes) {
                    // Meshes are stored along the anchor's axes once a scene is open.
                    const glm::dvec3 origin = anchorFromEcef(mesh.origin).xyz;
                    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
                        Triangle t;
                        for (std::size_t k = 0; k < 3; ++k)
                            t[k] = origin + glm::dvec3(mesh.positions[mesh.indices[i + k]]);
                        out.push_back(t);
                    }
                }
    return out;
}

double highest(const std::vector<Triangle>& triangles) {
    double top = -1e9;
    for (const Triangle& t : triangles)
        for (const glm::dvec3& p : t)
            top = std::max(top, p.z);
    return top;
}

Shot drawReal(Scene& scene, FrameRenderer& renderer, const RealView& view) {
    FrameRequest request;
    request.camera.widthPixels = 160;
    request.camera.heightPixels = 90;
    place(request.camera, {view.longitude, view.latitude, view.height},
          {view.heading, view.pitch, 0});
    request.sun = sunFromAngles(view.azimuth, view.elevation, scene.anchor);
    request.deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    const auto facts = renderer.draw(request);
    if (!facts)
        std::abort();
    return shotOf(renderer, scene.ecefFromAnchor, request, *facts);
}

Compared againstRays(const Scene& scene, const Shot& shot, const char* name) {
    const std::vector<Triangle> triangles = residentTriangles(scene);
    const Compared c = compare(shot, {triangles, shot.sun}, {highest(triangles), 2.0, true, false});
    std::printf("[ measured ] %s: %zu triangles; lit %zu, dark %zu, edge %zu; false lit %zu, "
                "false shadow %zu\n",
                name, triangles.size(), c.lit, c.dark, c.edge, c.falseLit, c.falseShadow);
    return c;
}

void expectRight(const Compared& c) {
    const double all = double(c.compared());
    EXPECT_LE(double(c.falseLit), 0.003 * all);
    EXPECT_LE(double(c.falseShadow), 0.003 * all);
    EXPECT_EQ(c.falseAway, 0u);
}

FrameOptions onGround(double height) {
    FrameOptions options;
    options.groundAuto = false;
    options.groundHeightMetres = height;
    options.maximumScreenSpaceError = 16.0;
    return options;
}

} // namespace

TEST(RealTiles, AmsterdamsShadowsAreThoseOfItsTriangles) {
    GNOMON_NEEDS_DATA("tiles-amsterdam-b3dm");
    SceneOptions open;
    open.inputs = {data("tiles-amsterdam-b3dm/tileset.json")};
    Scene scene = mustOpen(open);
    auto renderer = FrameRenderer::create(softwareContext(), scene, onGround(44.05));
    ASSERT_TRUE(renderer);
    for (const auto& [name, view] :
         {std::pair("oblique", RealView{4.9190299, 52.3861038, 96.34, 25, -32, 105, 30}),
          std::pair("low", RealView{4.9198493, 52.3862682, 46.23, 352, 4, 228, 26}),
          std::pair("top", RealView{4.9196086, 52.3867051, 154.98, 25, -89, 250, 28})}) {
        const Shot shot = drawReal(scene, **renderer, view);
        EXPECT_TRUE(shot.facts.complete);
        EXPECT_TRUE(shot.facts.missing.empty());
        const Compared c = againstRays(scene, shot, name);
        expectRight(c);
        EXPECT_LT(double(c.edge), 0.2 * double(c.compared())) << name;
        EXPECT_GT(double(c.dark), 0.02 * double(c.compared())) << name;
        EXPECT_GT(double(c.lit), 0.1 * double(c.compared())) << name;
    }
}

TEST(RealTiles, AmsterdamsGroundIsFoundFromItsBuildings) {
    GNOMON_NEEDS_DATA("tiles-amsterdam-b3dm");
    SceneOptions open;
    open.inputs = {data("tiles-amsterdam-b3dm/tileset.json")};
    Scene scene = mustOpen(open);
    auto renderer = FrameRenderer::create(softwareContext(), scene, {});
    ASSERT_TRUE(renderer);
    ASSERT_TRUE((*renderer)->groundHeightMetres());
    EXPECT_NEAR(*(*renderer)->groundHeightMetres(), 44.05, 2.0);
}

TEST(RealTiles, DelawaresShadowsAreThoseOfItsTriangles) {
    GNOMON_NEEDS_DATA("tiles-delaware-implicit");
    SceneOptions open;
    open.inputs = {data("tiles-delaware-implicit/tileset.json")};
    Scene scene = mustOpen(open);
    auto renderer = FrameRenderer::create(softwareContext(), scene, onGround(0.0));
    ASSERT_TRUE(renderer);
    const Shot shot =
        drawReal(scene, **renderer, {-75.5267533, 39.1546356, 175.01, 30, -30, 220, 30});
    EXPECT_TRUE(shot.facts.complete);
    EXPECT_TRUE(shot.facts.missing.empty());
    const Compared c = againstRays(scene, shot, "delaware");
    expectRight(c);
    EXPECT_GT(c.dark, 100u);
}

TEST(RealTiles, MarsPlacedOnTheEarthShadesItself) {
    GNOMON_NEEDS_DATA("tiles-mars-terrain-replace");
    SceneOptions open;
    open.inputs = {data("tiles-mars-terrain-replace/tileset.json")};
    open.placement = Placement{{10.0, 47.0, 500.0}, 0.0};
    Scene scene = mustOpen(open);
    FrameOptions options;
    options.groundAuto = false;
    auto renderer = FrameRenderer::create(softwareContext(), scene, options);
    ASSERT_TRUE(renderer);
    const Sphere all =
        boundingSphere(scene.layers[0].tileset->tree().node(TileTree::root()).volume);
    FrameRequest request;
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.ecefFromAnchor);
    const glm::dvec3 centre = anchorFromEcef(all.centre).xyz;
    request.camera =
        cameraFor(scene.ecefFromAnchor,
                  {centre + all.radiusMetres * glm::dvec3(-0.6, -0.8, 0.5), centre, 45, 160, 90});
    request.sun = sunFromAngles(250, 12, scene.anchor);
    request.deadline = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    const auto facts = (*renderer)->draw(request);
    ASSERT_TRUE(facts);
    EXPECT_TRUE(facts->complete);
    EXPECT_TRUE(facts->missing.empty());
    const Shot shot = shotOf(**renderer, scene.ecefFromAnchor, request, *facts);
    const auto seen = std::size_t(std::count_if(shot.depth.begin(), shot.depth.end(),
                                                [](float d) { return std::isfinite(d); }));
    EXPECT_GT(seen, 1000u);
    // Only what is drawn: coarser tiles of the same ground may be resident, so no rays here.
    std::size_t dark = 0, lit = 0;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i)
        if (!shot.sky(i)) {
            dark += shot.visibility[i] < 0.5f;
            lit += shot.visibility[i] >= 0.5f;
        }
    std::printf("[ measured ] mars: %zu lit, %zu dark\n", lit, dark);
    EXPECT_GT(lit, seen / 5);
    EXPECT_GT(dark, seen / 200);
}
