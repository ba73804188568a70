// Maps between the two layers nearest the sun: what they hold, byte for byte, and what Weiskopf and
// Ertl promise of them: that the bias hardly matters, and that silhouettes stay clean where closed
// bodies are drawn without their back faces.
#include "shadows/bias.h"
#include "tests/frame/passes.h"
#include "tests/frame/technique.h"

#include <gtest/gtest.h>

#include <cstring>
#include <optional>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A ring about a vertical axis, or about one along x. Closed.
void addTorus(Shapes& shapes, const glm::dvec3& centre, double ring, double tube, bool upright) {
    constexpr int kAround = 48, kAcross = 24;
    constexpr double kTurn = 6.283185307179586;
    std::vector<glm::dvec3> points;
    std::vector<std::uint32_t> corners;
    for (int i = 0; i < kAround; ++i)
        for (int j = 0; j < kAcross; ++j) {
            const double a = kTurn * i / kAround, b = kTurn * j / kAcross;
            const double out = ring + tube * std::cos(b);
            const glm::dvec3 p(out * std::cos(a), out * std::sin(a), tube * std::sin(b));
            points.push_back(centre + (upright ? glm::dvec3(p.z, p.x, p.y) : p));
            const auto at = [](int u, int v) {
                return std::uint32_t(u % kAround * kAcross + v % kAcross);
            };
            corners.insert(corners.end(), {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j),
                                           at(i + 1, j + 1), at(i, j + 1)});
        }
    shapes.add(points, corners);
}

// Two rings through each other, as in the paper's figures.
Shapes doubleTorus() {
    Shapes shapes;
    addTorus(shapes, {0, 0, 9}, 6, 2, false);
    addTorus(shapes, {0, 6, 9}, 6, 2, true);
    return shapes;
}

// A wall with a floor before it, of one sheet bent.
Shapes lShape() {
    Shapes shapes;
    shapes.add({{-10, -10, 1}, {10, -10, 1}, {10, 4, 1}, {-10, 4, 1}, {10, 4, 11}, {-10, 4, 11}},
               {0, 1, 2, 0, 2, 3, 3, 2, 4, 3, 4, 5});
    return shapes;
}

Shapes houses() {
    Shapes shapes;
    shapes.house({-8, -12}, {2, 4}, 5, 10);
    shapes.house({8, -10}, {18, 6}, 4, 8);
    shapes.box({-2, 8, 0}, {6, 14, 12});
    return shapes;
}

// No bias is enough for a surface that the sun grazes: beyond 78.5° between it and the sun pixels
// do not count.
constexpr double kLeastFacing = 0.2;

// Pixels that face the sun, those of them in shadow by rays, and those of the wrong kind: all of
// them, edges too.
struct Errors {
    std::size_t pixels = 0, dark = 0, falseLit = 0, falseShadow = 0;
    double share() const { return double(falseLit + falseShadow) / double(pixels); }
    void operator+=(const Errors& o) {
        pixels += o.pixels, dark += o.dark, falseLit += o.falseLit, falseShadow += o.falseShadow;
    }
};

Errors errorsOf(const Shot& shot, const SunRays& rays) {
    Errors out;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
        if (shot.sky(i) || shot.facing(i) < kLeastFacing || shot.cascade[i] == 255.0f)
            continue;
        const double tolerance = 2e-3 + 1e-6 * shot.depth[i] / shot.facing(i);
        const bool dark = rays.shadowed(shot.position[i], tolerance);
        const bool drawnDark = shot.visibility[i] < 0.5f;
        ++out.pixels;
        out.dark += dark;
        out.falseLit += dark && !drawnDark;
        out.falseShadow += !dark && drawnDark;
    }
    return out;
}

} // namespace

