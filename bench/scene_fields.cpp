// The shapes that are not drawn corner by corner: the surface of a field, and the picture of
// leaves.
#include "bench/scene_shapes.h"
#include "viewer/place/picture.h"
#include "viewer/place/random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace gnomon::bench {

namespace {

class SurfaceNet {
  public:
    SurfaceNet(Shape& into, const Field& field, double step)
        : into_(into), field_(field), step_(step),
          size_(glm::ivec3(glm::ceil((field.high - field.low) / step)) + 1) {
        for (int z = 0; z < size_.z; ++z)
            for (int y = 0; y < size_.y; ++y)
                for (int x = 0; x < size_.x; ++x)
                    values_.push_back(field.value(corner({x, y, z})));
        vertices_.assign(values_.size(), kNone);
    }

    void build() {
        for (int z = 0; z + 1 < size_.z; ++z)
            for (int y = 0; y + 1 < size_.y; ++y)
                for (int x = 0; x + 1 < size_.x; ++x)
                    makeVertex({x, y, z});
        for (int z = 1; z + 1 < size_.z; ++z)
            for (int y = 1; y + 1 < size_.y; ++y)
                for (int x = 1; x + 1 < size_.x; ++x)
                    for (int axis = 0; axis < 3; ++axis)
                        makeFace({x, y, z}, axis);
    }

  private:
    static constexpr std::uint32_t kNone = 0xffffffffu;

    std::size_t index(const glm::ivec3& c) const {
        return (std::size_t(c.z) * std::size_t(size_.y) + std::size_t(c.y)) * std::size_t(size_.x) +
               std::size_t(c.x);
    }
    glm::dvec3 corner(const glm::ivec3& c) const { return field_.low + step_ * glm::dvec3(c); }

    glm::dvec3 gradient(const glm::dvec3& p) const {
        const double h = 0.05 * step_;
        glm::dvec3 g(0.0);
        for (int i = 0; i < 3; ++i) {
            glm::dvec3 d(0.0);
            d[i] = h;
            g[i] = (field_.value(p + d) - field_.value(p - d)) / (2.0 * h);
        }
        return g;
    }

    // The mean of where the surface cuts the cell's edges, then down the gradient onto the surface.
    void makeVertex(const glm::ivec3& cell) {
        glm::dvec3 sum(0.0);
        int cuts = 0;
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < 4; ++i) {
                glm::ivec3 a = cell, along(0);
                along[axis] = 1;
                a[(axis + 1) % 3] += i & 1;
                a[(axis + 2) % 3] += i >> 1;
                const double from = values_[index(a)], to = values_[index(a + along)];
                if ((from < 0.0) == (to < 0.0))
                    continue;
                sum += corner(a) + step_ * from / (from - to) * glm::dvec3(along);
                ++cuts;
            }
        if (cuts == 0)
            return;
        glm::dvec3 p = sum / double(cuts), n = gradient(p);
        for (int i = 0; i < 4; ++i) {
            p -= field_.value(p) / glm::dot(n, n) * n;
            n = gradient(p);
        }
        vertices_[index(cell)] = std::uint32_t(into_.positions.size());
        into_.positions.push_back(glm::round(p / into_.latticeMetres) * into_.latticeMetres);
        into_.normals.emplace_back(glm::normalize(n));
        into_.uvs.emplace_back(0.0f);
        into_.colors.push_back(into_.color);
    }

    // The four cells around an edge that the surface cuts.
    void makeFace(const glm::ivec3& at, int axis) {
        glm::ivec3 along(0), u(0), v(0);
        along[axis] = 1;
        u[(axis + 1) % 3] = 1;
        v[(axis + 2) % 3] = 1;
        const bool inside = values_[index(at)] < 0.0;
        if (inside == (values_[index(at + along)] < 0.0))
            return;
        std::array corners = {vertices_[index(at - u - v)], vertices_[index(at - v)],
                              vertices_[index(at)], vertices_[index(at - u)]};
        if (!inside)
            std::swap(corners[1], corners[3]);
        for (const std::uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u})
            into_.indices.push_back(corners[i]);
    }

    Shape& into_;
    const Field& field_;
    double step_;
    glm::ivec3 size_;
    std::vector<double> values_;
    std::vector<std::uint32_t> vertices_; // of the cell above each corner
};

// One leaf: an ellipse pointed at both ends, its length along `angle`.
void paintLeaf(builtin::Pixels& pixels, glm::dvec2 at, double length, double angle,
               const glm::vec3& color) {
    const double c = std::cos(angle), s = std::sin(angle);
    const int reach = int(std::ceil(length));
    for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
            const double along = (c * x + s * y) / (0.5 * length);
            const double wide = std::abs(-s * x + c * y) / (0.22 * length);
            if (std::abs(along) > 1.0 || wide > 1.0 - along * along)
                continue;
            const int px = int(at.x) + x, py = int(at.y) + y;
            if (px < 0 || py < 0 || px >= pixels.size || py >= pixels.size)
                continue;
            const double shade = 0.85 + 0.15 * along;
            std::uint8_t* out = pixels.at(px, py);
            for (int i = 0; i < 3; ++i)
                out[i] = std::uint8_t(std::clamp(255.0 * shade * double(color[i]), 0.0, 255.0));
            out[3] = 255;
        }
}

} // namespace

void addIsosurface(Shape& into, const Field& field, double step) {
    SurfaceNet(into, field, step).build();
}

Result<std::vector<std::byte>> leafPicture(std::uint64_t seed) {
    constexpr int kSize = 512, kLeaves = 900;
    builtin::Pixels pixels(kSize, 4);
    for (int i = 0; i < kSize * kSize; ++i) // where it is clear, the colour bleeds in at mip levels
        for (int k = 0; k < 3; ++k)
            pixels.rgb[std::size_t(4 * i + k)] =
                std::array<std::uint8_t, 3>{70, 96, 44}[std::size_t(k)];
    builtin::Random random(seed);
    for (int i = 0; i < kLeaves; ++i) {
        // A round crown in the upper four fifths, thinner towards its rim, above a bare stem.
        const double angle = random.in(0, 2.0 * std::numbers::pi);
        const double radius = 0.46 * std::pow(random.in(0, 1), 0.6);
        const glm::dvec2 at(kSize * (0.5 + 0.98 * radius * std::cos(angle)),
                            kSize * (0.47 - radius * std::sin(angle)));
        const double tone = random.in(0.75, 1.15);
        paintLeaf(pixels, at, random.in(16, 30), random.in(0, std::numbers::pi),
                  glm::vec3(0.30f, 0.42f, 0.18f) * float(tone));
    }
    return builtin::encodePng(pixels);
}

} // namespace gnomon::bench
