// The scenes that the papers show, but for the factory and the lamps.
#include "bench/scene_making.h"

#include <array>
#include <cmath>

namespace gnomon::bench {

namespace {

constexpr glm::vec3 kFloorColor{0.78f, 0.76f, 0.72f};
constexpr glm::vec3 kWallColor{0.82f, 0.80f, 0.77f};
constexpr glm::vec3 kClay{0.78f, 0.52f, 0.36f};
constexpr glm::vec3 kBlue{0.36f, 0.50f, 0.66f};
constexpr glm::vec3 kGreen{0.46f, 0.58f, 0.38f};
constexpr glm::vec3 kWood{0.62f, 0.46f, 0.30f};
// Floors are slabs on the ground: closed, and casters as everything.
constexpr double kFloor = 0.1;

void addFloor(MadeScene& scene, double halfX, double halfY) {
    scene.solids.setColor(kFloorColor);
    addBox(scene.solids, {-halfX, -halfY, -0.2}, {halfX, halfY, kFloor});
}

// The edge of a level slab: its upper or lower line bounds the shadow, by where the sun is.
void probeSlab(MadeScene& scene, glm::dvec3 a, glm::dvec3 b, const glm::dvec3& outward,
               double thickness, double level) {
    if (glm::dot(scene.towardsSun(), outward) > 0.0)
        a.z -= thickness, b.z -= thickness;
    scene.probeEdge(a, b, -outward, level);
}

} // namespace

void makeLShape(MadeScene& scene, const Geodetic&) {
    addFloor(scene, 12, 9);
    scene.solids.setColor(kClay);
    // An L in the plane of x and up, seen from the south.
    constexpr std::array<glm::dvec2, 6> outline = {
        {{-2.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}, {-1.0, 1.0}, {-1.0, 4.0}, {-2.0, 4.0}}};
    constexpr double kHalfDepth = 0.8;
    const auto at = [&](std::size_t i, double y) {
        const glm::dvec2 p = outline[i % outline.size()];
        return glm::dvec3(p.x, y, kFloor + p.y);
    };
    std::vector<glm::dvec3> front, back;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        front.push_back(at(i, -kHalfDepth));
        back.push_back(at(outline.size() - i, kHalfDepth));
        scene.solids.quad(at(i + 1, -kHalfDepth), at(i, -kHalfDepth), at(i, kHalfDepth),
                          at(i + 1, kHalfDepth));
    }
    scene.solids.face(front);
    scene.solids.face(back);
    // The upright's top edge away from the sun, on the floor: 4 m up.
    if (scene.towardsSun().y < 0.0)
        scene.probeEdge({-2.0, kHalfDepth, kFloor + 4.0}, {-1.0, kHalfDepth, kFloor + 4.0},
                        {0, -1, 0}, kFloor);
    scene.look = {{8.5, -6.0, 6.0}, {0.4, 1.2, 1.3}, 40.0};
}

void makeDoubleTorus(MadeScene& scene, const Geodetic&) {
    addFloor(scene, 14, 10);
    scene.solids.setColor(kBlue);
    // A tube around the figure eight y² = x²(1 - x²), leaning back on the floor.
    constexpr double kScale = 4.2, kLean = 40.0 * kRadiansPerDegree;
    const double c = std::cos(kLean), s = std::sin(kLean);
    const glm::dvec3 centre(0.0, 0.0, kFloor + 2.72);
    const Field field{[=](const glm::dvec3& p) {
                          const glm::dvec3 d = (p - centre) / kScale;
                          const glm::dvec3 q(d.x, c * d.y + s * d.z, -s * d.y + c * d.z);
                          const double eight = q.x * q.x * (1.0 - q.x * q.x) - q.y * q.y;
                          return eight * eight + q.z * q.z * 0.35 - 0.016;
                      },
                      centre - glm::dvec3(5.4, 3.6, 3.6), centre + glm::dvec3(5.4, 3.6, 3.6)};
    constexpr double kStep = 0.06;
    addIsosurface(scene.solids, field, kStep);
    scene.look = {{4.5, -10.5, 7.5}, {0.2, 0.6, 1.9}, 42.0};
}

