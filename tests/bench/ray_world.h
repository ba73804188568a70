// Triangles put somewhere on the Earth by hand, for rays: no tiles, no GL. Coordinates are metres
// east, north and up of the place, and so are the rays'.
#pragma once

#include "bench/reference.h"
#include "geo/ellipsoid.h"

#include <glm/common.hpp>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <vector>

namespace gnomon::test {

inline constexpr Geodetic kPlace{6.96, 50.94, 55.0};

inline glm::dvec3 directionAt(double azimuthDegrees, double elevationDegrees) {
    const double a = azimuthDegrees * kRadiansPerDegree, e = elevationDegrees * kRadiansPerDegree;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

class RayWorld {
  public:
    RayWorld() : content_(std::make_shared<TileContent>()) { content_->materials.resize(1); }

    const Transform<Ecef, Enu>& ecefFromPlace() const { return ecefFromPlace_; }
    TileContent& content() { return *content_; }

    // A mesh of its own, whose origin is in its middle.
    Mesh& add(const std::vector<glm::dvec3>& points, const std::vector<std::uint32_t>& indices) {
        glm::dvec3 low(1e300), high(-1e300);
        for (const glm::dvec3& p : points)
            low = glm::min(low, p), high = glm::max(high, p);
        const glm::dvec3 middle = 0.5 * (low + high);
        Mesh mesh;
        mesh.origin = ecefFromPlace_(Point<Enu>{middle});
        mesh.indices = indices;
        for (const glm::dvec3& p : points)
            mesh.positions.push_back(glm::vec3(p - middle));
        content_->meshes.push_back(mesh);
        return content_->meshes.back();
    }
    Mesh& quad(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
        return add({a, b, c, d}, {0, 1, 2, 0, 2, 3});
    }
    // From corner `a` along `u` and `v`, in so many pieces each way.
    void grid(const glm::dvec3& a, const glm::dvec3& u, const glm::dvec3& v, std::uint32_t pieces) {
        Pieces all;
        all.grid(a, u, v, pieces);
        add(all.points, all.indices);
    }
    void box(const glm::dvec3& low, const glm::dvec3& high, std::uint32_t pieces = 1,
             const glm::dmat3& turn = glm::dmat3(1.0), const glm::dvec3& shift = glm::dvec3(0.0)) {
        const glm::dvec3 x(high.x - low.x, 0, 0), y(0, high.y - low.y, 0), z(0, 0, high.z - low.z);
        Pieces all;
        all.grid(low, y, x, pieces), all.grid(low, x, z, pieces), all.grid(low, z, y, pieces);
        all.grid(high, -x, -y, pieces), all.grid(high, -z, -x, pieces);
        all.grid(high, -y, -z, pieces);
        for (glm::dvec3& p : all.points)
            p = turn * p + shift;
        add(all.points, all.indices);
    }

    // Rays whose origin (Embree's, in float) is at `origin`.
    bench::RayScene rays(const glm::dvec3& origin = glm::dvec3(0.0)) const {
        const ResidentTile tile{content_, 1};
        auto built = bench::RayScene::build({&tile, 1}, ecefFromPlace_(Point<Enu>{origin}),
                                            ecefFromPlace_.axes());
        if (!built)
            std::abort();
        return std::move(built).value();
    }

    Camera camera(const glm::dvec3& eye, const glm::dvec3& target, int width, int height) const {
        const glm::dvec3 forward = glm::normalize(target - eye);
        const glm::dvec3 side(forward.y, -forward.x, 0.0);
        const glm::dvec3 right =
            glm::length(side) > 1e-9 ? glm::normalize(side) : glm::dvec3(1, 0, 0);
        Camera camera;
        camera.position = ecefFromPlace_(Point<Enu>{eye});
        camera.forward = ecefFromPlace_(Vector<Enu>{forward});
        camera.right = ecefFromPlace_(Vector<Enu>{right});
        camera.up = ecefFromPlace_(Vector<Enu>{glm::cross(right, forward)});
        camera.widthPixels = width;
        camera.heightPixels = height;
        return camera;
    }

  private:
    struct Pieces {
        std::vector<glm::dvec3> points;
        std::vector<std::uint32_t> indices;

        void grid(const glm::dvec3& a, const glm::dvec3& u, const glm::dvec3& v,
                  std::uint32_t pieces) {
            const auto first = std::uint32_t(points.size());
            for (std::uint32_t j = 0; j <= pieces; ++j)
                for (std::uint32_t i = 0; i <= pieces; ++i) {
                    points.push_back(a + (double(i) / pieces) * u + (double(j) / pieces) * v);
                    if (i == pieces || j == pieces)
                        continue;
                    const std::uint32_t k = first + j * (pieces + 1) + i, above = k + pieces + 1;
                    indices.insert(indices.end(), {k, k + 1, above + 1, k, above + 1, above});
                }
        }
    };

    Transform<Ecef, Enu> ecefFromPlace_ = ecefFromEnu(kPlace);
    std::shared_ptr<TileContent> content_;
};

} // namespace gnomon::test
