// Paraboloid maps: where directions fall, how evenly they sample, and how straight edges bend.
#include "shadows/paraboloid.h"

#include "geo/ellipsoid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>

using namespace gnomon;

namespace {

constexpr double kPi = std::numbers::pi;

class Directions {
  public:
    glm::dvec3 next() {
        const double z = uniform(-1.0, 1.0), a = uniform(0.0, 2.0 * kPi), r = std::sqrt(1 - z * z);
        return {r * std::cos(a), r * std::sin(a), z};
    }
    double uniform(double low, double high) {
        return low + (high - low) * double(generator_() >> 11) * 0x1p-53;
    }

  private:
    std::mt19937_64 generator_{7};
};

Lamp facing(const glm::dvec3& f) {
    Lamp lamp;
    lamp.facing = {f};
    return lamp;
}

LampMaps mapsOf(LampMethod method, bool allRound, int mapSize = 2048) {
    ShadowSettings settings;
    settings.lamps = method;
    settings.mapSize = mapSize;
    return lampMaps(settings, facing(allRound ? glm::dvec3(0) : glm::dvec3(0, 0, -1)));
}

using MapTriangle = std::array<glm::dvec2, 3>;

std::vector<MapTriangle> images(const LampTriangle& t, double limit, const LampMaps& maps,
                                std::size_t most = 1u << 20) {
    std::vector<LampTriangle> pieces;
    cutTriangle(t, limit, maps, most, pieces);
    std::vector<MapTriangle> out;
    for (const LampTriangle& piece : pieces) {
        MapTriangle& image = out.emplace_back();
        for (std::size_t i = 0; i < 3; ++i)
            image[i] = paraboloidPoint(glm::normalize(piece[i]));
    }
    return out;
}

double texelsPerUnit(const LampMaps& maps) {
    return maps.texels / maps.unitsAcross();
}

// The farthest that the edge's true image strays from the chord of its ends, by brute force.
double strayed(const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec2 pa = paraboloidPoint(glm::normalize(a));
    const glm::dvec2 pb = paraboloidPoint(glm::normalize(b));
    const glm::dvec2 along = glm::normalize(pb - pa);
    double farthest = 0.0;
    constexpr int kSamples = 20000;
    for (int i = 1; i < kSamples; ++i) {
        const double t = double(i) / kSamples; // even by angle at least near the ends
        const glm::dvec3 v = glm::normalize(glm::normalize(a) * (1 - t) + glm::normalize(b) * t);
        const glm::dvec2 p = paraboloidPoint(v) - pa;
        farthest = std::max(farthest, std::abs(p.x * along.y - p.y * along.x));
    }
    return farthest;
}

} // namespace

TEST(Paraboloid, KeepsEveryDirection) {
    Directions random;
    for (const LampMethod method : {LampMethod::Paraboloid, LampMethod::Cube}) {
        const LampMaps maps = mapsOf(method, true);
        for (int i = 0; i < 20000; ++i) {
            const glm::dvec3 v = random.next();
            const LampTexel texel = lampTexel(maps, 3.7 * v);
            ASSERT_GE(texel.map, 0);
            ASSERT_LT(texel.map, maps.count);
            ASSERT_GE(std::min(texel.at.x, texel.at.y), kLampGuardTexels - 1e-9);
            ASSERT_LE(std::max(texel.at.x, texel.at.y), maps.texels - kLampGuardTexels + 1e-9);
            ASSERT_LT(glm::length(lampDirection(maps, texel) - v), 1e-12);
        }
    }
    for (int i = 0; i < 20000; ++i) { // behind the lamp too, on the map ahead
        const glm::dvec3 v = random.next();
        ASSERT_LT(glm::length(paraboloidDirection(paraboloidPoint(v)) - v), 1e-9);
    }
}

TEST(Paraboloid, HemispheresMeetAtTheSameTexels) {
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, true);
    for (int i = 0; i < 720; ++i) {
        const double a = i * kPi / 360.0;
        const glm::dvec3 above(std::cos(a), std::sin(a), 1e-12), below(above.x, above.y, -above.z);
        const LampTexel p = lampTexel(maps, above), q = lampTexel(maps, below);
        EXPECT_EQ(p.map, 0);
        EXPECT_EQ(q.map, 1);
        EXPECT_LT(glm::length(p.at - q.at), 1e-6);
        EXPECT_NEAR(texelRadians(maps, above), texelRadians(maps, below), 1e-12);
    }
}

