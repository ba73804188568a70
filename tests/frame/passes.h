// The passes of viewer/frame.cpp driven one by one, so that surfaces seen once can be asked again
// under another camera's cascades.
#pragma once

#include "render/gpu_timer.h"
#include "render/visibility_pass.h"
#include "shadows/cascade_pass.h"
#include "shadows/light_basis.h"
#include "shadows/sun_pass.h"
#include "tests/frame/small_scene.h"
#include "viewer/ground.h"
#include "viewer/shadow_range.h"
#include "viewer/tile_cache.h"

#include <span>

namespace gnomon::test {

class Passes {
  public:
    Passes(Scene& scene, std::optional<double> groundHeight) : scene_(scene), cache_(scene) {
        if (groundHeight) {
            std::vector<std::string> warnings;
            ground_.emplace(makeGround(scene, *groundHeight), warnings);
        }
    }

    // Loads what the camera sees: all of a small scene.
    void load(const Camera& camera) {
        std::vector<Selection> selections;
        const View view = perspectiveView(camera);
        for (Layer& layer : scene_.layers)
            selections.push_back(settle(*layer.tileset, std::span(&view, 1), {8.0, false},
                                        std::chrono::steady_clock::now() + std::chrono::minutes(1))
                                     .selection);
        items_ = cache_.items(selections);
        if (ground_)
            for (const render::GpuMesh& mesh : ground_->meshes())
                items_.push_back({&*ground_, &mesh, 0});
    }

    void see(const Camera& camera) {
        surfaceCamera_ = camera;
        seen_.draw(camera, items_, axes());
    }

    const CascadeSet& fit(const Camera& camera, const SunPosition& sun,
                          const ShadowSettings& settings) {
        const ShadowReach reach =
            shadowReach(scene_, camera, sun, items_, settings, perspectiveView(camera));
        CascadeInput input;
        input.camera = camera;
        input.lightFromEcef = lightFromEcef(scene_.ecefFromAnchor, sun.towards);
        input.meshAxes = axes();
        input.nearMetres = reach.nearMetres;
        input.farMetres = reach.farMetres;
        input.rangeMetres = reach.rangeMetres;
        input.fadeMetres = reach.fadeMetres;
        set_ = fitCascades(input, settings);
        bound_ = casterBound(scene_, sun, set_.lightFromEcef, items_);
        for (Cascade& cascade : set_.cascades)
            setDepthRange(cascade, set_.mapSize, bound_);
        return set_;
    }
    // Maps for what was fitted last.
    void drawMaps(const ShadowSettings& settings) {
        timer_.start();
        maps_.draw(set_, settings, items_, timer_);
    }

    struct Answer {
        std::vector<float> visibility;
        std::vector<std::uint8_t> cascade;
    };
    // How much sun the surfaces seen get, with the cascades fitted to `camera`.
    Answer ask(const Camera& camera, const SunPosition& sun, const ShadowSettings& settings) {
        fit(camera, sun, settings);
        drawMaps(settings);
        sunPass_.draw(seen_, {surfaceCamera_, camera, sun.towards, &set_, &maps_, bound_, axes()},
                      settings, sun_);
        return {sun_.readVisibility(), sun_.readCascades()};
    }

    const CascadeSet& cascades() const { return set_; }
    CascadePass& maps() { return maps_; }
    std::span<const render::DrawItem> items() const { return items_; }

  private:
    glm::dmat3 axes() const { return scene_.ecefFromAnchor.axes(); } // meshes are stored along them

    Scene& scene_;
    TileCache cache_;
    std::optional<render::GpuTile> ground_;
    std::vector<render::DrawItem> items_;
    render::VisibilityPass seen_;
    CascadePass maps_;
    SunPass sunPass_;
    SunPicture sun_;
    render::GpuTimer timer_;
    Camera surfaceCamera_;
    CascadeSet set_;
    CasterBound bound_;
};

} // namespace gnomon::test
