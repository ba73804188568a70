// A factory hall, open at its sides: closed bodies and sheets of one side in one scene, thin bars
// over long gaps.
#include "bench/scene_making.h"

#include <cmath>

namespace gnomon::bench {

namespace {

constexpr double kFloor = 0.1;
constexpr double kHalfLength = 24.0, kHalfWidth = 10.0, kEaves = 8.0, kBay = 6.0;
constexpr double kTrussHeight = 1.5;
constexpr glm::vec3 kSteel{0.42f, 0.48f, 0.52f}, kRust{0.60f, 0.36f, 0.26f};
constexpr glm::vec3 kYellow{0.86f, 0.66f, 0.18f}, kSheet{0.70f, 0.72f, 0.72f};

void addFrame(Shape& into) {
    into.setColor(kSteel);
    for (double x = -kHalfLength; x <= kHalfLength; x += kBay) {
        for (const double y : {-kHalfWidth, kHalfWidth})
            addBeam(into, {x, y, kFloor}, {x, y, kEaves}, 0.3, 0.3, 0.03);
        addTruss(into, {x, -kHalfWidth, kEaves}, {x, kHalfWidth, kEaves}, kTrussHeight, 10, 0.12);
    }
    for (int i = 0; i <= 10; ++i) { // purlins
        const double y = -kHalfWidth + 2.0 * i, z = kEaves + kTrussHeight + 0.1;
        builtin::addBar(into, {-kHalfLength, y, z}, {kHalfLength, y, z}, 0.06, 0.10);
    }
    for (const double y : {-kHalfWidth, kHalfWidth}) // braces
        for (const double x : {-kHalfLength, kHalfLength - kBay}) {
            addPipe(into, {x, y, kFloor}, {x + kBay, y, kEaves}, 0.025, 8);
            addPipe(into, {x + kBay, y, kFloor}, {x, y, kEaves}, 0.025, 8);
        }
}

// Roof in strips with light between, and two walls: sheets that face outwards only.
void addSheets(Shape& into) {
    const double z = kEaves + kTrussHeight + 0.2;
    for (int bay = 0; bay < 8; ++bay) {
        const double x0 = -kHalfLength + kBay * bay + 1.2, x1 = x0 + kBay - 2.0;
        into.setColor(kSheet * (bay % 2 ? 0.95f : 1.0f));
        const double south = bay < 5 ? -kHalfWidth - 0.5 : 1.0; // the east is half roofed
        addCorrugated(into, {x0, south, z}, {x1, south, z}, {x1, kHalfWidth + 0.5, z},
                      {x0, kHalfWidth + 0.5, z}, 10, 0.04);
    }
    into.setColor({0.55f, 0.62f, 0.60f});
    const double y = kHalfWidth + 0.25;
    addCorrugated(into, {kHalfLength, y, kFloor}, {-kHalfLength + 12, y, kFloor},
                  {-kHalfLength + 12, y, 6.0}, {kHalfLength, y, 6.0}, 60, 0.04);
    addSheet(into, {kHalfLength + 0.2, -4, 2.2}, {kHalfLength + 0.2, 8, 2.2},
             {kHalfLength + 0.2, 8, 6.5}, {kHalfLength + 0.2, -4, 6.5});
}

void addCrane(Shape& into) {
    into.setColor(kSteel);
    const double rail = 6.2, half = kHalfWidth - 0.6;
    for (const double y : {-half, half})
        addBeam(into, {-kHalfLength, y, rail}, {kHalfLength, y, rail}, 0.25, 0.45, 0.03);
    into.setColor(kYellow);
    for (const double x : {3.0, 4.6})
        addBeam(into, {x, -half, rail + 0.6}, {x, half, rail + 0.6}, 0.3, 0.6, 0.03);
    addBox(into, {2.8, 0.2, rail + 0.95}, {4.8, 1.8, rail + 1.35});
    into.setColor({0.2f, 0.2f, 0.2f});
    for (const double x : {3.65, 3.95})
        addPipe(into, {x, 1.0, 2.6}, {x, 1.0, rail + 1.0}, 0.012, 6);
    addBox(into, {3.55, 0.85, 2.2}, {4.05, 1.15, 2.6});
    into.setColor(kRust);
    addBeam(into, {1.6, 1.0, 1.9}, {6.0, 1.0, 1.9}, 0.3, 0.4, 0.03);
    for (const double x : {2.2, 5.4})
        addPipe(into, {x, 1.0, 2.1}, {3.8, 1.0, 2.4}, 0.012, 6);
}

void addPipes(Shape& into) {
    const double radii[] = {0.05, 0.12, 0.2, 0.08};
    for (int i = 0; i < 4; ++i) {
        into.setColor(i % 2 ? kRust : kSheet);
        const double y = 7.2 + 0.55 * i, z = 4.6;
        addPipe(into, {-kHalfLength, y, z}, {kHalfLength, y, z}, radii[i], 20);
    }
    into.setColor(kSteel);
    for (double x = -kHalfLength + 3; x < kHalfLength; x += kBay) { // their hangers
        addPipe(into, {x, 7.0, 4.25}, {x, 9.1, 4.25}, 0.03, 8);
        addPipe(into, {x, 7.1, 4.25}, {x, 7.1, kEaves}, 0.015, 6);
        addPipe(into, {x, 9.0, 4.25}, {x, 9.0, kEaves}, 0.015, 6);
    }
}

void addTank(Shape& into) {
    into.setColor({0.76f, 0.78f, 0.80f});
    const glm::dvec3 foot(-8.0, 5.0, kFloor);
    addPipe(into, foot, foot + glm::dvec3(0, 0, 3.6), 1.5, 48);
    into.setColor(kRust);
    addPipe(into, foot + glm::dvec3(0, 0, 3.5), foot + glm::dvec3(0, 0, 6.8), 0.18, 24);
    into.setColor(kYellow);
    addLadder(into, foot + glm::dvec3(0.2, -1.75, 0.0), foot + glm::dvec3(0.2, -1.75, 4.6),
              {0.22, 0, 0}, 14);
    for (int i = 0; i < 24; ++i) { // railing round its top
        const double a = 6.283185307179586 * i / 24, b = 6.283185307179586 * (i + 1) / 24;
        const auto at = [&](double angle, double z) {
            return foot + glm::dvec3(1.4 * std::cos(angle), 1.4 * std::sin(angle), z);
        };
        if (i % 2 == 0)
            addPipe(into, at(a, 3.58), at(a, 4.6), 0.015, 6);
        addPipe(into, at(a, 4.6), at(b, 4.6), 0.015, 6);
        addPipe(into, at(a, 4.1), at(b, 4.1), 0.01, 6);
    }
}

// A gangway of flat bars on legs.
void addGangway(Shape& into) {
    into.setColor(kSteel);
    const double z = 3.0;
    for (int i = 0; i <= 100; ++i)
        builtin::addBar(into, {6 + 0.16 * i, -4.6, z}, {6 + 0.16 * i, -3.4, z}, 0.03, 0.03);
    for (const double y : {-4.6, -3.4}) {
        addPipe(into, {6, y, z}, {22, y, z}, 0.04, 10);
        addPipe(into, {6, y, z + 1.05}, {22, y, z + 1.05}, 0.022, 8);
        for (double x = 6; x <= 22; x += 2)
            addPipe(into, {x, y, x > 6.5 && std::fmod(x - 6, 4) == 0 ? kFloor : z},
                    {x, y, z + 1.05}, 0.022, 8);
    }
    into.setColor(kYellow);
    addLadder(into, {5.7, -4.0, kFloor}, {5.7, -4.0, z + 1.0}, {0, 0.25, 0}, 12);
}

void addGoods(Shape& into) {
    into.setColor({0.66f, 0.52f, 0.34f});
    const glm::dvec3 crates[] = {{-14, -3, 1.2}, {-12.4, -3.2, 0.9}, {-13.4, -3.1, 2.1},
                                 {12, 3, 1.4},   {14, 2.2, 1.0},     {-2, -5.5, 0.8}};
    for (const glm::dvec3& c : crates) {
        const double low = c.z == 2.1 ? kFloor + 1.2 : kFloor, half = 0.45 + 0.15 * (c.z < 1.0);
        addBox(into, {c.x - half, c.y - half, low}, {c.x + half, c.y + half, kFloor + c.z});
    }
    into.setColor({0.30f, 0.44f, 0.56f});
    for (int i = 0; i < 5; ++i)
        addPipe(into, {-4.0 + 0.75 * i, -1.6, kFloor}, {-4.0 + 0.75 * i, -1.6, kFloor + 0.9}, 0.3,
                28);
    into.setColor(kSheet); // a screen of one thin sheet, leaning
    addSheet(into, {-18, 1, kFloor}, {-15, 1, kFloor}, {-15, 1.5, 2.4}, {-18, 1.5, 2.4});
}

} // namespace

void makeFactory(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    into.setColor({0.66f, 0.65f, 0.62f});
    addBox(into, {-kHalfLength - 6, -kHalfWidth - 8, -0.3},
           {kHalfLength + 6, kHalfWidth + 6, kFloor});
    addFrame(into);
    addSheets(into);
    addCrane(into);
    addPipes(into);
    addTank(into);
    addGangway(into);
    addGoods(into);
    scene.look = {{-21.0, -8.6, 5.2}, {3.0, 3.2, 2.4}, 58.0};
}

} // namespace gnomon::bench
