// Hard cases of towns: slopes, thin bars, leaves, sheets of one side.
#include "bench/scene_making.h"

#include <array>
#include <cmath>

namespace gnomon::bench {

namespace {

constexpr glm::vec3 kMeadow{0.52f, 0.56f, 0.38f}, kPaving{0.72f, 0.71f, 0.68f};
constexpr glm::vec3 kTrunk{0.42f, 0.33f, 0.26f}, kIron{0.34f, 0.38f, 0.40f};

struct House {
    glm::dvec3 at{0.0}; // the middle of its floor, on the lowest ground around it
    glm::dvec2 half{5.0, 4.0};
    double eaves = 5.5, ridge = 9.0;
    bool ridgeAlongX = true;
    glm::vec3 wall{0.88f, 0.84f, 0.76f}, roof{0.62f, 0.34f, 0.28f};
};

// Walls and gables as one closed body, the roof as two slabs with eaves that stand out, a chimney.
void addHouse(Shape& into, const House& house) {
    const auto at = [&](double along, double across, double z) {
        return house.at +
               (house.ridgeAlongX ? glm::dvec3(along, across, z) : glm::dvec3(-across, along, z));
    };
    const double l = house.ridgeAlongX ? house.half.x : house.half.y;
    const double w = house.ridgeAlongX ? house.half.y : house.half.x;
    constexpr double kSunk = -0.6, kRoof = 0.22, kOverhang = 0.5;
    // The gable's outline, counter-clockwise seen from the end the axis comes from.
    const std::array<glm::dvec2, 5> outline = {
        {{-w, kSunk}, {w, kSunk}, {w, house.eaves}, {0, house.ridge}, {-w, house.eaves}}};
    std::vector<glm::dvec3> low, high;
    into.setColor(house.wall);
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 p = outline[i], q = outline[(i + 1) % outline.size()];
        const glm::dvec2 r = outline[outline.size() - 1 - i];
        high.push_back(at(l, p.x, p.y)); // seen along -axis, across runs to the right
        low.push_back(at(-l, r.x, r.y));
        into.quad(at(-l, p.x, p.y), at(-l, q.x, q.y), at(l, q.x, q.y), at(l, p.x, p.y));
    }
    into.face(high);
    into.face(low);
    into.setColor(house.roof);
    const glm::dvec2 down = glm::normalize(glm::dvec2(w, house.eaves - house.ridge));
    const glm::dvec2 normal(-down.y, down.x);
    for (const double side : {-1.0, 1.0}) {
        const glm::dvec2 top = glm::dvec2(0.0, house.ridge) + (0.5 * kRoof + 0.01) * normal;
        const glm::dvec2 foot =
            top + (glm::length(glm::dvec2(w, house.ridge - house.eaves)) + kOverhang) * down;
        const glm::dvec2 middle = 0.5 * (top + foot);
        const double half = 0.5 * glm::length(foot - top);
        std::array<glm::dvec2, 4> cut = {{middle - half * down - 0.5 * kRoof * normal,
                                          middle + half * down - 0.5 * kRoof * normal,
                                          middle + half * down + 0.5 * kRoof * normal,
                                          middle - half * down + 0.5 * kRoof * normal}};
        if (side < 0)
            cut = {{{-cut[1].x, cut[1].y},
                    {-cut[0].x, cut[0].y},
                    {-cut[3].x, cut[3].y},
                    {-cut[2].x, cut[2].y}}};
        const double end = l + kOverhang;
        std::vector<glm::dvec3> near, far;
        for (std::size_t i = 0; i < 4; ++i) {
            const glm::dvec2 p = cut[i], q = cut[(i + 1) % 4], r = cut[3 - i];
            far.push_back(at(end, p.x, p.y));
            near.push_back(at(-end, r.x, r.y));
            into.quad(at(-end, p.x, p.y), at(-end, q.x, q.y), at(end, q.x, q.y), at(end, p.x, p.y));
        }
        into.face(far);
        into.face(near);
    }
    into.setColor({0.56f, 0.40f, 0.34f});
    const double z = house.ridge - 0.25 * (house.ridge - house.eaves);
    builtin::addBar(into, at(0.5 * l, 0.25 * w, z - 0.8), at(0.5 * l, 0.25 * w, house.ridge + 0.9),
                    0.55, 0.55);
}

void addPickets(Shape& into, const glm::dvec3& a, const glm::dvec3& b, int pickets) {
    const glm::dvec3 up(0, 0, 1);
    for (int i = 0; i <= pickets; ++i) {
        const glm::dvec3 foot = glm::mix(a, b, double(i) / pickets);
        builtin::addBar(into, foot, foot + 1.1 * up, 0.05, 0.02);
    }
    for (const double z : {0.3, 0.85})
        builtin::addBar(into, a + z * up, b + z * up, 0.03, 0.06);
}

} // namespace

