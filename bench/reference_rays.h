// The triangles of a scene as Embree holds them, and rays through them that are decided in double.
//
// Embree works in float. Here it only finds which triangles' boxes a ray enters, from a little
// before the ray's start; whether the ray meets the triangle, and where, is decided in double from
// the triangle's own corners (bench/reference_rays.cpp). So a hit's place is as good as the data,
// no ray passes between triangles that share an edge, and where a ray begins needs no more room
// than the rounding of the vertices.
#pragma once

#include "bench/reference.h"

#include <glm/vec2.hpp>

#include <atomic>
#include <limits>
#include <memory>
#include <span>
#include <vector>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace gnomon::bench {

// A mesh as its rays see it. Its index among them is Embree's geometry id.
struct RayMesh {
    const Mesh* mesh = nullptr;
    const Material* look = nullptr; // null: no texture or alpha decides
    const Image* image = nullptr;   // of the look; null: none
    glm::dvec3 origin{0.0};         // stored
    // How far apart two surfaces can be that were one before their vertices were rounded.
    double liftMetres = 0.0;
    // By how much Embree's boxes are larger than the triangles.
    double roomMetres = 0.0;
    MeshId id;
};

// A ray that begins on a surface has its normal (unit, to the side it leaves on): then it begins by
// the hit mesh's lift above that surface.
struct Ray {
    glm::dvec3 from{0.0}, direction{0.0}; // the direction need not be unit; distances are in it
    glm::dvec3 normal{0.0};
    double minimum = 0.0, maximum = std::numeric_limits<double>::infinity();
};

class Rays {
  public:
    static Result<std::unique_ptr<Rays>> build(std::span<const ResidentTile> tiles,
                                               Point<Ecef> origin, const glm::dmat3& meshAxes);
    ~Rays();
    Rays(const Rays&) = delete;
    Rays& operator=(const Rays&) = delete;

    Point<Ecef> origin() const { return origin_; }
    const glm::dmat3& meshAxes() const { return meshAxes_; }
    std::uint64_t triangles() const { return triangles_; }
    std::size_t bytes() const { return std::size_t(std::max<std::int64_t>(bytes_, 0)); }

    RayHit nearest(const Ray& ray) const;
    bool any(const Ray& ray) const;
    // How many of rays that share their start get away. Those that do not rise above the surface
    // do not.
    int escaping(const glm::dvec3& from, const glm::dvec3& normal, const glm::dvec3& axis,
                 const glm::dvec3& right, const glm::dvec3& up,
                 std::span<const glm::vec2> offsets) const;

  private:
    Rays(Point<Ecef> origin, const glm::dmat3& meshAxes) : origin_(origin), meshAxes_(meshAxes) {}
    void add(const ResidentTile& tile);
    void makeRoom();
    void attach(std::uint32_t index);
    double backOff(const Ray& ray) const;

    Point<Ecef> origin_;
    glm::dmat3 meshAxes_;
    RTCDeviceTy* device_ = nullptr;
    RTCSceneTy* scene_ = nullptr;
    std::vector<std::shared_ptr<const TileContent>> kept_;
    std::vector<RayMesh> meshes_;
    std::uint64_t triangles_ = 0;
    std::atomic<std::int64_t> bytes_{0}; // Embree's
};

} // namespace gnomon::bench
