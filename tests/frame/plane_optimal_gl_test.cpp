// Maps in the eye's perspective: their shadows' edges on the plane, beside cascades of as many
// texels, and what happens off it. After the floor with spheres of Chong & Gortler.
#include "tests/frame/small_scene.h"

#include "shadows/projective_pass.h"

#include <gtest/gtest.h>

using namespace gnomon;
using namespace gnomon::test;

namespace {

// A ball, closed.
void ball(Shapes& shapes, const glm::dvec3& centre, double radius, int rings = 24,
          int sectors = 48) {
    std::vector<glm::dvec3> p{centre + glm::dvec3(0, 0, radius), centre - glm::dvec3(0, 0, radius)};
    for (int r = 1; r < rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const double a = 3.14159265358979 * r / rings, b = 6.28318530717959 * s / sectors;
            p.push_back(centre + radius * glm::dvec3(std::sin(a) * std::cos(b),
                                                     std::sin(a) * std::sin(b), std::cos(a)));
        }
    std::vector<std::uint32_t> t;
    const auto at = [&](int r, int s) {
        return std::uint32_t(2 + (r - 1) * sectors + s % sectors);
    };
    for (int s = 0; s < sectors; ++s) {
        t.insert(t.end(), {0, at(1, s), at(1, s + 1), 1, at(rings - 1, s + 1), at(rings - 1, s)});
        for (int r = 1; r + 1 < rings; ++r)
            t.insert(t.end(), {at(r, s), at(r + 1, s), at(r + 1, s + 1), at(r, s), at(r + 1, s + 1),
                               at(r, s + 1)});
    }
    shapes.add(p, t);
}

// Balls near and far, and, thinner than a ring of test rays tells, a table and a fence.
Shapes floorWithBalls(bool thin = true) {
    Shapes shapes;
    ball(shapes, {-1.5, 0, 1.0}, 0.6);
    ball(shapes, {1.2, 2.5, 0.8}, 0.5);
    ball(shapes, {-4, 25, 4}, 2.5);
    ball(shapes, {12, 60, 8}, 5.0);
    if (!thin)
        return shapes;
    shapes.box({-0.8, 5.0, 0.75}, {1.2, 6.4, 0.8});
    for (const glm::dvec2& leg : {glm::dvec2(-0.75, 5.05), {1.1, 5.05}, {-0.75, 6.3}, {1.1, 6.3}})
        shapes.box({leg.x, leg.y, 0.0}, {leg.x + 0.05, leg.y + 0.05, 0.76});
    for (int i = 0; i < 12; ++i)
        shapes.box({3.0 + 0.4 * i, 9.0, 0.0}, {3.05 + 0.4 * i, 9.05, 1.3});
    return shapes;
}

const Look kStanding{{0, -6, 2.2}, {0.4, 8, 0}, 50.0, 640, 360};

ShadowSettings technique(const std::string& words) {
    ShadowSettings s;
    if (const Failure failure = parseTechnique(words, s))
        ADD_FAILURE() << words;
    return s;
}

// Hard shadows against a ray a pixel, of the pixels that `counts` takes. How far the shadows'
// outlines lie apart, in pixels: the area between them over the length of the true one.
struct Edges {
    std::size_t compared = 0, wrong = 0, outline = 0, dark = 0;
    double worstPixels = 0.0; // of a wrong pixel, from the true outline
    double apart() const { return double(wrong) / double(std::max<std::size_t>(outline, 1)); }
};

template <class Counts>
Edges edges(const Shot& shot, const SunRays& rays, const Counts& counts) {
    const int w = shot.camera.widthPixels, h = shot.camera.heightPixels;
    std::vector<int> truth(shot.visibility.size(), -1);
    for (std::size_t i = 0; i < truth.size(); ++i)
        if (!shot.sky(i) && shot.facing(i) > 2.0 * kTanSun + 1e-4 && counts(i))
            truth[i] = rays.shadowed(shot.position[i], 1e-3 + 1e-6 * shot.depth[i]) ? 0 : 1;
    Edges out;
    std::vector<glm::ivec2> wrong, outline;
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(w) + std::size_t(x);
            if (truth[i] < 0)
                continue;
            ++out.compared;
            out.dark += truth[i] == 0;
            if (int(shot.visibility[i] >= 0.5f) != truth[i])
                wrong.push_back({x, y});
            const bool right = x + 1 < w && truth[i + 1] >= 0 && truth[i + 1] != truth[i];
            const bool below = y + 1 < h && truth[i + std::size_t(w)] >= 0 &&
                               truth[i + std::size_t(w)] != truth[i];
            if (right || below)
                outline.push_back({x, y});
        }
    out.wrong = wrong.size();
    out.outline = outline.size();
    for (const glm::ivec2& a : wrong) {
        double nearest = 1e9;
        for (const glm::ivec2& b : outline)
            nearest = std::min(nearest, std::hypot(double(a.x - b.x), double(a.y - b.y)));
        out.worstPixels = std::max(out.worstPixels, nearest);
    }
    return out;
}

