// Draws casters into the maps of a cascade set: reversed orthographic depth, 1 nearest the sun.
#pragma once

#include "render/gpu_tile.h"
#include "render/gpu_timer.h"
#include "render/handles.h"
#include "render/program.h"
#include "shadows/cascades.h"

#include <span>
#include <vector>

namespace gnomon {

// A flag for each caster: drawn into the map or not.
using DrawnCasters = std::vector<bool>;

class CascadePass {
  public:
    CascadePass();
    // Redraws every map in full, as the settings' bias wants it; marks `timer` after each. Returns
    // what was drawn into each.
    std::vector<DrawnCasters> draw(const CascadeSet& set, const ShadowSettings& settings,
                                   std::span<const render::DrawItem> casters,
                                   render::GpuTimer& timer);

    const render::Texture& maps() const { return maps_; } // 32F array, kept modulo N
    std::size_t bytes() const;
    // The texels of one map as they are kept, row by row.
    std::vector<float> read(int cascade) const;

  private:
    void resize(int mapSize, int count);
    void drawPage(const CascadeSet& set, const Cascade& cascade, const CascadePage& page,
                  ShadowCull cull, std::span<const render::DrawItem> casters,
                  std::span<const LightBox> boxes, DrawnCasters& drawn);

    render::Program opaque_, alphaTested_;
    render::Texture maps_;
    std::vector<render::Framebuffer> targets_;
    int mapSize_ = 0;
};

} // namespace gnomon
