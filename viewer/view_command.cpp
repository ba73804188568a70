// `gnomon view`: a window on the scene. Draws when something changed: the hand, the tiles, the
// size.
#include "render/context.h"
#include "viewer/commands.h"
#include "viewer/image_file.h"
#include "viewer/messages.h"
#include "viewer/orbit.h"
#include "viewer/overlay_facts.h"
#include "viewer/shot.h"
#include "viewer/stop_signal.h"
#include "viewer/window.h"

#include <chrono>
#include <cmath>

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kDegreesPerPixel = 0.25;
constexpr double kZoomPerClick = 0.85;
constexpr double kIdleSeconds = 0.25;      // between looks at the clock when nothing happens
constexpr double kStreamingSeconds = 0.01; // while tiles are on their way

class Viewer {
  public:
    explicit Viewer(const ViewOptions& options) : options_(options) {}

    int run() {
        if (Failure failure = prepare()) {
            sayError(*failure);
            return exitCodeOf(failure->kind);
        }
        if (Failure failure = loop()) {
            sayError(*failure);
            return exitCodeOf(failure->kind);
        }
        return exitCode_;
    }

  private:
    Failure prepare() {
        const PictureOptions& picture = options_.picture;
        Result<Shots> shots = Shots::create(picture);
        if (!shots)
            return shots.error();
        Result<Scene> scene = openAsked(picture);
        if (!scene)
            return scene.error();
        scene_.emplace(std::move(*scene));
        if (say(scene_->problems))
            exitCode_ = exit_code::kSkipped;
        auto window = Window::open("gnomon", picture.widthPixels, picture.heightPixels);
        if (!window)
            return window.error();
        window_ = std::move(*window);
        auto context = render::Context::adoptCurrent();
        if (!context)
            return context.error();
        context_ = std::move(*context);
        auto renderer =
            FrameRenderer::create(*context_, *scene_, frameOptionsFor(picture, *scene_));
        if (!renderer)
            return renderer.error();
        renderer_ = std::move(*renderer);
        shot_ = shots->at(0.0, *scene_);
        orbit_.emplace(*scene_, shot_.camera);
        return {};
    }

    Failure loop() {
        const Clock::time_point start = Clock::now();
        bool redraw = true, streaming = true;
        while (true) {
            const Window::Input input =
                window_->poll(redraw ? 0.0 : (streaming ? kStreamingSeconds : kIdleSeconds));
            redraw = follow(input) || streaming || redraw;
            const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
            const bool timeUp = options_.quitAfterSeconds && seconds >= *options_.quitAfterSeconds;
            if (redraw || timeUp) {
                Result<FrameFacts> facts = draw();
                if (!facts)
                    return facts.error();
                saySkippedTiles();
                streaming = !facts->complete;
                redraw = false;
            }
            if (input.quit || timeUp || stopSignal() != 0)
                break;
        }
        if (options_.screenshot)
            return writeScreenshot(*options_.screenshot);
        return {};
    }

    Failure writeScreenshot(const std::string& path) {
        Picture picture = renderer_->picture();
        const auto overlay = Overlay::create();
        if (overlay) {
            OverlayFacts facts = overlayFactsOf(*scene_);
            shot_.camera = orbit_->camera();
            setMoment(facts, *scene_, shot_, renderer_->groundHeightMetres());
            for (const std::string& name : (*overlay)->draw(picture, facts))
                sayWarning("overlay", "the picture has no room for " + name);
        } else {
            sayWarning("overlay", overlay.error().message() + ": nothing is written over pictures");
        }
        return writeImage(picture, ImageFormat::Png, path);
    }

    // True when the view changed.
    bool follow(const Window::Input& input) {
        if (input.turnX != 0.0 || input.turnY != 0.0)
            orbit_->turn(kDegreesPerPixel * input.turnX, -kDegreesPerPixel * input.turnY);
        if (input.panX != 0.0 || input.panY != 0.0)
            orbit_->pan(input.panX, -input.panY);
        if (input.wheel != 0.0)
            orbit_->zoom(std::pow(kZoomPerClick, input.wheel));
        orbit_->resize(window_->width(), window_->height());
        return input.turnX != 0.0 || input.turnY != 0.0 || input.panX != 0.0 || input.panY != 0.0 ||
               input.wheel != 0.0 || input.resized;
    }

    Result<FrameFacts> draw() {
        FrameRequest request;
        request.camera = orbit_->camera();
        request.sun = shot_.sun;
        request.time = shot_.time;
        request.waitForTiles = false;
        Result<FrameFacts> facts = renderer_->draw(request);
        if (facts) {
            renderer_->present(window_->width(), window_->height());
            window_->swap();
        }
        return facts;
    }

    void saySkippedTiles() {
        said_.resize(scene_->layers.size(), 0);
        for (std::size_t i = 0; i < scene_->layers.size(); ++i) {
            const auto& failures = scene_->layers[i].tileset->failures();
            for (; said_[i] < failures.size(); ++said_[i]) {
                sayError(failures[said_[i]].error);
                exitCode_ = exit_code::kSkipped;
            }
        }
    }

    const ViewOptions& options_;
    std::optional<Scene> scene_;
    std::unique_ptr<Window> window_; // before the context it brought
    std::unique_ptr<render::Context> context_;
    std::unique_ptr<FrameRenderer> renderer_;
    Shot shot_;
    std::optional<Orbit> orbit_;
    std::vector<std::size_t> said_; // failures told so far, a count per layer
    int exitCode_ = exit_code::kDone;
};

} // namespace

int runView(const ViewOptions& options) {
    catchStopSignals();
    return Viewer(options).run();
}

} // namespace gnomon
