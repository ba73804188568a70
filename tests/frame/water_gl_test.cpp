// Water over the ground: what of it is drawn, that surface and ground below have each their own
// shadow, and what it does to the picture.
#include "render/visibility_pass.h"
#include "render/water_pass.h"
#include "tests/frame/fake_water.h"
#include "viewer/water_legend.h"

#include <gtest/gtest.h>

#include <numeric>

using namespace gnomon;
using namespace gnomon::test;

namespace {

constexpr double kNoon = 180.0; // the sun in the south

double slopeAt(double x) {
    return -1.0 - 0.1 * x;
}

// A slope that sinks to the east, its shore at x = -10, and along it a wall whose top's northern
// edge stands at y = -9, z = 6.
Shapes slopeWithWall() {
    Shapes shapes;
    shapes.quad({-20, -25, slopeAt(-20)}, {40, -25, slopeAt(40)}, {40, 25, slopeAt(40)},
                {-20, 25, slopeAt(-20)});
    shapes.box({-20, -10, -6}, {40, -9, 6});
    return shapes;
}

FakeWater::Shape levelOverSlope() {
    FakeWater::Shape shape;
    shape.low = {-20, -25};
    shape.high = {40, 25};
    shape.level = [](glm::dvec2, double seconds) { return seconds / 120.0; };
    shape.depth = [](glm::dvec2 p, double seconds) { return seconds / 120.0 - slopeAt(p.x); };
    return shape;
}

// A small scene with a layer of water, at the moment 0 if not told.
struct WaterScene {
    WaterScene(const Shapes& shapes, const FakeWater::Shape& shape, bool ground = false,
               const ShadowSettings& shadows = {})
        : scene(shapes, {kCologne, ground, shadows}),
          water(std::make_shared<FakeWater>(ecefFromEnu(kCologne), shape)) {
        WaterLayer layer;
        layer.uri = "flood.nc";
        layer.surface = water;
        scene.scene().waters.push_back(layer);
    }
    WaterLook& look() { return scene.scene().waters[0].look; }
    FrameRequest request(const Look& look, double azimuth, double elevation,
                         double seconds = 0.0) const {
        FrameRequest request = scene.request(look, azimuth, elevation);
        request.time = UtcTime{seconds};
        return request;
    }

    SmallScene scene;
    std::shared_ptr<FakeWater> water;
};

// The same pixels with the water, and what is below it.
struct TwoLayers {
    Shot top, below;
    std::vector<float> sunBelow; // in the picture with the water

    TwoLayers(WaterScene& water, FrameRequest request) {
        top = water.scene.draw(request);
        sunBelow = water.scene.renderer().opaqueSun().values;
        request.withoutWater = true;
        below = water.scene.draw(request);
    }
    bool isWater(std::size_t i) const { return top.depth[i] < below.depth[i]; }
    double brightness(std::size_t i) const {
        const std::uint8_t* rgb = &top.picture.rgb[3 * i];
        return (rgb[0] + rgb[1] + rgb[2]) / 3.0;
    }
};

const Look kOblique{{10, 32, 30}, {10, 0, 0}};
const Look kFromAbove{{12, 4, 60}, {12, 4.01, 0}};

struct Found {
    std::size_t lit = 0, dark = 0, wrong = 0;
};

// By where the wall's top hides a sun of 45° from the south: where y + z < -3. Away from that edge
// by what a penumbra and two texels may spread.
void addPoint(Found& found, const glm::dvec3& p, double visibility, double texel) {
    const double beyond = p.y + p.z + 3.0;
    if (p.y < -8.9 || std::abs(beyond) < 0.1 + 3.0 * texel)
        return;
    ++(beyond > 0.0 ? found.lit : found.dark);
    found.wrong += (beyond > 0.0) != (visibility > 0.5);
}

void expectBothShadows(const ShadowSettings& shadows, bool still) {
    WaterScene water(slopeWithWall(), levelOverSlope(), false, shadows);
    FrameRequest request = water.request(kOblique, kNoon, 45);
    request.still = still;
    const TwoLayers seen(water, request);
    Found surface, ground;
    for (std::size_t i = 0; i < seen.top.depth.size(); ++i) {
        if (!seen.isWater(i))
            continue;
        EXPECT_NEAR(seen.top.position[i].z, 0.0, 1e-3);
        addPoint(surface, seen.top.position[i], seen.top.visibility[i], seen.top.texel(i));
        if (seen.below.normal[i].z > 0.9)
            addPoint(ground, seen.below.position[i], seen.sunBelow[i], seen.below.texel(i));
    }
    for (const Found& found : {surface, ground}) {
        EXPECT_GT(found.lit, 2000u);
        EXPECT_GT(found.dark, 500u);
        EXPECT_EQ(found.wrong, 0u);
    }
}

ShadowSettings withMethod(ShadowMethod method) {
    ShadowSettings settings;
    settings.method = method;
    return settings;
}

} // namespace

