// One frame, from a settled scene to pictures: a pure function of (scene, camera, sun, settings).
// frame.cpp reads as the list of what happens in it.
#pragma once

#include "geo/camera.h"
#include "geo/sun.h"
#include "shadows/settings.h"
#include "streaming/mesh.h"
#include "viewer/scene.h"

#include <array>
#include <chrono>
#include <functional>
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
    // Of tiles on the GPU, for residentTiles() and for the maps of lamps that are lit. Without,
    // about twice as many tiles fit into the memory. create() decides it.
    bool keepContents = true;
    // How long the tiles are waited for that the flat ground's height is found from; and whether
    // that they do not come is an error then.
    std::chrono::duration<double> groundPatience{30.0};
    bool groundMustBeKnown = false;
};

struct Coming {
    Camera camera;
    SunPosition sun;
    std::optional<UtcTime> time;
};

struct FrameRequest {
    Camera camera;
    SunPosition sun;
    std::optional<UtcTime> time;                    // what stands, and how the water is
    std::chrono::steady_clock::time_point deadline; // for the tiles it needs
    std::function<bool()> stopped; // asked while it waits for them: true is as the deadline
    // What is drawn after it, the next first: their tiles are loaded while this one is drawn.
    std::vector<Coming> coming;
    bool still = false;       // the picture stands alone: no other follows it in motion
    bool waitForTiles = true; // capture: settle first; view: draw what is there
    // The surfaces that the last frame saw are asked again, under this camera's shadow maps: what
    // changes between the two answers flickers. Wants the same size of picture.
    bool keepSurfaces = false;
    // As if there were none: rays that are asked instead know of no water.
    bool withoutWater = false;
};

struct CascadeFacts {
    double nearMetres = 0, farMetres = 0, texelMetres = 0;
    std::uint32_t casters = 0; // meshes drawn into it
};

struct FrameFacts {
    bool complete = false;
    std::uint32_t tilesSelected = 0;
    std::uint64_t tilesLoaded = 0;
    // Wanted by this frame, and not there: tiles that failed or are late; water, with its reason.
    std::vector<std::string> missing;
    std::vector<std::string> late; // of these, the ones still loading when the deadline passed
    std::vector<std::string> lateReasons; // what went wrong with each of them so far; or empty
    double screenSpaceError = 0;
    bool overBudget = false; // its tiles do not fit into the memory, however coarse
    std::size_t decodedBytes = 0, gpuBytes = 0;
    std::size_t mostTileBytes = 0; // tiles took at any moment so far, see MemoryLedger::most()
    std::uint64_t triangles = 0;
    std::uint32_t draws = 0;
    double selectMs = 0, uploadMs = 0, totalMs = 0; // CPU
    std::vector<double> depthMs;                    // GPU, a value per map
    double resolveMs = 0; // of all maps: from two layers to the map's depth; 0 without
    double visibilityMs = 0, sunMs = 0, compositeMs = 0, gpuTotalMs = 0;
    double waterMs = 0; // its surface, and the sun on it
    std::uint64_t waterTriangles = 0;
    double lampMs = 0;                          // maps that had to be drawn, and light
    std::uint32_t lamps = 0, lampMapsDrawn = 0; // lit; and the maps among theirs drawn this frame
    std::vector<CascadeFacts> cascades;
    std::size_t shadowBytes = 0; // of the shadow maps
    // Distance from the eye where shadows have faded out, over the last how many metres.
    double shadowRangeMetres = 0, shadowFadeMetres = 0;
};

// A tile as it was drawn: what rays ask instead. `id` is the Tile picture's; 0 is the ground.
struct ResidentTile {
    std::shared_ptr<const TileContent> content;
    std::uint32_t id = 0;
};
// A mesh of a tile, by the tile's id and the mesh's index in its content.
struct MeshId {
    std::uint32_t tile = 0, mesh = 0;
    auto operator<=>(const MeshId&) const = default;
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
    // Of the nearest surface, water included; Tile of the nearest that is opaque. One channel for
    // Sun (0…1, -1 sky), Depth (metres along the view axis, +inf sky), Cascade (0-based;
    // kFirstProjective and more: maps in the eye's perspective; 255 none) and Tile (id, 0 none);
    // three for Normal (ENU at the camera, 0 sky).
    FloatPicture aov(Aov which);
    // The share of sun of the opaque surface, also where water is over it; -1 sky.
    FloatPicture opaqueSun();
    // Names for the ids in the Tile picture; index 0 is "".
    const std::vector<std::string>& tileNames() const;
    // Of the last frame, for those who hold its shadows against rays:
    std::vector<ResidentTile> residentTiles() const;
    std::vector<std::vector<MeshId>> drawnCasters() const; // ascending, a list per cascade
    // Metres across the texel an opaque pixel's shadow is from, in the light's plane; 0 none.
    FloatPicture texels();
    // The same as Aov::Sun and texels(), of a lamp by its index in the scene; 0 turned away or out
    // of its range, -1 sky. Empty for one that was not lit.
    FloatPicture lampVisibility(std::size_t lamp);
    FloatPicture lampTexels(std::size_t lamp);
    glm::dmat3 meshAxes() const; // the contents' positions are along these (columns, in ECEF)

    void present(int windowWidth, int windowHeight); // into the window's framebuffer

  private:
    struct State;
    explicit FrameRenderer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