// Closed bodies and an open sheet, the ground, and a body in another.
TEST(DualLayers, AreTheSameBytesPeeledAndByAtomics) {
    Shapes shapes = houses();
    addTorus(shapes, {-20, 0, 9}, 6, 2, false);
    shapes.quad({22, 10, 0}, {32, 10, 0}, {32, 14, 6}, {22, 14, 6});
    shapes.box({9, -9, 1}, {17, 5, 3});
    for (const ShadowCull cull : {ShadowCull::Auto, ShadowCull::None, ShadowCull::Front}) {
        SmallScene scene(shapes);
        std::size_t raised = 0, drawn = 0, differing = 0;
        for (const double metres : {0.0, 0.05, 2.0, 1e4})
            for (const double azimuth : {40.0, 220.0}) {
                const FrameRequest request =
                    scene.request({{-45, -55, 25}, {0, 0, 0}}, azimuth, 35);
                Passes passes(scene.scene(), kCologne.heightMetres);
                passes.load(request.camera);
                const auto maps = [&](ShadowBias bias) {
                    ShadowSettings settings = technique("csm+dual-peel+none", 512);
                    settings.cascades = 2;
                    settings.bias = bias;
                    settings.biasMetres = metres;
                    settings.cull = cull;
                    passes.fit(request.camera, request.sun, settings);
                    passes.drawMaps(settings);
                    return std::array{passes.maps().read(0), passes.maps().read(1)};
                };
                const auto nearest = maps(ShadowBias::Constant),
                           peeled = maps(ShadowBias::DualPeel),
                           atomic = maps(ShadowBias::DualAtomic);
                for (std::size_t c = 0; c < 2; ++c) {
                    const Cascade& cascade = passes.cascades().cascades[c];
                    const auto most = float(std::min(metres / cascade.depthRangeMetres, 0.5));
                    for (std::size_t i = 0; i < peeled[c].size(); ++i) {
                        drawn += nearest[c][i] > 0.0f;
                        differing += std::memcmp(&peeled[c][i], &atomic[c][i], 4) != 0;
                        const float alone = nearest[c][i] - std::min(0.5f * nearest[c][i], most);
                        EXPECT_LE(peeled[c][i], nearest[c][i]);
                        EXPECT_GE(peeled[c][i], alone);
                        raised += peeled[c][i] > alone;
                    }
                }
            }
        std::printf("[ measured ] %zu of %zu texels differ; %zu raised by a second layer\n",
                    differing, drawn, raised);
        EXPECT_EQ(differing, 0u);
        EXPECT_GT(drawn, 100000u);
        EXPECT_GT(raised, 10000u);
    }
}

// Windows that moved, so that a map is drawn in up to four pages: the cells that both have are the
// same bytes, whichever camera they were drawn for.
TEST(DualLayers, KeepTheirBytesWhereWindowsOverlap) {
    SmallScene scene(houses());
    const FrameRequest request = scene.request({{-45, -55, 25}, {0, 0, 0}}, 140, 35);
    Passes passes(scene.scene(), kCologne.heightMetres);
    passes.load(request.camera);
    for (const char* text : {"single+dual-peel+none", "single+dual-atomic+none"}) {
        const ShadowSettings settings = technique(text, 512);
        const std::int64_t n = settings.mapSize;
        std::optional<Cascade> before;
        std::vector<float> last;
        std::size_t moved = 0, differing = 0, compared = 0;
        Camera camera = request.camera;
        for (int frame = 0; frame < 12; ++frame) {
            passes.fit(camera, request.sun, settings);
            passes.drawMaps(settings);
            const Cascade now = passes.cascades().cascades[0];
            const std::vector<float> map = passes.maps().read(0);
            if (before && before->texelMetres == now.texelMetres &&
                before->farPlaneMetres == now.farPlaneMetres &&
                before->depthRangeMetres == now.depthRangeMetres) {
                moved += before->cornerX != now.cornerX;
                const auto modulo = [n](std::int64_t a) { return std::size_t(((a % n) + n) % n); };
                for (auto y = std::max(before->cornerY, now.cornerY);
                     y < std::min(before->cornerY, now.cornerY) + n; ++y)
                    for (auto x = std::max(before->cornerX, now.cornerX);
                         x < std::min(before->cornerX, now.cornerX) + n; ++x, ++compared) {
                        const std::size_t at = modulo(y) * std::size_t(n) + modulo(x);
                        differing += std::memcmp(&map[at], &last[at], sizeof(float)) != 0;
                    }
            }
            before = now;
            last = map;
            camera.position = camera.position + (7.3 * now.texelMetres) * camera.right;
        }
        std::printf("[ measured ] %s: %zu of %zu texels differ, windows moved %zu\n", text,
                    differing, compared, moved);
        EXPECT_EQ(differing, 0u) << text;
        EXPECT_GT(moved, 5u) << text;
    }
}

