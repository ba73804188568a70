#include "streaming/clean.h"

#include "glb_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace gnomon {

using namespace test;

namespace {

Soup soupOf(const std::vector<float>& positions, const std::vector<std::uint32_t>& indices) {
    Soup soup;
    for (std::size_t i = 0; i + 2 < positions.size(); i += 3) {
        soup.positions.emplace_back(positions[i], positions[i + 1], positions[i + 2]);
    }
    const std::size_t n = soup.positions.size();
    soup.normals.resize(n);
    soup.uvs.resize(n);
    soup.colors.resize(n);
    soup.features.resize(n);
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        soup.triangles.push_back({{indices[i], indices[i + 1], indices[i + 2]}, 0, 0});
    }
    return soup;
}

Soup boxSoup(glm::vec3 from = glm::vec3(0.0f), glm::vec3 to = glm::vec3(1.0f)) {
    return soupOf(boxCorners(from, to), boxTriangles());
}

void turn(Soup& soup, std::size_t triangle) {
    std::swap(soup.triangles[triangle].vertex[1], soup.triangles[triangle].vertex[2]);
}

double volume(const CleanSoup& clean) {
    double six = 0.0;
    for (const Soup::Triangle& t : clean.triangles) {
        six += glm::dot(clean.local[t.vertex[0]],
                        glm::cross(clean.local[t.vertex[1]], clean.local[t.vertex[2]]));
    }
    return six / 6.0;
}

void add(Soup& soup, const Soup& more) {
    const auto first = std::uint32_t(soup.positions.size());
    soup.positions.insert(soup.positions.end(), more.positions.begin(), more.positions.end());
    for (Soup::Triangle t : more.triangles) {
        for (std::uint32_t& v : t.vertex) {
            v += first;
        }
        soup.triangles.push_back(t);
    }
    const std::size_t n = soup.positions.size();
    soup.normals.resize(n);
    soup.uvs.resize(n);
    soup.colors.resize(n);
    soup.features.resize(n);
}

} // namespace

TEST(Clean, ABoxIsClosedAndOutward) {
    const CleanSoup clean = gnomon::clean(boxSoup(), {});
    EXPECT_EQ(clean.triangles.size(), 12u);
    EXPECT_EQ(clean.closedTriangles, 12u);
    EXPECT_EQ(clean.components, 1u);
    EXPECT_EQ(clean.closedComponents, 1u);
    EXPECT_NEAR(volume(clean), 1.0, 1e-12);
    EXPECT_NEAR(glm::length(clean.areaVector), 0.0, 1e-12);
}

TEST(Clean, ABoxWoundInsideOutIsTurned) {
    Soup soup = boxSoup();
    for (std::size_t i = 0; i < 12; ++i) {
        turn(soup, i);
    }
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.closedTriangles, 12u);
    EXPECT_NEAR(volume(clean), 1.0, 1e-12);
}

TEST(Clean, AnyMixOfWindingsGivesTheSameSolid) {
    for (unsigned mask = 0; mask < 4096; ++mask) {
        Soup soup = boxSoup();
        for (std::size_t i = 0; i < 12; ++i) {
            if (mask >> i & 1u) {
                turn(soup, i);
            }
        }
        const CleanSoup clean = gnomon::clean(soup, {});
        ASSERT_EQ(clean.closedTriangles, 12u) << mask;
        ASSERT_NEAR(volume(clean), 1.0, 1e-12) << mask;
        ASSERT_NEAR(glm::length(clean.areaVector), 0.0, 1e-12) << mask;
    }
}

TEST(Clean, ABoxWithoutALidIsOpenAndKeepsItsWinding) {
    Soup soup = boxSoup();
    soup.triangles.erase(soup.triangles.begin() + 2, soup.triangles.begin() + 4); // z = 1
    turn(soup, 0);
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.closedTriangles, 0u);
    EXPECT_EQ(clean.components, 1u);
    EXPECT_EQ(clean.closedComponents, 0u);
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        EXPECT_TRUE(std::equal(soup.triangles[i].vertex, soup.triangles[i].vertex + 3,
                               clean.triangles[i].vertex));
    }
}

TEST(Clean, TheSecondOfTwoEqualTrianglesIsDropped) {
    Soup soup = boxSoup();
    add(soup, boxSoup());                                                 // other vertices
    std::rotate(soup.triangles[13].vertex, soup.triangles[13].vertex + 1, // another first corner
                soup.triangles[13].vertex + 3);
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.triangles.size(), 12u);
    EXPECT_EQ(clean.duplicates, 12u);
    EXPECT_EQ(clean.closedTriangles, 12u);
    EXPECT_EQ(clean.triangles[0].vertex[0], soup.triangles[0].vertex[0]); // the first stayed
}