TEST(Water, HasItsOwnShadowAndTheGroundBelowHasItsOwn) {
    expectBothShadows({}, false);
}

TEST(Water, HasBothShadowsWhereCascadesAreFittedToWhatIsSeen) {
    expectBothShadows({}, true);
}

TEST(Water, HasBothShadowsWithMapsInTheEyesPerspective) {
    expectBothShadows(withMethod(ShadowMethod::PlaneOptimal), true);
}

TEST(Water, IsInTheShadowMapsWhereItReachesFartherThanAllElse) {
    // A tower by a lake, its shadow 200 m long on nothing but water.
    Shapes tower;
    tower.box({-4, -8, -5}, {4, 0, 40});
    FakeWater::Shape shape;
    shape.low = {-150, -30};
    shape.high = {150, 300};
    shape.cellMetres = 5.0;
    for (const bool still : {false, true}) {
        WaterScene water(tower, shape);
        FrameRequest request =
            water.request({{15, -20, 12}, {0, 120, 0}}, kNoon, std::atan(0.2) / kRadiansPerDegree);
        request.still = still;
        const TwoLayers seen(water, request);
        std::size_t dark = 0, lit = 0, wrong = 0;
        for (std::size_t i = 0; i < seen.top.depth.size(); ++i) {
            const glm::dvec3& p = seen.top.position[i];
            // The penumbra's half is a metre wide at the shadow's end, ten along it.
            if (!seen.isWater(i) || std::abs(std::abs(p.x) - 4.0) < 1.5 || p.y < 2.0 ||
                std::abs(p.y - 200.0) < 15.0)
                continue;
            const bool shaded = std::abs(p.x) < 4.0 && p.y < 200.0;
            ++(shaded ? dark : lit);
            wrong += shaded != (seen.top.visibility[i] < 0.5f);
        }
        EXPECT_GT(dark, 500u);
        EXPECT_GT(lit, 10000u);
        EXPECT_EQ(wrong, 0u);
    }
}

TEST(Water, ShowsBothShadowsInThePicture) {
    for (const WaterColors colors : {WaterColors::Depth, WaterColors::Natural}) {
        WaterScene water(slopeWithWall(), levelOverSlope());
        water.look().colors = colors;
        const TwoLayers seen(water, water.request(kFromAbove, kNoon, 45));
        // Where the water is 0.8 to 1 m deep: none, the surface only, or both are lit.
        double sum[3] = {}, count[3] = {};
        for (std::size_t i = 0; i < seen.top.depth.size(); ++i) {
            const float surface = seen.top.visibility[i], ground = seen.sunBelow[i];
            const double depth = -slopeAt(seen.top.position[i].x);
            if (!seen.isWater(i) || depth < 0.8 || depth > 1.0 || seen.below.normal[i].z < 0.9 ||
                surface != std::round(surface) || ground != std::round(ground))
                continue;
            const int zone = int(surface) + int(ground);
            EXPECT_LE(ground, surface); // the sun comes in over the wall's top
            sum[zone] += seen.brightness(i);
            ++count[zone];
        }
        for (const double c : count)
            EXPECT_GT(c, 20.0);
        EXPECT_GT(sum[1] / count[1], sum[0] / count[0] + 3.0);
        EXPECT_GT(sum[2] / count[2], sum[1] / count[1] + 3.0);
    }
}

