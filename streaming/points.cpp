#include "streaming/points.h"

#include "streaming/clean.h"
#include "streaming/neighbours.h"
#include "streaming/normal_axes.h"
#include "streaming/split.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gnomon {

namespace {

// Peak use for a point: itself, four corners and triangles as a soup, their keys and tables while
// they are cut, and what becomes of them in the mesh: up to eight vertices, as the lower face has
// normals of its own. Measured: 760.
constexpr std::uint64_t kBytesPerPoint = 900;

bool isNear(const glm::dvec3& p) {
    return std::abs(p.x) < kFarthestMetres && std::abs(p.y) < kFarthestMetres &&
           std::abs(p.z) < kFarthestMetres; // false for NaN
}

template <class T>
void keepOnly(std::vector<T>& values, const std::vector<std::uint32_t>& kept) {
    if (values.empty()) {
        return;
    }
    for (std::size_t i = 0; i < kept.size(); ++i) {
        values[i] = values[kept[i]]; // kept[i] >= i
    }
    values.resize(kept.size());
}

// All clouds as one, with the material of each point.
struct Points : PointCloud {
    std::vector<std::uint32_t> materials;
};

template <class T>
void append(std::vector<T>& to, std::vector<T>& from, std::size_t before, std::size_t after,
            const T& otherwise) {
    if (to.empty() && from.empty()) {
        return;
    }
    to.resize(before, otherwise);
    to.insert(to.end(), from.begin(), from.end());
    to.resize(after, otherwise);
    from = {};
}

Points joined(std::vector<PointCloud> clouds) {
    Points out;
    for (PointCloud& cloud : clouds) {
        const std::size_t before = out.size(), after = before + cloud.size();
        append(out.normals, cloud.normals, before, after, glm::vec3(0.0f));
        append(out.colors, cloud.colors, before, after, 0xffffffffu);
        append(out.features, cloud.features, before, after, kNoFeature);
        out.materials.resize(after, cloud.material);
        if (out.positions.empty()) {
            out.positions = std::move(cloud.positions);
        } else {
            append(out.positions, cloud.positions, before, after, glm::dvec3(0.0));
        }
    }
    return out;
}

// Drops what has no place, and as many as memory asks, spread evenly over the file's order.
void choose(Points& cloud, const Transform<Ecef, Tile>& ecefFromTile, ByteBudget& budget,
            PointSolids& out) {
    std::vector<std::uint32_t> kept;
    kept.reserve(cloud.size());
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
        if (isNear(cloud.positions[i]) &&
            isNear(ecefFromTile(Point<Tile>{cloud.positions[i]}).xyz)) {
            kept.push_back(i);
        }
    }
    out.invalid = cloud.size() - kept.size();
    const std::uint64_t room = budget.left() / kBytesPerPoint;
    if (kept.size() > room) {
        out.leftOut = kept.size() - room;
        for (std::uint64_t i = 0; i < room; ++i) {
            kept[i] = kept[i * kept.size() / room]; // not before i
        }
        kept.resize(room);
    }
    budget.take(kept.size(), kBytesPerPoint, "points");
    cloud.keep(kept);
    keepOnly(cloud.materials, kept);
}

// Nothing but the direction in which `m`, symmetric, is smallest: Jacobi's rotations.
glm::dvec3 smallestAxis(glm::dmat3 m) {
    glm::dmat3 axes(1.0);
    constexpr std::pair<int, int> kPairs[] = {{0, 1}, {0, 2}, {1, 2}};
    constexpr int kSweeps = 8; // it converges quadratically: six reach the last bit
    const auto isDone = [&m] {
        constexpr double kSmall = 1e-15; // beside a trace of 1
        return std::abs(m[0][1]) + std::abs(m[0][2]) + std::abs(m[1][2]) < kSmall;
    };
    for (int sweep = 0; sweep < kSweeps && !isDone(); ++sweep) {
        for (const auto& [p, q] : kPairs) {
            if (m[p][q] == 0.0) {
                continue;
            }
            const double theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
            const double t =
                std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
            const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
            glm::dmat3 turn(1.0);
            turn[p][p] = turn[q][q] = c;
            turn[q][p] = s;
            turn[p][q] = -s;
            m = glm::transpose(turn) * m * turn;
            axes = axes * turn;
        }
    }
    const int smallest = m[0][0] <= m[1][1] && m[0][0] <= m[2][2] ? 0 : m[1][1] <= m[2][2] ? 1 : 2;
    return axes[smallest];
}