TEST(Clean, TheSameTriangleTheOtherWayRoundIsADuplicateToo) {
    Soup soup = soupOf({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 1});
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.triangles.size(), 1u);
    EXPECT_EQ(clean.duplicates, 1u);
    EXPECT_NEAR(clean.areaVector.z, 0.5, 1e-15); // the first one's winding
}

TEST(Clean, TwoBoxesAreTwoComponents) {
    Soup soup = boxSoup();
    add(soup, boxSoup(glm::vec3(5.0f), glm::vec3(7.0f)));
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.components, 2u);
    EXPECT_EQ(clean.closedComponents, 2u);
}

TEST(Clean, BoxesThatTouchInAnEdgeAreBothClosed) {
    Soup soup = boxSoup();
    add(soup, boxSoup({1, 1, 0}, {2, 2, 1}));
    turn(soup, 14); // whatever its winding
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.closedTriangles, 24u);
    EXPECT_NEAR(volume(clean), 2.0, 1e-12);
}

// The wall stands twice, once for each house: one of it goes, and the houses must stay solid.
TEST(Clean, HousesThatShareAWallStayClosed) {
    Soup soup = boxSoup();
    Soup other = boxSoup({1, 0, 0}, {2, 1, 1});
    add(soup, other);
    // Both walls at x = 1 cut along the same diagonal.
    soup.triangles[12 + 8] = {{8 + 0, 8 + 4, 8 + 6}, 0, 0};
    soup.triangles[12 + 9] = {{8 + 0, 8 + 6, 8 + 2}, 0, 0};
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.duplicates, 2u);
    EXPECT_EQ(clean.closedTriangles, 20u); // all but the wall
}

TEST(Clean, AFenceAtABoxsEdgeLeavesTheBoxClosed) {
    Soup soup = boxSoup();
    add(soup, soupOf({1, 1, 0, 1, 1, 1, 3, 3, 0}, {0, 1, 2}));
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.components, 1u);
    EXPECT_EQ(clean.closedComponents, 0u);
    EXPECT_EQ(clean.closedTriangles, 12u);
    EXPECT_FALSE(clean.closed[12]);
}

TEST(Clean, ASheetWithTwoSidesIsNoSolid) {
    // Two squares face to face, cut along different diagonals: every edge matched, no volume.
    const Soup soup =
        soupOf({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {0, 1, 2, 0, 2, 3, 1, 0, 3, 1, 3, 2});
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.triangles.size(), 4u);
    EXPECT_EQ(clean.closedTriangles, 0u);
}

TEST(Clean, AMoebiusBandIsNoSolid) {
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    constexpr std::uint32_t kSteps = 20;
    for (std::uint32_t i = 0; i < kSteps; ++i) {
        const double a = 2.0 * M_PI * i / kSteps;
        for (const double side : {-0.3, 0.3}) {
            const double r = 2.0 + side * std::cos(a / 2.0);
            positions.insert(positions.end(), {float(r * std::cos(a)), float(r * std::sin(a)),
                                               float(side * std::sin(a / 2.0))});
        }
        const std::uint32_t a0 = 2 * i, a1 = 2 * i + 1;
        const bool last = i + 1 == kSteps;
        const std::uint32_t b0 = last ? 1 : a0 + 2, b1 = last ? 0 : a1 + 2;
        indices.insert(indices.end(), {a0, b0, a1, a1, b0, b1});
    }
    const CleanSoup clean = gnomon::clean(soupOf(positions, indices), {});
    EXPECT_EQ(clean.triangles.size(), std::size_t(2 * kSteps));
    EXPECT_EQ(clean.closedTriangles, 0u);
}

TEST(Clean, VerticesAPartOfAMillimetreApartAreOne) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> jitter(-0.2e-3, 0.2e-3);
    std::uniform_real_distribution<double> place(-1000.0, 1000.0);
    for (int trial = 0; trial < 300; ++trial) { // anywhere in the welding grid
        const glm::dvec3 at(place(random), place(random), place(random));
        const Soup box = boxSoup(glm::vec3(0.0f), glm::vec3(20.0f));
        Soup apart;
        for (const Soup::Triangle& t : box.triangles) {
            Soup one = soupOf({0, 0, 0, 0, 0, 0, 0, 0, 0}, {0, 1, 2});
            for (std::size_t k = 0; k < 3; ++k) {
                one.positions[k] = at + box.positions[t.vertex[k]] +
                                   glm::dvec3(jitter(random), jitter(random), jitter(random));
            }
            add(apart, one);
        }
        const CleanSoup clean = gnomon::clean(apart, {});
        ASSERT_EQ(clean.components, 1u) << trial;
        ASSERT_EQ(clean.closedTriangles, 12u) << trial;
    }
}

