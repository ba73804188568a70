// Rooms at night, with lamps: Brabec, Annen & Seidel, "Shadow mapping for hemispherical and
// omnidirectional light sources", 2002.
#include "bench/scene_making.h"

namespace gnomon::bench {

namespace {

constexpr glm::vec3 kPlaster{0.84f, 0.82f, 0.78f}, kWood{0.60f, 0.44f, 0.30f};
constexpr double kThick = 0.2;
// Of rooms of some metres: plaster 3 m away comes out bright, not white.
constexpr glm::vec3 kPower{16.0f, 14.5f, 12.0f};

// Six slabs that meet and do not overlap, round a room whose floor is at height 0.
void addRoom(Shape& into, double halfX, double halfY, double height) {
    const double x = halfX + kThick, y = halfY + kThick;
    into.setColor({0.62f, 0.58f, 0.54f});
    addBox(into, {-x, -y, -kThick}, {x, y, 0});
    into.setColor(kPlaster);
    addBox(into, {-x, -y, height}, {x, y, height + kThick});
    addBox(into, {-x, -y, 0}, {-halfX, y, height});
    addBox(into, {halfX, -y, 0}, {x, y, height});
    addBox(into, {-halfX, -y, 0}, {halfX, -halfY, height});
    addBox(into, {-halfX, halfY, 0}, {halfX, y, height});
}

void addShelf(Shape& into, const glm::dvec3& at, double width) {
    const double depth = 0.4, high = 2.1, board = 0.03;
    for (const double x : {0.0, width - board})
        addBox(into, at + glm::dvec3(x, 0, 0), at + glm::dvec3(x + board, depth, high));
    for (int i = 0; i < 5; ++i) {
        const double z = 0.1 + 0.48 * i;
        addBox(into, at + glm::dvec3(board, 0, z),
               at + glm::dvec3(width - board, depth, z + board));
        for (int book = 0; book < 6 && i < 4; ++book) {
            const double x = board + 0.05 + 0.14 * (book + (i + book) % 3);
            addBox(into, at + glm::dvec3(x, 0.05, z + board),
                   at + glm::dvec3(x + 0.05, 0.28, z + board + 0.22 + 0.03 * ((i * 5 + book) % 4)));
        }
    }
}

} // namespace

void makeLampRoom(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    constexpr double kHeight = 3.2;
    addRoom(into, 6.0, 4.5, kHeight);
    into.setColor({0.74f, 0.66f, 0.58f});
    for (const double x : {-3.2, 3.2})
        for (const double y : {-2.2, 2.2}) {
            addPipe(into, {x, y, 0}, {x, y, kHeight}, 0.22, 40);
            addBox(into, {x - 0.32, y - 0.32, 0}, {x + 0.32, y + 0.32, 0.15});
        }
    into.setColor(kWood);
    addTable(into, {1.3, 1.6, 0}, {1.6, 0.9, 0.75});
    addChair(into, {1.0, 0.85, 0}, 3.2);
    addChair(into, {2.5, 1.7, 0}, -1.4);
    addChair(into, {-1.6, -1.2, 0}, 0.8);
    addShelf(into, {-5.0, 4.05, 0}, 1.4);
    addShelf(into, {-3.4, 4.05, 0}, 1.4);
    into.setColor({0.44f, 0.56f, 0.42f});
    addSphere(into, {-1.8, 1.4, 0.5}, glm::dvec3(0.5), 40);
    into.setColor({0.40f, 0.50f, 0.64f});
    addBox(into, {4.4, -1.0, 0}, {5.4, 0.4, 0.9});
    addPipe(into, {1.1, 1.6, 0.75}, {1.1, 1.6, 1.0}, 0.05, 24);
    addLadder(into, {5.6, 2.2, 0}, {5.9, 2.2, 2.8}, {0, 0.25, 0}, 9);
    // The lamp hangs free; its cord ends above it.
    into.setColor({0.2f, 0.2f, 0.2f});
    addPipe(into, {0, 0, 2.25}, {0, 0, kHeight}, 0.012, 10);
    scene.lamps.push_back({{0.0, 0.0, 1.9}, {0, 0, 0}, 20.0, kPower});
    scene.ground = false;
    scene.look = {{-1.0, -4.3, 2.6}, {0.3, 1.6, 0.9}, 72.0};
}

void makeCeilingLamp(MadeScene& scene, const Geodetic&) {
    Shape& into = scene.solids;
    constexpr double kHeight = 3.0;
    addRoom(into, 5.5, 4.0, kHeight);
    for (const double x : {-3.0, 0.0, 3.0})
        for (const double y : {-1.7, 1.7}) {
            into.setColor(kWood);
            addTable(into, {x, y, 0}, {1.4, 0.8, 0.75});
            into.setColor({0.52f, 0.36f, 0.28f});
            addChair(into, {x - 0.2, y - 0.65, 0}, 3.14159 + 0.3 * x);
            addChair(into, {x + 0.2, y + 0.65, 0}, 0.25 * y);
            into.setColor({0.42f, 0.54f, 0.66f});
            addPipe(into, {x - 0.35, y, 0.75}, {x - 0.35, y, 1.02}, 0.05, 24);
            into.setColor({0.50f, 0.60f, 0.40f});
            addSphere(into, {x + 0.3, y + 0.1, 0.85}, glm::dvec3(0.10), 24);
        }
    into.setColor({0.70f, 0.62f, 0.54f});
    addBox(into, {4.6, -0.5, 0}, {5.1, 0.5, 1.6});
    // A rod under the ceiling, beside the lamp and in its half space.
    into.setColor({0.3f, 0.32f, 0.34f});
    addPipe(into, {-5.5, 0.9, 2.5}, {5.5, 0.9, 2.5}, 0.03, 12);
    scene.lamps.push_back({{0.0, 0.0, 2.95}, {0, 0, -1}, 20.0, kPower});
    scene.ground = false;
    scene.look = {{-5.1, -3.6, 2.45}, {0.8, 0.6, 0.6}, 70.0};
}

} // namespace gnomon::bench
