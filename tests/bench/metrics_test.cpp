// Figures of error on answers made by hand, where every figure is known beforehand.
#include "bench/metrics.h"
#include "tests/bench/ray_world.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::bench;
using namespace gnomon::test;

namespace {

constexpr int kSize = 200;
constexpr double kEyeHeight = 60.0;
const double kHalfView = kEyeHeight * std::tan(22.5 * kRadiansPerDegree); // of the floor, metres
const double kMetresPerPixel = 2.0 * kHalfView / kSize;

// A floor seen from straight above, x to the right; the sun in the west, 45° high, so that a thing
// `h` above the floor has its shadow `h` to the right.
class Stage {
  public:
    explicit Stage(RayWorld& world, double sunDiameter = 0.533, int rays = 64)
        : place_(world.ecefFromPlace()),
          camera_(world.camera({0, 0, kEyeHeight}, {0, 0, 0}, kSize, kSize)),
          light_(SunDisc{directionAt(270, 45), sunDiameter}) {
        world.quad({-200, -200, 0}, {200, -200, 0}, {200, 200, 0}, {-200, 200, 0});
        rays_.emplace(world.rays({0, 0, kEyeHeight}));
        ReferenceOptions options;
        options.light = light_;
        options.raysPerPixel = rays;
        reference_ = std::move(traceReference(*rays_, camera_, options)).value();
    }

    const Reference& reference() const { return reference_; }
    // Where a pixel's centre is on the floor.
    static double xOf(std::size_t pixel) {
        return (double(pixel % kSize) + 0.5 - 0.5 * kSize) * kMetresPerPixel;
    }
    bool onFloor(std::size_t i) const {
        return reference_.surfaces[i].position.z < -kEyeHeight + 0.1;
    }

    Answer perfect(bool soft, double texel = 0.1) const {
        Answer answer;
        answer.soft = soft;
        answer.visibility = soft ? reference_.visibility : reference_.hard;
        answer.texels.assign(answer.visibility.size(), float(texel));
        return answer;
    }
    Comparison compare(const Answer& answer, std::span<const Probe> probes = {}) const {
        return bench::compare(*rays_, reference_, light_, answer, camera_, probes, place_);
    }

  private:
    Transform<Ecef, Enu> place_;
    Camera camera_;
    bench::Light light_;
    std::optional<RayScene> rays_;
    Reference reference_;
};

// A plate 8 m wide at a height of 20 m, longer than the view: its shadow is the stripe x = 16…24.
RayWorld plate() {
    RayWorld world;
    world.quad({-4, -150, 20}, {4, -150, 20}, {4, 150, 20}, {-4, 150, 20});
    return world;
}
// A wall 1 m thick and 10 m high; its shadow reaches from its foot at x = 0.5 to 10.5.
RayWorld wall() {
    RayWorld world;
    world.box({-0.5, -150, 0}, {0.5, 150, 10});
    return world;
}

} // namespace

TEST(Metrics, APerfectAnswerHasNoErrorButStillABand) {
    RayWorld world = plate();
    const Stage stage(world);
    for (const bool soft : {false, true}) {
        const Metrics m = stage.compare(stage.perfect(soft)).metrics;
        EXPECT_EQ(m.pixels, std::uint64_t(kSize) * kSize);
        EXPECT_EQ(m.litFacing, m.pixels);
        EXPECT_EQ(m.falseLitAll + m.falseShadowAll + m.falseLit + m.falseShadow, 0.0);
        EXPECT_EQ(m.meanAbsolute + m.rootMeanSquare + m.acne + m.leak, 0.0);
        EXPECT_EQ(m.edgePixels, 0.0);
        EXPECT_GT(m.band, 0.0);
    }
}

