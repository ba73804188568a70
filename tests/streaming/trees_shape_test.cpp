// What trees look like: solids, as large as said, and no further from the finest than said.
#include "streaming/features/trees_shape.h"

#include "tests/streaming/plants_support.h"

#include <random>

using namespace gnomon;
using namespace gnomon::test;

namespace {

template <class Visit>
void eachShape(const Visit& visit) {
    for (const TreeForm form : {TreeForm::Broad, TreeForm::Needle})
        for (unsigned v = 0; v < treeVariants(form); ++v)
            for (const TreeDetail detail :
                 {TreeDetail::Near, TreeDetail::Far, TreeDetail::Farthest})
                visit(form, v, detail, treeShape(form, v, detail));
}

Soup soupOf(const TreeShape& shape, const glm::dvec3& scale) {
    Soup soup;
    for (const glm::dvec3& p : shape.positions)
        soup.positions.push_back(scale * p);
    for (const auto& t : shape.triangles)
        soup.triangles.push_back({{t[0], t[1], t[2]}, 0, 0});
    soup.normals.resize(soup.positions.size());
    soup.uvs.resize(soup.positions.size());
    soup.colors.resize(soup.positions.size());
    soup.features.resize(soup.positions.size());
    return soup;
}

// How many solids hold the point: crossings of a ray upward, aslant so that it meets no edge.
int depthInside(const Soup& soup, const glm::dvec3& p) {
    const glm::dvec3 ray(0.0137, 0.0291, 1.0);
    int depth = 0;
    for (const Soup::Triangle& t : soup.triangles) {
        const glm::dvec3 a = soup.positions[t.vertex[0]] - p, b = soup.positions[t.vertex[1]] - p,
                         c = soup.positions[t.vertex[2]] - p;
        const double u = glm::dot(ray, glm::cross(b, c)), v = glm::dot(ray, glm::cross(c, a)),
                     w = glm::dot(ray, glm::cross(a, b));
        const double det = u + v + w;
        const bool meets = (u > 0) == (v > 0) && (v > 0) == (w > 0) && det != 0.0;
        if (meets && glm::dot(glm::cross(b - a, c - a), a) / det > 0.0)
            depth += det > 0.0 ? 1 : -1;
    }
    return depth;
}

// By descent over the triangle's own coordinates: another way than the one under test.
double distanceTo(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                  const glm::dvec3& c) {
    const auto onSegment = [&](const glm::dvec3& from, const glm::dvec3& to) {
        const glm::dvec3 d = to - from;
        const double t = std::clamp(glm::dot(p - from, d) / glm::dot(d, d), 0.0, 1.0);
        return glm::length(from + t * d - p);
    };
    double best = std::min({onSegment(a, b), onSegment(b, c), onSegment(c, a)});
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const bool over = glm::dot(glm::cross(b - a, p - a), n) >= 0 &&
                      glm::dot(glm::cross(c - b, p - b), n) >= 0 &&
                      glm::dot(glm::cross(a - c, p - c), n) >= 0;
    return over ? std::min(best, std::abs(glm::dot(p - a, glm::normalize(n)))) : best;
}

// The largest distance of points that show of `from` to the surface of `to`, by random points.
double farthest(const Soup& from, const Soup& to, std::mt19937& random) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    double most = 0.0;
    for (const Soup::Triangle& t : from.triangles) {
        const glm::dvec3 &a = from.positions[t.vertex[0]], &b = from.positions[t.vertex[1]],
                         &c = from.positions[t.vertex[2]];
        const glm::dvec3 outward = 1e-6 * glm::normalize(glm::cross(b - a, c - a));
        for (int i = 0; i < 40; ++i) {
            double u = unit(random), v = unit(random);
            if (u + v > 1.0) {
                u = 1.0 - u;
                v = 1.0 - v;
            }
            const glm::dvec3 p = i == 0 ? a : a + u * (b - a) + v * (c - a);
            if (depthInside(from, p + outward) > 0)
                continue;
            double nearest = 1e9;
            for (const Soup::Triangle& s : to.triangles)
                nearest = std::min(nearest, distanceTo(p, to.positions[s.vertex[0]],
                                                       to.positions[s.vertex[1]],
                                                       to.positions[s.vertex[2]]));
            most = std::max(most, nearest);
        }
    }
    return most;
}

} // namespace

