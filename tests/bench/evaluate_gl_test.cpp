// The whole measuring on small built-in scenes: techniques known to be good or bad come out so.
#include "bench/evaluate.h"
#include "bench/scenes.h"
#include "tests/frame/small_scene.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::bench;

namespace {

struct Bench {
    BenchScene scene;
    std::unique_ptr<FrameRenderer> renderer;

    explicit Bench(const char* name, int width = 240, int height = 135)
        : scene(std::move(openBenchScene(name)).value()) {
        scene.camera.widthPixels = width;
        scene.camera.heightPixels = height;
        renderer =
            std::move(FrameRenderer::create(test::softwareContext(), scene.scene, scene.frame))
                .value();
    }
    EvaluationInput input() {
        EvaluationInput in{scene.scene, *renderer, scene.frame,  scene.camera,
                           sun(),       {},        scene.probes, {}};
        in.raysPerPixel = 16;
        in.framesTimed = 1;
        return in;
    }
    SunPosition sun() const {
        return sunFromAngles(scene.sun.azimuthDegrees, scene.sun.elevationDegrees,
                             scene.scene.anchor);
    }
    FrameRequest request() const {
        FrameRequest request;
        request.camera = scene.camera;
        request.sun = sun();
        request.deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
        return request;
    }
};

Row measured(Evaluation& evaluation, const char* text) {
    Result<Row> row = evaluation.measure(parseOneTechnique(text, {}).value());
    if (!row)
        std::abort();
    return std::move(row).value();
}

} // namespace

TEST(Evaluation, ABadBiasIsFoundOutAndAGoodOneIsNot) {
    Bench bench("l-shape");
    auto prepared = Evaluation::prepare(bench.input(), {});
    ASSERT_TRUE(bool(prepared)) << prepared.error().message();
    EXPECT_GT(prepared->litFacing(), 1000u);
    EXPECT_TRUE(prepared->warnings().empty());

    const Row good = measured(*prepared, "csm+receiver-plane+pcss:16,32");
    ASSERT_FALSE(good.error);
    const Metrics& g = good.comparison.metrics;
    EXPECT_LE(g.falseLit + g.falseShadow, 0.001);
    EXPECT_EQ(g.acne, 0.0);
    EXPECT_LT(g.meanAbsolute, 0.005);
    EXPECT_GT(good.frameMs, 0.0);
    EXPECT_EQ(good.depthMs.size(), 4u);
    EXPECT_EQ(good.texelMetres.size(), 4u);
    EXPECT_GE(good.bytes, 4u * 2048 * 2048 * 4);
    EXPECT_EQ(good.lostCasters, 0u);
    EXPECT_FALSE(good.resolveMs);
    EXPECT_GT(measured(*prepared, "csm+dual-atomic+none").resolveMs.value_or(0.0), 0.0);

    const Row acne = measured(*prepared, "csm+constant:0+none@cascades=1@map-size=512");
    ASSERT_FALSE(acne.error);
    EXPECT_GT(acne.comparison.metrics.acne, 0.01);
    EXPECT_EQ(acne.texelMetres.size(), 1u);

    const Row leak = measured(*prepared, "csm+constant:1+none");
    ASSERT_FALSE(leak.error);
    EXPECT_GT(leak.comparison.metrics.leak, 10.0 * g.leak);
    EXPECT_GT(leak.comparison.metrics.falseLitAll, 10.0 * g.falseLitAll);
}

TEST(Evaluation, WhatCannotBeHadIsARowAndOffHasOnlyItsTime) {
    Bench bench("l-shape");
    auto prepared = Evaluation::prepare(bench.input(), {});
    ASSERT_TRUE(bool(prepared));
    const Row lamp = measured(*prepared, "paraboloid");
    ASSERT_TRUE(lamp.error);
    EXPECT_NE(lamp.error->reason.find("no lamp"), std::string::npos);
    const Row off = measured(*prepared, "off");
    EXPECT_FALSE(off.error);
    EXPECT_GT(off.frameMs, 0.0);
    EXPECT_EQ(off.comparison.metrics.litFacing, 0u);
    EXPECT_EQ(off.bytes, 0u);
}

TEST(Evaluation, StopsWhenItIsTold) {
    Bench bench("l-shape");
    const auto stopped =
        Evaluation::prepare(bench.input(), [](const char*, auto...) { return false; });
    EXPECT_FALSE(bool(stopped));
    int asked = 0;
    auto prepared = Evaluation::prepare(bench.input(), [&asked](const char* what, auto...) {
        asked += what == nullptr;
        return what != nullptr; // goes on until a technique is timed
    });
    ASSERT_TRUE(bool(prepared));
    EXPECT_FALSE(bool(prepared->measure(parseOneTechnique("csm", {}).value())));
    EXPECT_EQ(asked, 1);
}

