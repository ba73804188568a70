// The shapes: solids closed and wound outwards, sheds open, terrain without cracks.
#include "viewer/place/tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace gnomon::builtin {
namespace {

using Key = std::array<std::int64_t, 3>;

Key keyOf(const Shape& shape, std::uint32_t vertex) {
    const glm::dvec3 p = (shape.positions[vertex] + shape.origin) / kLatticeMetres;
    return {std::llround(p.x), std::llround(p.y), std::llround(p.z)};
}

struct Component {
    std::size_t triangles = 0;
    double volume = 0;    // by the divergence theorem; positive when wound outwards
    bool balanced = true; // every directed edge has its opposite
};

std::vector<Component> componentsOf(const Shape& shape) {
    std::map<Key, int> welded;
    std::vector<int> id(shape.positions.size()), parent;
    for (std::uint32_t v = 0; v < shape.positions.size(); ++v) {
        const auto [it, fresh] = welded.try_emplace(keyOf(shape, v), int(parent.size()));
        if (fresh)
            parent.push_back(it->second);
        id[v] = it->second;
    }
    const auto root = [&](int v) {
        while (parent[std::size_t(v)] != v)
            v = parent[std::size_t(v)] = parent[std::size_t(parent[std::size_t(v)])];
        return v;
    };
    for (std::size_t t = 0; t < shape.indices.size(); t += 3)
        for (std::size_t k = 1; k < 3; ++k)
            parent[std::size_t(root(id[shape.indices[t + k]]))] = root(id[shape.indices[t]]);
    std::map<int, Component> components;
    std::map<std::pair<int, int>, int> edges;
    for (std::size_t t = 0; t < shape.indices.size(); t += 3) {
        const std::uint32_t* i = &shape.indices[t];
        Component& c = components[root(id[i[0]])];
        ++c.triangles;
        c.volume += glm::dot(shape.positions[i[0]],
                             glm::cross(shape.positions[i[1]], shape.positions[i[2]])) /
                    6;
        for (int k = 0; k < 3; ++k) {
            const int a = id[i[k]], b = id[i[(k + 1) % 3]];
            a < b ? ++edges[{a, b}] : --edges[{b, a}];
        }
    }
    for (const auto& [edge, sum] : edges)
        if (sum != 0)
            components[root(edge.first)].balanced = false;
    std::vector<Component> out;
    for (const auto& [_, c] : components)
        out.push_back(c);
    return out;
}

void expectSolid(const Shape& shape, const std::string& what) {
    const auto components = componentsOf(shape);
    for (const Component& c : components) {
        EXPECT_TRUE(c.balanced) << what << ": a component of " << c.triangles
                                << " triangles is open";
        EXPECT_GT(c.volume, 1e-4) << what;
    }
}

void expectSoundFaces(const Shape& shape, const std::string& what) {
    for (std::size_t t = 0; t < shape.indices.size(); t += 3) {
        const std::uint32_t* i = &shape.indices[t];
        const glm::dvec3 n = glm::cross(shape.positions[i[1]] - shape.positions[i[0]],
                                        shape.positions[i[2]] - shape.positions[i[0]]);
        ASSERT_GT(glm::length(n), 1e-6) << what;
        ASSERT_GT(glm::dot(glm::normalize(n), glm::dvec3(shape.normals[i[0]])), 0.4) << what;
    }
}

Building sample() {
    Building b;
    b.centre = {3.3, 4.7};
    b.half = {7, 5};
    b.baseMetres = -1.5;
    b.eavesMetres = 9.3;
    b.roofMetres = 4.1;
    b.overhangMetres = 0.4;
    b.gableOverhangMetres = 0.3;
    b.chimney = b.roofBox = true;
    b.headingRadians = 0.05;
    return b;
}

TEST(Shape, EveryRoofAtEveryDetailIsASolid) {
    for (const Roof roof : {Roof::Flat, Roof::Gable, Roof::Hip, Roof::Shed})
        for (const bool along : {false, true})
            for (const Detail detail : {Detail::Full, Detail::Plain, Detail::Boxes})
                for (const double overhang : {0.0, 0.4}) {
                    Building b = sample();
                    b.roof = roof;
                    b.ridgeAlongX = along;
                    b.overhangMetres = overhang;
                    Shape shape;
                    addBuilding(shape, b, detail);
                    expectSolid(shape, "roof " + std::to_string(int(roof)));
                    expectSoundFaces(shape, "roof " + std::to_string(int(roof)));
                }
}

TEST(Shape, EveryLIsASolidOfItsOwnVolume) {
    for (const int x : {-1, 1})
        for (const int y : {-1, 1}) {
            Building b = sample();
            b.roof = Roof::Flat;
            b.roofBox = false;
            b.notch = {4, 3};
            b.notchCorner = {x, y};
            Shape shape;
            addBuilding(shape, b, Detail::Boxes);
            expectSolid(shape, "L");
            const auto components = componentsOf(shape);
            ASSERT_EQ(components.size(), 1u);
            const double area = 14 * 10 - 4 * 3, height = 9.3 + 4.1 / 2 + 1.5;
            EXPECT_NEAR(components[0].volume, area * height, area * height * 2e-3);
            addBuilding(shape, b, Detail::Full);
            expectSolid(shape, "L with a parapet");
            expectSoundFaces(shape, "L with a parapet");
        }
}

TEST(Shape, TreesAreSolids) {
    for (const TreeKind kind : {TreeKind::Broad, TreeKind::Poplar, TreeKind::Conifer})
        for (const bool simple : {false, true}) {
            const Shape tree = treeShape(kind, simple);
            EXPECT_LE(tree.triangles(), 90u);
            for (const Component& c : componentsOf(tree)) {
                EXPECT_TRUE(c.balanced);
                EXPECT_GT(c.volume, 1e-4);
            }
            for (const glm::dvec3& p : tree.positions)
                EXPECT_LT(std::hypot(p.x, p.y), 0.34 * 1.1 + kLatticeMetres);
        }
}

TEST(Shape, EverySolidOfTheWholePlaceIsClosedAtEveryLevel) {
    const Plan plan(1, 60);
    std::size_t buildings = 0;
    for (int level = 0; level <= plan.levels(); ++level)
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x) {
                const TileShapes shapes = tileShapes(plan, {level, x, y});
                const std::string what = "level " + std::to_string(level);
                expectSolid(shapes.houses, what);
                expectSolid(shapes.offices, what);
                expectSoundFaces(shapes.houses, what);
                buildings += level == plan.levels() ? shapes.buildings : 0;
                EXPECT_EQ(shapes.houses.features.size(),
                          shapes.houses.withFeatures ? shapes.houses.positions.size() : 0);
            }
    EXPECT_EQ(buildings, 60u);
}