TEST(TreeShape, IsMadeOfClosedSolidsWoundOutward) {
    eachShape([](TreeForm form, unsigned variant, TreeDetail detail, const TreeShape& shape) {
        const std::string which = std::to_string(int(form)) + " " + std::to_string(variant) + " " +
                                  std::to_string(int(detail));
        const Soup soup = soupOf(shape, {4, 4, 12});
        const CleanSoup cleaned = clean(soup, {});
        ASSERT_EQ(cleaned.triangles.size(), shape.triangles.size()) << which;
        EXPECT_EQ(cleaned.closedTriangles, shape.triangles.size()) << which;
        EXPECT_EQ(cleaned.closedComponents, cleaned.components) << which;
        for (std::size_t i = 0; i < cleaned.triangles.size(); ++i)
            EXPECT_EQ(cleaned.triangles[i].vertex[1], soup.triangles[i].vertex[1]) << which;
        EXPECT_GT(signedVolume(soup), 0.0);
        for (const glm::dvec3& n : shape.normals)
            ASSERT_NEAR(glm::length(n), 1.0, 1e-9) << which;
    });
}

TEST(TreeShape, HasTheTrianglesThatItsHeaderSays) {
    const auto count = [](TreeForm form, TreeDetail detail) {
        return treeShape(form, 0, detail).triangles.size();
    };
    EXPECT_EQ(count(TreeForm::Broad, TreeDetail::Near), 96u);
    EXPECT_EQ(count(TreeForm::Broad, TreeDetail::Far), 24u);
    EXPECT_EQ(count(TreeForm::Broad, TreeDetail::Farthest), 8u);
    EXPECT_EQ(count(TreeForm::Needle, TreeDetail::Near), 80u);
    EXPECT_EQ(count(TreeForm::Needle, TreeDetail::Far), 20u);
    EXPECT_EQ(count(TreeForm::Needle, TreeDetail::Farthest), 8u);
}

TEST(TreeShape, IsAsHighAndAsWideAsSaid) {
    eachShape([](TreeForm, unsigned, TreeDetail detail, const TreeShape& shape) {
        double high = 0.0, low = 0.0, wide = 0.0;
        for (const glm::dvec3& p : shape.positions) {
            high = std::max(high, p.z);
            low = std::min(low, p.z);
            wide = std::max(wide, std::hypot(p.x, p.y));
        }
        const double slack = detail == TreeDetail::Near ? 1e-12 : 0.12;
        EXPECT_NEAR(high, 1.0, slack);
        EXPECT_NEAR(wide, 1.0, std::max(slack, 0.1));
        EXPECT_NEAR(low, -kTreeRootDepth, 1e-12);
    });
}

TEST(TreeShape, LosesHalfItsVolumeAtMostFarAway) {
    for (const TreeForm form : {TreeForm::Broad, TreeForm::Needle})
        for (unsigned v = 0; v < treeVariants(form); ++v) {
            const double near =
                signedVolume(soupOf(treeShape(form, v, TreeDetail::Near), {1, 1, 1}));
            for (const TreeDetail detail : {TreeDetail::Far, TreeDetail::Farthest}) {
                const double far = signedVolume(soupOf(treeShape(form, v, detail), {1, 1, 1}));
                EXPECT_GT(far, 0.5 * near);
                EXPECT_LT(far, 1.3 * near);
            }
        }
}

TEST(TreeShape, DeviatesFromTheFinestByNoMoreThanIsSaid) {
    std::mt19937 random(4);
    eachShape([&](TreeForm form, unsigned variant, TreeDetail detail, const TreeShape& shape) {
        for (const auto& [height, radius] :
             {std::pair{12.0, 12.0 * usualCrownRadius(form)}, {20.0, 2.0}, {6.0, 4.0}}) {
            const glm::dvec3 scale(radius, radius, height);
            const Soup near = soupOf(treeShape(form, variant, TreeDetail::Near), scale);
            const Soup here = soupOf(shape, scale);
            const double said = treeDeviationMetres(form, variant, detail, height, radius);
            if (detail == TreeDetail::Near) {
                EXPECT_EQ(said, 0.0);
                continue;
            }
            const double seen =
                std::max(farthest(near, here, random), farthest(here, near, random));
            EXPECT_LE(seen, said) << int(form) << variant << int(detail) << " " << height;
            // Nor is it said to be much worse than it is.
            EXPECT_GE(seen, (height == 12.0 ? 0.9 : 0.5) * said)
                << int(form) << variant << int(detail) << " " << height;
        }
    });
}
