// Plane-optimal maps for the planes that a picture shows most of.
#pragma once

#include "shadows/plane_finder.h"
#include "shadows/settings.h"

namespace gnomon {

struct PlaneMapsInput {
    SeenSurfaces seen;
    Camera camera;         // that the maps are for; the surfaces may have been seen by another
    glm::dvec3 towardsSun; // along the meshes' axes, unit
    glm::dvec4 reach{0.0}; // dot(reach, (p, 1)): metres along a sun ray to the highest caster, for
                           // positions relative to `camera`
    double rangeMetres = 0.0; // no receiver is farther from the eye
};

// At most settings.planes; relative to `camera`. Each covers the pixels that belong to its plane,
// and a margin for the filter.
std::vector<ProjectiveMap> planeOptimalMaps(const PlaneMapsInput& input,
                                            const ShadowSettings& settings);

} // namespace gnomon
