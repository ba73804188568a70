#include "render/water_pass.h"

#include "render/readback.h"
#include "shaders/interface.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon::render {

namespace {

constexpr int kColorTexels = 256; // between two of them sRGB bytes differ by one or two

Texture makeColors(ColorMap map) {
    std::vector<std::uint8_t> texels;
    for (int i = 0; i < kColorTexels; ++i) {
        const glm::vec3 color = colorAt(map, double(i) / (kColorTexels - 1));
        for (int c = 0; c < 3; ++c)
            texels.push_back(std::uint8_t(std::lround(255.0f * color[c])));
        texels.push_back(255);
    }
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_1D, 1, &id);
    glTextureStorage1D(id, 1, GL_SRGB8_ALPHA8, kColorTexels);
    glTextureSubImage1D(id, 0, 0, kColorTexels, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
    glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    return Texture(id);
}

// The pixels that a box may cover, as a span of x and of y; all of them when it reaches behind the
// near plane.
struct Span2 {
    glm::dvec2 low{std::numeric_limits<double>::infinity()};
    glm::dvec2 high{-std::numeric_limits<double>::infinity()};
};

void addBox(Span2& span, const OrientedBox& box, const Camera& camera) {
    for (const Point<Ecef>& corner : corners(box)) {
        const Vector<Ecef> v = corner - camera.position;
        const double depth = dot(v, camera.forward);
        if (depth < kNearPlaneMetres) {
            span.low = glm::dvec2(-1.0);
            span.high = glm::dvec2(1.0);
            return;
        }
        const glm::dvec2 ndc(dot(v, camera.right) / (depth * camera.tanHalfWidth()),
                             dot(v, camera.up) / (depth * camera.tanHalfHeight()));
        span.low = glm::max(glm::min(span.low, ndc), glm::dvec2(-1.0));
        span.high = glm::min(glm::max(span.high, ndc), glm::dvec2(1.0));
    }
}

PixelRect pixels(const Span2& span, int width, int height) {
    if (!(span.low.x < span.high.x && span.low.y < span.high.y))
        return {};
    // A pixel more on each side than rounding could want.
    const auto low = [](double ndc, int size) {
        return std::clamp(int(std::floor(0.5 * (ndc + 1.0) * size)) - 1, 0, size);
    };
    const auto high = [](double ndc, int size) {
        return std::clamp(int(std::ceil(0.5 * (ndc + 1.0) * size)) + 1, 0, size);
    };
    const int x = low(span.low.x, width), y = low(span.low.y, height);
    return {x, y, high(span.high.x, width) - x, high(span.high.y, height) - y};
}

PixelRect boundsOf(const WaterPassInput& input, const View& view) {
    Span2 span;
    for (const WaterItem& item : input.items)
        for (const GpuWaterMesh& mesh : item.water->meshes())
            if (classify(BoundingVolume(mesh.box), view.planes) != Containment::Outside)
                addBox(span, mesh.box, input.camera);
    return pixels(span, input.camera.widthPixels, input.camera.heightPixels);
}

} // namespace

WaterPass::WaterPass() = default;

void WaterPass::resize(int width, int height) {
    if (width == width_ && height == height_)
        return;
    width_ = width;
    height_ = height;
    depth_ = makeTarget(GL_DEPTH_COMPONENT32F, width, height);
    normals_ = makeTarget(GL_RGBA16, width, height);
    color_ = makeTarget(GL_SRGB8_ALPHA8, width, height);
    value_ = makeTarget(GL_R32F, width, height);
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    target_ = Framebuffer(id);
    glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, color_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT1, normals_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT2, value_.id(), 0);
    const unsigned buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    glNamedFramebufferDrawBuffers(id, 3, buffers);
}

void WaterPass::setGroundErrors(std::span<const float> errors) {
    if (errorTexture_ && std::equal(errors.begin(), errors.end(), errors_.begin(), errors_.end()))
        return;
    errors_.assign(errors.begin(), errors.end());
    errorBuffer_ = makeBuffer(errors_.size() * sizeof(float), errors_.data());
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
    glTextureBuffer(id, GL_R32F, errorBuffer_.id());
    errorTexture_ = Texture(id);
}

const Texture& WaterPass::colors(ColorMap map) {
    Texture& texture = colors_[map];
    if (!texture)
        texture = makeColors(map);
    return texture;
}

std::uint64_t WaterPass::draw(const VisibilityPass& seen, const WaterPassInput& input) {
    const View view = perspectiveView(input.camera);
    bounds_ = boundsOf(input, view);
    if (!any())
        return 0;
    resize(seen.width(), seen.height());
    if (program_.id() == 0)
        program_ = Program("water.vert", "water.frag");
    viewBlock_ = &seen.viewBlock();
    setGroundErrors(input.groundErrors);
    bindUniformBlock(BLOCK_VIEW, *viewBlock_);
    bindTexture(TEX_DEPTH, seen.depth());
    bindTexture(TEX_TILES, seen.tiles());
    bindTexture(TEX_GROUND_ERROR, errorTexture_);

    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    const float none = 0.0f; // the other targets are read only where there is depth
    glClearNamedFramebufferfv(target_.id(), GL_DEPTH, 0, &none);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDisable(GL_CULL_FACE);
    program_.use();
    const glm::vec3 up(glm::transpose(input.meshAxes) * ellipsoidNormal(input.camera.position).xyz);
    glUniform3f(3, up.x, up.y, up.z);
    glUniform1i(4, int(errors_.size()));
    std::uint64_t triangles = 0;
    for (const WaterItem& item : input.items)
        triangles += drawItem(item, input, view);
    return triangles;
}

std::uint64_t WaterPass::drawItem(const WaterItem& item, const WaterPassInput& input,
                                  const View& view) {
    const glm::dmat3 storedFromEcef = glm::transpose(input.meshAxes);
    glBindVertexArray(item.water->vertices().id());
    bindTexture(TEX_FACE_NORMALS, item.water->faceNormals());
    bindTexture(TEX_COLOR_MAP, colors(item.map));
    glUniform4f(1, item.most > 0.0 ? float(1.0 / item.most) : 1.0f, item.bySpeed ? 1.0f : 0.0f,
                item.natural ? 1.0f : 0.0f, 0.0f);
    std::uint64_t triangles = 0;
    for (const GpuWaterMesh& mesh : item.water->meshes()) {
        if (classify(BoundingVolume(mesh.box), view.planes) == Containment::Outside)
            continue;
        const glm::vec3 offset(storedFromEcef * (mesh.origin - input.camera.position).xyz);
        glUniform3f(0, offset.x, offset.y, offset.z);
        glUniform1ui(2, mesh.firstIndex / 3);
        glDrawElementsBaseVertex(GL_TRIANGLES, int(mesh.indices), GL_UNSIGNED_INT,
                                 reinterpret_cast<const void*>(std::uintptr_t(mesh.firstIndex) * 4),
                                 mesh.baseVertex);
        triangles += mesh.indices / 3;
    }
    return triangles;
}

std::vector<float> WaterPass::readViewDepth() const {
    std::vector<float> depth =
        readTopDown<float>(depth_, width_, height_, 1, GL_DEPTH_COMPONENT, GL_FLOAT);
    for (float& d : depth)
        d = d <= 0.0f ? std::numeric_limits<float>::infinity() : float(kNearPlaneMetres) / d;
    return depth;
}

std::vector<std::uint16_t> WaterPass::readNormals() const {
    return readTopDown<std::uint16_t>(normals_, width_, height_, 4, GL_RGBA, GL_UNSIGNED_SHORT);
}

} // namespace gnomon::render