void makeFloorWallSpheres(MadeScene& scene, const Geodetic&) {
    addFloor(scene, 10, 7);
    scene.solids.setColor(kWallColor);
    addBox(scene.solids, {-10, 4.5, kFloor}, {10, 4.8, kFloor + 7});
    const auto ball = [&](const glm::vec3& color, double x, double y, double above, double r) {
        scene.solids.setColor(color);
        addSphere(scene.solids, {x, y, kFloor + above + r}, glm::dvec3(r), 40);
    };
    ball(kClay, -3.4, 1.6, 0.0, 1.1);
    ball(kBlue, 0.2, -0.8, 0.0, 0.8);
    ball(kGreen, 2.8, 1.4, 2.1, 0.75);
    ball(kClay, 4.6, -1.6, 0.0, 0.5);
    ball(kGreen, -1.4, -2.4, 0.0, 0.35);
    ball(kBlue, -0.9, 2.4, 3.6, 0.4);
    ball(kClay, 1.6, -2.9, 0.7, 0.22);
    // The wall's own top edge, on the ground behind it or on the floor before it.
    scene.look = {{-1.5, -9.2, 4.2}, {0.4, 1.6, 1.7}, 45.0};
}

void makeTableFloor(MadeScene& scene, const Geodetic&) {
    addFloor(scene, 5, 5);
    const glm::dvec3 size(2.2, 1.1, 0.75);
    const double top = kFloor + size.z;
    scene.solids.setColor(kWood);
    addTable(scene.solids, {0, 0, kFloor}, size);
    scene.solids.setColor({0.55f, 0.36f, 0.28f});
    addChair(scene.solids, {0.5, 0.8, kFloor}, 0.1);
    addChair(scene.solids, {-1.6, 0.05, kFloor}, 1.45);
    scene.solids.setColor(kBlue);
    addPipe(scene.solids, {-0.75, 0.12, top}, {-0.75, 0.12, top + 0.28}, 0.045, 32); // bottle
    addPipe(scene.solids, {-0.75, 0.12, top + 0.28}, {-0.75, 0.12, top + 0.36}, 0.015, 24);
    scene.solids.setColor({0.9f, 0.88f, 0.84f});
    addPipe(scene.solids, {-0.3, -0.2, top}, {-0.3, -0.2, top + 0.1}, 0.04, 32); // cups
    addPipe(scene.solids, {0.55, 0.22, top}, {0.55, 0.22, top + 0.1}, 0.04, 32);
    scene.solids.setColor(kGreen);
    addSphere(scene.solids, {0.18, -0.05, top + 0.09}, glm::dvec3(0.09),
              14); // fruit: rings wider than the weld
    addSphere(scene.solids, {0.36, -0.12, top + 0.06}, glm::dvec3(0.06), 12);
    scene.solids.setColor(kClay);
    addBox(scene.solids, {0.6, -0.35, top}, {0.9, -0.15, top + 0.05}); // books
    addBox(scene.solids, {0.63, -0.33, top + 0.05}, {0.87, -0.14, top + 0.08});
    const double x = size.x / 2, y = size.y / 2, slab = 0.04;
    // Away from legs and from what stands on it.
    probeSlab(scene, {-0.1 * x, -y, top}, {0.1 * x, -y, top}, {0, -1, 0}, slab, kFloor);
    probeSlab(scene, {x, 0.05 * y, top}, {x, 0.2 * y, top}, {1, 0, 0}, slab, kFloor);
    scene.look = {{1.5, -2.9, 2.2}, {0.1, -0.1, 0.5}, 44.0};
}

void makeWallNearEye(MadeScene& scene, const Geodetic&) {
    scene.solids.setColor(kFloorColor);
    addBox(scene.solids, {-6, -6, -0.2}, {14, 44, kFloor});
    scene.solids.setColor(kWallColor);
    addBox(scene.solids, {-0.9, -3, kFloor}, {-0.6, 40, kFloor + 3});
    // Posts with a rail in the sun's way: their shadows cross the floor and climb the wall.
    for (int i = 0; i < 16; ++i) {
        const double y = -3.7 + 2.6 * i;
        scene.solids.setColor(kClay);
        addBox(scene.solids, {3.4, y - 0.09, kFloor}, {3.58, y + 0.09, kFloor + 3.2});
        if (i % 3 == 1) {
            scene.solids.setColor(kBlue);
            addSphere(scene.solids, {3.49, y, kFloor + 3.45}, glm::dvec3(0.28), 24);
        }
    }
    scene.solids.setColor(kWood);
    builtin::addBar(scene.solids, {3.49, -4.7, kFloor + 2.6}, {3.49, 36.3, kFloor + 2.6}, 0.08,
                    0.12);
    scene.solids.setColor(kGreen);
    addBox(scene.solids, {1.6, 9, kFloor}, {2.4, 9.8, kFloor + 0.8});
    addBox(scene.solids, {1.2, 17, kFloor}, {2.2, 18, kFloor + 1.0});
    // The wall passes 35 cm beside the eye.
    scene.look = {{-0.25, 0.0, kFloor + 1.65}, {0.35, 8.0, kFloor + 0.9}, 55.0};
}

} // namespace gnomon::bench
