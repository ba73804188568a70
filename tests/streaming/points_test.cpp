// Points to solids: their size, their shape, and how the surface they sample is covered.
#include "glb_builder.h"

#include "streaming/neighbours.h"
#include "streaming/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

namespace gnomon {

namespace {

std::vector<glm::dvec3> gridOf(int side, double spacing) {
    std::vector<glm::dvec3> out;
    for (int i = 0; i < side * side; ++i) {
        out.emplace_back((i % side) * spacing, (i / side) * spacing, 0.0);
    }
    return out;
}

std::vector<glm::dvec3> strewn(int count, double side, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> along(0.0, side);
    std::vector<glm::dvec3> out;
    for (int i = 0; i < count; ++i) {
        out.emplace_back(along(generator), along(generator), 0.0);
    }
    return out;
}

PointSolids solids(std::vector<glm::dvec3> positions,
                   const glm::dmat4& ecefFromTile = glm::dmat4(1.0)) {
    std::vector<PointCloud> clouds(1);
    clouds[0].positions = std::move(positions);
    ByteBudget budget(std::uint64_t(1) << 30);
    Transform<Ecef, Tile> transform;
    transform.matrix = ecefFromTile;
    return solidsOf(std::move(clouds), transform, glm::dmat3(1.0), budget);
}

struct Triangle {
    glm::dvec3 a, b, c;
};

std::vector<Triangle> trianglesOf(const PointSolids& solids) {
    std::vector<Triangle> out;
    for (const Mesh& mesh : solids.meshes) {
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            out.push_back({test::vertex(mesh, mesh.indices[i]),
                           test::vertex(mesh, mesh.indices[i + 1]),
                           test::vertex(mesh, mesh.indices[i + 2])});
        }
    }
    return out;
}

bool coversInPlan(const Triangle& t, double x, double y) {
    const auto side = [&](const glm::dvec3& p, const glm::dvec3& q) {
        return (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
    };
    const double u = side(t.a, t.b), v = side(t.b, t.c), w = side(t.c, t.a);
    return (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
}

// How much of the middle of a square of that side the solids cover, seen from above.
double coverOf(const PointSolids& solids, double side) {
    const std::vector<Triangle> triangles = trianglesOf(solids);
    constexpr int kSamples = 60;
    int covered = 0;
    for (int i = 0; i < kSamples * kSamples; ++i) {
        const double x = side * (0.2 + 0.6 * ((i % kSamples) + 0.37) / kSamples);
        const double y = side * (0.2 + 0.6 * ((i / kSamples) + 0.41) / kSamples);
        covered += std::any_of(triangles.begin(), triangles.end(),
                               [&](const Triangle& t) { return coversInPlan(t, x, y); });
    }
    return double(covered) / (kSamples * kSamples);
}

} // namespace

TEST(Neighbours, AreThoseThatTryingAllFinds) {
    std::mt19937 generator(7);
    std::uniform_int_distribution<int> along(0, 12); // many ties and doubles
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 700; ++i) {
        points.emplace_back(along(generator), along(generator), along(generator) / 4);
    }
    const NeighbourTree tree(points);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        std::vector<double> all;
        for (std::uint32_t j = 0; j < points.size(); ++j) {
            if (j != i) {
                const glm::dvec3 d = points[j] - points[i];
                all.push_back(glm::dot(d, d));
            }
        }
        std::sort(all.begin(), all.end());
        const Neighbours found = tree.of(i);
        ASSERT_EQ(found.count, kNeighbours);
        for (std::size_t k = 0; k < kNeighbours; ++k) {
            ASSERT_EQ(found.nearest[k].squaredMetres, all[k]) << i;
            ASSERT_NE(found.nearest[k].point, i);
        }
    }
}

TEST(Neighbours, AreQuickWhereAllPointsAreInOnePlace) {
    const std::vector<glm::dvec3> points(200000, glm::dvec3(1.0, 2.0, 3.0));
    const NeighbourTree tree(points);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(tree.of(i).count, kNeighbours);
    }
}

TEST(Points, SpacingIsThatOfTheSurfaceTheySample) {
    std::vector<double> grid = spacingsOf(gridOf(30, 0.5));
    EXPECT_NEAR(grid[30 * 15 + 15], 0.5, 0.05);
    const std::vector<double> random = spacingsOf(strewn(900, 15.0, 3));
    double mean = 0.0;
    for (const double s : random) {
        mean += s / double(random.size());
    }
    EXPECT_NEAR(mean, 0.5, 0.06);
}

TEST(Points, SolidsCoverASampledSurface) {
    EXPECT_EQ(coverOf(solids(gridOf(12, 1.0)), 11.0), 1.0);
    EXPECT_GT(coverOf(solids(strewn(300, 15.0, 5)), 15.0), 0.95);
}

