// Scenes whose shadows are known by heart: those of the four papers, and hard cases of cities. Made
// by code, in metres east, north and up of an anchor, opened like any input.
#pragma once

#include "viewer/frame.h"
#include "viewer/scene.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon::bench {

// A line on a surface along which shadow changes once: its ends in the scene's ENU frame. Penumbra:
// from lit to dark, to measure widths. Contact: from an occluder's foot outwards, within its
// shadow, to measure where the shadow begins.
struct Probe {
    enum class Kind { Penumbra, Contact } kind = Kind::Penumbra;
    glm::dvec3 from{0.0}, to{0.0};
    double gapMetres = 0.0; // from blocker to receiver along the ray to the sun, where it is known
};

struct SceneDescription {
    const char *name, *about; // "l-shape"; one line, with the paper it is from
};
std::span<const SceneDescription> sceneDescriptions();

struct BenchScene {
    Scene scene;
    Camera camera;      // size and all; the default view
    SunAngles sun;      // its default sun, or the one asked for
    FrameOptions frame; // ground, lamps; shadows as shipped
    std::vector<Probe> probes;
};

inline constexpr Geodetic kDefaultPlace{6.96, 50.94, 55.0}; // Cologne

// Probes are for `sun`, by default the scene's own; a sun below the
// horizon has none. Fails (Usage) naming the scenes when there is none of this name.
Result<BenchScene> openBenchScene(const std::string& name, const Geodetic& place = kDefaultPlace,
                                  const std::optional<SunAngles>& sun = {});

} // namespace gnomon::bench