TEST(Shape, ShedsAreOpen) {
    const Plan plan(1, 400);
    Shape shape;
    addShed(shape, plan, {{30, 30}, 0.3, {3, 1.5, 2.4}});
    const auto components = componentsOf(shape);
    ASSERT_FALSE(components.empty());
    for (const Component& c : components)
        EXPECT_FALSE(c.balanced);
    EXPECT_EQ(shape.triangles(), 8u);
}

TEST(Shape, TheTowerIs120MetresHighAndTheBridgeReachesBothBanks) {
    const Plan plan(1, 60);
    Shape tower, bridge;
    addTower(tower, plan, Detail::Full);
    addBridge(bridge, plan, Detail::Full);
    double top = 0;
    for (const auto& p : tower.positions)
        top = std::max(top, p.z);
    EXPECT_NEAR(top, plan.ground(Plan::centre()) + 120, 0.1);
    expectSolid(tower, "tower");
    expectSolid(bridge, "bridge");
    EXPECT_GT(bridge.triangles(), 2000u); // thin bars
    for (const Detail detail : {Detail::Full, Detail::Plain}) {
        Shape again;
        addBridge(again, plan, detail);
        double south = 1e9, north = -1e9;
        for (const auto& p : again.positions)
            south = std::min(south, p.y), north = std::max(north, p.y);
        EXPECT_NEAR(north - south, 2 * plan.deckHalfLength(), 0.2);
    }
}

