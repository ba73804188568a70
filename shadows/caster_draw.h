// Draws casters into whatever map is bound: opaque ones first, then those whose texture decides;
// with the faces left out that the culling says, for closed components and for open ones.
#pragma once

#include "render/gpu_tile.h"
#include "render/program.h"
#include "shadows/settings.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <functional>
#include <span>

namespace gnomon {

struct CasterDraw {
    std::span<const render::DrawItem> casters;
    ShadowCull cull = ShadowCull::Auto;
    // Both take vertex attributes from GpuTile; the second also has `vec2 alphaTest` (x: base
    // alpha, y: cutoff) at kAlphaTestLocation and samples TEX_BASE_COLOR.
    const render::Program *opaque = nullptr, *alphaTested = nullptr;
    std::function<bool(std::size_t)> wants;             // by index: outside the map or not
    std::function<void()> start;                        // uniforms of all, once a program
    std::function<void(const render::DrawItem&)> place; // uniforms of one
};
inline constexpr int kAlphaTestLocation = 5;

// The state is the caller's: framebuffer, viewport, depth test. Leaves face culling off.
void drawCasters(const CasterDraw& draw);

void setUniform(int location, const glm::dvec3& v);

} // namespace gnomon
