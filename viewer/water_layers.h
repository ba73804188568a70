// The water of a scene at a moment, on the GPU; and what it looks like.
#pragma once

#include "geo/camera.h"
#include "render/water_pass.h"
#include "shaders/interface.h"
#include "viewer/scene.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

class WaterLayers {
  public:
    explicit WaterLayers(const Scene& scene) : scene_(scene) {}

    // Brings the layers to this moment; those whose own moment stays are kept. What cannot be shown
    // is told in a line each.
    std::vector<std::string> show(std::optional<UtcTime> time);
    void hide() { items_.clear(); }

    const std::vector<render::WaterItem>& items() const { return items_; } // of what is shown
    std::vector<OrientedBox> boxes() const;
    std::size_t bytes() const;

  private:
    struct Moment {
        double seconds = 0.0;
        std::unique_ptr<render::GpuWater> water; // null: it failed
        std::string failure;
    };
    Moment make(const WaterLayer& layer, double seconds) const;

    const Scene& scene_;
    std::vector<std::optional<Moment>> moments_; // one a layer
    std::vector<render::WaterItem> items_;
};

// For the picture that `camera` sees.
shader::WaterBlock waterLook(const Camera& camera, const Transform<Ecef, Enu>& ecefFromAnchor);

} // namespace gnomon
