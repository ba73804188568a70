// The ray-traced reference against what is known in closed form, and against rays in double through
// every triangle.
#include "bench/reference.h"
#include "bench/reference_disc.h"
#include "tests/bench/ray_world.h"
#include "tests/frame/sun_rays.h"
#include "tests/viewer/files.h"
#include "viewer/ground.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <random>
#include <thread>

using namespace gnomon;
using namespace gnomon::bench;
using namespace gnomon::test;

namespace {

const double kTangent = std::tan(0.5 * 0.533 * kRadiansPerDegree);
const glm::dvec3 kUp(0, 0, 1);

// Share of a unit disc beyond the line at `s` from its centre.
double discBeyond(double s) {
    s = std::clamp(s, -1.0, 1.0);
    return (std::acos(s) - s * std::sqrt(1.0 - s * s)) / std::numbers::pi;
}

// A reference's hard shadows against all triangles' in double, `origin` where the latter have the
// former's. Within `radius` of a shadow's edge neither is asked.
struct Agreement {
    int lit = 0, dark = 0, wrong = 0, edges = 0;
};
Agreement agreement(const Reference& reference, const SunRays& rays, const glm::dvec3& sun,
                    const glm::dvec3& origin, double leastFacing, double radius, double tolerance) {
    Agreement out;
    for (std::size_t i = 0; i < reference.surfaces.size(); ++i) {
        const SurfacePoint& p = reference.surfaces[i];
        if (!p.any || glm::dot(p.normal, sun) < leastFacing)
            continue;
        const auto truth = rays.around(p.position + origin, p.normal, radius, tolerance);
        out.edges += truth == SunRays::Answer::Edge;
        if (truth == SunRays::Answer::Edge)
            continue;
        const bool shadowed = truth == SunRays::Answer::Dark;
        (shadowed ? out.dark : out.lit) += 1;
        out.wrong += shadowed != (reference.hard[i] == 0.0f);
    }
    return out;
}

struct Penumbra {
    double worst = 0.0, bias = 0.0;
    int points = 0, between = 0;
};

// Across the penumbra of a roof whose edge is at x = 0, `height` above the floor.
Penumbra measurePenumbra(double height, double elevation, int rays) {
    RayWorld world;
    world.grid({-1000, -1000, 0}, {2000, 0, 0}, {0, 2000, 0}, 4);
    world.quad({-500, -1500, height}, {0, -1500, height}, {0, 1500, height}, {-500, 1500, height});
    const RayScene scene = world.rays({0, 0, 2});
    const glm::dvec3 towards = directionAt(270, elevation); // from the roof's side
    const double gap = height / towards.z;
    const double middle = -height * towards.x / towards.z;
    Penumbra out;
    for (int i = -60; i <= 60; ++i) {
        const double x = middle + 1.2 * gap * kTangent / towards.z * i / 60.0;
        const RayHit floor = scene.first({x, 0.3 * i, 1 - 2}, {0, 0, -1});
        const double lit = discBeyond(-(x - middle) * towards.z / (gap * kTangent));
        const double got = scene.visibility(floor.position, floor.normal, SunDisc{towards, 0.533},
                                            rays, std::uint32_t(i + 1000));
        out.worst = std::max(out.worst, std::abs(got - lit));
        out.bias += got - lit;
        out.between += got > 0.0 && got < 1.0;
        ++out.points;
    }
    out.bias = std::abs(out.bias) / out.points;
    return out;
}

} // namespace

TEST(Reference, PenumbraOfAHalfPlaneIsTheDiscsSegment) {
    for (const double height : {10.0, 200.0})
        for (const double elevation : {90.0, 40.0})
            for (const int rays : {64, 256, 1000}) {
                const Penumbra p = measurePenumbra(height, elevation, rays);
                std::printf("[ measured ] %g m, sun at %g°, %d rays: worst %.4f, mean %.5f\n",
                            height, elevation, rays, p.worst, p.bias);
                EXPECT_GT(p.between, 60);
                // A line cuts about 2 sqrt(N) of N strata, each wrong by half a ray at random.
                EXPECT_LT(p.worst, 2.0 / std::pow(double(rays), 0.75));
                EXPECT_LT(p.bias, 0.5 / std::pow(double(rays), 0.75));
            }
}

TEST(Reference, OneRayGoesToTheCentre) {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    world.quad({-50, -50, 10}, {0, -50, 10}, {0, 50, 10}, {-50, 50, 10});
    const RayScene scene = world.rays();
    const SunDisc sun{kUp, 0.533};
    for (std::uint32_t seed = 0; seed < 100; ++seed) {
        EXPECT_EQ(scene.visibility({-1e-4, 0, 0}, kUp, sun, 1, seed), 0.0);
        EXPECT_EQ(scene.visibility({1e-4, 0, 0}, kUp, sun, 1, seed), 1.0);
    }
}