bool projective(const Shot& shot, std::size_t i) {
    return shot.cascade[i] >= float(kFirstProjective) && shot.cascade[i] < 255.0f;
}

void print(const char* what, const Edges& e) {
    std::printf(
        "[ measured ] %s: outlines %.4f px apart over %zu px, worst %.1f px, %zu of %zu wrong\n",
        what, e.apart(), e.outline, e.worstPixels, e.wrong, e.compared);
}

} // namespace

TEST(PlaneOptimal, HasItsEdgesWhereRaysHaveThem) {
    const Shapes shapes = floorWithBalls();
    SmallScene scene(shapes, {kCologne, true, technique("plane-optimal+receiver-plane+none")});
    for (const double elevation : {8.0, 35.0, 70.0})
        for (const double azimuth : {15.0, 100.0, 190.0, 280.0}) {
            const Shot shot = scene.draw(kStanding, azimuth, elevation);
            const Edges floor = edges(shot, scene.rays(azimuth, elevation),
                                      [&](std::size_t i) { return projective(shot, i); });
            EXPECT_GT(floor.compared, 60000u) << azimuth << " " << elevation;
            EXPECT_GT(floor.outline, 200u) << azimuth << " " << elevation;
            EXPECT_LE(floor.apart(), 0.05) << azimuth << " " << elevation;
            EXPECT_LE(floor.worstPixels, 1.0) << azimuth << " " << elevation;
        }
}

// Casters so low that any bias would lose them: there is none but for rounding.
TEST(PlaneOptimal, ShowsTheShadowOfASlabOfAnInch) {
    Shapes shapes;
    for (int i = 0; i < 5; ++i)
        shapes.box({-1.5 + 0.6 * i, 1.0 + 0.2 * i, 0},
                   {-1.2 + 0.6 * i, 1.3 + 0.2 * i, 0.005 * (1 + i)});
    SmallScene scene(shapes, {kCologne, true, technique("plane-optimal+receiver-plane+none")});
    const Look kneeling{{0, -0.5, 1.2}, {0, 1.4, 0}, 60.0, 640, 360};
    for (const double azimuth : {20.0, 110.0, 250.0}) {
        const Shot shot = scene.draw(kneeling, azimuth, 25);
        const Edges e = edges(shot, scene.rays(azimuth, 25), [&](std::size_t i) {
            return projective(shot, i) && shot.position[i].z < 1e-3;
        });
        print("slabs of 5 to 25 mm", e);
        EXPECT_GT(e.outline, 100u);
        EXPECT_LE(e.apart(), 0.05);
        EXPECT_LE(e.worstPixels, 1.5);
    }
}

