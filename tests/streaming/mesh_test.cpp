#include "streaming/mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gnomon {

TEST(OctNormal, IsWithinFiveHundredThousandthsOfARadian) {
    std::mt19937_64 random(7);
    std::normal_distribution<double> gauss;
    double worst = 0.0;
    for (int i = 0; i < 200000; ++i) {
        const glm::dvec3 n =
            glm::normalize(glm::dvec3(gauss(random), gauss(random), gauss(random)));
        worst = std::max(worst, glm::length(glm::cross(n, decodeOct(encodeOct(n)))));
        ASSERT_GT(glm::dot(n, decodeOct(encodeOct(n))), 0.0);
    }
    EXPECT_LE(worst, 5e-5);
    EXPECT_GT(worst, 1e-6); // or the samples missed the hard directions
}

TEST(OctNormal, KeepsTheAxesExactly) {
    for (int axis = 0; axis < 3; ++axis) {
        for (const double sign : {1.0, -1.0}) {
            glm::dvec3 n(0.0);
            n[axis] = sign;
            EXPECT_EQ(decodeOct(encodeOct(n)), n);
        }
    }
}

TEST(OctNormal, TakesNonsenseWithoutHarm) {
    EXPECT_EQ(encodeOct(glm::dvec3(0.0)).x, 0);
    EXPECT_EQ(encodeOct(glm::dvec3(NAN)).y, 0);
    EXPECT_NEAR(glm::length(decodeOct({-32768, -32768})), 1.0, 1e-12);
}

TEST(Mesh, CountsItsBytes) {
    Mesh mesh;
    const std::size_t empty = mesh.bytes();
    mesh.positions.resize(10);
    mesh.indices.resize(6);
    EXPECT_EQ(mesh.bytes(), empty + 10 * 12 + 6 * 4);
    TileContent content;
    const std::size_t none = content.bytes();
    content.images.push_back({4, 4, std::vector<std::uint8_t>(64)});
    EXPECT_EQ(content.bytes(), none + sizeof(Image) + 64);
}

} // namespace gnomon