TEST(Water, IsNeverDrawnWhereItsDepthIsNotAboveZero) {
    // Level a metre over flat ground; the shore runs through the middle of cells.
    FakeWater::Shape shape;
    shape.cellMetres = 4.0;
    shape.level = [](glm::dvec2, double) { return 1.0; };
    shape.depth = [](glm::dvec2 p, double) { return 0.3 * (p.x - 1.3); };
    Shapes shapes;
    shapes.box({-40, 20, 0}, {-39, 21, 1});
    WaterScene water(shapes, shape, true);
    const TwoLayers seen(water, water.request(kFromAbove, kNoon, 45));
    std::size_t wet = 0, dry = 0;
    for (std::size_t i = 0; i < seen.top.depth.size(); ++i) {
        const glm::dvec3& p = seen.top.position[i];
        if (seen.isWater(i)) {
            ASSERT_GT(p.x, 1.3 - 1e-4);
            ++wet;
        } else if (p.x < 29.0 && std::abs(p.y) < 29.0) {
            ASSERT_LT(p.x, 1.5); // seen a metre lower, as far as that shifts it
            ++dry;
        }
    }
    EXPECT_GT(wet, 10000u);
    EXPECT_GT(dry, 5000u);
}

TEST(Water, IsNotDrawnOverDryGroundNorInFrontOfAWall) {
    WaterScene water(slopeWithWall(), levelOverSlope());
    for (const Look& look : {kOblique, kFromAbove, Look{{-18, 20, 3}, {20, -9, 0}}}) {
        const TwoLayers seen(water, water.request(look, kNoon, 45));
        std::size_t above = 0, under = 0;
        for (std::size_t i = 0; i < seen.top.depth.size(); ++i) {
            const glm::dvec3& p = seen.below.position[i];
            ASSERT_LE(seen.top.depth[i], seen.below.depth[i]);
            if (seen.below.sky(i) || std::abs(p.z) < 1e-3)
                continue;
            ASSERT_EQ(seen.isWater(i), p.z < 0.0) << p.x << " " << p.y << " " << p.z;
            ++(p.z > 0.0 ? above : under);
        }
        EXPECT_GT(above, 1000u);
        EXPECT_GT(under, 5000u);
    }
}

TEST(Water, ShowsOverGroundThatIsDrawnTooHighAsFarAsThatMayBeWrong) {
    // Ground stands 0.3 m out of the water.
    Shapes slab;
    slab.box({-30, -30, -1}, {30, 30, 0.3});
    SmallScene scene(slab, {kCologne, false, {}});
    const FrameRequest request = scene.request(kFromAbove, kNoon, 45);
    scene.draw(request); // loads it
    const glm::dmat3 axes = scene.renderer().meshAxes();
    const TileContent content = *scene.renderer().residentTiles().front().content;
    std::vector<std::string> warnings;
    const render::GpuTile tile(content, warnings);
    std::vector<render::DrawItem> items;
    for (const render::GpuMesh& mesh : tile.meshes())
        items.push_back({&tile, &mesh, 1});
    render::VisibilityPass seen;
    seen.draw(request.camera, items, axes);

    const auto shownShare = [&](double depthMetres, std::vector<float> errors) {
        FakeWater::Shape shape;
        shape.depth = [&](glm::dvec2, double) { return depthMetres; };
        const auto meshes = FakeWater(ecefFromEnu(kCologne), shape).meshes(0.0, axes);
        const render::GpuWater water(*meshes);
        const render::WaterItem item{&water};
        render::WaterPass pass;
        pass.draw(seen, {request.camera, axes, std::span(&item, 1), errors});
        const std::vector<float> depth = pass.readViewDepth();
        const auto shown =
            std::count_if(depth.begin(), depth.end(), [](float d) { return std::isfinite(d); });
        return double(shown) / double(depth.size());
    };
    EXPECT_GT(shownShare(1.0, {0.0f, 0.31f}), 0.5);
    EXPECT_EQ(shownShare(1.0, {0.0f, 0.29f}), 0.0);
    EXPECT_EQ(shownShare(0.29, {0.0f, 0.5f}), 0.0); // farther than it is deep
    EXPECT_EQ(shownShare(1.0, {0.5f, 0.0f}), 0.0);  // another tile's
    EXPECT_EQ(shownShare(1.0, {0.5f}), 0.0);        // nothing known of it
}

