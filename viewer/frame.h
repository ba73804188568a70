// One frame, from a settled scene to pictures: a pure function of (scene, camera, sun, settings).
// frame.cpp reads as the list of what happens in it.
#pragma once

#include "geo/camera.h"
#include "geo/sun.h"
#include "shadows/settings.h"
#include "viewer/scene.h"

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

namespace render {
class Context;
}

enum class Aov { Sun, Depth, Normal, Cascade, Tile };

struct FrameOptions {
    ShadowSettings shadows;
    double maximumScreenSpaceError = 8.0;
    std::optional<double> groundHeightMetres; // of the flat ground above the ellipsoid
    bool groundAuto = true;                   // find it from the inputs' bases
};

struct FrameRequest {
    Camera camera;
    SunPosition sun;
    std::chrono::steady_clock::time_point deadline; // for the tiles it needs
    bool waitForTiles = true; // capture: settle first; view: draw what is there
};

struct CascadeFacts {
    double nearMetres = 0, farMetres = 0, texelMetres = 0;
    std::uint32_t casters = 0; // meshes drawn into it
};

struct FrameFacts {
    bool complete = false;
    std::uint32_t tilesSelected = 0;
    std::uint64_t tilesLoaded = 0;
    std::vector<std::string> missing; // wanted by this frame, and not there: failed or late
    std::vector<std::string> late;    // of these, the ones still loading when the deadline passed
    double screenSpaceError = 0;
    std::size_t decodedBytes = 0, gpuBytes = 0;
    std::uint64_t triangles = 0;
    std::uint32_t draws = 0;
    double selectMs = 0, uploadMs = 0, totalMs = 0; // CPU
    std::vector<double> depthMs;                    // GPU, a value per cascade
    double visibilityMs = 0, sunMs = 0, compositeMs = 0, gpuTotalMs = 0;
    std::vector<CascadeFacts> cascades;
};

// Rows top to bottom.
struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};
struct FloatPicture {
    int width = 0, height = 0, channels = 1;
    std::vector<float> values;
};

class FrameRenderer {
  public:
    static Result<std::unique_ptr<FrameRenderer>> create(render::Context& context, Scene& scene,
                                                         const FrameOptions& options);
    ~FrameRenderer();

    void setOptions(const FrameOptions& options);
    // The ground's height above the ellipsoid that `auto` found (or was given); none without
    // ground.
    std::optional<double> groundHeightMetres() const;

    Result<FrameFacts> draw(const FrameRequest& request);

    Picture picture();
    // One channel for Sun (0…1, -1 sky), Depth (metres along the view axis, +inf sky), Cascade
    // (0-based, 255 none) and Tile (id, 0 none); three for Normal (ENU at the camera, 0 sky).
    FloatPicture aov(Aov which);
    // Names for the ids in the Tile picture; index 0 is "".
    const std::vector<std::string>& tileNames() const;
    void present(int windowWidth, int windowHeight); // into the window's framebuffer

  private:
    struct State;
    explicit FrameRenderer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