// What one caster and the other alone have at a texel says what both together must have.
TEST(DualLayers, LieHalfWayToTheSecondButNoFartherThanTheOffset) {
    Shapes roof;
    roof.quad({-20, -20, 6}, {20, -20, 6}, {20, 20, 6}, {-20, 20, 6});
    SmallScene scene(roof);
    const FrameRequest request = scene.request({{-30, -35, 25}, {0, 0, 0}}, 200, 40);
    Passes passes(scene.scene(), kCologne.heightMetres);
    passes.load(request.camera);
    ShadowSettings settings = technique("single+constant+none", 512);
    passes.fit(request.camera, request.sun, settings);
    CascadePass pass;
    render::GpuTimer timer;
    const auto map = [&](const char* bias, std::span<const render::DrawItem> items) {
        EXPECT_FALSE(parseShadowBias(bias, settings));
        timer.start();
        pass.draw(passes.cascades(), settings, items, timer);
        EXPECT_EQ(int(timer.milliseconds().size()), CascadePass::marksPerMap(settings));
        return pass.read(0);
    };
    const std::span<const render::DrawItem> both = passes.items();
    std::vector<render::DrawItem> onlyRoof, onlyGround, twice(both.begin(), both.end());
    twice.insert(twice.end(), both.begin(), both.end());
    for (const render::DrawItem& item : both)
        (item.tileId == 0 ? onlyGround : onlyRoof).push_back(item);
    const std::vector<float> a = map("constant", onlyRoof), b = map("constant", onlyGround);
    const Cascade& cascade = passes.cascades().cascades[0];
    std::size_t between = 0, offset = 0;
    for (const auto& [bias, metres] :
         {std::pair("midpoint", 1e9), std::pair("dual-peel:0.25", 0.25),
          std::pair("dual-atomic:1", 1.0), std::pair("dual-peel:30", 30.0)}) {
        const auto most = float(std::min(metres / cascade.depthRangeMetres, 0.5));
        const std::vector<float> dual = map(bias, both);
        EXPECT_EQ(dual, map(bias, twice)) << bias; // the same surface again is no second layer
        for (std::size_t i = 0; i < dual.size(); ++i) {
            const float first = std::max(a[i], b[i]), second = std::min(a[i], b[i]);
            const float half = 0.5f * (first - second);
            ASSERT_EQ(dual[i], first - std::min(half, most)) << bias << " " << i;
            between += second > 0.0f && half < most;
            offset += second > 0.0f && half > most;
        }
    }
    EXPECT_GT(between, 5000u);
    EXPECT_GT(offset, 5000u);
}

