// The water that a flood result shows at a moment: surface, shore, depth. Linear in time between
// steps, a dry step counting as no depth; the shore lies where the level meets the ground between a
// wet node and a dry one, so it is smooth, and no dry node is ever under water. The rule, and how
// it keeps to the model's own area and volume: water_surface_shore.h.
#pragma once

#include "streaming/flood/flood.h"
#include "streaming/terrain/ground_heights.h"

#include "geo/bounds.h"

#include <glm/vec3.hpp>

namespace gnomon {

struct WaterVertex {
    glm::vec3 position; // relative to the mesh's origin, along the scene's mesh axes
    float depth;        // metres; 0 at the shore, where the mesh ends
    glm::vec2 velocity; // m/s along east and north; 0 when not known
};

struct WaterMesh {
    Point<Ecef> origin;
    OrientedBox box;
    double radiusMetres = 0;
    std::vector<WaterVertex> vertices;
    std::vector<std::uint32_t> indices; // counter-clockwise seen from above
};

struct WaterSurfaceOptions {
    double dryMetres = 0.01; // no deeper than this is dry
};

struct WaterAt {
    double levelMetres = 0; // above the ellipsoid
    double depthMetres = 0; // above the model's bed
    std::optional<glm::vec2> velocity;
    bool interpolated = false; // see FloodData::isInterpolated
};

// Sums over the whole result at a moment.
struct WaterTotals {
    double wetAreaSquareMetres = 0, volumeCubicMetres = 0;        // of the nodes and their cells
    double shownAreaSquareMetres = 0, shownVolumeCubicMetres = 0; // of the surface that is drawn
    double maxDepthMetres = 0, maxSpeed = 0;
};

class WaterSurface {
  public:
    virtual ~WaterSurface() = default;
    // Fails, in one line, when there is no ground for it to stand on, or no water at all.
    static Result<std::shared_ptr<WaterSurface>>
    create(std::shared_ptr<const FloodData> data,
           const std::shared_ptr<const GroundHeights>& ground, const WaterSurfaceOptions& options);

    // With the notes of what was made out for this ground (FloodData::on).
    virtual const FloodData& data() const = 0;
    virtual std::array<double, 4> extent() const = 0; // west, south, east, north, degrees
    virtual Sphere bounds() const = 0;
    // `seconds` in the data's own reckoning (FloodData::stepSeconds); before the first step and
    // after the last the nearest. The same answer for the same moment, whatever was asked before.
    virtual Result<std::vector<WaterMesh>> meshes(double seconds,
                                                  const glm::dmat3& meshAxes) const = 0;
    virtual Result<std::optional<WaterAt>> at(double seconds, glm::dvec2 lonLat) const = 0;
    virtual Result<WaterTotals> totals(double seconds) const = 0;
    // Over all steps: what the colours' range is chosen by.
    virtual double deepestMetres() const = 0;
    virtual double fastest() const = 0;
};

} // namespace gnomon