TEST(PlaneOptimal, IsSharperOnThePlaneThanCascadesOfAsManyTexels) {
    const Shapes shapes = floorWithBalls();
    SmallScene scene(shapes, {kCologne, true, technique("plane-optimal+receiver-plane+none")});
    const SunRays rays = scene.rays(215, 35);
    const Shot ours = scene.draw(kStanding, 215, 35);
    const auto onPlane = [&](std::size_t i) { return projective(ours, i); };
    const Edges plane = edges(ours, rays, onPlane);
    print("plane-optimal", plane);
    // One map of a lixel a pixel has no more than 640 × 360 texels; a cascade of 512² has more.
    ShadowSettings equal = technique("csm+receiver-plane+none");
    equal.cascades = 1;
    equal.mapSize = 512;
    scene.setShadows(equal);
    const Edges one = edges(scene.draw(kStanding, 215, 35), rays, onPlane);
    print("one map of 512²", one);
    equal.cascades = 4;
    equal.mapSize = 2048;
    scene.setShadows(equal);
    const Edges many = edges(scene.draw(kStanding, 215, 35), rays, onPlane);
    print("four of 2048²", many);
    EXPECT_LE(plane.apart(), 0.05);
    EXPECT_GT(one.apart(), 10.0 * plane.apart());
    EXPECT_GT(one.apart(), 0.5);
    EXPECT_GE(many.apart(), plane.apart());
}

TEST(PlaneOptimal, LeavesWhatIsOffItsPlanesToTheCascades) {
    Shapes shapes = floorWithBalls();
    shapes.box({-4.0, -3.0, 0}, {-1.0, -2.8, 3}); // a wall near the eye
    SmallScene scene(shapes, {kCologne, true, technique("plane-optimal+receiver-plane+none")});
    for (const double azimuth : {160.0, 215.0}) {
        const Shot shot = scene.draw(kStanding, azimuth, 35);
        std::size_t off = 0;
        for (std::size_t i = 0; i < shot.visibility.size(); ++i)
            if (!shot.sky(i) && (shot.position[i].z > 0.1 || shot.normal[i].z < 0.9)) {
                EXPECT_FALSE(projective(shot, i));
                ++off;
            }
        EXPECT_GT(off, 10000u);
        const Compared c = compare(shot, scene.rays(azimuth, 35), {13.0, 2.0, false});
        EXPECT_EQ(c.falseLit, 0u) << azimuth;
        EXPECT_EQ(c.falseShadow, 0u) << azimuth;
        EXPECT_EQ(c.falseAway, 0u) << azimuth;
        EXPECT_GT(c.dark, 2000u);
    }
}

TEST(PlaneOptimal, TakesAWallForAPlaneOfItsOwn) {
    Shapes shapes = floorWithBalls();
    shapes.box({-30, 12, 0}, {30, 12.4, 15});
    SmallScene scene(shapes, {kCologne, true, technique("plane-optimal:2+receiver-plane+none")});
    const Shot shot = scene.draw(kStanding, 190, 25);
    std::size_t wall = 0, second = 0;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i)
        if (!shot.sky(i) && shot.position[i].z > 0.1 && shot.normal[i].y < -0.999 &&
            shot.position[i].y > 11.9) {
            ++wall;
            second += projective(shot, i);
        }
    EXPECT_GT(wall, 20000u);
    EXPECT_GT(second, wall * 99 / 100);
    const Edges both =
        edges(shot, scene.rays(190, 25), [&](std::size_t i) { return projective(shot, i); });
    print("floor and wall", both);
    EXPECT_LE(both.apart(), 0.05);
    EXPECT_EQ(shot.facts.depthMs.size(), 6u); // four cascades and two planes
}

