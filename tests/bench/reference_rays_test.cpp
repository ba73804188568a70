// Rays through triangles: what they hit, where, and from where they start.
#include "bench/reference.h"
#include "tests/bench/ray_world.h"
#include "viewer/ground.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

using namespace gnomon;
using namespace gnomon::bench;
using namespace gnomon::test;

namespace {

using Triangle = std::array<glm::dvec3, 3>;
const glm::dvec3 kUp(0, 0, 1);

} // namespace

TEST(Rays, NoRayLeavesAFinelyTessellatedBox) {
    std::mt19937 random(7);
    std::normal_distribution<double> any;
    for (const glm::dvec3& far : {glm::dvec3(0.0), glm::dvec3(14000, -14000, 300)}) {
        RayWorld world;
        const glm::dvec3 x = glm::normalize(glm::dvec3(0.8, 0.5, 0.3)),
                         y = glm::normalize(glm::cross(kUp, x));
        const glm::dmat3 turn(x, y, glm::cross(x, y));
        world.box({-5, -6, -4}, {5, 6, 4}, 40, turn, far);
        const RayScene scene = world.rays();
        int escaped = 0;
        for (int i = 0; i < 100000; ++i) {
            const glm::dvec3 from = far + 0.5 * glm::dvec3(any(random), any(random), any(random));
            // Half of them towards the corners that triangles share.
            const Mesh& mesh = world.content().meshes[0];
            const std::size_t corner = random() % mesh.positions.size();
            const glm::dvec3 to =
                i % 2 ? scene.stored(mesh.origin) + glm::dvec3(mesh.positions[corner])
                      : from + glm::dvec3(any(random), any(random), any(random));
            escaped += !scene.first(from, to - from).any;
            escaped += !scene.blocked(from, glm::dvec3(0.0), to - from);
        }
        EXPECT_EQ(escaped, 0);
    }
}

namespace {

// Points of a surface as a camera sees them, and how many the sun at `elevation` above it misses.
struct SelfShadow {
    int asked = 0, hard = 0, soft = 0;
};

SelfShadow selfShadow(const RayScene& scene, const glm::dvec3& eye, const glm::dvec3& target,
                      double spread, const glm::dvec3& normal, double elevation) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> across(-spread, spread);
    const glm::dvec3 u = glm::normalize(glm::cross(normal, glm::dvec3(0.3, 0.9, 0.1)));
    const glm::dvec3 v = glm::cross(normal, u);
    SelfShadow out;
    for (int i = 0; i < 400; ++i) {
        const double turn = 0.1 + i, e = elevation * kRadiansPerDegree;
        const SunDisc sun{std::sin(e) * normal +
                          std::cos(e) * (std::cos(turn) * u + std::sin(turn) * v)};
        const glm::dvec3 aim = target + across(random) * u + across(random) * v;
        const RayHit hit = scene.first(eye, aim - eye);
        if (!hit.any || glm::dot(hit.normal, normal) < 0.5)
            continue;
        ++out.asked;
        out.hard += scene.visibility(hit.position, hit.normal, sun, 1, 0) < 1.0;
        out.soft += scene.visibility(hit.position, hit.normal, sun, 16, std::uint32_t(i)) < 1.0;
    }
    return out;
}

} // namespace

TEST(Rays, APlaneDoesNotShadeItselfNearOrFarAtAnySun) {
    for (const double away : {0.0, 20000.0})
        for (const double tilt : {0.0, 0.37, 1.3}) {
            RayWorld world;
            const glm::dvec3 at(0.6 * away, 0.8 * away, -40.0);
            const glm::dvec3 u(std::cos(tilt), 0, std::sin(tilt)), v(0.0, 1.0, 0.0);
            const glm::dvec3 normal = glm::cross(u, v);
            // Meshes side by side, whose corners were rounded about origins of their own, and the
            // same plane once more in pieces that fit nowhere.
            for (int j = -2; j < 2; ++j)
                for (int i = -2; i < 2; ++i)
                    world.grid(at + 97.3 * i * u + 97.3 * j * v, 97.3 * u, 97.3 * v, 13);
            world.grid(at - 151.7 * u - 133.1 * v, 271.9 * u, 277.7 * v, 7);
            const RayScene scene = world.rays();
            for (const double elevation : {0.1, 0.3, 1.0, 5.0, 30.0, 60.0, 90.0}) {
                const SelfShadow s = selfShadow(scene, {3, -2, 1}, at, 120.0, normal, elevation);
                EXPECT_GT(s.asked, 300);
                EXPECT_EQ(s.hard, 0) << away << " m, tilt " << tilt << ", sun " << elevation;
                EXPECT_EQ(elevation < 0.3 ? 0 : s.soft, 0)
                    << away << " m, tilt " << tilt << ", sun " << elevation;
            }
        }
}

