#include "render/composite_pass.h"

#include "render/readback.h"

#include <epoxy/gl.h>

namespace gnomon::render {

CompositePass::CompositePass()
    : lookBlock_(makeDynamicBuffer(sizeof(shader::LookBlock))),
      waterBlock_(makeDynamicBuffer(sizeof(shader::WaterBlock))) {
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    empty_ = VertexArray(id);
}

void CompositePass::resize(int width, int height) {
    if (width_ == width && height_ == height)
        return;
    width_ = width;
    height_ = height;
    color_ = makeTarget(GL_SRGB8_ALPHA8, width_, height_);
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    target_ = Framebuffer(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color_.id(), 0);
}

void CompositePass::bindWater(const CompositeInput& input) {
    update(waterBlock_, input.waterLook);
    bindUniformBlock(BLOCK_WATER, waterBlock_);
    bindTexture(TEX_WATER_DEPTH, input.water->depth());
    bindTexture(TEX_WATER_NORMALS, input.water->normals());
    bindTexture(TEX_WATER_COLOR, input.water->color());
    bindTexture(TEX_WATER_VALUE, input.water->value());
    bindTexture(TEX_WATER_SUN, *input.waterSunVisibility);
}

void CompositePass::draw(const CompositeInput& input) {
    resize(input.seen.width(), input.seen.height());
    update(lookBlock_, input.look);
    bindUniformBlock(BLOCK_VIEW, input.seen.viewBlock());
    bindUniformBlock(BLOCK_LOOK, lookBlock_);
    bindTexture(TEX_DEPTH, input.seen.depth());
    bindTexture(TEX_NORMALS, input.seen.normals());
    bindTexture(TEX_ALBEDO, input.seen.albedo());
    bindTexture(TEX_SUN, input.sunVisibility);
    std::string defines;
    if (input.lampLight != nullptr) {
        defines += " LAMPS";
        bindTexture(TEX_LAMP_LIGHT, *input.lampLight);
    }
    if (input.water != nullptr) {
        defines += " WATER";
        bindWater(input);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    glDisable(GL_DEPTH_TEST);
    Program& program = programs_[defines];
    if (program.id() == 0)
        program = Program("fullscreen.vert", "composite.frag", defines);
    program.use();
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

std::vector<std::uint8_t> CompositePass::read() const {
    return readTopDown<std::uint8_t>(color_, width_, height_, 3, GL_RGB, GL_UNSIGNED_BYTE);
}

void CompositePass::present(int windowWidth, int windowHeight) const {
    glDisable(GL_FRAMEBUFFER_SRGB); // the bytes are sRGB already
    glBlitNamedFramebuffer(target_.id(), 0, 0, 0, width_, height_, 0, 0, windowWidth, windowHeight,
                           GL_COLOR_BUFFER_BIT, GL_LINEAR);
    glEnable(GL_FRAMEBUFFER_SRGB);
}

} // namespace gnomon::render
