#include "render/composite_pass.h"

#include "render/readback.h"

#include <epoxy/gl.h>

namespace gnomon::render {

CompositePass::CompositePass()
    : program_("fullscreen.vert", "composite.frag"),
      lookBlock_(makeDynamicBuffer(sizeof(shader::LookBlock))) {
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    empty_ = VertexArray(id);
}

void CompositePass::draw(const VisibilityPass& seen, const Texture& sunVisibility,
                         const shader::LookBlock& look, const Texture* lampLight) {
    if (width_ != seen.width() || height_ != seen.height()) {
        width_ = seen.width();
        height_ = seen.height();
        color_ = makeTarget(GL_SRGB8_ALPHA8, width_, height_);
        unsigned id = 0;
        glCreateFramebuffers(1, &id);
        target_ = Framebuffer(id);
        glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color_.id(), 0);
    }
    update(lookBlock_, look);
    bindUniformBlock(BLOCK_VIEW, seen.viewBlock());
    bindUniformBlock(BLOCK_LOOK, lookBlock_);
    bindTexture(TEX_DEPTH, seen.depth());
    bindTexture(TEX_NORMALS, seen.normals());
    bindTexture(TEX_ALBEDO, seen.albedo());
    bindTexture(TEX_SUN, sunVisibility);
    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    glDisable(GL_DEPTH_TEST);
    if (lampLight != nullptr) {
        if (lampProgram_.id() == 0)
            lampProgram_ = Program("fullscreen.vert", "composite.frag", "LAMPS");
        bindTexture(TEX_LAMP_LIGHT, *lampLight);
    }
    (lampLight != nullptr ? lampProgram_ : program_).use();
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