TEST(Points, SolidsAreClosedOutwardWoundAndFlatOnTheSurface) {
    const PointSolids made = solids(gridOf(12, 1.0));
    EXPECT_EQ(made.triangles, 4 * 144u);
    const std::vector<Triangle> triangles = trianglesOf(made);
    for (std::size_t t = 0; t < triangles.size(); t += 4) {
        glm::dvec3 centre(0.0);
        double volume = 0.0;
        for (std::size_t i = t; i < t + 4; ++i) {
            const auto& [a, b, c] = triangles[i];
            centre += (a + b + c) / 12.0;
            volume += glm::dot(a, glm::cross(b, c)) / 6.0;
        }
        EXPECT_GT(volume, 0.0); // outward, all of them
        EXPECT_NEAR(centre.z, 0.0, 1e-6);
        EXPECT_NEAR(centre.x, std::round(centre.x), 1e-5);
        for (std::size_t i = t; i < t + 4; ++i) {
            const auto& [a, b, c] = triangles[i];
            const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a));
            EXPECT_GT(std::abs(n.z), 0.96); // within 14 degrees
            EXPECT_GT(glm::dot(n, (a + b + c) / 3.0 - centre), 0.0);
        }
    }
    for (const Mesh& mesh : made.meshes) {
        EXPECT_EQ(mesh.closedTriangles, mesh.triangles());
    }
}

TEST(Points, WithoutNormalsTheyLieInThePlaneOfTheirNeighbours) {
    // A grid on the plane x = 2 z.
    std::vector<glm::dvec3> points = gridOf(12, 1.0);
    for (glm::dvec3& p : points) {
        p.z = p.x / 2.0;
    }
    const PointSolids made = solids(points);
    const glm::dvec3 across = glm::normalize(glm::dvec3(-0.5, 0.0, 1.0));
    for (const Mesh& mesh : made.meshes) {
        for (const OctNormal n : mesh.normals) {
            EXPECT_GT(std::abs(glm::dot(decodeOct(n), across)), 0.999);
        }
    }
}

TEST(Points, OneFarFromAllOthersStaysSmall) {
    std::vector<glm::dvec3> points = gridOf(12, 1.0);
    points.emplace_back(0.0, 0.0, 5000.0);
    double largest = 0.0;
    for (const Triangle& t : trianglesOf(solids(points))) {
        largest = std::max({largest, glm::distance(t.a, t.b), glm::distance(t.b, t.c)});
    }
    // An equilateral triangle of circumradius R has sides of √3 R.
    EXPECT_LT(largest, std::sqrt(3.0) * std::sqrt(2.0) * kMostSpacings * 1.1);
    EXPECT_GT(largest, 3.0);
}

TEST(Points, OneAloneHasAHandsBreadth) {
    for (const std::size_t count : {1u, 50u}) {
        const PointSolids made = solids(std::vector<glm::dvec3>(count, {7.0, 8.0, 9.0}));
        EXPECT_EQ(made.triangles, 4 * count);
        const Triangle t = trianglesOf(made).at(3); // the base
        EXPECT_NEAR(glm::distance(t.a, t.b), std::sqrt(6.0) * kLoneSpacingMetres, 1e-5);
    }
}

TEST(Points, AFewJustTouch) {
    const Triangle t = trianglesOf(solids({{0, 0, 0}, {3, 0, 0}, {0, 50, 0}})).at(3);
    EXPECT_NEAR(glm::distance(t.a, t.b), std::sqrt(6.0) * 3.0, 1e-5);
}

TEST(Points, AreTheSameUnderAMirroringTransform) {
    glm::dmat4 mirror(1.0);
    mirror[0][0] = -1.0;
    double volume = 0.0;
    for (const Triangle& t : trianglesOf(solids(gridOf(5, 1.0), mirror))) {
        volume += glm::dot(t.a, glm::cross(t.b, t.c)) / 6.0;
    }
    EXPECT_GT(volume, 0.0);
}

TEST(Points, HoldFromASpeckToAContinent) {
    for (const double spacing : {1e-12, 1e-6, 1.0, 1e5}) {
        for (const double away : {0.0, 1e8}) {
            glm::dmat4 far(1.0);
            far[3] = glm::dvec4(away, 0.0, 0.0, 1.0);
            const PointSolids made = solids(gridOf(6, spacing), far);
            EXPECT_EQ(made.triangles, 4 * 36u);
            for (const Mesh& mesh : made.meshes) {
                for (const OctNormal n : mesh.faceNormals) {
                    EXPECT_NEAR(glm::length(decodeOct(n)), 1.0, 1e-9);
                }
                for (const glm::vec3& p : mesh.positions) {
                    EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
                }
            }
        }
    }
}

} // namespace gnomon