void makeHouseRow(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    constexpr double kSlope = 0.10, kHalf = 62.0;
    const auto ground = [&](double x) { return kSlope * (x + kHalf); };
    into.setColor(kMeadow);
    // A wedge that rises to the east: closed, standing on the flat ground.
    const std::array<glm::dvec2, 3> wedge = {
        {{-kHalf, -0.3}, {kHalf, -0.3}, {kHalf, ground(kHalf)}}};
    const auto corner = [&](std::size_t i, double y) {
        return glm::dvec3(wedge[i % 3].x, y, wedge[i % 3].y);
    };
    for (std::size_t i = 0; i < 3; ++i)
        into.quad(corner(i + 1, -40), corner(i, -40), corner(i, 40), corner(i + 1, 40));
    into.face(std::array{corner(0, -40), corner(1, -40), corner(2, -40)});
    into.face(std::array{corner(2, 40), corner(1, 40), corner(0, 40)});
    // The street, a slab that lies a little above the slope.
    into.setColor(kPaving);
    builtin::addBar(into, {-kHalf + 2, -9.5, ground(-kHalf + 2)},
                    {kHalf - 2, -9.5, ground(kHalf - 2)}, 5.0, 0.12);
    const glm::vec3 walls[] = {
        {0.90f, 0.86f, 0.78f}, {0.84f, 0.74f, 0.62f}, {0.80f, 0.84f, 0.84f}, {0.92f, 0.90f, 0.88f}};
    for (int i = 0; i < 8; ++i) {
        House house;
        const double x = -50.0 + 14.0 * i;
        house.ridgeAlongX = i % 3 != 1;
        house.half = {4.6 + 0.4 * (i % 2), 4.2};
        house.at = {x, 0.8 * (i % 2), ground(x - house.half.x)};
        house.eaves = 5.6 + 0.5 * (i % 3);
        house.ridge = house.eaves + 3.4;
        house.wall = walls[i % 4];
        addHouse(into, house);
        into.setColor({0.50f, 0.40f, 0.32f});
        addPickets(into, {x - 6.4, -5.8, ground(x - 6.4)}, {x + 5.0, -5.8, ground(x + 5.0)}, 60);
        into.setColor({0.36f, 0.48f, 0.30f});
        addCrown(into, {x + 7.0, -4.0, ground(x + 7.0) + 1.2}, {0.9, 0.9, 1.3}, 0.06);
    }
    scene.look = {{22.0, -26.0, 18.0}, {-7.0, -1.0, 6.5}, 46.0};
}

void makeBridge(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    constexpr double kHalf = 27.0, kDeck = 7.0, kSide = 3.4;
    into.setColor({0.66f, 0.64f, 0.58f});
    addBox(into, {-60, -45, -0.2}, {60, 45, 0.1});
    into.setColor({0.72f, 0.70f, 0.66f});
    for (const double x : {-kHalf, -9.0, 9.0, kHalf})
        addBox(into, {x - 0.8, -2.8, 0.1}, {x + 0.8, 2.8, kDeck - 0.5});
    for (const double side : {-1.0, 1.0})
        addBox(into, {side > 0 ? kHalf : -50, -4, 0.1}, {side > 0 ? 50 : -kHalf, 4, kDeck});
    into.setColor({0.5f, 0.5f, 0.5f});
    addBox(into, {-kHalf, -kSide, kDeck - 0.5}, {kHalf, kSide, kDeck});
    into.setColor({0.40f, 0.52f, 0.50f});
    for (const double y : {-kSide + 0.15, kSide - 0.15})
        addTruss(into, {-kHalf, y, kDeck + 0.15}, {kHalf, y, kDeck + 0.15}, 5.4, 18, 0.16);
    for (int i = 0; i <= 18; ++i) { // ties across, and crosses of rods between them
        const double x = -kHalf + 3.0 * i, z = kDeck + 5.55, y = kSide - 0.15;
        builtin::addBar(into, {x, -y, z}, {x, y, z}, 0.08, 0.10);
        if (i < 18) {
            addPipe(into, {x, -y, z}, {x + 3.0, y, z}, 0.015, 6);
            addPipe(into, {x, y, z}, {x + 3.0, -y, z}, 0.015, 6);
        }
    }
    into.setColor(kIron);
    for (const double y : {-kSide + 0.4, kSide - 0.4}) { // railings
        for (const double z : {0.4, 0.75, 1.1})
            addPipe(into, {-kHalf, y, kDeck + z}, {kHalf, y, kDeck + z}, 0.02, 6);
        for (int i = 0; i <= 54; ++i)
            addPipe(into, {-kHalf + i, y, kDeck}, {-kHalf + i, y, kDeck + 1.1}, 0.018, 6);
    }
    // Telegraph poles beside it, with wires of 2 cm.
    for (const double x : {-30.0, 0.0, 30.0}) {
        addPipe(into, {x, 12.0, 0.1}, {x, 12.0, 9.0}, 0.12, 12);
        builtin::addBar(into, {x, 11.0, 8.5}, {x, 13.0, 8.5}, 0.1, 0.12);
    }
    for (const double y : {11.1, 11.7, 12.3, 12.9})
        addPipe(into, {-30, y, 8.62}, {30, y, 8.62}, 0.01, 6);
    scene.look = {{20.0, 33.0, 17.5}, {-1.0, 4.0, 3.5}, 45.0};
}

