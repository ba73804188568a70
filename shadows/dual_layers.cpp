#include "shadows/dual_layers.h"

#include "shaders/interface.h"

#include <epoxy/gl.h>

namespace gnomon {

namespace {

constexpr int kOffsetLocation = 6; // shaders/dual_depth.glsl

CasterPrograms casterPrograms(const char* define) {
    return {{"depth.vert", "depth.frag", define}, {"depth.vert", "depth_alpha.frag", define}};
}

void clearToZero(const render::Texture& texture) {
    const GLuint zero = 0;
    glClearTexImage(texture.id(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
}

} // namespace

void DualLayers::prepare(ShadowBias bias, glm::ivec2 mapSize) {
    if (bias == bias_ && mapSize == mapSize_)
        return;
    *this = DualLayers();
    bias_ = bias;
    mapSize_ = mapSize;
    if (hasTwoLayers(bias))
        peels() ? preparePeeling() : prepareAtomics();
}

void DualLayers::preparePeeling() {
    first_ = render::makeTarget(GL_DEPTH_COMPONENT32F, mapSize_.x, mapSize_.y);
    firstPrograms_ = casterPrograms("FIRST_LAYER");
    secondPrograms_ = casterPrograms("SECOND_LAYER");
}

void DualLayers::prepareAtomics() {
    first_ = render::makeTarget(GL_R32UI, mapSize_.x, mapSize_.y);
    second_ = render::makeTarget(GL_R32UI, mapSize_.x, mapSize_.y);
    firstPrograms_ = casterPrograms("BOTH_LAYERS");
    resolve_ = render::Program("fullscreen.vert", "dual_layers.frag");
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    empty_ = render::VertexArray(id);
}

const CasterPrograms& DualLayers::startFirst() const {
    return firstPrograms_;
}

const CasterPrograms& DualLayers::startSecond() const {
    // The depth map is tested and read, and no longer written: that is allowed after the barrier.
    glTextureBarrier();
    render::bindTexture(TEX_CASCADES, first_);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_LESS);
    glEnable(GL_BLEND);
    glBlendEquation(GL_MAX);
    return secondPrograms_;
}

const CasterPrograms& DualLayers::startBoth() const {
    clearToZero(first_);
    clearToZero(second_);
    glBindImageTexture(IMAGE_FIRST_LAYER, first_.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    glBindImageTexture(IMAGE_SECOND_LAYER, second_.id(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32UI);
    glDisable(GL_DEPTH_TEST);
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    return firstPrograms_;
}

void DualLayers::resolve(float offset) const {
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    resolve_.use();
    setOffset(offset);
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void DualLayers::finish() const {
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
    glDepthFunc(GL_GREATER);
    glEnable(GL_DEPTH_TEST);
}

void DualLayers::setOffset(float offset) const {
    glUniform1f(kOffsetLocation, offset);
}

std::size_t DualLayers::bytes() const {
    const std::size_t each = std::size_t(mapSize_.x) * std::size_t(mapSize_.y) * sizeof(float);
    return (first_ ? each : 0) + (second_ ? each : 0);
}

} // namespace gnomon
