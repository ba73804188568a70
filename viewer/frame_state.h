// Private to frame.cpp, which draws, and frame_pictures.cpp, which reads back what was drawn.
#pragma once

#include "render/composite_pass.h"
#include "render/gpu_timer.h"
#include "render/visibility_pass.h"
#include "render/water_pass.h"
#include "shadows/cascade_pass.h"
#include "shadows/projective_pass.h"
#include "shadows/sun_pass.h"
#include "viewer/frame.h"
#include "viewer/lamps.h"
#include "viewer/tile_cache.h"
#include "viewer/water_layers.h"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace gnomon {

struct FrameRenderer::State {
    State(render::Context& gl, Scene& shown, const FrameOptions& given)
        : context(gl), scene(shown), options(given), cache(shown, given.keepContents),
          waters(shown), lamps(shown) {}

    render::Context& context;
    Scene& scene;
    FrameOptions options;
    TileCache cache;
    WaterLayers waters;
    std::optional<double> groundHeight;
    std::shared_ptr<const TileContent> groundContent;
    std::unique_ptr<render::GpuTile> ground;
    double coarser = 1.0; // a window's error, times what was asked for, to fit into the memory

    render::VisibilityPass visibilityPass;
    render::WaterPass waterPass;
    CascadePass cascadePass;
    ProjectivePass projectivePass;
    SunPass sunPass;
    SunPicture sun, waterSun; // of the opaque surfaces, and of the water's
    LampLights lamps;
    render::CompositePass compositePass;
    render::GpuTimer timer;
    struct Last { // of the frame drawn last
        Camera camera;
        Camera surfaceCamera; // differs only where surfaces were kept
        std::vector<Selection> selections;
        std::vector<render::DrawItem> items;
        CascadeSet cascades;
        std::vector<ProjectiveMap> projective; // relative to `camera`
        glm::dvec3 towardsSun;                 // along the meshes' axes
        std::vector<DrawnCasters> drawn;       // of the cascades, then of these
    } last;

    // What a frame has come to, step by step.
    struct Frame {
        Frame(const FrameRequest& of, const FrameOptions& options, double maximumScreenSpaceError);
        FrameRequest request;
        ShadowSettings shadows; // off by night
        double screenSpaceError;
        std::vector<View> views; // the camera's, then those of the maps
        std::vector<Selection> selections;
        std::vector<render::DrawItem> items;
        // A window uploads tiles for so long a frame, so that it never stalls: below 4 ms with the
        // part that is under way when the time is over.
        std::chrono::steady_clock::duration uploadTime = std::chrono::milliseconds(3);
        CascadeInput input;
        CascadeSet cascades;
        CasterBound casters;
        FrameFacts facts;
    };

    // The steps.
    void showWater(Frame& frame);
    void findTiles(Frame& frame);
    void fitShadows(Frame& frame);
    void findCasters(Frame& frame);
    void askForMore(Frame& frame);
    void drawSurfaces(Frame& frame);
    void drawMaps(Frame& frame);
    void drawLight(Frame& frame);
    void drawPicture(const Frame& frame);
    void noteCost(Frame& frame);
    FrameFacts keep(Frame frame);

    Failure chooseGround();
    void select(Frame& frame);
    std::vector<StreamedTileset*> standing(std::optional<UtcTime> time) const; // null: it does not
    void settleTiles(Frame& frame);
    void takeTiles(Frame& frame);
    void fitCascadesTo(Frame& frame) const;
    void prefetch(const Frame& frame);
    MemoryLedger* ledger() const;
    std::vector<float> groundErrors(const Frame& frame) const;
    CascadeSet tightened(Frame& frame);
    std::vector<ProjectiveMap> projectiveMaps(const Frame& frame);
    // Read back, rows top to bottom: as VisibilityPass's, or the water's where it is nearer.
    struct NearestSurfaces {
        std::vector<float> viewDepth;
        std::vector<std::uint16_t> normals;
        std::vector<bool> water;
    };
    NearestSurfaces nearestSurfaces() const;
    std::vector<float> normals(const NearestSurfaces& nearest) const; // ENU at the camera
    void noteTiles(Frame& frame) const;
    std::vector<ResidentTile> residentTiles(const std::vector<Selection>& selections) const;
    std::vector<LampCaster> lampCasters(const Frame& frame) const;
    glm::dmat3 meshAxes() const { return scene.ecefFromAnchor.axes(); }
};

} // namespace gnomon