TEST(Metrics, AllLitIsFalseByTheShadowsShareOfThePicture) {
    RayWorld world = plate();
    const Stage stage(world);
    Answer answer = stage.perfect(false, 0.5);
    answer.filterRadiusTexels = 0.5;
    answer.visibility.assign(answer.visibility.size(), 1.0f);
    const Comparison out = stage.compare(answer);
    const Metrics& m = out.metrics;
    const double stripe = 8.0 / (2.0 * kHalfView);
    EXPECT_NEAR(m.falseLitAll, stripe, 0.006);
    EXPECT_NEAR(m.meanAbsolute, stripe, 0.006);
    EXPECT_NEAR(m.rootMeanSquare, std::sqrt(stripe), 0.01);
    EXPECT_EQ(m.falseShadowAll, 0.0);
    EXPECT_EQ(m.leak, 0.0); // nothing stands there
    // 0.75 m in the light's plane is 0.75 √2 m on the floor, on both sides of both edges.
    const double side = 0.75 * std::sqrt(2.0) / (2.0 * kHalfView);
    EXPECT_NEAR(m.band, 4.0 * side, 0.012);
    EXPECT_NEAR(m.falseLit, stripe - 2.0 * side, 0.012);
    EXPECT_EQ(m.edgePixels, 32.0); // nothing to be near to
    std::size_t inBand = 0, outside = 0;
    for (const Verdict verdict : out.verdicts) {
        inBand += verdict == Verdict::FalseLitInBand;
        outside += verdict == Verdict::FalseLit;
    }
    EXPECT_NEAR(double(inBand + outside) / double(m.litFacing), m.falseLitAll, 1e-12);
    EXPECT_NEAR(double(outside) / double(m.litFacing), m.falseLit, 1e-12);
}

TEST(Metrics, AShadowMovedByPixelsIsOffByAsMany) {
    RayWorld world = plate();
    const Stage stage(world);
    for (const int k : {1, 3, 7}) {
        Answer answer = stage.perfect(false);
        for (std::size_t i = 0; i < answer.visibility.size(); ++i)
            if (Stage::xOf(i) > 8.0) // to the left
                answer.visibility[i] = i % kSize + std::size_t(k) < kSize
                                           ? stage.reference().hard[i + std::size_t(k)]
                                           : 1.0f;
        const Metrics m = stage.compare(answer).metrics;
        ASSERT_TRUE(m.edgePixels);
        EXPECT_NEAR(*m.edgePixels, k, 1e-9);
        EXPECT_NEAR(m.falseLitAll, double(k) / kSize, 1e-9);
        EXPECT_NEAR(m.falseShadowAll, double(k) / kSize, 1e-9);
    }
}

TEST(Metrics, DotsFarFromAnyShadowAreAcneAndThoseBesideOneAreNot) {
    RayWorld world = plate();
    const Stage stage(world);
    Answer answer = stage.perfect(false, 0.5); // two texels: 1.41 m on the floor
    std::size_t far = 0, beside = 0;
    for (std::size_t i = 0; i < answer.visibility.size(); ++i) {
        const double x = Stage::xOf(i);
        const bool isFar = x < -15.0 && i % 7 == 0, isBeside = x > 24.2 && x < 24.6 && i % 3 == 0;
        if (isFar || isBeside)
            answer.visibility[i] = 0.0f;
        far += isFar, beside += isBeside;
    }
    ASSERT_GT(far, 100u);
    ASSERT_GT(beside, 20u);
    const Metrics m = stage.compare(answer).metrics;
    EXPECT_NEAR(m.acne, double(far) / double(m.litFacing), 1e-12);
    EXPECT_NEAR(m.falseShadowAll, double(far + beside) / double(m.litFacing), 1e-12);
    EXPECT_NEAR(m.falseShadow, double(far) / double(m.litFacing), 1e-12); // the others: in the band
}

TEST(Metrics, LightAtAWallsFootIsALeakAndLightInTheOpenIsNot) {
    RayWorld world = wall();
    const Stage stage(world);
    Answer answer = stage.perfect(false, 0.5);
    std::size_t foot = 0, open = 0;
    for (std::size_t i = 0; i < answer.visibility.size(); ++i) {
        const double x = Stage::xOf(i);
        if (!stage.onFloor(i) || stage.reference().hard[i] > 0.0f)
            continue;
        const bool isFoot = x<1.4, isOpen = x> 4.0 && x < 8.0 && i % 5 == 0;
        if (isFoot || isOpen)
            answer.visibility[i] = 1.0f;
        foot += isFoot, open += isOpen;
    }
    ASSERT_GT(foot, 100u);
    ASSERT_GT(open, 100u);
    const Metrics m = stage.compare(answer).metrics;
    EXPECT_NEAR(m.leak, double(foot) / double(m.litFacing), 1e-12);
    EXPECT_NEAR(m.falseLitAll, double(foot + open) / double(m.litFacing), 1e-12);
    EXPECT_EQ(m.acne, 0.0);
}

