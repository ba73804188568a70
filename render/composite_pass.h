// Light, haze, sky and tone mapping: from surfaces and their share of sun to the picture.
#pragma once

#include "render/handles.h"
#include "render/program.h"
#include "render/visibility_pass.h"
#include "render/water_pass.h"
#include "shaders/interface.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace gnomon::render {

struct CompositeInput {
    const VisibilityPass& seen;
    const Texture& sunVisibility; // of `seen`
    shader::LookBlock look;
    const Texture* lampLight = nullptr; // RGBA16F, added to the day's; null: none is lit
    // Over that; null: none is seen.
    const WaterPass* water = nullptr;
    const Texture* waterSunVisibility = nullptr;
    shader::WaterBlock waterLook{};
};

class CompositePass {
  public:
    CompositePass();
    void draw(const CompositeInput& input);
    // RGB8, sRGB, rows top to bottom.
    std::vector<std::uint8_t> read() const;
    // Into the framebuffer that is bound for the window, scaled to it.
    void present(int windowWidth, int windowHeight) const;

  private:
    void resize(int width, int height);
    void bindWater(const CompositeInput& input);

    std::map<std::string, Program> programs_; // by their defines; compiled when first used
    Buffer lookBlock_, waterBlock_;
    Texture color_;
    Framebuffer target_;
    VertexArray empty_;
    int width_ = 0, height_ = 0;
};

} // namespace gnomon::render
