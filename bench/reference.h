// The truth that shadows are held against: rays, by Embree, over the triangles that a frame drew.
//
// A camera ray a pixel in double precision, then rays from the surface it meets to the light: one
// to its centre, or many stratified over the sun's disc. Rays leave a surface by an error bound,
// not by an epsilon. Triangles whose texture decides (alpha tests) let rays through where it is
// clear. The same scene, camera and light give the same bytes, on any number of cores.
#pragma once

#include "geo/camera.h"
#include "geo/result.h"
#include "viewer/frame.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <variant>
#include <vector>

namespace gnomon::bench {

// Positions and directions here are "stored": metres from the RayScene's origin along the meshes'
// own axes (FrameRenderer::meshAxes).

struct SunDisc {
    glm::dvec3 towards{0, 0, 1}; // unit
    double diameterDegrees = 0.533;
};
struct LampPoint {
    glm::dvec3 position{0.0};
    // Lights only the half space that this points into (unit); zero: all round.
    glm::dvec3 facing{0.0};
};
using Light = std::variant<SunDisc, LampPoint>;

// What a ray met.
struct RayHit {
    bool any = false;
    double distanceMetres = 0.0;
    glm::dvec3 position{0.0};
    glm::dvec3 normal{0.0}; // of the triangle, unit, towards where the ray came from
    MeshId mesh;
    std::uint32_t triangle = 0; // of the mesh
};

class RayScene {
  public:
    // All triangles of the tiles. Fails (named) without memory or when there is none.
    static Result<RayScene> build(std::span<const ResidentTile> tiles, Point<Ecef> origin,
                                  const glm::dmat3& meshAxes);
    ~RayScene();
    RayScene(RayScene&&) noexcept;

    Point<Ecef> origin() const;
    glm::dvec3 stored(Point<Ecef> p) const;
    glm::dvec3 stored(Vector<Ecef> v) const;
    std::uint64_t triangles() const;
    std::size_t bytes() const;

    // The first surface along a ray, leaves' clear texels passed through.
    RayHit first(const glm::dvec3& from, const glm::dvec3& direction,
                 double maximumMetres = 1e30) const;
    // From a surface point towards the light; the point is moved off its surface by an error bound.
    RayHit blocker(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& towards,
                   double maximumMetres = 1e30) const;
    bool blocked(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& towards,
                 double maximumMetres = 1e30) const;

    // Share of the light that reaches a surface point, 0…1, from `rays` rays (1: to its centre).
    // `seed` picks the stratified pattern. A surface turned away gets 0.
    double visibility(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                      int rays, std::uint32_t seed) const;
    // Whether the light's share differs anywhere on the surfaces around a point, within
    // `radiusMetres` of it measured in the plane normal to the light, from what it is at the point
    // (fully lit, fully dark, or between; with a `soft` light the whole disc counts, else its
    // centre). The surfaces around are those that a ray from the light meets near the point's own
    // plane: over the edge of a roof there is none.
    bool changesWithin(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                       bool soft, double radiusMetres) const;
    // Whether anything shadowed (not fully lit) lies that near.
    bool shadowWithin(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                      bool soft, double radiusMetres) const;
    // Whether something stands on the surface that near: an occluder's contact.
    bool contactWithin(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                       double radiusMetres) const;

  private:
    friend struct Tracer;
    friend struct Around;
    struct State;
    explicit RayScene(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// What a pixel sees. Rows top to bottom.
struct SurfacePoint {
    bool any = false; // else sky
    glm::dvec3 position{0.0}, normal{0.0};
    double viewDepthMetres = 0.0;
    MeshId mesh;
};

struct Reference {
    int width = 0, height = 0;
    std::vector<SurfacePoint> surfaces;
    std::vector<float> visibility; // share of the light; 0 turned away, sky 1
    std::vector<float> hard;       // the same by one ray to the light's centre, 0 or 1
    int raysPerPixel = 1;
    double milliseconds = 0.0;
};

struct ReferenceOptions {
    Light light;
    int raysPerPixel = 64; // 1: hard only, `visibility` equals `hard`
    unsigned threads = 0;  // 0: all cores
};

// Traces a picture through pixel centres. `progress` (may be empty) hears rows done of all, from
// the calling thread; when it answers false the work stops and the result is an Error ("stopped").
Result<Reference> traceReference(const RayScene& scene, const Camera& camera,
                                 const ReferenceOptions& options,
                                 const std::function<bool(int done, int all)>& progress = {});

// Calls `work(begin, end)` over 0…count on all cores in blocks; the helper the metrics use too.
void inParallel(std::size_t count, std::size_t block, unsigned threads,
                const std::function<void(std::size_t begin, std::size_t end)>& work);

} // namespace gnomon::bench