TEST(Reference, NothingShinesOnASurfaceTurnedAwayAndHalfASunOnTheHorizon) {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    const RayScene scene = world.rays();
    EXPECT_EQ(scene.visibility({0, 0, 0}, kUp, SunDisc{directionAt(90, -0.01)}, 64, 1), 0.0);
    EXPECT_EQ(scene.visibility({0, 0, 0}, -kUp, SunDisc{directionAt(90, 30)}, 64, 1), 0.0);
    EXPECT_NEAR(scene.visibility({0, 0, 0}, kUp, SunDisc{directionAt(90, 1e-4)}, 256, 1), 0.5,
                0.02);
    EXPECT_NEAR(scene.visibility({0, 0, 0}, kUp, SunDisc{directionAt(90, 0.13325)}, 256, 1),
                discBeyond(-0.5), 0.02);
    EXPECT_EQ(scene.visibility({0, 0, 0}, kUp, SunDisc{directionAt(90, 0.27)}, 256, 1), 1.0);
    // Rays that sink below the surface do not count, even where they miss its edge.
    EXPECT_NEAR(scene.visibility({49.9999, 0, 0}, kUp, SunDisc{directionAt(90, 1e-4)}, 256, 1), 0.5,
                0.02);
}

TEST(Reference, LampsShineFromAPointAndIntoHalfOfSpace) {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    world.quad({2, -1, 0}, {2, 1, 0}, {2, 1, 2}, {2, -1, 2});
    world.quad({-9, -9, 9}, {9, -9, 9}, {9, 9, 9}, {-9, 9, 9}); // above the lamp
    const RayScene scene = world.rays();
    const LampPoint all{{0, 0, 4}};
    EXPECT_EQ(scene.visibility({1, 0, 0}, kUp, all, 16, 1), 1.0);
    EXPECT_EQ(scene.visibility({3, 0, 0}, kUp, all, 16, 1), 0.0);
    EXPECT_EQ(scene.visibility({3.99, 0, 0}, kUp, all, 1, 1), 0.0);
    EXPECT_EQ(scene.visibility({4.01, 0, 0}, kUp, all, 1, 1), 1.0) << "over the wall";
    EXPECT_EQ(scene.visibility({3, 1.6, 0}, kUp, all, 1, 1), 1.0) << "past its side";
    EXPECT_EQ(scene.visibility({0, 0, 9}, -kUp, all, 1, 1), 1.0);
    EXPECT_EQ(scene.visibility({0, 0, 9}, kUp, all, 1, 1), 0.0) << "turned away";
    const LampPoint down{{0, 0, 4}, {0, 0, -1}};
    EXPECT_EQ(scene.visibility({1, 0, 0}, kUp, down, 1, 1), 1.0);
    EXPECT_EQ(scene.visibility({0, 0, 9}, -kUp, down, 1, 1), 0.0) << "behind it";
}