namespace {

// A sheet over another; of the upper one a texture leaves half.
std::string cutOutSheetOverASheet() {
    GlbBuilder builder;
    const auto sheet = [&](float half, float height) -> Json& {
        return builder.triangles(
            {-half, height, half, half, height, half, half, height, -half, -half, height, -half},
            {0, 1, 2, 0, 2, 3});
    };
    sheet(12.0f, 4.0f);
    Json& leaves = sheet(20.0f, 9.0f);
    leaves["attributes"]["TEXCOORD_0"] = builder.floats({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2");
    leaves["material"] = 0;
    const std::string png = pngOf(2, 1, 4, std::string("\xff\xff\xff\x00\xff\xff\xff\xff", 8));
    builder.root["images"] = Json::array(
        {{{"bufferView", builder.view(png.data(), png.size())}, {"mimeType", "image/png"}}});
    builder.root["textures"] = Json::array({{{"source", 0}}});
    builder.root["materials"] =
        Json::array({{{"alphaMode", "MASK"},
                      {"doubleSided", true},
                      {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
    return builder.text();
}

} // namespace

TEST(DualLayers, SeeThroughWhatATextureCutsOut) {
    softwareContext();
    Folder folder;
    SceneOptions open;
    open.inputs = {folder.write("scene.glb", cutOutSheetOverASheet())};
    open.placement = Placement{kCologne, 0.0};
    Scene scene = mustOpen(open);
    const Camera camera = cameraFor(ecefFromEnu(kCologne), {{-30, -35, 25}, {0, 0, 0}});
    Passes passes(scene, kCologne.heightMetres);
    passes.load(camera);
    ShadowSettings settings = technique("single+constant+none", 512);
    passes.fit(camera, sunFromAngles(200, 50, kCologne), settings);
    std::vector<render::DrawItem> solid;
    for (const render::DrawItem& item : passes.items())
        if (!item.tile->material(*item.mesh).look.alphaTest)
            solid.push_back(item);
    ASSERT_EQ(solid.size() + 1, passes.items().size());
    CascadePass pass;
    render::GpuTimer timer;
    const auto map = [&](const char* bias, std::span<const render::DrawItem> items) {
        EXPECT_FALSE(parseShadowBias(bias, settings));
        timer.start();
        pass.draw(passes.cascades(), settings, items, timer);
        return pass.read(0);
    };
    const std::vector<float> nearest = map("constant", passes.items()),
                             nearestSolid = map("constant", solid),
                             peeled = map("dual-peel:1e4", passes.items()),
                             atomic = map("dual-atomic:1e4", passes.items()),
                             peeledSolid = map("dual-peel:1e4", solid);
    EXPECT_EQ(peeled, atomic);
    std::size_t leaves = 0, holes = 0;
    for (std::size_t i = 0; i < peeled.size(); ++i)
        if (nearest[i] > nearestSolid[i]) { // half way to whatever is solid below
            ++leaves;
            const float half = 0.5f * (nearest[i] - nearestSolid[i]);
            ASSERT_EQ(peeled[i], nearest[i] - std::min(half, 0.5f)) << i;
        } else { // as if the leaves were not there
            ++holes;
            ASSERT_EQ(peeled[i], peeledSolid[i]) << i;
        }
    std::printf("[ measured ] %zu texels of leaves, %zu without\n", leaves, holes);
    EXPECT_GT(leaves, 1000u);
    EXPECT_GT(holes, 1000u);
}

TEST(DualLayers, TakeTheMemoryThatTheyNeedAndNoMore) {
    SmallScene scene(houses());
    const FrameRequest request = scene.request({{-30, -35, 25}, {0, 0, 0}}, 200, 40);
    Passes passes(scene.scene(), kCologne.heightMetres);
    passes.load(request.camera);
    const std::size_t map = std::size_t(512) * 512 * sizeof(float);
    for (const auto& [text, maps] :
         {std::pair("csm+constant+none", 4), std::pair("csm+dual-peel+none", 5),
          std::pair("csm+dual-atomic+none", 6), std::pair("csm+midpoint+none", 5),
          std::pair("csm+slope+none", 4), std::pair("single+dual-peel+none", 2)}) {
        const ShadowSettings settings = technique(text, 512);
        passes.fit(request.camera, request.sun, settings);
        passes.drawMaps(settings);
        EXPECT_EQ(passes.maps().bytes(), std::size_t(maps) * map) << text;
    }
}

// From b0, what the steepest of the pixels that count need, to a hundred times as much.
TEST(DualLayers, MakeTheBiasMatterLittleWhereAConstantOneFails) {
    for (const auto& [name, shapes] :
         {std::pair("l-shape", lShape()), std::pair("torus", doubleTorus()),
          std::pair("houses", houses())}) {
        SmallScene scene(shapes);
        const auto errors = [&](const char* bias, double times) {
            Errors all;
            for (const double azimuth : {160.0, 215.0})
                for (const double elevation : {35.0, 55.0}) {
                    ShadowSettings settings =
                        technique(std::string("single+") + bias + "+bilinear", 512);
                    settings.rangeMetres = 150.0;
                    const Look look{{-24, -30, 40}, {0, 0, 3}, 32, 320, 180};
                    scene.setShadows(settings);
                    const double texel =
                        scene.draw(look, azimuth, elevation).facts.cascades[0].texelMetres;
                    const double tanAngle =
                        std::sqrt(1.0 - kLeastFacing * kLeastFacing) / kLeastFacing;
                    settings.biasMetres = times * riseMetres(settings, texel, tanAngle);
                    scene.setShadows(settings);
                    all += errorsOf(scene.draw(look, azimuth, elevation),
                                    scene.rays(azimuth, elevation));
                }
            std::printf("[ measured ] %s %s %5.0f b0: %.4f of the pixels wrong (lit %zu, shadow "
                        "%zu; %zu dark of %zu)\n",
                        name, bias, times, all.share(), all.falseLit, all.falseShadow, all.dark,
                        all.pixels);
            return all;
        };
        const Errors least = errors("dual-peel", 1.0), tenfold = errors("dual-peel", 10.0),
                     most = errors("dual-peel", 100.0);
        const Errors constantLeast = errors("constant", 1.0),
                     constantMost = errors("constant", 100.0);
        EXPECT_GT(least.dark, 2000u);
        EXPECT_NEAR(tenfold.share() / least.share(), 1.0, 0.1) << name;
        EXPECT_NEAR(most.share() / least.share(), 1.0, 0.1) << name;
        EXPECT_GT(std::max(constantLeast.share(), constantMost.share()), 3.0 * most.share())
            << name;
    }
}

namespace {

// A box, a thin plate in the air, both closed; and a sheet, open, of which both sides are seen.
Shapes bodiesAndASheet() {
    Shapes shapes;
    shapes.box({-8, -6, 0}, {4, 6, 10});
    shapes.box({12, -6, 8}, {24, 6, 8.2});
    shapes.quad({-30, -14, 0}, {-18, -14, 0}, {-18, 10, 7}, {-30, 10, 7});
    return shapes;
}

// Of the tops of the box and the plate, which nothing shades, the share that is not fully lit.
double acneOnTops(SmallScene& scene, const char* text, ShadowCull cull, bool box) {
    ShadowSettings settings = technique(text, 512);
    settings.cull = cull;
    settings.rangeMetres = 300.0;
    scene.setShadows(settings);
    std::size_t pixels = 0, wrong = 0;
    double texel = 0.0;
    for (const double azimuth : {165.0, 187.0}) {
        const Shot shot = scene.draw({{8, -50, 40}, {8, 0, 6}, 32, 480, 270}, azimuth, 20);
        texel = shot.facts.cascades[0].texelMetres;
        for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
            const double top = box ? 10.0 : 8.2;
            if (shot.sky(i) || shot.normal[i].z < 0.99 || std::abs(shot.position[i].z - top) > 0.05)
                continue;
            ++pixels;
            wrong += shot.visibility[i] != 1.0f;
        }
    }
    EXPECT_GT(pixels, 5000u);
    std::printf("[ measured ] %s, cull %d, %s, texel %.2f m: %zu of %zu\n", text, int(cull),
                box ? "box" : "plate", texel, wrong, pixels);
    return double(wrong) / double(pixels);
}

} // namespace

// At the edges that a body shows against what lies behind it its front and its back meet: with both
// in the map the layers are too close there to keep the surface from shading itself (the paper's
// figure 5f), and on a thin body everywhere.
TEST(DualLayers, KeepSilhouettesCleanWhereBackFacesOfClosedBodiesAreLeftOut) {
    SmallScene scene(bodiesAndASheet());
    for (const bool box : {true, false}) {
        const auto acne = [&](const char* text, ShadowCull cull) {
            return acneOnTops(scene, text, cull, box);
        };
        const double least = box ? 0.005 : 0.2;
        EXPECT_EQ(acne("single+dual-peel:20+bilinear", ShadowCull::Auto), 0.0);
        EXPECT_EQ(acne("single+dual-atomic:20+bilinear", ShadowCull::Auto), 0.0);
        EXPECT_GT(acne("single+dual-peel:20+bilinear", ShadowCull::None), least);
        EXPECT_GT(acne("single+midpoint+bilinear", ShadowCull::Auto), least); // Woo's takes both
        EXPECT_EQ(acne("single+midpoint+bilinear", ShadowCull::Back), 0.0);
        EXPECT_GT(acne("single+constant:0.02+bilinear", ShadowCull::Auto), 0.2);
    }
}

// The open sheet beside it, of which nothing is left out, casts and stays lit.
TEST(DualLayers, TakeOpenSheetsFromBothSides) {
    SmallScene scene(bodiesAndASheet());
    ShadowSettings settings = technique("single+dual-peel+bilinear");
    settings.rangeMetres = 150.0;
    scene.setShadows(settings);
    Errors all;
    for (const double azimuth : {20.0, 160.0, 250.0}) // its upper and its lower side to the sun
        all += errorsOf(scene.draw({{-40, -44, 26}, {-20, 0, 3}, 40, 320, 180}, azimuth, 35),
                        scene.rays(azimuth, 35));
    std::printf("[ measured ] false lit %zu of %zu, false shadow %zu of %zu\n", all.falseLit,
                all.dark, all.falseShadow, all.pixels - all.dark);
    EXPECT_GT(all.dark, 5000u);
    EXPECT_LT(all.share(), 0.02);
}
