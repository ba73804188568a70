// Draws casters into maps that follow the eye's perspective, and hands these to the sun pass.
#pragma once

#include "render/gpu_tile.h"
#include "render/gpu_timer.h"
#include "render/handles.h"
#include "render/program.h"
#include "shadows/cascade_pass.h"
#include "shadows/projective.h"
#include "shadows/settings.h"

#include <span>
#include <vector>

namespace gnomon {

// What stands for a projective map where others are cascades by their index (sun.frag).
inline constexpr std::size_t kFirstProjective = 128;

struct ProjectiveInput {
    std::span<const ProjectiveMap> maps; // at most kMaxPlanes
    Camera camera;                       // whose position the maps count from
    Camera surfaceCamera;                // that saw the receivers
    glm::dmat3 meshAxes{1.0};
    glm::dvec3 towardsSun; // along the meshes' axes, unit
};

class ProjectivePass {
  public:
    ProjectivePass();
    // Marks `timer` after each map. Returns what was drawn into each. Of the bias only the culling
    // counts here: receivers are compared with their own plane, maps hold the nearest layer.
    std::vector<DrawnCasters> draw(const ProjectiveInput& input, const ShadowSettings& settings,
                                   std::span<const render::DrawItem> casters,
                                   render::GpuTimer& timer);
    // What projective.glsl reads: of the last draw.
    void bind() const;

    std::size_t bytes() const;
    // The stored depths of one map, row by row from the bottom.
    std::vector<float> read(std::size_t map) const;

  private:
    void resize(std::span<const ProjectiveMap> maps);
    void drawMap(const ProjectiveInput& input, const ProjectiveMap& map, ShadowCull cull,
                 std::span<const render::DrawItem> casters, DrawnCasters& drawn);

    render::Program opaque_, alphaTested_;
    render::Buffer block_;
    render::Texture maps_; // 32F array; a map fills the lower left corner of its layer
    std::vector<render::Framebuffer> targets_;
    int width_ = 0, height_ = 0;
    std::vector<ProjectiveMap> drawn_;
};

} // namespace gnomon