TEST(Metrics, WhatIsBeyondTheShadowsOrSeesAnotherSurfaceIsNotAsked) {
    RayWorld world = plate();
    const Stage stage(world);
    Answer answer = stage.perfect(false);
    for (const SurfacePoint& surface : stage.reference().surfaces)
        answer.viewDepths.push_back(float(surface.viewDepthMetres));
    std::size_t left = 0;
    for (std::size_t i = 0; i < answer.visibility.size(); ++i) {
        answer.visibility[i] = 1.0f - answer.visibility[i]; // all wrong, so all seen
        if (i % 3 == 0)
            answer.texels[i] = 0.0f;
        else if (i % 3 == 1)
            answer.viewDepths[i] += 1.0f;
        left += i % 3 == 2;
    }
    const Comparison out = stage.compare(answer);
    EXPECT_EQ(out.metrics.litFacing, left);
    EXPECT_EQ(out.metrics.pixels, answer.visibility.size());
    EXPECT_NEAR(out.metrics.falseLitAll + out.metrics.falseShadowAll, 1.0, 1e-12);
    for (std::size_t i = 0; i < out.verdicts.size(); ++i)
        ASSERT_EQ(out.verdicts[i] == Verdict::NotAsked, i % 3 != 2);
}

// The sun ten degrees across, so that pixels are small beside the penumbra: 7 m on the floor.
TEST(Metrics, PenumbraErrorIsThatOfTheWidth) {
    RayWorld world = plate();
    const Stage stage(world, 10.0, 256);
    Probe probe;
    probe.from = {11, 1, 0};
    probe.to = {20, 1, 0};
    const Metrics perfect = stage.compare(stage.perfect(true), {&probe, 1}).metrics;
    ASSERT_TRUE(perfect.penumbraError);
    EXPECT_EQ(*perfect.penumbraError, 0.0);
    EXPECT_FALSE(perfect.penumbraTexels);

    Answer narrow = stage.perfect(true);
    for (std::size_t i = 0; i < narrow.visibility.size(); ++i) // 2.4 m from 0.1 to 0.9
        narrow.visibility[i] = float(std::clamp(0.5 - (Stage::xOf(i) - 16.0) / 3.0, 0.0, 1.0));
    // The edge, 20 √2 m from the floor along the ray, seen under 10°, at 45°.
    const double width =
        0.687 * 20.0 * std::sqrt(2.0) * 2.0 * std::tan(5.0 * kRadiansPerDegree) * std::sqrt(2.0);
    const Metrics m = stage.compare(narrow, {&probe, 1}).metrics;
    ASSERT_TRUE(m.penumbraError);
    EXPECT_NEAR(*m.penumbraError, 1.0 - 2.4 / width, 0.02);

    // Where the map's texels are too coarse for a penumbra, its drawn width is told in these.
    Answer coarse = narrow;
    coarse.texels.assign(coarse.texels.size(), 2.0f);
    const Metrics c = stage.compare(coarse, {&probe, 1}).metrics;
    EXPECT_FALSE(c.penumbraError);
    ASSERT_TRUE(c.penumbraTexels);
    EXPECT_NEAR(*c.penumbraTexels, 2.4 / std::sqrt(2.0) / 2.0, 0.02);

    // One that is not drawn at all is all wrong.
    Answer none = stage.perfect(true);
    none.visibility.assign(none.visibility.size(), 1.0f);
    EXPECT_EQ(stage.compare(none, {&probe, 1}).metrics.penumbraError, 1.0);
}

TEST(Metrics, PeterPanningIsTheGapAtTheFoot) {
    RayWorld world = wall();
    const Stage stage(world);
    Probe probe;
    probe.kind = Probe::Kind::Contact;
    probe.from = {0.5, 2, 0};
    probe.to = {8.5, 2, 0};
    const Metrics perfect = stage.compare(stage.perfect(false), {&probe, 1}).metrics;
    ASSERT_TRUE(perfect.peterPanningMetres);
    EXPECT_EQ(*perfect.peterPanningMetres, 0.0);
    Answer off = stage.perfect(false);
    for (std::size_t i = 0; i < off.visibility.size(); ++i)
        if (stage.onFloor(i) && Stage::xOf(i) > 0.0 && Stage::xOf(i) < 2.5)
            off.visibility[i] = 1.0f;
    const Metrics m = stage.compare(off, {&probe, 1}).metrics;
    ASSERT_TRUE(m.peterPanningMetres);
    // Whole pixels; and the wall, nearer to the eye than its foot, hides the first of them.
    EXPECT_NEAR(*m.peterPanningMetres, 1.9, kMetresPerPixel);
}