TEST(Reference, IsTheSameToTheByteOnAnyNumberOfThreads) {
    RayWorld world;
    world.grid({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, 20);
    for (int i = 0; i < 30; ++i)
        world.box({-40 + 2.7 * i, 3.0 * (i % 7), 0},
                  {-38.5 + 2.7 * i, 3.0 * (i % 7) + 2, 4 + i % 5});
    const Camera camera = world.camera({-30, -60, 40}, {0, 0, 0}, 97, 61);
    ReferenceOptions options;
    options.light = SunDisc{directionAt(160, 35), 6.0};
    options.raysPerPixel = 32;
    std::vector<Reference> traced;
    for (const unsigned threads : {1u, 2u, 3u, 1u}) {
        options.threads = threads;
        const RayScene scene = world.rays({-30, -60, 40});
        auto reference = traceReference(scene, camera, options);
        ASSERT_TRUE(reference);
        traced.push_back(std::move(reference).value());
    }
    int between = 0;
    for (const float v : traced[0].visibility)
        between += v > 0.0f && v < 1.0f;
    EXPECT_GT(between, 50);
    for (const Reference& r : traced) {
        EXPECT_EQ(r.visibility, traced[0].visibility);
        EXPECT_EQ(r.hard, traced[0].hard);
        ASSERT_EQ(r.surfaces.size(), traced[0].surfaces.size());
        for (std::size_t i = 0; i < r.surfaces.size(); ++i) {
            EXPECT_EQ(r.surfaces[i].any, traced[0].surfaces[i].any);
            EXPECT_EQ(std::memcmp(&r.surfaces[i].position, &traced[0].surfaces[i].position,
                                  2 * sizeof(glm::dvec3)),
                      0);
            EXPECT_EQ(r.surfaces[i].mesh, traced[0].surfaces[i].mesh);
        }
    }
}

TEST(Reference, APictureIsWhatItsPixelsRaysSay) {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    world.box({-2, -2, 0}, {2, 2, 6});
    const glm::dvec3 eye(-10, -20, 15);
    const Camera camera = world.camera(eye, {0, 0, 8}, 64, 36);
    const RayScene scene = world.rays(eye);
    const SunDisc sun{directionAt(60, 25), 3.0};
    const auto reference = traceReference(scene, camera, {sun, 16, 0});
    ASSERT_TRUE(reference);
    EXPECT_EQ(reference->width, 64);
    EXPECT_EQ(reference->height, 36);
    EXPECT_EQ(reference->raysPerPixel, 16);
    int sky = 0, away = 0, dark = 0, lit = 0;
    for (std::size_t i = 0; i < reference->surfaces.size(); ++i) {
        const SurfacePoint& p = reference->surfaces[i];
        if (!p.any) {
            ++sky;
            EXPECT_EQ(reference->visibility[i], 1.0f);
            continue;
        }
        const double hard = scene.visibility(p.position, p.normal, sun, 1, 0);
        EXPECT_EQ(double(reference->hard[i]), hard);
        EXPECT_EQ(double(reference->visibility[i]),
                  scene.visibility(p.position, p.normal, sun, 16, std::uint32_t(i)));
        // Back through the pixel's centre.
        const glm::dvec3 forward = scene.stored(camera.forward);
        EXPECT_NEAR(p.viewDepthMetres, glm::dot(p.position, forward), 1e-9);
        const double x = glm::dot(p.position, scene.stored(camera.right)) / p.viewDepthMetres;
        const double y = glm::dot(p.position, scene.stored(camera.up)) / p.viewDepthMetres;
        EXPECT_NEAR((x / camera.tanHalfWidth() + 1.0) * 32.0, double(i % 64) + 0.5, 1e-9);
        EXPECT_NEAR((1.0 - y / camera.tanHalfHeight()) * 18.0, double(i / 64) + 0.5, 1e-9);
        const bool turned = glm::dot(p.normal, sun.towards) <= 0.0;
        away += turned, dark += !turned && hard == 0.0, lit += hard == 1.0;
    }
    EXPECT_GT(sky, 100);
    EXPECT_GT(away, 40);
    EXPECT_GT(dark, 40);
    EXPECT_GT(lit, 500);
}

TEST(Reference, TellsHowFarItIsAndStopsWhenAsked) {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    const Camera camera = world.camera({0, 0, 10}, {0, 0, 0}, 64, 48);
    const RayScene scene = world.rays();
    const auto caller = std::this_thread::get_id();
    for (const unsigned threads : {1u, 2u}) {
        int last = 0, calls = 0;
        const auto whole =
            traceReference(scene, camera, {SunDisc{kUp}, 4, threads}, [&](int done, int all) {
                EXPECT_EQ(std::this_thread::get_id(), caller);
                EXPECT_EQ(all, 48);
                EXPECT_GE(done, last);
                last = done;
                ++calls;
                return true;
            });
        EXPECT_TRUE(whole);
        EXPECT_EQ(last, 48);
        EXPECT_GE(calls, threads == 1 ? 48 : 1);
    }
    int last = 0;
    const auto stopped = traceReference(scene, camera, {SunDisc{kUp}, 4, 1}, [&](int done, int) {
        last = done;
        return done < 5;
    });
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().reason, "stopped");
    EXPECT_EQ(last, 5);
}

TEST(Reference, NothingToTraceIsSaid) {
    const auto none = RayScene::build({}, Point<Ecef>{}, glm::dmat3(1.0));
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().message(), "reference: there are no triangles to trace rays through");
    const ResidentTile empty{std::make_shared<TileContent>(), 1};
    EXPECT_FALSE(RayScene::build({&empty, 1}, Point<Ecef>{}, glm::dmat3(1.0)));
}

