// Light, haze, sky and tone mapping: from surfaces and their share of sun to the picture.
#pragma once

#include "render/handles.h"
#include "render/program.h"
#include "render/visibility_pass.h"
#include "shaders/interface.h"

#include <cstdint>
#include <vector>

namespace gnomon::render {

class CompositePass {
  public:
    CompositePass();
    // `lampLight` (RGBA16F; null: none is lit) is added to the day's.
    void draw(const VisibilityPass& seen, const Texture& sunVisibility,
              const shader::LookBlock& look, const Texture* lampLight = nullptr);
    // RGB8, sRGB, rows top to bottom.
    std::vector<std::uint8_t> read() const;
    // Into the framebuffer that is bound for the window, scaled to it.
    void present(int windowWidth, int windowHeight) const;

  private:
    Program program_, lampProgram_; // the second is compiled when first used
    Buffer lookBlock_;
    Texture color_;
    Framebuffer target_;
    VertexArray empty_;
    int width_ = 0, height_ = 0;
};

} // namespace gnomon::render