TEST(Rays, TheEarthDoesNotShadeItselfByDay) {
    Scene scene;
    scene.anchor = kPlace;
    scene.ecefFromAnchor = ecefFromEnu(kPlace);
    const ResidentTile ground{std::make_shared<TileContent>(makeGround(scene, 40.0)), 0};
    const auto rays =
        RayScene::build({&ground, 1}, scene.ecefFromAnchor.origin(), scene.ecefFromAnchor.axes());
    ASSERT_TRUE(rays);
    for (const double spread : {30.0, 3000.0, 20000.0})
        for (const double elevation : {0.5, 3.0, 45.0}) {
            const SelfShadow s =
                selfShadow(*rays, {0, 0, 500}, {100, 50, -15.0}, spread, kUp, elevation);
            EXPECT_GT(s.asked, 300);
            EXPECT_EQ(s.hard, 0) << spread << " m, sun " << elevation;
        }
}

TEST(Rays, PositionsAreThoseOfTheTrianglesKilometresAway) {
    RayWorld world;
    const glm::dvec3 corner(4000.3, 3000.7, -50.2), u(150.1, 3.3, 20.7), v(-2.2, 140.9, 11.1);
    world.grid(corner, u, v, 9);
    const RayScene scene = world.rays({10, 20, 30});
    const glm::dvec3 normal = glm::normalize(glm::cross(u, v));
    double worst = 0.0, worstNormal = 0.0, offRay = 0.0;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> within(0.02, 0.98);
    for (int i = 0; i < 1000; ++i) {
        const glm::dvec3 origin(10, 20, 30), eye(-3, 5, 200);
        const glm::dvec3 way = corner + within(random) * u + within(random) * v - origin - eye;
        const RayHit hit = scene.first(eye, way);
        ASSERT_TRUE(hit.any);
        worst = std::max(worst, std::abs(glm::dot(hit.position + origin - corner, normal)));
        worstNormal = std::max(worstNormal, glm::length(hit.normal - normal));
        offRay = std::max(offRay, glm::length(glm::cross(glm::normalize(way), hit.position - eye)));
        EXPECT_NEAR(hit.distanceMetres, glm::length(hit.position - eye), 1e-9);
        EXPECT_EQ(hit.mesh, (MeshId{1, 0}));
        EXPECT_LT(hit.triangle, 162u);
    }
    std::printf("[ measured ] off the plane %.2g m, off the ray %.2g m, normal %.2g\n", worst,
                offRay, worstNormal);
    EXPECT_LT(worst, 2e-5); // the rounding of corners 150 m about an origin
    EXPECT_LT(worstNormal, 2e-6);
    EXPECT_LT(offRay, 1e-8);
}

namespace {

// Möller & Trumbore's test, in double.
double distanceTo(const Triangle& t, const glm::dvec3& from, const glm::dvec3& way) {
    const glm::dvec3 u = t[1] - t[0], v = t[2] - t[0], p = glm::cross(way, v), s = from - t[0];
    const glm::dvec3 q = glm::cross(s, u);
    const double area = glm::dot(u, p);
    const double a = glm::dot(s, p) / area, b = glm::dot(way, q) / area;
    const double distance = glm::dot(v, q) / area;
    return a >= 0.0 && b >= 0.0 && a + b <= 1.0 && distance > 0.0 ? distance : 1e300;
}

} // namespace

TEST(Rays, TheFirstIsTheNearestOfAll) {
    std::mt19937 random(23);
    std::uniform_real_distribution<double> at(-20, 20), size(-7, 7);
    RayWorld world;
    std::vector<Triangle> triangles;
    for (int i = 0; i < 300; ++i) {
        Triangle t;
        const glm::dvec3 p(at(random), at(random), at(random));
        for (glm::dvec3& corner : t)
            corner = glm::vec3(p + glm::dvec3(size(random), size(random), size(random)));
        world.add({t[0], t[1], t[2]}, {0, 1, 2});
        triangles.push_back(t);
    }
    const RayScene scene = world.rays();
    int met = 0, missed = 0, cut = 0;
    for (int i = 0; i < 5000; ++i) {
        const glm::dvec3 from(at(random), at(random), at(random));
        const glm::dvec3 way = glm::normalize(glm::dvec3(at(random), at(random), at(random)));
        double nearest = 1e300;
        for (const Triangle& t : triangles)
            nearest = std::min(nearest, distanceTo(t, from, way));
        const RayHit hit = scene.first(from, way);
        ASSERT_EQ(hit.any, nearest < 1e300);
        ASSERT_EQ(scene.blocked(from, glm::dvec3(0.0), way), hit.any);
        ++(hit.any ? met : missed);
        if (!hit.any)
            continue;
        ASSERT_NEAR(hit.distanceMetres, nearest, 1e-4);
        ASSERT_LE(glm::dot(hit.normal, way), 0.0);
        const Triangle& t = triangles[hit.mesh.mesh];
        ASSERT_NEAR(distanceTo(t, from, way), nearest, 1e-4);
        // And nothing beyond the length that was asked for.
        ASSERT_FALSE(scene.first(from, way, nearest - 1e-3).any);
        ASSERT_TRUE(scene.first(from, way, nearest + 1e-3).any);
        ASSERT_EQ(scene.blocked(from, glm::dvec3(0.0), way, nearest - 1e-3), false);
        ++cut;
    }
    EXPECT_GT(met, 1000);
    EXPECT_GT(missed, 200);
    EXPECT_GT(cut, 1000);
}