TEST(Water, ChangesNothingWhereThereIsNoneOrItIsNotWanted) {
    SmallScene dry(slopeWithWall(), {kCologne, false, {}});
    const Shot plain = dry.draw(kOblique, kNoon, 45);

    WaterScene wet(slopeWithWall(), levelOverSlope());
    FrameRequest request = wet.request(kOblique, kNoon, 45);
    request.withoutWater = true;
    const Shot unwanted = wet.scene.draw(request);
    EXPECT_EQ(unwanted.picture.rgb, plain.picture.rgb);
    EXPECT_EQ(unwanted.visibility, plain.visibility);
    EXPECT_EQ(wet.water->made, 0);

    FakeWater::Shape behind = levelOverSlope();
    behind.low = {0, 100};
    behind.high = {20, 120};
    WaterScene out(slopeWithWall(), behind);
    const Shot outOfView = out.scene.draw(out.request(kOblique, kNoon, 45));
    EXPECT_EQ(outOfView.picture.rgb, plain.picture.rgb);
    EXPECT_EQ(outOfView.facts.waterTriangles, 0u);

    const Shot changed = wet.scene.draw(wet.request(kOblique, kNoon, 45));
    EXPECT_NE(changed.picture.rgb, plain.picture.rgb);
    EXPECT_GT(changed.facts.waterTriangles, 1000u);
    EXPECT_EQ(changed.tile, plain.tile); // ids stay the opaque surfaces'
}

TEST(Water, WhenNaturalTakesMoreOfTheGroundsLightTheDeeperItIs) {
    Shapes slope;
    slope.quad({-20, -25, slopeAt(-20)}, {40, -25, slopeAt(40)}, {40, 25, slopeAt(40)},
               {-20, 25, slopeAt(-20)});
    WaterScene water(slope, levelOverSlope());
    water.look().colors = WaterColors::Natural;
    // From straight above, with the sun where it is not mirrored to the eye.
    const TwoLayers seen(water, water.request({{10, 0, 70}, {10, 0.01, 0}}, kNoon, 40));
    constexpr int kBins = 10;
    double sum[kBins] = {}, count[kBins] = {};
    for (std::size_t i = 0; i < seen.top.depth.size(); ++i) {
        const int bin = int(-slopeAt(seen.top.position[i].x) / 0.25);
        if (!seen.isWater(i) || bin >= kBins)
            continue;
        sum[bin] += seen.brightness(i);
        ++count[bin];
    }
    for (int i = 1; i < kBins; ++i)
        EXPECT_LT(sum[i] / count[i], sum[i - 1] / count[i - 1] - 0.5) << i;
}

TEST(Water, IsAFunctionOfItsMomentWhateverWasDrawnBefore) {
    for (const WaterColors colors : {WaterColors::Depth, WaterColors::Natural}) {
        WaterScene water(slopeWithWall(), levelOverSlope());
        water.look().colors = colors;
        const auto drawnAt = [&](double seconds) {
            return water.scene.draw(water.request(kOblique, kNoon, 45, seconds));
        };
        const Shot first = drawnAt(0.0), other = drawnAt(60.0), again = drawnAt(0.0);
        EXPECT_EQ(again.picture.rgb, first.picture.rgb);
        EXPECT_EQ(again.visibility, first.visibility);
        EXPECT_EQ(again.depth, first.depth);
        EXPECT_EQ(again.cascade, first.cascade);
        EXPECT_NE(other.picture.rgb, first.picture.rgb);
        EXPECT_NE(other.depth, first.depth);
    }
}

