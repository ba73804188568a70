// Water made by code: a level surface over ground that a function gives, in a place's frame of
// east, north, up.
#pragma once

#include "streaming/flood/water_surface.h"
#include "tests/frame/small_scene.h"

#include <functional>

namespace gnomon::test {

// Steps of a minute.
class FakeFlood : public FloodData {
  public:
    const FloodGeometry& geometry() const override { return geometry_; }
    WaterKind kind() const override { return WaterKind::Depth; }
    const std::vector<double>& stepSeconds() const override { return steps_; }
    bool stepsAreAbsolute() const override { return true; }
    Result<std::vector<float>> values(std::size_t) const override { return std::vector<float>{}; }
    bool hasVelocity() const override { return velocity; }
    Result<std::vector<glm::vec2>> velocities(std::size_t) const override {
        return std::vector<glm::vec2>{};
    }
    bool velocity = true;

  private:
    FloodGeometry geometry_;
    std::vector<double> steps_{0.0, 60.0, 120.0};
};

class FakeWater : public WaterSurface {
  public:
    struct Shape {
        glm::dvec2 low{-30, -30}, high{30, 30};
        double cellMetres = 1.0;
        // Of a place and a moment.
        std::function<double(glm::dvec2, double)> level = [](glm::dvec2, double) { return 0.0; };
        std::function<double(glm::dvec2, double)> depth = [](glm::dvec2, double) { return 1.0; };
        glm::vec2 velocity{0.5f, 0.0f};
        double deepest = 4.0, fastest = 2.0;
    };
    FakeWater(const Transform<Ecef, Enu>& ecefFromPlace, Shape shape)
        : ecefFromPlace_(ecefFromPlace), shape_(std::move(shape)) {}

    const FloodData& data() const override { return flood; }
    std::array<double, 4> extent() const override { return {}; }
    Sphere bounds() const override { return {ecefFromPlace_.origin(), 100.0}; }
    // Meshes of at most 32 cells across, as wide as the whole.
    Result<std::vector<WaterMesh>> meshes(double seconds, const glm::dmat3& axes) const override {
        ++made;
        if (failing)
            return Error{"flood.nc", "step 1 cannot be read"};
        std::vector<WaterMesh> meshes;
        const glm::dvec2 size = shape_.high - shape_.low;
        const int columns = std::max(int(std::lround(size.x / shape_.cellMetres)), 1);
        const int rows = std::max(int(std::lround(size.y / shape_.cellMetres)), 1);
        for (int y = 0; y < rows; y += 32)
            for (int x = 0; x < columns; x += 32)
                meshes.push_back(mesh({x, y}, {std::min(x + 32, columns), std::min(y + 32, rows)},
                                      seconds, axes));
        return meshes;
    }
    Result<std::optional<WaterAt>> at(double, glm::dvec2) const override {
        return std::optional<WaterAt>{};
    }
    Result<WaterTotals> totals(double) const override { return WaterTotals{}; }
    double deepestMetres() const override { return shape_.deepest; }
    double fastest() const override { return shape_.fastest; }

    FakeFlood flood;
    bool failing = false;
    mutable int made = 0;

  private:
    WaterMesh mesh(glm::ivec2 low, glm::ivec2 high, double seconds, const glm::dmat3& axes) const {
        WaterMesh mesh;
        const auto place = [&](int x, int y) {
            return shape_.low + shape_.cellMetres * glm::dvec2(x, y);
        };
        const glm::dvec2 middle = 0.5 * (place(low.x, low.y) + place(high.x, high.y));
        mesh.origin = ecefFromPlace_(Point<Enu>{{middle, 0.0}});
        std::vector<Point<Ecef>> points;
        const int across = high.x - low.x + 1;
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const glm::dvec2 p = place(x, y);
                points.push_back(ecefFromPlace_(Point<Enu>{{p, shape_.level(p, seconds)}}));
                mesh.vertices.push_back(
                    {glm::vec3(glm::transpose(axes) * (points.back() - mesh.origin).xyz),
                     float(shape_.depth(p, seconds)), shape_.velocity});
            }
        for (int y = 0; y < high.y - low.y; ++y)
            for (int x = 0; x < high.x - low.x; ++x) {
                const auto at = std::uint32_t(y * across + x), up = at + std::uint32_t(across);
                mesh.indices.insert(mesh.indices.end(), {at, at + 1, up + 1, at, up + 1, up});
            }
        mesh.box = boxAround(points, axes);
        mesh.radiusMetres = boundingSphere(BoundingVolume(mesh.box)).radiusMetres;
        return mesh;
    }

    Transform<Ecef, Enu> ecefFromPlace_;
    Shape shape_;
};

} // namespace gnomon::test