TEST(Paraboloid, SamplesTheHemisphereByAFactorOfFourAtMost) {
    // Steradians of texels by their corners, against the formula; and the factor itself.
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, false);
    const double unit = maps.unitsAcross() / maps.texels;
    double least = 1e9, most = 0.0;
    for (int y = 0; y < maps.texels; y += 7)
        for (int x = 0; x < maps.texels; x += 7) {
            const glm::dvec2 centre =
                (glm::dvec2(x + 0.5, y + 0.5) / double(maps.texels) - 0.5) * maps.unitsAcross();
            if (glm::length(centre) > 1.0)
                continue;
            glm::dvec3 corner[4];
            for (int i = 0; i < 4; ++i)
                corner[i] = lampDirection(
                    maps, {0, glm::dvec2(x + (i == 1 || i == 2), y + (i == 2 || i == 3))});
            const double angle =
                0.5 * glm::length(glm::cross(corner[2] - corner[0], corner[3] - corner[1]));
            EXPECT_NEAR(angle / (unit * unit), paraboloidSolidAngle(centre), 1e-4);
            // As wide as it is high, since angles are kept.
            EXPECT_NEAR(glm::length(corner[1] - corner[0]), glm::length(corner[3] - corner[0]),
                        5e-3 * unit);
            EXPECT_NEAR(glm::length(corner[1] - corner[0]),
                        texelRadians(maps, paraboloidDirection(centre)), 5e-3 * unit);
            least = std::min(least, angle);
            most = std::max(most, angle);
        }
    EXPECT_LE(most / least, 4.0 + 1e-6);
    EXPECT_GT(most / least, 3.9); // and it is reached: no bound that says little
    std::printf("[ measured ] sampling varies by %.4f\n", most / least);
}

TEST(Paraboloid, CubeHasTheSameTexels) {
    for (const int size : {512, 2048, 8192}) {
        const LampMaps p = mapsOf(LampMethod::Paraboloid, true, size);
        const LampMaps c = mapsOf(LampMethod::Cube, true, size);
        EXPECT_EQ(p.count, 2);
        EXPECT_EQ(c.count, 6);
        EXPECT_NEAR(6.0 * c.texels * c.texels / (2.0 * p.texels * p.texels), 1.0, 0.01);
        EXPECT_EQ(mapsOf(LampMethod::Paraboloid, false, size).count, 1);
    }
}

TEST(Paraboloid, FramesTurnContinuouslyAwayFromTheZenith) {
    const Transform<Ecef, Enu> anchor = ecefFromEnu({6.96, 50.94, 55.0});
    const auto rotation = [&](const glm::dvec3& enu) {
        return lampFromEcef(anchor, facing(anchor.axes() * glm::normalize(enu))).axes();
    };
    Directions random;
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 v = i == 0 ? glm::dvec3(0, 0, -1) : random.next();
        if (v.z > 0.9)
            continue;
        const glm::dmat3 here = rotation(v), there = rotation(v + 1e-6 * random.next());
        for (int c = 0; c < 3; ++c)
            EXPECT_LT(glm::length(here[c] - there[c]), 2e-5);
        // Ahead is where it faces; a rotation, not a mirror.
        EXPECT_LT(glm::length(here * (anchor.axes() * v) - glm::dvec3(0, 0, 1)), 1e-12);
        EXPECT_NEAR(glm::determinant(here), 1.0, 1e-12);
    }
}

TEST(EdgeBend, IsTheTrueMaximum) {
    Directions random;
    int compared = 0;
    for (int i = 0; i < 400; ++i) {
        const glm::dvec3 a = random.uniform(0.3, 30.0) * random.next();
        const glm::dvec3 b = random.uniform(0.3, 30.0) * random.next();
        const double bend = edgeBend(a, b);
        // Far behind, the image runs out to infinity; there no sampling can tell.
        if (a.z < -0.5 * glm::length(a) || b.z < -0.5 * glm::length(b) || bend > 3.0)
            continue;
        EXPECT_NEAR(bend, strayed(a, b), 1e-6 + 1e-4 * bend);
        ++compared;
    }
    EXPECT_GT(compared, 100);
}