// Of the plane through a point and its neighbours; `otherwise` where they are all in one place.
glm::dvec3 planeNormal(const std::vector<glm::dvec3>& points, std::uint32_t point,
                       const Neighbours& near, const glm::dvec3& otherwise) {
    glm::dvec3 mean(0.0);
    for (std::size_t i = 0; i < near.count; ++i) {
        mean += points[near.nearest[i].point] - points[point];
    }
    mean /= double(near.count + 1);
    glm::dmat3 spread = glm::outerProduct(mean, mean);
    for (std::size_t i = 0; i < near.count; ++i) {
        const glm::dvec3 d = points[near.nearest[i].point] - points[point] - mean;
        spread += glm::outerProduct(d, d);
    }
    const double scale = spread[0][0] + spread[1][1] + spread[2][2];
    if (!(scale > 0.0 && std::isfinite(1.0 / scale))) {
        return otherwise;
    }
    const glm::dvec3 n = smallestAxis(spread * (1.0 / scale));
    return glm::dot(n, otherwise) < 0.0 ? -n : n;
}

double spacingOf(const Neighbours& near) {
    if (near.count < kNeighbours) {
        return near.count > 0 ? std::sqrt(near.nearest[0].squaredMetres) : 0.0;
    }
    return std::sqrt(near.nearest[kNeighbours - 1].squaredMetres * std::numbers::pi /
                     double(kNeighbours - 1));
}

