// Scenes to measure by: penumbrae of known width, and where shadows begin at walls.
#include "bench/scene_making.h"

#include <array>
#include <cmath>

namespace gnomon::bench {

namespace {

constexpr double kFloor = 0.1;
constexpr glm::vec3 kFloorColor{0.76f, 0.75f, 0.72f};

} // namespace

// Blades hang from masts at heights that put their northern edges' gaps along the rays of the
// scene's own sun (from the south, 50° up) at round numbers. Each mast stands as far south as its
// shadow is long, so that all shadows end side by side before the eye; widths leave room for the
// penumbrae, 9.3 mm a metre of gap.
void makeTower(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    into.setColor(kFloorColor);
    addBox(into, {-20, -150, -0.3}, {34, 24, kFloor});
    struct Blade {
        double gap, x0, x1;
    };
    constexpr std::array<Blade, 6> blades = {{{5, 0.0, 1.5},
                                              {10, 2.2, 3.9},
                                              {20, 4.8, 6.8},
                                              {50, 8.2, 10.8},
                                              {100, 13.0, 16.4},
                                              {200, 20.0, 25.2}}};
    constexpr double kElevation = 50.0 * kRadiansPerDegree, kDepth = 6.0, kThick = 0.1;
    for (const Blade& blade : blades) {
        const double top = kFloor + blade.gap * std::sin(kElevation);
        const double north = 4.0 - blade.gap * std::cos(kElevation); // shadows end at y = 4
        into.setColor({0.70f, 0.42f, 0.30f});
        addBox(into, {blade.x0, north - kDepth, top - kThick}, {blade.x1, north, top});
        // The mast stands clear of the probes, at the blade's western corner, and ends under it.
        into.setColor({0.45f, 0.48f, 0.50f});
        const double half = std::min(0.02 + 0.001 * blade.gap, 0.15);
        const glm::dvec3 foot(blade.x0 + half, north - kDepth + half, kFloor);
        addBox(into, foot - glm::dvec3(half, half, 0),
               {foot.x + half, foot.y + half, top - kThick});
        const double least = 0.2;
        const bool sunInTheNorth = scene.towardsSun().y > 0.0;
        const auto line = [&](double y, double z) {
            scene.probeEdge({blade.x0, y, z}, {blade.x1, y, z}, {0, y == north ? -1.0 : 1.0, 0},
                            kFloor, least);
        };
        line(north, sunInTheNorth ? top - kThick : top);
        line(north - kDepth, sunInTheNorth ? top : top - kThick);
    }
    scene.look = {{-4.5, 8.2, 6.2}, {5.6, 1.9, 0.0}, 50.0};
}

// Walls along west to east, lit from the south: their shadows begin at their northern feet.
void makeContactWall(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    into.setColor(kFloorColor);
    addBox(into, {-14, -10, -0.3}, {14, 10, kFloor});
    constexpr double kHeight = 2.0, kLength = 2.6;
    const auto wall = [&](double x, double thick, const glm::vec3& color, bool underside) {
        into.setColor(color);
        const std::array corners = {glm::dvec2(x, -thick), glm::dvec2(x + kLength, -thick),
                                    glm::dvec2(x + kLength, 0.0), glm::dvec2(x, 0.0)};
        std::vector<glm::dvec3> roof;
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::dvec2 a = corners[i], b = corners[(i + 1) % 4];
            roof.emplace_back(a, kFloor + kHeight);
            if (!underside)
                into.quad({a, kFloor}, {b, kFloor}, {b, kFloor + kHeight}, {a, kFloor + kHeight});
        }
        if (underside)
            addBox(into, {corners[0], kFloor}, {corners[2], kFloor + kHeight});
        else
            into.face(roof);
        const double away = scene.towardsSun().y < 0.0 ? 1.0 : -1.0;
        const glm::dvec3 foot(x + 0.5 * kLength, away > 0 ? 0.0 : -thick, kFloor);
        // Within the shadow for any sun above the horizon and within 45° of square on.
        const double reach = std::min(0.8, 0.6 * std::abs(scene.towardsSun().y) * kHeight /
                                               std::max(scene.towardsSun().z, 1e-3));
        if (scene.towardsSun().z > 0.0 && reach > 0.05)
            scene.probes.push_back(
                {Probe::Kind::Contact, foot, foot + glm::dvec3(0, away * reach, 0), 0.0});
    };
    wall(-9.4, 0.05, {0.62f, 0.68f, 0.76f}, true);
    wall(-6.2, 0.15, {0.76f, 0.60f, 0.44f}, true);
    wall(-3.0, 0.30, {0.56f, 0.66f, 0.48f}, true);
    wall(0.2, 1.00, {0.72f, 0.50f, 0.42f}, true);
    wall(3.4, 0.30, {0.66f, 0.56f, 0.70f}, false);
    // One plane, without thickness, facing north.
    into.setColor({0.82f, 0.76f, 0.50f});
    const double x = 6.6;
    addSheet(into, {x + kLength, 0, kFloor}, {x, 0, kFloor}, {x, 0, kFloor + kHeight},
             {x + kLength, 0, kFloor + kHeight});
    const double away = scene.towardsSun().y < 0.0 ? 1.0 : -1.0;
    const glm::dvec3 foot(x + 0.5 * kLength, 0.0, kFloor);
    if (scene.towardsSun().z > 0.0 && std::abs(scene.towardsSun().y) > 0.05)
        scene.probes.push_back(
            {Probe::Kind::Contact, foot, foot + glm::dvec3(0, 0.5 * away, 0), 0.0});
    scene.look = {{-3.6, 11.4, 5.6}, {-1.3, 0.2, 0.5}, 46.0};
}

} // namespace gnomon::bench