TEST(Reference, AgreesWithEveryTriangleTriedInDouble) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> at(-40, 40), size(-6, 6);
    RayWorld world;
    std::vector<Triangle> triangles;
    const auto add = [&](const Triangle& t) {
        world.add({t[0], t[1], t[2]}, {0, 1, 2});
        triangles.push_back(t);
    };
    add({glm::dvec3(-90, -90, 0), {90, -90, 0}, {90, 90, 0}});
    add({glm::dvec3(-90, -90, 0), {90, 90, 0}, {-90, 90, 0}});
    for (int i = 0; i < 250; ++i) {
        const glm::dvec3 p(at(random), at(random), 12 + 0.25 * at(random));
        const auto corner = [&] { return glm::vec3(size(random), size(random), size(random)); };
        add({p + glm::dvec3(corner()), p + glm::dvec3(corner()), p + glm::dvec3(corner())});
    }
    const glm::dvec3 eye(30, -70, 45);
    const RayScene scene = world.rays(eye);
    for (const double elevation : {8.0, 35.0, 80.0}) {
        const glm::dvec3 sun = directionAt(100, elevation);
        const auto reference =
            traceReference(scene, world.camera(eye, {0, 0, 5}, 160, 90), {SunDisc{sun}, 1, 0});
        ASSERT_TRUE(reference);
        const SunRays rays(triangles, sun);
        const Agreement found = agreement(*reference, rays, sun, eye, 1e-3, 1e-3, 0.02);
        EXPECT_EQ(found.wrong, 0) << elevation;
        EXPECT_LT(found.edges, 30);
        EXPECT_GT(found.lit, 1000);
        EXPECT_GT(found.dark, 1000);
    }
}

TEST(Parallel, DoesEveryItemOnceOnAnyNumberOfThreads) {
    for (const std::size_t count : {0u, 1u, 7u, 64u, 1000u})
        for (const unsigned threads : {0u, 1u, 2u, 9u}) {
            std::vector<std::atomic<int>> done(count);
            inParallel(count, 7, threads, [&](std::size_t begin, std::size_t end) {
                EXPECT_LE(end - begin, 7u);
                for (std::size_t i = begin; i < end; ++i)
                    ++done[i];
            });
            for (const auto& d : done)
                EXPECT_EQ(d, 1);
        }
}

TEST(RealTiles, AmsterdamsRaysAgreeWithEveryTriangleTriedInDouble) {
    GNOMON_NEEDS_DATA("tiles-amsterdam-b3dm");
    SceneOptions open;
    open.inputs = {data("tiles-amsterdam-b3dm/tileset.json")};
    Result<Scene> opened = openScene(open);
    ASSERT_TRUE(opened);
    Scene& scene = *opened;
    View above;
    above.eye = scene.ecefFromAnchor.origin();
    above.forward = -scene.ecefFromAnchor(Vector<Enu>{kUp});
    above.pixelMetres = 1e-3;
    const Settled settled = settle(*scene.layers[0].tileset, {&above, 1}, {1.0, false},
                                   std::chrono::steady_clock::now() + std::chrono::minutes(1));
    ASSERT_TRUE(settled.complete);
    std::vector<ResidentTile> tiles{{std::make_shared<TileContent>(makeGround(scene, 44.05)), 0}};
    for (const TileIndex tile : settled.selection.draw)
        tiles.push_back({scene.layers[0].tileset->content(tile), std::uint32_t(tiles.size())});

    Camera camera;
    camera.widthPixels = 160;
    camera.heightPixels = 90;
    place(camera, {4.9190299, 52.3861038, 96.34}, {25, -32, 0});
    const auto rays = RayScene::build(tiles, camera.position, scene.ecefFromAnchor.axes());
    ASSERT_TRUE(rays);
    std::vector<Triangle> triangles;
    for (const ResidentTile& tile : tiles)
        for (const Mesh& mesh : tile.content->meshes)
            for (std::size_t i = 0; i + 2 < mesh.indices.size() && tile.id != 0; i += 3) {
                Triangle& t = triangles.emplace_back();
                for (std::size_t k = 0; k < 3; ++k)
                    t[k] =
                        rays->stored(mesh.origin) + glm::dvec3(mesh.positions[mesh.indices[i + k]]);
            }
    const glm::dvec3 sun = rays->stored(sunFromAngles(105, 30, scene.anchor).towards);
    const auto reference = traceReference(*rays, camera, {SunDisc{sun}, 16, 0});
    ASSERT_TRUE(reference);
    const SunRays brute(triangles, sun);
    const Agreement found = agreement(*reference, brute, sun, glm::dvec3(0), 0.01, 0.01, 0.002);
    std::printf("[ measured ] %zu triangles; lit %d, dark %d, edge %d; wrong %d\n",
                triangles.size(), found.lit, found.dark, found.edges, found.wrong);
    EXPECT_EQ(found.wrong, 0);
    EXPECT_LT(found.edges, 200);
    EXPECT_GT(found.lit, 3000);
    EXPECT_GT(found.dark, 500);
}