double medianOf(std::vector<double> values) {
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// The bounds of points.h. A spacing of 0 (more points in one place than there are neighbours looked
// at) becomes the median. Below `least` doubles could no longer tell the corners apart.
void bound(std::vector<double>& spacings, double least) {
    std::vector<double> some;
    std::copy_if(spacings.begin(), spacings.end(), std::back_inserter(some),
                 [](double s) { return s > 0.0; });
    const double median = some.empty() ? kLoneSpacingMetres : medianOf(std::move(some));
    for (double& s : spacings) {
        s = std::max(least, s > 0.0 ? std::min(s, kMostSpacings * median) : median);
    }
}

class Solids {
  public:
    Solids(const Points& cloud, const Transform<Ecef, Tile>& ecefFromTile)
        : cloud_(cloud), transform_(ecefFromTile), axes_(ecefFromTile.axes()),
          ecefNormalAxes_(normalAxesOf(axes_)) {
        place();
    }

    std::vector<Mesh> run(const std::optional<glm::dmat3>& meshAxes) {
        const NeighbourTree tree(points_);
        std::vector<glm::dvec3> normals(points_.size());
        std::vector<double> spacings(points_.size());
        const glm::dvec3 up = unitOr(axes_[2], {0.0, 0.0, 1.0});
        for (const std::uint32_t i : tree.order()) {
            const Neighbours near = tree.of(i);
            spacings[i] = spacingOf(near);
            normals[i] = givenNormal(i);
            if (normals[i] == glm::dvec3(0.0)) {
                normals[i] = planeNormal(points_, i, near, up);
            }
        }
        constexpr double kLeastMetres = 1e-9, kLeastPart = 0x1p-40;
        bound(spacings, std::max(kLeastMetres, kLeastPart * farthest_));
        reserve();
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            add(i, normals[i], spacings[i]);
        }
        return split(soup_, clean_, transform_, meshAxes);
    }

    std::uint64_t triangles() const { return clean_.triangles.size(); }

  private:
    static glm::dvec3 unitOr(const glm::dvec3& v, const glm::dvec3& otherwise) {
        const double length = glm::length(v);
        return length > 0.0 && std::isfinite(length) ? v / length : otherwise;
    }

    glm::dvec3 givenNormal(std::uint32_t i) const {
        return cloud_.normals.empty()
                   ? glm::dvec3(0.0)
                   : unitOr(ecefNormalAxes_ * glm::dvec3(cloud_.normals[i]), glm::dvec3(0.0));
    }

    void place() {
        glm::dvec3 min(std::numeric_limits<double>::infinity()), max = -min;
        for (const glm::dvec3& p : cloud_.positions) {
            min = glm::min(min, p);
            max = glm::max(max, p);
        }
        const glm::dvec3 centre = cloud_.size() > 0 ? (min + max) / 2.0 : glm::dvec3(0.0);
        clean_.origin = transform_(Point<Tile>{centre});
        points_.reserve(cloud_.size());
        for (const glm::dvec3& p : cloud_.positions) {
            points_.push_back(axes_ * (p - centre) + 0.0); // + 0: no negative zeros
            farthest_ = std::max(farthest_, glm::length(points_.back()));
        }
    }

    void reserve() {
        const std::size_t n = points_.size() * 4;
        clean_.local.reserve(n);
        clean_.triangles.reserve(n);
        clean_.closed.assign(n, 1);
        soup_.normals.reserve(n);
        soup_.colors.reserve(cloud_.colors.empty() ? 0 : n);
        soup_.features.reserve(cloud_.features.empty() ? 0 : n);
    }

    void add(std::uint32_t i, const glm::dvec3& normal, double spacing) {
        const double radius = std::numbers::sqrt2 * spacing, height = radius / 8.0;
        // Any direction in the surface will do; the axis most across the normal is a steady one.
        const glm::dvec3 across =
            std::abs(normal.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
        const glm::dvec3 u = glm::normalize(glm::cross(across, normal));
        const glm::dvec3 v = glm::cross(normal, u);
        const glm::dvec3 base = points_[i] - normal * (height / 4.0);
        const double half = 0.5 * radius, side = std::numbers::sqrt3 / 2.0 * radius;
        const std::uint32_t first = std::uint32_t(clean_.local.size());
        clean_.local.push_back(base + u * radius);
        clean_.local.push_back(base - u * half + v * side);
        clean_.local.push_back(base - u * half - v * side);
        clean_.local.push_back(points_[i] + normal * (height * 3.0 / 4.0));
        // Normals are turned by the inverse transpose on their way out, so by the transpose here.
        const glm::vec3 stored(unitOr(glm::transpose(axes_) * normal, glm::dvec3(0.0)));
        soup_.normals.insert(soup_.normals.end(), 4, stored);
        std::uint32_t attributes = Soup::Normals;
        if (!cloud_.colors.empty()) {
            soup_.colors.insert(soup_.colors.end(), 4, cloud_.colors[i]);
            attributes |= Soup::Colors;
        }
        if (!cloud_.features.empty()) {
            soup_.features.insert(soup_.features.end(), 4, cloud_.features[i]);
            attributes |= Soup::Features;
        }
        constexpr std::uint32_t kFaces[4][3] = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}};
        for (const auto& f : kFaces) {
            clean_.triangles.push_back(
                {{first + f[0], first + f[1], first + f[2]}, cloud_.materials[i], attributes});
        }
    }

    const Points& cloud_;
    const Transform<Ecef, Tile>& transform_;
    glm::dmat3 axes_, ecefNormalAxes_;
    std::vector<glm::dvec3> points_; // from clean_.origin, ECEF's axes
    double farthest_ = 0.0;
    Soup soup_;
    CleanSoup clean_;
};

} // namespace

void PointCloud::keep(const std::vector<std::uint32_t>& points) {
    keepOnly(positions, points);
    keepOnly(normals, points);
    keepOnly(colors, points);
    keepOnly(features, points);
}

std::vector<double> spacingsOf(const std::vector<glm::dvec3>& points) {
    const NeighbourTree tree(points);
    std::vector<double> out(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        out[i] = spacingOf(tree.of(i));
    }
    return out;
}

PointSolids solidsOf(std::vector<PointCloud> clouds, const Transform<Ecef, Tile>& ecefFromTile,
                     const std::optional<glm::dmat3>& meshAxes, ByteBudget& budget) {
    PointSolids out;
    Points points = joined(std::move(clouds));
    choose(points, ecefFromTile, budget, out);
    if (points.size() == 0) {
        return out;
    }
    Solids solids(points, ecefFromTile);
    out.meshes = solids.run(meshAxes);
    out.triangles = solids.triangles();
    return out;
}

} // namespace gnomon
