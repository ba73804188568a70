// A window with a GL 4.5 context, and what the hand did in it. The only place that knows GLFW.
#pragma once

#include "geo/result.h"

#include <memory>
#include <string>

namespace gnomon {

class Window {
  public:
    static Result<std::unique_ptr<Window>> open(const std::string& title, int width, int height);
    ~Window();

    // Since the last poll(): pixels dragged with each button, wheel clicks.
    struct Input {
        double panX = 0, panY = 0;   // left button
        double turnX = 0, turnY = 0; // right button, or left with ctrl
        double wheel = 0;
        bool resized = false, quit = false;
    };
    // Waits for input, but not longer than this.
    Input poll(double secondsAtMost);
    int width() const; // of the framebuffer, pixels
    int height() const;
    void swap();

  private:
    struct State;
    explicit Window(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