// Maps drawn for a narrow view do not hold the houses around it.
TEST(Evaluation, CastersThatNoMapHoldsAreCounted) {
    Bench bench("place");
    auto prepared = Evaluation::prepare(bench.input(), {});
    ASSERT_TRUE(bool(prepared));
    const Row row = measured(*prepared, "csm+receiver-plane+bilinear");
    ASSERT_TRUE(row.lostCasters);
    EXPECT_EQ(*row.lostCasters, 0u);

    const std::vector<ResidentTile> resident = bench.renderer->residentTiles();
    const auto rays =
        RayScene::build(resident, bench.scene.camera.position, bench.renderer->meshAxes());
    ASSERT_TRUE(bool(rays));
    const bench::Light light = SunDisc{rays->stored(bench.sun().towards), 0.533};
    const auto reference = traceReference(*rays, bench.scene.camera, {light, 1, 0});
    ASSERT_TRUE(bool(reference));
    std::optional<std::string> warning;
    const FrameRequest request = bench.request();
    LostCasters lost = LostCasters::find(*rays, *reference, light, bench.scene.scene, resident,
                                         bench.scene.camera, 8.0, request.deadline, warning);
    EXPECT_FALSE(warning);
    EXPECT_EQ(lost.count(*bench.renderer, row.comparison), 0u);

    // The same surfaces, looked up in maps for a narrow view of the picture's lower edge.
    FrameRequest narrow = request;
    narrow.keepSurfaces = true;
    Orientation lower = orientationOf(request.camera);
    lower.pitchDegrees -= 0.4 * request.camera.verticalFovRadians / kRadiansPerDegree;
    place(narrow.camera, geodeticOf(request.camera.position), lower);
    narrow.camera.verticalFovRadians = 2.0 * kRadiansPerDegree;
    ASSERT_TRUE(bool(bench.renderer->draw(narrow)));
    const auto cascades = bench.renderer->aov(Aov::Cascade).values;
    ASSERT_TRUE(std::any_of(cascades.begin(), cascades.end(), [](float c) { return c < 4.0f; }));
    EXPECT_GT(lost.count(*bench.renderer, row.comparison).value_or(0), 3u);
}

// A frame that only holds what a narrow view needs lacks tiles whose shadows fall into a wide one.
TEST(Evaluation, CastersOfTilesThatAreNotThereAreCountedToo) {
    Bench bench("place");
    FrameRequest narrow = bench.request();
    Orientation lower = orientationOf(narrow.camera);
    lower.pitchDegrees -= 0.4 * narrow.camera.verticalFovRadians / kRadiansPerDegree;
    place(narrow.camera, geodeticOf(narrow.camera.position), lower);
    narrow.camera.verticalFovRadians = 2.0 * kRadiansPerDegree;
    ASSERT_TRUE(bool(bench.renderer->draw(narrow)));
    const std::vector<ResidentTile> resident = bench.renderer->residentTiles();
    const Camera& wide = bench.scene.camera;
    const auto rays = RayScene::build(resident, wide.position, bench.renderer->meshAxes());
    ASSERT_TRUE(bool(rays));
    const bench::Light light = SunDisc{rays->stored(bench.sun().towards), 0.533};
    const auto reference = traceReference(*rays, wide, {light, 1, 0});
    ASSERT_TRUE(bool(reference));
    std::optional<std::string> warning;
    LostCasters lost = LostCasters::find(*rays, *reference, light, bench.scene.scene, resident,
                                         wide, 8.0, narrow.deadline, warning);
    EXPECT_FALSE(warning);
    Comparison all;
    all.verdicts.assign(reference->surfaces.size(), Verdict::Right);
    const std::optional<std::uint64_t> before = lost.count(*bench.renderer, all);
    std::printf("[ measured ] %zu tiles, %llu lost\n", resident.size(),
                static_cast<unsigned long long>(before.value_or(0)));
    EXPECT_GT(before.value_or(0), 0u);
    // Once they are there and drawn they are lost no more.
    ASSERT_TRUE(bool(bench.renderer->draw(bench.request())));
    EXPECT_EQ(lost.count(*bench.renderer, all), 0u);
}

TEST(Flips, NothingFlickersInAStableCascadeAndAMapFittedToEachViewDoes) {
    Bench bench("l-shape");
    const std::vector<Camera> path = smallMotion(bench.scene.camera, 6);
    ASSERT_EQ(path.size(), 6u);
    EXPECT_NEAR(length(path[5].position - path[0].position), 5 * 0.017, 1e-4);
    const auto flipsOf = [&](const char* text, double blendFraction = 0.1) {
        FrameOptions options = bench.scene.frame;
        options.shadows = parseOneTechnique(text, {})->settings;
        options.shadows.blendFraction = blendFraction;
        bench.renderer->setOptions(options);
        return countFlips(*bench.renderer, bench.request(), options.shadows, path, {}).value();
    };
    const Flips stable = flipsOf("csm+receiver-plane+bilinear@fit=stable");
    EXPECT_GT(stable.asked, 50'000u);
    EXPECT_EQ(stable.flips, 0u);
    // Where two cascades are mixed nothing is asked: the wider that is the less.
    const Flips mixed = flipsOf("csm+receiver-plane+bilinear@fit=stable", 0.9);
    std::printf("[ measured ] asked %llu, %llu where most is mixed\n",
                static_cast<unsigned long long>(stable.asked),
                static_cast<unsigned long long>(mixed.asked));
    EXPECT_LT(mixed.asked, stable.asked / 2);
    EXPECT_GT(mixed.asked, 1000u);
    EXPECT_EQ(mixed.flips, 0u);
    const Flips fitted = flipsOf("perspective+receiver-plane+bilinear");
    EXPECT_GT(fitted.asked, 50'000u);
    EXPECT_GT(fitted.flips, 10u);
    EXPECT_FALSE(
        bool(countFlips(*bench.renderer, bench.request(), {}, path, [] { return false; })));
}