TEST(EdgeBend, AtTheRimIs39TexelsForAnEighthOfATurn) {
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, false);
    const auto rim = [](double degrees) {
        return glm::dvec3(std::cos(degrees * kRadiansPerDegree),
                          std::sin(degrees * kRadiansPerDegree), 0.0);
    };
    const double texels = edgeBend(rim(10), rim(55)) * 0.5 * maps.texels;
    EXPECT_NEAR(texels, 39.0, 0.1);
    EXPECT_LE(edgeBend(rim(0), rim(5.06)) * 0.5 * maps.texels, 0.5);
    EXPECT_GT(edgeBend(rim(0), rim(5.1)) * 0.5 * maps.texels, 0.5);
    // Edges in a plane with the axis stay straight.
    EXPECT_NEAR(edgeBend({0.01, 0.02, 1.0}, {1.0, 2.0, 0.1}), 0.0, 1e-12);
    EXPECT_GT(edgeBend({0.1, 0.0, -1.0}, {-0.1, 0.0, -1.0}), 1e3); // through straight behind
}

TEST(EdgeSegments, BendNoMoreThanAskedAndAreTheSameFromBothEnds) {
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, false);
    Directions random;
    int most = 0;
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 a = random.uniform(0.3, 30.0) * random.next();
        const glm::dvec3 b = random.uniform(0.3, 30.0) * random.next();
        if (a.z < 0 || b.z < 0)
            continue;
        int before = 1 << 30;
        for (const double limit : {0.25, 0.5, 1.0, 4.0, 16.0, 64.0}) {
            const double units = limit / texelsPerUnit(maps);
            const int n = edgeSegments(a, b, units);
            EXPECT_EQ(n, edgeSegments(b, a, units));
            EXPECT_LE(n, before); // fewer where more bend is allowed
            before = n;
            if (limit == 0.5)
                most = std::max(most, n);
        }
        const glm::dvec3 m = edgeMiddle(a, b), w = edgeMiddle(b, a);
        EXPECT_EQ(m, w); // to the last bit
        const glm::dvec3 va = glm::normalize(a), vb = glm::normalize(b), vm = glm::normalize(m);
        EXPECT_NEAR(glm::dot(va, vm), glm::dot(vb, vm), 1e-9);
    }
    EXPECT_LE(most, 64);
    std::printf("[ measured ] at most %d pieces an edge ahead of the lamp at half a texel\n", most);
}

// Outer edges of a cut triangle, those that belong to one piece only, as a closed chain: the same
// points whatever triangle is on the other side.
TEST(CutTriangle, MeetsItsNeighbourAtTheSamePoints) {
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, true);
    const double limit = 0.5 / texelsPerUnit(maps);
    const auto key = [](const glm::dvec2& p) { return std::pair(p.x, p.y); };
    using Edge = std::pair<std::pair<double, double>, std::pair<double, double>>;
    Directions random;
    std::size_t shared = 0;
    for (int round = 0; round < 60; ++round) {
        const auto corner = [&] { return random.uniform(0.5, 20.0) * random.next(); };
        const glm::dvec3 a = corner(), b = corner(), c = corner(), d = corner();
        const std::vector<MapTriangle> pieces = images({a, b, c}, limit, maps);
        const std::vector<MapTriangle> other = images({b, a, d}, limit, maps);
        // Every edge inside is drawn by two pieces; those on a–b by one of each triangle.
        std::map<Edge, int> count;
        const auto add = [&](const std::vector<MapTriangle>& all, int weight) {
            for (const MapTriangle& t : all)
                for (std::size_t i = 0; i < 3; ++i) {
                    auto p = key(t[i]), q = key(t[(i + 1) % 3]);
                    if (q < p)
                        std::swap(p, q);
                    count[{p, q}] += weight;
                }
        };
        add(pieces, 1);
        add(other, 1000);
        for (const auto& [edge, n] : count) {
            EXPECT_LE(n % 1000, 2);
            EXPECT_LE(n / 1000, 2);
            shared += n == 1001;
        }
        // Along a–b both have the same pieces, up to what lies beyond the map for one of them.
        const glm::dvec3 plane = glm::normalize(glm::cross(a, b));
        for (const auto& [edge, n] : count) {
            const glm::dvec3 p = paraboloidDirection({edge.first.first, edge.first.second});
            const glm::dvec3 q = paraboloidDirection({edge.second.first, edge.second.second});
            const auto between = [&](const glm::dvec3& v) {
                return std::abs(glm::dot(v, plane)) < 1e-12 &&
                       glm::dot(glm::cross(a, v), plane) > -1e-9 &&
                       glm::dot(glm::cross(v, b), plane) > -1e-9;
            };
            if (between(p) && between(q) && p.z > 0.0 && q.z > 0.0) {
                EXPECT_TRUE(n % 1000 == 1 && n / 1000 == 1) << n;
            }
        }
    }
    EXPECT_GT(shared, 300u);
}