// The corners on one side of a tile, in the place's own lattice.
std::set<Key> edgeCorners(const Shape& terrain, int axis, double metres) {
    std::set<Key> keys;
    for (std::uint32_t v = 0; v < terrain.positions.size(); ++v) {
        const Key k = keyOf(terrain, v);
        if (k[std::size_t(axis)] == std::llround(metres / kLatticeMetres))
            keys.insert(k);
    }
    return keys;
}

TEST(Terrain, MeetsItsNeighboursExactlyWhateverTheirLevels) {
    const Plan plan(1, 400);
    // A coarse tile against the two finer ones on its eastern side, and each against the other.
    const Rect west = tileRect(plan, {1, 0, 0});
    const auto coarse = edgeCorners(terrainShape(plan, west), 0, west.east);
    std::set<Key> fine;
    for (const int y : {0, 1})
        fine.merge(edgeCorners(terrainShape(plan, tileRect(plan, {2, 2, y})), 0, west.east));
    EXPECT_EQ(coarse, fine);
    EXPECT_EQ(coarse.size(), std::size_t(512 / 4 + 1));
    std::set<Key> finest;
    for (int y = 0; y < 4; ++y)
        finest.merge(edgeCorners(terrainShape(plan, tileRect(plan, {3, 4, y})), 0, west.east));
    EXPECT_EQ(coarse, finest);
}

TEST(Terrain, CoversItsTileOnceAndFacesUp) {
    const Plan plan(1, 400);
    for (int level = 0; level <= plan.levels(); ++level) {
        const Rect rect = tileRect(plan, {level, 0, 0});
        const Shape shape = terrainShape(plan, rect);
        double area = 0;
        std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
        for (std::size_t t = 0; t < shape.indices.size(); t += 3) {
            const std::uint32_t* i = &shape.indices[t];
            const glm::dvec3 n = glm::cross(shape.positions[i[1]] - shape.positions[i[0]],
                                            shape.positions[i[2]] - shape.positions[i[0]]);
            ASSERT_GT(n.z, 0) << level;
            area += n.z / 2;
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t a = i[k], b = i[(k + 1) % 3];
                a < b ? ++edges[{a, b}] : --edges[{b, a}];
            }
        }
        EXPECT_NEAR(area, rect.width() * rect.height(), 1e-6 * area);
        // What is open is the outline alone: four sides of finest steps.
        const auto open =
            std::count_if(edges.begin(), edges.end(), [](const auto& e) { return e.second != 0; });
        EXPECT_EQ(open, 4 * std::int64_t(rect.width() / kGroundStepMetres));
    }
}

TEST(Tiles, HoldTheirContentWithinTheirBoxes) {
    const Plan plan(1, 60);
    const HeightRange range = plan.heightRange();
    for (int level = 0; level <= plan.levels(); ++level)
        for (int y = 0; y < 1 << level; ++y)
            for (int x = 0; x < 1 << level; ++x) {
                const Rect rect = tileRect(plan, {level, x, y});
                const TileShapes shapes = tileShapes(plan, {level, x, y});
                const Shape terrain = terrainShape(plan, rect);
                for (const Shape* shape :
                     {&shapes.houses, &shapes.offices, &shapes.sheds, &terrain})
                    for (const glm::dvec3& local : shape->positions) {
                        const glm::dvec3 p = local + shape->origin;
                        ASSERT_TRUE(p.x >= rect.west && p.x <= rect.east && p.y >= rect.south &&
                                    p.y <= rect.north && p.z >= range.low && p.z <= range.high)
                            << level << ' ' << x << ' ' << y << ": " << p.x << ' ' << p.y << ' '
                            << p.z;
                    }
                for (const Tree& t : shapes.trees)
                    ASSERT_LE(plan.ground(t.at) + t.heightMetres, range.high);
            }
}

} // namespace
} // namespace gnomon::builtin
