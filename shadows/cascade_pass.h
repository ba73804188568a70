// Draws casters into the maps of a cascade set: reversed orthographic depth, 1 nearest the sun. A
// map holds the nearest layer, or lies between the two nearest, as the bias wants.
#pragma once

#include "render/gpu_tile.h"
#include "render/gpu_timer.h"
#include "render/handles.h"
#include "shadows/cascades.h"
#include "shadows/dual_layers.h"

#include <span>
#include <vector>

namespace gnomon {

// A flag for each caster: drawn into the map or not.
using DrawnCasters = std::vector<bool>;

class CascadePass {
  public:
    CascadePass();
    // Redraws every map in full, as the settings' bias wants it; sets marksPerMap() marks after
    // each. Returns what was drawn into each.
    std::vector<DrawnCasters> draw(const CascadeSet& set, const ShadowSettings& settings,
                                   std::span<const render::DrawItem> casters,
                                   render::GpuTimer& timer);
    // After the casters; where atomics find the two layers, also after the resolve.
    static int marksPerMap(const ShadowSettings& settings);

    // An array kept modulo N: 32F depth, or R32F where two layers are resolved to one.
    const render::Texture& maps() const { return maps_; }
    std::size_t bytes() const;
    // The texels of one map as they are kept, row by row.
    std::vector<float> read(int cascade) const;

  private:
    struct Map {
        const CascadeSet& set;
        const Cascade& cascade;
        const render::Framebuffer& target;
        ShadowCull cull;
        std::span<const render::DrawItem> casters;
        std::span<const LightBox> boxes;
        float layerOffset; // stored depth
        DrawnCasters drawn;
    };
    void resize(glm::ivec2 mapSize, int count, ShadowBias bias);
    render::Framebuffer target(int cascade) const;
    void drawLayers(Map& map, render::GpuTimer& timer);
    void drawPages(Map& map, const CasterPrograms& programs, bool overlapsOnly = false) const;
    void drawPage(Map& map, const CascadePage& page, const CasterPrograms& programs) const;

    CasterPrograms nearest_;
    DualLayers layers_;
    render::Texture maps_;
    std::vector<render::Framebuffer> targets_;
    glm::ivec2 mapSize_{0};
    ShadowBias bias_ = ShadowBias::Constant;
};

} // namespace gnomon