TEST(Rays, AFootCastsFromItsVeryContactOn) {
    RayWorld world;
    world.grid({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, 10);
    world.quad({0, -20, 0}, {0, 20, 0}, {0, 20, 5}, {0, -20, 5});
    for (const double away : {0.0, 3000.0}) {
        const RayScene scene = world.rays({away, 0, 0});
        const SunDisc sun{directionAt(270, 30)};
        for (const double x : {1e-3, 1e-2, 0.1, 1.0}) {
            EXPECT_EQ(scene.visibility({x - away, 1, 0}, kUp, sun, 64, 1), 0.0) << x;
            EXPECT_EQ(scene.visibility({-x - away, 1, 0}, kUp, sun, 64, 1), 1.0) << x;
        }
    }
}

namespace {

// A leaf over the floor: 4 m square, 2 m up, with a texture of 8 by 8.
RayWorld leafOverFloor(const Image& image, const Material& look, double repeats) {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    Mesh& leaf = world.quad({0, 0, 2}, {4, 0, 2}, {4, 4, 2}, {0, 4, 2});
    const float r = float(repeats);
    leaf.uvs = {{0, 0}, {r, 0}, {r, r}, {0, r}};
    leaf.material = 1;
    world.content().materials.push_back(look);
    world.content().images.push_back(image);
    return world;
}

Image checkers(int side) {
    Image image{side, side, std::vector<std::uint8_t>(std::size_t(4 * side * side), 255)};
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x)
            image.rgba[std::size_t(4 * (y * side + x) + 3)] = (x / 2 + y / 2) % 2 ? 255 : 0;
    return image;
}

} // namespace

TEST(Rays, LeavesLetRaysThroughWhereTheyAreClear) {
    for (const Wrap wrap : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge})
        for (const bool nearest : {true, false}) {
            Material look;
            look.image = 0;
            look.alphaTest = true;
            look.nearestFilter = nearest;
            look.wrapS = look.wrapT = wrap;
            const RayScene scene = leafOverFloor(checkers(8), look, 2.0).rays();
            int clear = 0, solid = 0;
            for (int j = 0; j < 16; ++j)
                for (int i = 0; i < 16; ++i) {
                    // The middle of a pair of texels' inner half, where no filter mixes.
                    const auto folded = [&](int t) {
                        return t < 8                       ? t
                               : wrap == Wrap::Repeat      ? t - 8
                               : wrap == Wrap::ClampToEdge ? 7
                                                           : 15 - t;
                    };
                    const bool opaque = (folded(i) / 2 + folded(j) / 2) % 2;
                    const glm::dvec3 p(0.25 * (i + 0.5), 0.25 * (j + 0.5), 0.0);
                    const double lit = scene.visibility(p, kUp, SunDisc{kUp, 0.533}, 16, 1);
                    EXPECT_EQ(lit, opaque ? 0.0 : 1.0) << i << " " << j << " " << int(wrap);
                    const RayHit seen = scene.first(p + glm::dvec3(0, 0, 5), -kUp);
                    EXPECT_NEAR(seen.position.z, opaque ? 2.0 : 0.0, 1e-6);
                    clear += !opaque, solid += opaque;
                }
            EXPECT_GT(clear, 60);
            EXPECT_GT(solid, 60);
        }
}

TEST(Rays, LinearFilteringMovesALeafsEdge) {
    Image image{2, 1, {0, 0, 0, 255, 0, 0, 0, 0}}; // solid, clear
    Material look;
    look.image = 0;
    look.alphaTest = true;
    look.wrapS = Wrap::ClampToEdge;
    look.alphaCutoff = 0.25f; // alpha falls from 1 to 0 between x = 1 and 3: 0.25 at 2.5
    const RayScene scene = leafOverFloor(image, look, 1.0).rays();
    EXPECT_TRUE(scene.blocked({2.49, 1, 0}, kUp, kUp));
    EXPECT_FALSE(scene.blocked({2.51, 1, 0}, kUp, kUp));
    look.baseColor.a = 0.5f; // … and 0.5 of it at 2.0
    const RayScene thin = leafOverFloor(image, look, 1.0).rays();
    EXPECT_TRUE(thin.blocked({1.99, 1, 0}, kUp, kUp));
    EXPECT_FALSE(thin.blocked({2.01, 1, 0}, kUp, kUp));
    look.alphaTest = false;
    EXPECT_TRUE(leafOverFloor(image, look, 1.0).rays().blocked({3.5, 1, 0}, kUp, kUp));
}