TEST(Clean, VerticesThreeMillimetresApartAreTwo) {
    Soup soup = soupOf({0, 0, 0, 20, 0, 0, 0, 20, 0}, {0, 1, 2});
    add(soup, soupOf({0, 0, 0.003f, 20, 0, 0.003f, 20, -20, 0}, {0, 1, 2}));
    EXPECT_EQ(gnomon::clean(soup, {}).components, 2u);
}

TEST(Clean, TrianglesWithoutAreaAreDroppedAndCounted) {
    const Soup soup =
        soupOf({0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 1, 0, 1, 0, 0}, {0, 1, 2, 0, 0, 1, 1, 4, 3, 0, 1, 3});
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.triangles.size(), 1u);
    EXPECT_EQ(clean.degenerate, 3u); // in a line; a corner twice; two corners in one place
}

TEST(Clean, ATriangleWithoutAreaStillClosesASolid) {
    // The edge from corner 0 to 1 has a midpoint on one side only: a triangle without area fills
    // in.
    std::vector<float> positions = boxCorners(glm::vec3(0.0f), glm::vec3(1.0f));
    positions.insert(positions.end(), {0.5f, 0.0f, 0.0f});
    std::vector<std::uint32_t> indices = boxTriangles();
    indices.erase(indices.begin() + 3, indices.begin() + 6); // 0 3 1
    indices.insert(indices.end(), {0, 3, 8, 8, 3, 1, 0, 8, 1});
    const CleanSoup clean = gnomon::clean(soupOf(positions, indices), {});
    EXPECT_EQ(clean.degenerate, 1u);
    EXPECT_EQ(clean.triangles.size(), 13u);
    EXPECT_EQ(clean.closedTriangles, 13u);
}

TEST(Clean, SliversThinnerThanTheWeldAreStillDrawn) {
    const Soup soup = soupOf({0, 0, 0, 10, 0, 0, 10, 0.0005f, 0}, {0, 1, 2});
    const CleanSoup clean = gnomon::clean(soup, {});
    EXPECT_EQ(clean.triangles.size(), 1u);
    EXPECT_EQ(clean.degenerate, 0u);
}

TEST(Clean, NonFiniteVerticesTakeTheirTrianglesWithThem) {
    for (const float bad : {float(NAN), float(INFINITY), -float(INFINITY), 1e30f}) {
        Soup soup = boxSoup();
        add(soup, soupOf({bad, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}));
        const CleanSoup clean = gnomon::clean(soup, {});
        EXPECT_EQ(clean.invalid, 1u);
        EXPECT_EQ(clean.triangles.size(), 12u);
        EXPECT_EQ(clean.closedTriangles, 12u);
    }
}

TEST(Clean, ATransformBeyondUseLeavesNothingButACount) {
    Transform<Ecef, Tile> transform;
    transform.matrix[3][0] = 1e300;
    const CleanSoup clean = gnomon::clean(boxSoup(), transform);
    EXPECT_EQ(clean.invalid, 12u);
    EXPECT_TRUE(clean.triangles.empty());
}

TEST(Clean, AMirroringTransformKeepsSolidsOutwardAndTurnsTheRest) {
    Transform<Ecef, Tile> mirror;
    mirror.matrix[0][0] = -1.0;
    EXPECT_NEAR(volume(gnomon::clean(boxSoup(), mirror)), 1.0, 1e-12);

    const CleanSoup sheet = gnomon::clean(soupOf({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}), mirror);
    const auto& v = sheet.triangles.at(0).vertex;
    const glm::dvec3 normal =
        glm::cross(sheet.local[v[1]] - sheet.local[v[0]], sheet.local[v[2]] - sheet.local[v[0]]);
    EXPECT_GT(normal.z, 0.0); // still up
    EXPECT_GT(sheet.areaVector.z, 0.0);
}

TEST(Clean, CleansInTheSameWayEveryTime) {
    std::mt19937 random(11);
    std::uniform_int_distribution<int> coordinate(0, 6);
    std::vector<float> positions;
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < 6000; ++i) {
        positions.push_back(float(coordinate(random)));
    }
    for (std::uint32_t i = 0; i < 3000; ++i) {
        indices.push_back(std::uint32_t(random() % 2000));
    }
    const Soup soup = soupOf(positions, indices);
    const CleanSoup a = gnomon::clean(soup, {}), b = gnomon::clean(soup, {});
    ASSERT_EQ(a.triangles.size(), b.triangles.size());
    EXPECT_GT(a.triangles.size(), 100u);
    EXPECT_EQ(a.closed, b.closed);
    EXPECT_EQ(a.triangles.size() + a.duplicates + a.degenerate + a.invalid, 1000u);
}

} // namespace gnomon