TEST(Water, IsMadeAnewOnlyWhenItsMomentChanges) {
    WaterScene water(slopeWithWall(), levelOverSlope());
    const auto drawAt = [&](double seconds) {
        water.scene.draw(water.request(kOblique, kNoon, 45, seconds));
    };
    drawAt(30.0);
    drawAt(30.0);
    water.look().colors = WaterColors::Natural;
    drawAt(30.0);
    EXPECT_EQ(water.water->made, 1);
    drawAt(31.0);
    EXPECT_EQ(water.water->made, 2);
    drawAt(120.0); // the last step: it stands still beyond
    drawAt(5000.0);
    EXPECT_EQ(water.water->made, 3);
}

TEST(Water, ThatCannotBeReadIsNamedAndTheRestIsShown) {
    WaterScene water(slopeWithWall(), levelOverSlope());
    water.water->failing = true;
    const Shot shot = water.scene.draw(water.request(kOblique, kNoon, 45));
    ASSERT_EQ(shot.facts.missing.size(), 1u);
    EXPECT_NE(shot.facts.missing[0].find("flood.nc"), std::string::npos);
    EXPECT_NE(shot.facts.missing[0].find("cannot be read"), std::string::npos);
    EXPECT_EQ(shot.facts.waterTriangles, 0u);
}

TEST(Water, IsColouredByTheNumberThatTheLegendNames) {
    // Fully lit and deep, over no ground: the paint alone.
    Shapes post;
    post.box({-28, -28, -20}, {-27, -27, -19});
    for (const WaterColors colors : {WaterColors::Depth, WaterColors::Speed}) {
        FakeWater::Shape shape;
        shape.depth = [](glm::dvec2, double) { return 2.5; };
        shape.velocity = {0.6f, 0.8f};
        WaterScene water(post, shape);
        water.look().colors = colors;
        water.look().most = 5.0;
        const WaterLegend legend = legendOf(water.scene.scene().waters[0]);
        EXPECT_EQ(legend.most, 5.0);
        const glm::vec3 meant =
            colorAt(legend.map, (colors == WaterColors::Depth ? 2.5 : 1.0) / legend.most);
        const Shot shot = water.scene.draw(water.request({{0, 0, 20}, {0, 0.01, 0}}, kNoon, 60));
        const std::size_t middle = shot.depth.size() / 2 + 160;
        ASSERT_EQ(shot.visibility[middle], 1.0f);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(shot.picture.rgb[3 * middle + c], 255.0 * meant[int(c)], 3.0);
    }
}

TEST(WaterLegend, ReachesToANiceNumberThatHoldsTheData) {
    EXPECT_EQ(niceAtLeast(0.0), 1.0);
    EXPECT_EQ(niceAtLeast(std::nan("")), 1.0);
    EXPECT_DOUBLE_EQ(niceAtLeast(1.0), 1.0);
    EXPECT_DOUBLE_EQ(niceAtLeast(1.01), 1.5);
    EXPECT_DOUBLE_EQ(niceAtLeast(7.3), 8.0);
    EXPECT_DOUBLE_EQ(niceAtLeast(9.0), 10.0);
    EXPECT_DOUBLE_EQ(niceAtLeast(0.034), 0.04);
    for (double v = 0.001; v < 1e4; v *= 1.07) {
        EXPECT_GE(niceAtLeast(v), v * (1 - 1e-9));
        EXPECT_LE(niceAtLeast(v), 1.51 * v);
    }
}

TEST(WaterLegend, IsOfDepthWhereSpeedsAreAskedForAndThereAreNone) {
    FakeWater::Shape shape;
    shape.deepest = 6.2;
    const auto water = std::make_shared<FakeWater>(ecefFromEnu(kCologne), shape);
    WaterLayer layer;
    layer.surface = water;
    layer.look.colors = WaterColors::Speed;
    EXPECT_EQ(legendOf(layer).unit, "m/s");
    EXPECT_EQ(legendOf(layer).most, 2.0);
    water->flood.velocity = false;
    EXPECT_EQ(legendOf(layer).unit, "m");
    EXPECT_EQ(legendOf(layer).most, 8.0);
    layer.look.colors = WaterColors::Natural;
    EXPECT_TRUE(legendOf(layer).title.empty());
}