TEST(CutTriangle, HasNoEdgeOffByMoreThanAskedAndCoversTheSame) {
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, false);
    const double limit = 0.5 / texelsPerUnit(maps);
    Directions random;
    for (int round = 0; round < 60; ++round) {
        const auto corner = [&] { return random.uniform(0.5, 20.0) * random.next(); };
        const glm::dvec3 a = corner(), b = corner(), c = corner();
        std::vector<LampTriangle> cut;
        cutTriangle({a, b, c}, limit, maps, 1u << 20, cut);
        for (const LampTriangle& t : cut)
            for (std::size_t i = 0; i < 3; ++i)
                EXPECT_LE(edgeBend(t[i], t[(i + 1) % 3]), limit);
        const std::vector<MapTriangle> pieces = images({a, b, c}, limit, maps);
        // Rays from the lamp hit the triangle where a piece covers the map, edges aside.
        const glm::dmat3 inverse = glm::inverse(glm::dmat3(a, b, c));
        const auto sideOf = [](const MapTriangle& t, const glm::dvec2& p, double slack) {
            double least = 1e9, most = -1e9;
            for (std::size_t i = 0; i < 3; ++i) {
                const glm::dvec2 e = t[(i + 1) % 3] - t[i], d = p - t[i];
                const double s = (e.x * d.y - e.y * d.x) / glm::length(e);
                least = std::min(least, s);
                most = std::max(most, s);
            }
            return least >= -slack || most <= slack;
        };
        for (int i = 0; i < 200; ++i) {
            const glm::dvec2 p(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7));
            const glm::dvec3 weights = inverse * paraboloidDirection(p);
            const bool hit = std::min({weights.x, weights.y, weights.z}) >= 0.0;
            bool covered = false, nearly = false;
            for (const MapTriangle& t : pieces) {
                covered = covered || sideOf(t, p, 0.0);
                nearly = nearly || sideOf(t, p, limit * 1.001);
            }
            if (hit) {
                EXPECT_TRUE(nearly); // no hole wider than the bend allowed
            }
            if (covered && !hit) {
                // Then an edge is within the bend.
                bool close = false;
                for (int k = 0; k < 64 && !close; ++k) {
                    const glm::dvec2 q =
                        p +
                        1.01 * limit * glm::dvec2(std::cos(k * kPi / 32), std::sin(k * kPi / 32));
                    const glm::dvec3 w = inverse * paraboloidDirection(q);
                    close = std::min({w.x, w.y, w.z}) >= 0.0;
                }
                EXPECT_TRUE(close);
            }
        }
    }
}

TEST(CutTriangle, LeavesWhatIsBehindAndStopsWhenToldTo) {
    const LampMaps maps = mapsOf(LampMethod::Paraboloid, false);
    const LampTriangle behind{{{-5, -5, -1}, {5, -5, -1}, {0, 7, -1}}};
    for (const MapTriangle& t : images(behind, 1e-3, maps)) // at the rim's guard at most
        EXPECT_LT(std::min({glm::length(t[0]), glm::length(t[1]), glm::length(t[2])}), 1.02);
    const LampTriangle floor{{{-500, -500, 2}, {500, -500, 2}, {0, 700, 2}}};
    EXPECT_EQ(images(floor, 0.0, maps).size(), 1u);
    const std::size_t stopped = images(floor, 1e-3, maps, 100).size();
    EXPECT_GE(stopped, 100u);
    EXPECT_LT(stopped, 400u);
    const std::size_t cut = images(floor, 0.5 / texelsPerUnit(maps), maps).size();
    std::printf("[ measured ] a floor that fills the hemisphere: %zu triangles\n", cut);
    EXPECT_LT(cut, 15000u);
}
