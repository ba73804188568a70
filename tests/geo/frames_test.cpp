#include "geo/frames.h"

#include "geo/camera.h"
#include "random_places.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;
using gnomon::testing::Random;

namespace {

// What must not compile is part of the interface.
template <class A, class B>
concept Subtract = requires(A a, B b) {
    a - b;
};
template <class A, class B>
concept Add = requires(A a, B b) {
    a + b;
};
template <class A, class B>
concept Multiply = requires(A a, B b) {
    a* b;
};
template <class A, class B>
concept Dot = requires(A a, B b) {
    dot(a, b);
};
template <class T, class P>
concept Apply = requires(T t, P p) {
    t(p);
};
template <class A, class B>
concept Narrow = requires(A a, B b) {
    relativeTo(a, b);
};

static_assert(Subtract<Point<Ecef>, Point<Ecef>>);
static_assert(!Subtract<Point<Ecef>, Point<Enu>>);
static_assert(!Subtract<Point<Ecef>, Vector<Enu>>);
static_assert(Add<Point<Ecef>, Vector<Ecef>>);
static_assert(!Add<Point<Ecef>, Point<Ecef>>);
static_assert(!Add<Vector<Tile>, Vector<Ecef>>);
static_assert(Dot<Vector<Eye>, Vector<Eye>>);
static_assert(!Dot<Vector<Eye>, Vector<Light>>);
static_assert(!std::is_convertible_v<Point<Ecef>, Vector<Ecef>>);
static_assert(!std::is_convertible_v<Point<Ecef>, Point<Enu>>);

static_assert(Multiply<Transform<Ecef, Enu>, Transform<Enu, Tile>>);
static_assert(!Multiply<Transform<Ecef, Enu>, Transform<Ecef, Tile>>);
static_assert(std::is_same_v<decltype(Transform<Ecef, Enu>{} * Transform<Enu, Tile>{}),
                             Transform<Ecef, Tile>>);
static_assert(Apply<Transform<Ecef, Enu>, Point<Enu>>);
static_assert(Apply<Transform<Ecef, Enu>, Vector<Enu>>);
static_assert(!Apply<Transform<Ecef, Enu>, Point<Ecef>>);
static_assert(std::is_same_v<decltype(rigidInverse(Transform<Ecef, Enu>{})), Transform<Enu, Ecef>>);

static_assert(Narrow<Point<Ecef>, Point<Ecef>>);
static_assert(!Narrow<Point<Enu>, Point<Ecef>>);
static_assert(!std::is_convertible_v<glm::dvec3, glm::vec3>);

// Half a unit in the last place of 1 in float.
constexpr double kEpsilon = 0x1p-24;

double largest(const glm::dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

} // namespace

TEST(Frames, RigidInverseUndoesARotationAndAShift) {
    const Transform<Ecef, Enu> ecefFromEnuHere = ecefFromEnu({6.9, 50.9, 60.0});
    const Transform<Enu, Ecef> enuFromEcef = rigidInverse(ecefFromEnuHere);
    const Point<Enu> p{{1234.5, -678.9, 42.0}};
    EXPECT_LE(length(enuFromEcef(ecefFromEnuHere(p)) - p), 5e-9);
    const Transform<Enu, Enu> identity = enuFromEcef * ecefFromEnuHere;
    EXPECT_LE(largest((identity(p) - p).xyz), 5e-9);
}

TEST(Frames, ATransformMovesPointsAndOnlyTurnsVectors) {
    Transform<Ecef, Tile> t;
    t.matrix[3] = glm::dvec4(10.0, 20.0, 30.0, 1.0);
    EXPECT_EQ(t(Point<Tile>{{1, 2, 3}}).xyz, glm::dvec3(11, 22, 33));
    EXPECT_EQ(t(Vector<Tile>{{1, 2, 3}}).xyz, glm::dvec3(1, 2, 3));
    EXPECT_EQ(t.origin().xyz, glm::dvec3(10, 20, 30));
}

TEST(Frames, AVertexStoredRelativeToItsTileIsOffByItsRadiusTimesEpsilonAtMost) {
    Random random(1);
    double worstAxis = 0.0, worstNorm = 0.0;
    for (int i = 0; i < 200000; ++i) {
        const double radius = random.magnitude(1.0, 1e5);
        const Point<Ecef> origin = ecefOf({random.in(-180, 180), random.in(-90, 90), 0.0});
        const Point<Ecef> p = origin + Vector<Ecef>{radius * random.in(0, 1) * random.direction()};
        const glm::dvec3 error = glm::dvec3(relativeTo(origin, p)) - (p - origin).xyz;
        worstAxis = std::max(worstAxis, largest(error) / radius);
        worstNorm = std::max(worstNorm, glm::length(error) / radius);
    }
    EXPECT_LE(worstAxis, kEpsilon);
    EXPECT_LE(worstNorm, std::sqrt(3.0) * kEpsilon);
    EXPECT_GE(worstAxis, 0.5 * kEpsilon); // the bound is no slacker than it says
}

// What the GPU does: float vertex, float rotation, and the tile's place relative to the camera,
// subtracted in double before it becomes float.
TEST(Frames, ACameraRelativeVertexInFloatIsOffByFiveEpsilonOfRadiusPlusDistanceAtMost) {
    Random random(2);
    double worst = 0.0;
    for (int i = 0; i < 300000; ++i) {
        const double radius = random.magnitude(0.1, 1e5), distance = random.magnitude(0.1, 1e6);
        Camera camera;
        place(camera, {random.in(-180, 180), random.in(-90, 90), random.in(0, 1e4)},
              {random.in(0, 360), random.in(-90, 90), random.in(-180, 180)});
        const glm::dmat3 rotation = eyeFromEcefRotation(camera);
        const Point<Ecef> origin = camera.position + Vector<Ecef>{distance * random.direction()};
        const Point<Ecef> vertex = origin + Vector<Ecef>{radius * random.direction()};

        const glm::vec3 stored = relativeTo(origin, vertex);
        const glm::vec3 shift(rotation * (origin - camera.position).xyz);
        const glm::vec3 eye = glm::mat3(rotation) * stored + shift;
        const glm::dvec3 exact = rotation * (vertex - camera.position).xyz;
        worst = std::max(worst,
                         glm::length(glm::dvec3(eye) - exact) / ((radius + distance) * kEpsilon));
    }
    RecordProperty("worst_in_epsilons", std::to_string(worst));
    EXPECT_LE(worst, 5.0);
    EXPECT_GE(worst, 1.0);
}

TEST(Frames, AbsoluteEcefInFloatWouldBeOffByAQuarterOfAMetre) {
    Random random(3);
    double worst = 0.0;
    for (int i = 0; i < 10000; ++i) {
        const glm::dvec3 p = ecefOf({random.in(-180, 180), random.in(-90, 90), 0.0}).xyz;
        worst = std::max(worst, largest(glm::dvec3(glm::vec3(p)) - p));
    }
    EXPECT_GT(worst, 0.24);
    EXPECT_LE(worst, 0.25);
}
