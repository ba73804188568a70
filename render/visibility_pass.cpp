#include "render/visibility_pass.h"

#include "geo/view.h"
#include "render/readback.h"
#include "shaders/interface.h"

#include <epoxy/gl.h>

#include <limits>

namespace gnomon::render {

namespace {

shader::ViewBlock blockFor(const Camera& camera, const glm::dmat3& axes) {
    const glm::dmat4 eyeFromRelative(eyeFromEcefRotation(camera) * axes);
    const double w = camera.tanHalfWidth(), h = camera.tanHalfHeight();
    shader::ViewBlock block;
    block.clipFromRelative =
        glm::mat4(reversedInfiniteProjection(camera, kNearPlaneMetres) * eyeFromRelative);
    const glm::dmat3 stored = glm::transpose(axes);
    block.rayRight = glm::vec4(glm::vec3(stored * camera.right.xyz * w), 0.0f);
    block.rayUp = glm::vec4(glm::vec3(stored * camera.up.xyz * h), 0.0f);
    block.rayForward = glm::vec4(glm::vec3(stored * camera.forward.xyz), float(kNearPlaneMetres));
    return block;
}

void setMaterial(const GpuTile& tile, const GpuMaterial& material) {
    const Material& look = material.look;
    glUniform4f(1, look.baseColor.r, look.baseColor.g, look.baseColor.b, look.baseColor.a);
    glUniform4f(2, material.texture >= 0 ? 1.0f : 0.0f, look.unlit ? 1.0f : 0.0f,
                look.alphaTest ? look.alphaCutoff : 0.0f, 0.0f);
    tile.bindTextures(material);
}

} // namespace

VisibilityPass::VisibilityPass()
    : program_("visibility.vert", "visibility.frag"),
      viewBlock_(makeDynamicBuffer(sizeof(shader::ViewBlock))) {}

void VisibilityPass::resize(int width, int height) {
    if (width == width_ && height == height_)
        return;
    width_ = width;
    height_ = height;
    depth_ = makeTarget(GL_DEPTH_COMPONENT32F, width, height);
    albedo_ = makeTarget(GL_SRGB8_ALPHA8, width, height);
    normals_ = makeTarget(GL_RGBA16, width, height);
    tiles_ = makeTarget(GL_R32UI, width, height);
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    target_ = Framebuffer(id);
    glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, albedo_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT1, normals_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT2, tiles_.id(), 0);
    const unsigned buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    glNamedFramebufferDrawBuffers(id, 3, buffers);
}

std::uint64_t VisibilityPass::draw(const Camera& camera, std::span<const DrawItem> items,
                                   const glm::dmat3& axes) {
    const glm::dmat3 storedFromEcef = glm::transpose(axes);
    resize(camera.widthPixels, camera.heightPixels);
    update(viewBlock_, blockFor(camera, axes));
    bindUniformBlock(BLOCK_VIEW, viewBlock_);

    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    const float sky = 0.0f;
    const float none[4] = {0, 0, 0, 0};
    const unsigned noTile[4] = {0, 0, 0, 0};
    glClearNamedFramebufferfv(target_.id(), GL_DEPTH, 0, &sky);
    glClearNamedFramebufferfv(target_.id(), GL_COLOR, 0, none);
    glClearNamedFramebufferfv(target_.id(), GL_COLOR, 1, none);
    glClearNamedFramebufferuiv(target_.id(), GL_COLOR, 2, noTile);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDisable(GL_CULL_FACE);
    program_.use();

    const View view = perspectiveView(camera);
    std::uint64_t triangles = 0;
    draws_ = 0;
    const GpuTile* boundTile = nullptr;
    const GpuMaterial* boundMaterial = nullptr;
    for (const DrawItem& item : items) {
        if (classify(BoundingVolume(item.mesh->box), view.planes) == Containment::Outside)
            continue;
        if (item.tile != boundTile) {
            boundTile = item.tile;
            boundMaterial = nullptr;
            glBindVertexArray(item.tile->vertices().id());
            bindTexture(TEX_FACE_NORMALS, item.tile->faceNormals());
        }
        const GpuMaterial& material = item.tile->material(*item.mesh);
        if (&material != boundMaterial) {
            boundMaterial = &material;
            setMaterial(*item.tile, material);
        }
        const glm::vec3 offset(storedFromEcef * (item.mesh->origin - camera.position).xyz);
        glUniform3f(0, offset.x, offset.y, offset.z);
        glUniform1ui(3, item.mesh->firstIndex / 3);
        glUniform1ui(4, item.tileId);
        const std::uint32_t count =
            item.mesh->closedIndices + item.mesh->openIndices + item.mesh->skirtIndices;
        glDrawElementsBaseVertex(
            GL_TRIANGLES, int(count), GL_UNSIGNED_INT,
            reinterpret_cast<const void*>(std::uintptr_t(item.mesh->firstIndex) * 4),
            item.mesh->baseVertex);
        triangles += count / 3;
        ++draws_;
    }
    return triangles;
}

std::vector<float> VisibilityPass::readViewDepth() const {
    std::vector<float> depth =
        readTopDown<float>(depth_, width_, height_, 1, GL_DEPTH_COMPONENT, GL_FLOAT);
    for (float& d : depth)
        d = d <= 0.0f ? std::numeric_limits<float>::infinity() : float(kNearPlaneMetres) / d;
    return depth;
}

std::vector<std::uint16_t> VisibilityPass::readNormals() const {
    return readTopDown<std::uint16_t>(normals_, width_, height_, 4, GL_RGBA, GL_UNSIGNED_SHORT);
}

std::vector<std::uint32_t> VisibilityPass::readTiles() const {
    return readTopDown<std::uint32_t>(tiles_, width_, height_, 1, GL_RED_INTEGER, GL_UNSIGNED_INT);
}

} // namespace gnomon::render
