// Draws maps that lie between the two layers nearest the sun (ShadowBias::Midpoint and Dual…). They
// are colours, one float each, as blending serves them; read like the depth textures of the others.
//
// Peeled: casters are drawn twice, over one depth map that serves all maps in turn. The first time
// it takes the first layer, and the map's texel is what it would be without a second; the second
// time only what lies strictly behind passes, and raises that texel (shaders/depth_layers.glsl). No
// pass over all texels is left to do. Atomic: casters are drawn once, without depth test, and
// resolve() makes the map of the two images that they leave. Both give the same bytes.
#pragma once

#include "render/handles.h"
#include "render/program.h"
#include "shadows/settings.h"

#include <glm/vec2.hpp>

#include <cstddef>

namespace gnomon {

// Programs that draw casters, opaque and alpha-tested.
struct CasterPrograms {
    render::Program opaque, alphaTested;
};

class DualLayers {
  public:
    // Makes what the bias needs and frees what it does not: nothing for one layer.
    void prepare(ShadowBias bias, glm::ivec2 mapSize);
    bool peels() const { return bias_ != ShadowBias::DualAtomic; }
    // Peeling: the depth map, to be attached behind each map.
    const render::Texture& depth() const { return first_; }

    // Each for the framebuffer of one map, which is bound, and what is to be drawn into it then.
    const CasterPrograms& startFirst() const;
    const CasterPrograms& startSecond() const;
    const CasterPrograms& startBoth() const;
    void resolve(float offset) const; // atomics; `offset` in stored depth
    // Ends what startSecond and startBoth changed.
    void finish() const;
    // Of these programs, where they have it.
    void setOffset(float offset) const;

    std::size_t bytes() const;

  private:
    void preparePeeling();
    void prepareAtomics();

    ShadowBias bias_ = ShadowBias::Constant;
    glm::ivec2 mapSize_{0};
    render::Texture first_, second_; // a 32F depth alone when peeling, else two R32UI
    CasterPrograms firstPrograms_, secondPrograms_;
    render::Program resolve_;
    render::VertexArray empty_;
};

} // namespace gnomon
