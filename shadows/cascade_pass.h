// Draws casters into the maps of a cascade set: reversed orthographic depth, 1 nearest the sun.
#pragma once

#include "render/gpu_tile.h"
#include "render/gpu_timer.h"
#include "render/handles.h"
#include "render/program.h"
#include "shadows/cascades.h"

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon {

class CascadePass {
  public:
    CascadePass();
    // Redraws every map in full; marks `timer` after each. Returns the meshes drawn into each.
    std::vector<std::uint32_t> draw(const CascadeSet& set, ShadowCull cull,
                                    std::span<const render::DrawItem> casters,
                                    render::GpuTimer& timer);

    const render::Texture& maps() const { return maps_; } // 32F array, kept modulo N
    std::size_t bytes() const;
    // The texels of one map as they are kept, row by row.
    std::vector<float> read(int cascade) const;

  private:
    void resize(int mapSize, int count);
    std::uint32_t drawPage(const CascadeSet& set, const Cascade& cascade, const CascadePage& page,
                           ShadowCull cull, std::span<const render::DrawItem> casters,
                           std::span<const LightBox> boxes);

    render::Program opaque_, alphaTested_;
    render::Texture maps_;
    std::vector<render::Framebuffer> targets_;
    int mapSize_ = 0;
};

} // namespace gnomon
