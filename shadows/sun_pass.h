// How much of the sun each seen surface gets, in screen space: sun.frag over what the camera sees,
// the nearest opaque surfaces or the water's, and the cascades' maps.
#pragma once

#include "render/handles.h"
#include "render/program.h"
#include "render/visibility_pass.h"
#include "render/water_pass.h"
#include "shadows/cascade_pass.h"
#include "shadows/cascades.h"
#include "shadows/projective_pass.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace gnomon {

struct SunPassInput {
    // The camera that `seen` was drawn with, and the one the cascades were fitted to. They differ
    // only when the surfaces of one frame are asked again under another's maps (the flip test).
    Camera surfaceCamera;
    Camera cascadeCamera;
    Vector<Ecef> towardsSun;
    const CascadeSet* cascades = nullptr; // null: only surfaces turned away are dark
    const CascadePass* maps = nullptr;
    CasterBound casters;
    glm::dmat3 meshAxes{1.0}; // as `seen` was drawn with
    // Asked before the cascades, of which there may then be none; wants `cascades` for the range.
    const ProjectivePass* projective = nullptr;
    // There is terrain of measured heights: no facet continues the next.
    bool rough = false;
};

// The surfaces that are asked; their textures are read while the pass draws.
struct SunReceivers {
    // Implicit: either is what the camera sees.
    SunReceivers(const render::VisibilityPass& seen)
        : depth(seen.depth()), normals(seen.normals()), viewBlock(seen.viewBlock()),
          width(seen.width()), height(seen.height()), bounds{0, 0, width, height} {}
    SunReceivers(const render::WaterPass& seen)
        : depth(seen.depth()), normals(seen.normals()), viewBlock(seen.viewBlock()),
          width(seen.width()), height(seen.height()), bounds(seen.bounds()) {}

    const render::Texture& depth;
    const render::Texture& normals;
    const render::Buffer& viewBlock;
    int width, height;
    render::PixelRect bounds; // the answer elsewhere is left as it was
};

// The answer, a value a pixel.
class SunPicture {
  public:
    const render::Texture& visibility() const { return visibility_; } // R16, 1 lit
    // Rows top to bottom.
    std::vector<float> readVisibility() const;
    std::vector<std::uint8_t> readCascades() const; // 128 and more: projective; 255 none

  private:
    friend class SunPass;
    void resize(int width, int height);

    render::Texture visibility_, cascade_;
    render::Framebuffer target_;
    int width_ = 0, height_ = 0;
};

class SunPass {
  public:
    SunPass();
    void draw(const SunReceivers& seen, const SunPassInput& input, const ShadowSettings& settings,
              SunPicture& into);

  private:
    void use(const ShadowSettings& settings, const SunPassInput& input);

    std::map<std::string, render::Program> programs_; // by their defines; compiled when first used
    render::Buffer block_;
    render::VertexArray empty_;
};

} // namespace gnomon