void makeTrees(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    into.setColor({0.70f, 0.69f, 0.64f});
    addBox(into, {-32, -18, -0.2}, {32, 18, 0.1});
    into.setColor({0.80f, 0.78f, 0.74f});
    addBox(into, {-30, 8.5, 0.1}, {30, 8.9, 3.1}); // a wall behind, for shadows that stand
    for (int i = 0; i < 8; ++i) {
        const double x = -24.5 + 7.0 * i, y = 0.6 * (i % 3), height = 7.0 + 0.7 * ((i * 3) % 4);
        into.setColor(kTrunk);
        if (i % 2 == 0) {
            addPipe(into, {x, y, 0.1}, {x, y, 0.55 * height}, 0.16, 12);
            addCrossedQuads(scene.leaves, {x, y, 0.1 + 0.12 * height}, 0.82 * height, 0.9 * height,
                            4, 0.3 * i);
        } else {
            addPipe(into, {x, y, 0.1}, {x, y, 0.5 * height}, 0.18, 12);
            into.setColor({0.34f + 0.02f * float(i), 0.47f, 0.24f});
            addCrown(into, {x, y, 0.68 * height}, glm::dvec3(0.30, 0.30, 0.32) * height, 0.05);
        }
    }
    for (int i = 0; i < 14; ++i) // shrubs of leaves before the wall
        addCrossedQuads(scene.leaves, {-26.0 + 4.0 * i, 6.6 + 0.5 * (i % 2), 0.0}, 2.2, 2.0, 3,
                        0.7 * i);
    scene.look = {{-13.5, -13.5, 5.0}, {-1.5, 2.0, 2.9}, 48.0};
}

void makeShed(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    into.setColor(kPaving);
    addSheet(into, {-20, -14, 0.05}, {20, -14, 0.05}, {20, 14, 0.05}, {-20, 14, 0.05});
    // A lean-to, open to the front: walls that face outwards.
    into.setColor({0.72f, 0.75f, 0.74f});
    addSheet(into, {-4, 4, 0}, {-10, 4, 0}, {-10, 4, 2.6}, {-4, 4, 2.6});
    addSheet(into, {-10, 4, 0}, {-10, -1, 0}, {-10, -1, 3.2}, {-10, 4, 2.6});
    addSheet(into, {-4, -1, 0}, {-4, 4, 0}, {-4, 4, 2.6}, {-4, -1, 3.2});
    into.setColor({0.44f, 0.48f, 0.50f});
    addCorrugated(into, {-10.3, -1.5, 3.3}, {-3.7, -1.5, 3.3}, {-3.7, 4.3, 2.62},
                  {-10.3, 4.3, 2.62}, 24, 0.03);
    // A bus shelter whose sheets face inwards, roof and all.
    into.setColor({0.50f, 0.62f, 0.66f});
    addSheet(into, {0, 3, 0.1}, {5, 3, 0.1}, {5, 3, 2.4}, {0, 3, 2.4});
    addSheet(into, {0, 1, 0.1}, {0, 3, 0.1}, {0, 3, 2.4}, {0, 1, 2.4});
    addSheet(into, {0, 3.2, 2.45}, {5.2, 3.2, 2.45}, {5.2, 0.6, 2.45}, {0, 0.6, 2.45});
    into.setColor(kIron);
    for (const double x : {0.0, 5.0})
        for (const double y : {0.7, 3.0})
            addPipe(into, {x, y, 0}, {x, y, 2.44}, 0.03, 10);
    // A tent of two sheets, and a board that turns its back to the sun.
    into.setColor({0.80f, 0.60f, 0.36f});
    addSheet(into, {-3, -7, 0}, {1.5, -7, 0}, {1.5, -5.4, 2.1}, {-3, -5.4, 2.1});
    addSheet(into, {1.5, -3.8, 0}, {-3, -3.8, 0}, {-3, -5.4, 2.1}, {1.5, -5.4, 2.1});
    into.setColor({0.78f, 0.80f, 0.82f});
    addSheet(into, {10, 0.5, 0.9}, {6, -0.7, 0.9}, {6, -0.7, 3.4}, {10, 0.5, 3.4});
    into.setColor(kIron);
    for (const double t : {0.15, 0.85}) {
        const glm::dvec3 foot = glm::mix(glm::dvec3(6, -0.74, 0), glm::dvec3(10, 0.46, 0), t);
        addPipe(into, foot, foot + glm::dvec3(0, 0, 3.3), 0.04, 10);
    }
    // A fence of single sheets on edge, each with its gap.
    into.setColor({0.62f, 0.50f, 0.38f});
    for (int i = 0; i < 40; ++i) {
        const double x = -14.0 + 0.7 * i;
        addSheet(into, {x, 8, 0}, {x + 0.55, 8, 0}, {x + 0.55, 8, 1.6}, {x, 8, 1.6});
    }
    scene.look = {{9.5, -13.5, 7.0}, {1.2, 0.0, 1.0}, 46.0};
}

} // namespace gnomon::bench