// Every filter, away from edges by its width: nothing lit that is dark, nor dark that is lit.
TEST(PlaneOptimal, IsRightWithEveryFilter) {
    const Shapes shapes = floorWithBalls(false);
    SmallScene scene(shapes);
    for (const char* words :
         {"plane-optimal+receiver-plane+bilinear", "plane-optimal+receiver-plane+pcf:5",
          "plane-optimal+receiver-plane+jitter4", "plane-optimal+receiver-plane+pcss"}) {
        scene.setShadows(technique(words));
        for (const double azimuth : {30.0, 215.0}) {
            const Shot shot = scene.draw(kStanding, azimuth, 35);
            const FloatPicture texels = scene.renderer().texels();
            const SunRays rays = scene.rays(azimuth, 35);
            std::size_t lit = 0, dark = 0, edge = 0;
            for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
                if (shot.sky(i) || !projective(shot, i))
                    continue;
                ASSERT_GT(texels.values[i], 0.0f);
                const double radius = 5.0 * texels.values[i] + 13.0 / 0.57 * kTanSun;
                switch (rays.around(shot.position[i], shot.normal[i], radius, 2e-3)) {
                case SunRays::Answer::Edge:
                    ++edge;
                    break;
                case SunRays::Answer::Lit:
                    ++lit;
                    EXPECT_EQ(shot.visibility[i], 1.0f) << words << " " << i;
                    break;
                case SunRays::Answer::Dark:
                    ++dark;
                    EXPECT_EQ(shot.visibility[i], 0.0f) << words << " " << i;
                    break;
                }
            }
            EXPECT_GT(lit, 20000u);
            EXPECT_GT(dark, 200u);
        }
    }
}

// Half the width of the penumbra is the gap times tan of the sun's radius, in a map whose texels
// are oblong and of every size.
TEST(PlaneOptimal, HasPenumbraeAsWideAsTheGapMakesThem) {
    Shapes shapes;
    shapes.box({-40, 10, 7.9}, {40, 18, 8.0}); // a roof in the air, its edges along x
    ShadowSettings settings = technique("plane-optimal+receiver-plane+pcss:16,64");
    settings.lightDiameterDegrees = 3.0;
    SmallScene scene(shapes, {kCologne, true, settings});
    const Look above{{0, -3, 30}, {0, 4, 0}, 40.0, 640, 360};
    const double elevation = 50.0;
    // The sun in the north throws the roof's shadow to the south, on to the floor in view.
    const Shot shot = scene.draw(above, 0.0, elevation);
    const double sine = std::sin(elevation * kRadiansPerDegree);
    const double tangent = std::tan(1.5 * kRadiansPerDegree);
    // Along y on the floor: the southern upper edge falls at 10 - 8 / tan e.
    const double edge = 10.0 - 8.0 / std::tan(elevation * kRadiansPerDegree);
    const double half = 8.0 / sine * tangent / sine; // the disc seen slanted
    double worst = 0.0, sum = 0.0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
        if (shot.sky(i) || !projective(shot, i))
            continue;
        const double s = (shot.position[i].y - edge) / half; // -1 lit … 1 dark
        if (std::abs(s) > 1.5)
            continue;
        const double t = std::clamp(s, -1.0, 1.0);
        const double covered = 0.5 + (t * std::sqrt(1.0 - t * t) + std::asin(t)) / 3.14159265358979;
        const double error = std::abs(shot.visibility[i] - (1.0 - covered));
        worst = std::max(worst, error);
        sum += error;
        ++count;
    }
    ASSERT_GT(count, 3000u);
    std::printf("[ measured ] penumbra: mean error %.4f, worst %.3f over %zu pixels\n",
                sum / double(count), worst, count);
    EXPECT_LT(sum / double(count), 0.03);
    EXPECT_LT(worst, 0.2);
}

