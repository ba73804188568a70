// Skirts hide from the eye where tiles of different detail do not meet. For light they are not
// there: not for the reference's rays, not in the maps of lamps.
#include "bench/reference.h"
#include "shadows/lamp_casters.h"
#include "tests/bench/ray_world.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A floor, and above it in one mesh a roof and, last, a skirt of two triangles.
RayWorld floorRoofAndSkirt() {
    RayWorld world;
    world.quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0});
    Mesh& mesh = world.add({{-5, -5, 10},
                            {5, -5, 10},
                            {5, 5, 10},
                            {-5, 5, 10},
                            {15, -5, 10},
                            {25, -5, 10},
                            {25, 5, 10},
                            {15, 5, 10}},
                           {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7});
    mesh.skirtTriangles = 2;
    return world;
}

} // namespace

TEST(Skirts, DoNotStopTheReferencesRays) {
    const bench::RayScene rays = floorRoofAndSkirt().rays();
    EXPECT_EQ(rays.triangles(), 4u);
    const glm::dvec3 up(0, 0, 1);
    EXPECT_TRUE(rays.blocked({0, 0, 0}, up, up));
    EXPECT_FALSE(rays.blocked({20, 0, 0}, up, up));
    EXPECT_FALSE(rays.first({20, 0, 20}, up).any);
}

TEST(Skirts, AreNotInTheMapsOfLamps) {
    RayWorld world = floorRoofAndSkirt();
    Lamp lamp;
    lamp.position = world.ecefFromPlace()(Point<Enu>{{0, 0, 30}});
    lamp.rangeMetres = 200.0;
    const Transform<LampFrame, Ecef> fromEcef = lampFromEcef(world.ecefFromPlace(), lamp);
    LampMaps maps;
    maps.method = LampMethod::Cube;
    maps.count = 6;
    const auto content = std::make_shared<TileContent>(world.content());
    const std::vector<LampCaster> casters{{content, 0, nullptr}, {content, 1, nullptr}};
    const LampGeometry with =
        lampGeometry(fromEcef, lamp, maps, world.ecefFromPlace().axes(), 0.5, casters);
    EXPECT_EQ(with.sourceTriangles, 4u);
    content->meshes[1].skirtTriangles = 0;
    const LampGeometry without =
        lampGeometry(fromEcef, lamp, maps, world.ecefFromPlace().axes(), 0.5, casters);
    EXPECT_EQ(without.sourceTriangles, 6u);
}
