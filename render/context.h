// A GL 4.5 core context: without a window (EGL, Mesa's surfaceless platform or a device), or one
// that a window brought. Refuses to start, by name, without what gnomon stands on.
#pragma once

#include "geo/result.h"

#include <memory>
#include <optional>
#include <string>

namespace gnomon::render {

struct ContextOptions {
    // An EGL device by number; -1 for Mesa's software rasteriser. Unset: the first device that is a
    // GPU, else the software rasteriser.
    std::optional<int> device;
    bool debugIsFatal = false; // tests: any GL error or undefined behaviour stops the program
};

class Context {
  public:
    static Result<std::unique_ptr<Context>> createHeadless(const ContextOptions& options = {});
    // Takes over the context that is current on this thread (a window's); does not own it.
    static Result<std::unique_ptr<Context>> adoptCurrent(const ContextOptions& options = {});
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    const std::string& rendererName() const { return renderer_; }
    // True for llvmpipe and its like: no GPU is at work.
    bool isSoftware() const;
    // Waits until all that was asked of the GPU is done.
    void finish() const;
    // True once the driver lost the context (GL_KHR_robustness); nothing drawn since is valid.
    bool lost() const;
    // True once after the driver said that it has no memory left for something it was asked to
    // hold; nothing drawn with that is valid.
    bool outOfMemory() const;

  private:
    struct Egl;
    Context(std::unique_ptr<Egl> egl);
    Failure checkAndSetUp(const ContextOptions& options);
    std::unique_ptr<Egl> egl_;
    std::string renderer_;
};

} // namespace gnomon::render
