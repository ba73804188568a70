// Lamps: a map or two of what each sees, and what it gives to the surfaces that the camera sees.
//
// A lamp's maps are drawn again only when something in them changed; what they hold does not depend
// on what was drawn before, so pictures do not either.
#pragma once

#include "render/gpu_timer.h"
#include "render/handles.h"
#include "render/program.h"
#include "render/visibility_pass.h"
#include "shadows/lamp_casters.h"
#include "shadows/settings.h"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

struct LampPassInput {
    Camera surfaceCamera;     // that `seen` was drawn with
    glm::dmat3 meshAxes{1.0}; // as for the visibility pass
    Transform<Ecef, Enu> ecefFromAnchor;
    std::span<const Lamp> lamps;       // of the scene
    std::span<const std::size_t> live; // into `lamps`
    std::span<const LampCaster> casters;
    double exposure = 1.0; // on every lamp's power
};

// Of one lamp; rows top to bottom.
struct LampPicture {
    std::vector<float> visibility, texelMetres; // -1 sky, 0 turned away or out of range; 0 none
};

class LampPass {
  public:
    LampPass();
    ~LampPass();

    // Brings the maps of the live lamps up to date.
    void drawMaps(const LampPassInput& input, const ShadowSettings& settings);
    // What the live lamps give to what was seen.
    void draw(const render::VisibilityPass& seen, const LampPassInput& input,
              const ShadowSettings& settings);
    const render::Texture& light() const { return light_; } // RGBA16F, exposure applied

    // A live lamp's shadow alone, of those drawn last; empty for one that has no maps.
    std::optional<LampPicture> shadowOf(const render::VisibilityPass& seen,
                                        const LampPassInput& input, std::size_t lamp,
                                        const ShadowSettings& settings);

    std::size_t bytes() const;
    int mapsDrawn() const { return mapsDrawn_; }           // by the last drawMaps()
    std::uint64_t triangles() const { return triangles_; } // in these, as cut
    // The texels of one map of a lamp: distances in metres, row by row; infinite where nothing is.
    std::vector<float> read(std::size_t lamp, int map) const;

  private:
    struct Slot;

    const Slot* slotOf(std::size_t lamp) const;
    void assignLayers(const LampPassInput& input, const ShadowSettings& settings);
    void resize(int texels, int layers);
    void fill(Slot& slot, const LampPassInput& input, const ShadowSettings& settings,
              std::vector<LampCaster> casters);
    void drawMap(const Slot& slot, int map, const LampMapTriangles& triangles,
                 std::span<const LampCaster> casters);
    void setLamp(const Slot& slot, const LampPassInput& input, const ShadowSettings& settings);
    void bindSeen(const render::VisibilityPass& seen, const ShadowSettings& settings);
    const render::Program& program(std::string_view fragment, const std::string& defines);

    std::map<std::string, render::Program> programs_; // by file and defines
    render::Buffer block_;
    render::VertexArray empty_;
    render::Texture maps_; // 32F array: 0 at the lamp's near distance, 1 at its range
    std::vector<render::Framebuffer> layers_;
    int texels_ = 0;
    std::vector<std::unique_ptr<Slot>> slots_;
    int mapsDrawn_ = 0;
    std::uint64_t triangles_ = 0;

    render::Texture light_;
    render::Framebuffer lightTarget_;
    int width_ = 0, height_ = 0;
};

} // namespace gnomon
