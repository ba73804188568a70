// What a RayScene is made of, for the files that implement it.
#pragma once

#include "bench/reference_light.h"
#include "bench/reference_rays.h"

namespace gnomon::bench {

struct RayScene::State {
    std::unique_ptr<Rays> rays;

    // The light's share at a point, by a ray to its centre or rays to its disc.
    double centre(const glm::dvec3& point, const glm::dvec3& normal,
                  const Incoming& incoming) const;
    double disc(const glm::dvec3& point, const glm::dvec3& normal, const Incoming& incoming,
                std::span<const glm::vec2> offsets) const;
};

} // namespace gnomon::bench