TEST(PlaneOptimal, AsksTheSurfacesOfAnotherCameraAgain) {
    const Shapes shapes = floorWithBalls();
    SmallScene scene(shapes, {kCologne, true, technique("plane-optimal+receiver-plane+none")});
    Shot first = scene.draw(kStanding, 215, 35);
    Look moved = kStanding;
    moved.eye += glm::dvec3(0.11, 0.05, 0.04);
    FrameRequest request = scene.request(moved, 215, 35);
    request.keepSurfaces = true;
    Result<FrameFacts> facts = scene.renderer().draw(request);
    ASSERT_TRUE(facts);
    const std::vector<float> again = scene.renderer().aov(Aov::Sun).values;
    const std::vector<float> cascade = scene.renderer().aov(Aov::Cascade).values;
    const Edges before =
        edges(first, scene.rays(215, 35), [&](std::size_t i) { return projective(first, i); });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < cascade.size(); ++i)
        kept += cascade[i] >= 128.0f && cascade[i] < 255.0f;
    EXPECT_GT(kept, before.compared * 9 / 10);
    // Of the same surfaces: lixels are no longer exactly theirs.
    first.visibility = again;
    first.cascade = cascade;
    const Edges after =
        edges(first, scene.rays(215, 35), [&](std::size_t i) { return projective(first, i); });
    print("from 12 cm beside", after);
    EXPECT_LE(after.apart(), 0.5);
    EXPECT_LE(after.worstPixels, 3.0);
    EXPECT_GT(after.wrong, before.wrong);
}

// ------------------------------------------------------------------------------------------------
TEST(Perspective, IsRightAwayFromEdges) {
    const Shapes shapes = floorWithBalls(false);
    SmallScene scene(shapes, {kCologne, true, technique("perspective+receiver-plane+none")});
    for (const double azimuth : {100.0, 0.0, 180.0}) { // across, ahead, behind
        const Shot shot = scene.draw(kStanding, azimuth, 40);
        const FloatPicture texels = scene.renderer().texels();
        const SunRays rays = scene.rays(azimuth, 40);
        std::size_t lit = 0, dark = 0, wrong = 0, edge = 0;
        for (std::size_t i = 0; i < shot.visibility.size(); ++i) {
            if (shot.sky(i) || shot.facing(i) < 0.05 || !projective(shot, i))
                continue;
            const SunRays::Answer truth =
                rays.around(shot.position[i], shot.normal[i], 2.0 * texels.values[i] + 1e-3, 5e-3);
            edge += truth == SunRays::Answer::Edge;
            lit += truth == SunRays::Answer::Lit;
            dark += truth == SunRays::Answer::Dark;
            wrong += truth == SunRays::Answer::Lit && shot.visibility[i] < 0.5f;
            wrong += truth == SunRays::Answer::Dark && shot.visibility[i] >= 0.5f;
        }
        std::printf(
            "[ measured ] perspective, sun at %.0f: lit %zu, dark %zu, edge %zu, wrong %zu\n",
            azimuth, lit, dark, edge, wrong);
        EXPECT_EQ(wrong, 0u) << azimuth;
        EXPECT_GT(lit + dark + edge, 100000u);
        EXPECT_GT(lit, 50000u);
        EXPECT_EQ(shot.facts.depthMs.size(), 1u);
        EXPECT_EQ(shot.facts.cascades.size(), 0u);
    }
}

TEST(Perspective, CastsWhatStandsBehindTheEye) {
    Shapes shapes;
    shapes.box({-3, -40, 0}, {3, -36, 30}); // behind
    shapes.box({-1, 30, 0}, {1, 32, 2});
    SmallScene scene(shapes, {kCologne, true, technique("perspective+receiver-plane+none")});
    const Shot shot = scene.draw(Look{{0, -20, 8}, {0, 20, 0}}, 180, 25);
    const Edges e = edges(shot, scene.rays(180, 25), [&](std::size_t i) {
        return projective(shot, i) && shot.normal[i].z > 0.99;
    });
    print("perspective, a tower behind the eye", e);
    EXPECT_GT(e.dark, 2000u);
    EXPECT_LT(e.apart(), 1.0);
    EXPECT_LE(e.worstPixels, 3.0);
}
