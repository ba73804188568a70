#include "shadows/sun_pass.h"

#include "render/readback.h"
#include "shaders/interface.h"

#include <epoxy/gl.h>

#include <cmath>

namespace gnomon {

namespace {

glm::vec4 filterBlock(const ShadowSettings& s) {
    switch (s.filter) {
    case ShadowFilter::None:
        return {};
    case ShadowFilter::Bilinear:
        return {1, 0, 0, 0};
    case ShadowFilter::Pcf:
        return {float(s.pcfWidth), 0, 0, 0};
    case ShadowFilter::Pcss:
        return {0, 0, float(s.blockerSamples), float(s.filterSamples)};
    }
    return {};
}

glm::vec4 withW(const glm::dvec3& v, double w) {
    return glm::vec4(glm::dvec4(v, w));
}

// The depth map holds floats of [0, 1]: rounding of the vertex transform and the interpolation, a
// few units in the last place near 1; and lattice rounding of a vertex seen through a 45° slope.
double mapRounding(const Cascade& cascade, int mapSize) {
    constexpr double kUlp = 1.0 / (1 << 24);
    return 8.0 * kUlp * cascade.depthRangeMetres + 4.0 * kUlp * mapSize * cascade.texelMetres;
}

void setCascade(shader::SunBlock& block, std::size_t i, const Cascade& cascade,
                const glm::dvec3& cameraInLight, int mapSize) {
    const glm::dvec3 offset = windowFromLight(cascade, cameraInLight);
    block.cascadeOffset[i] = withW(offset, cascade.texelMetres);
    block.cascadeSplit[i] =
        glm::vec4(float(cascade.nearMetres), float(cascade.farMetres),
                  float(cascade.blendStartMetres), float(cascade.depthRangeMetres));
    const auto modulo = [&](std::int64_t a) { return float(((a % mapSize) + mapSize) % mapSize); };
    block.cascadeOrigin[i] = glm::vec4(modulo(cascade.cornerX), modulo(cascade.cornerY),
                                       float(mapRounding(cascade, mapSize)), 0.0f);
}

shader::SunBlock sunBlock(const SunPassInput& input, const ShadowSettings& settings) {
    shader::SunBlock block{};
    const double tanSun = std::tan(0.5 * settings.lightDiameterDegrees * kRadiansPerDegree);
    const Camera& fitted = input.cascadeCamera;
    const Vector<Ecef> shift = input.surfaceCamera.position - fitted.position;
    const glm::dmat3 stored = glm::transpose(input.meshAxes);
    block.toSun = withW(stored * input.towardsSun.xyz, tanSun);
    block.selection = withW(stored * fitted.forward.xyz, dot(fitted.forward, shift));
    block.eye = withW(stored * -shift.xyz, 0.0);
    block.filter_ = filterBlock(settings);
    if (input.cascades == nullptr)
        return block;
    const CascadeSet& set = *input.cascades;
    block.fade = glm::vec4(float(set.rangeMetres), float(set.fadeMetres),
                           float(set.cascades.size()), float(set.mapSize));
    const glm::dmat3 rows = glm::transpose(set.lightFromEcef.axes() * input.meshAxes);
    block.axisX = withW(rows[0], 0.0);
    block.axisY = withW(rows[1], 0.0);
    block.axisZ = withW(rows[2], 0.0);
    const glm::dvec3 camera = set.lightFromEcef(input.surfaceCamera.position).xyz;
    for (std::size_t i = 0; i < set.cascades.size(); ++i)
        setCascade(block, i, set.cascades[i], camera, set.mapSize);

    // How far along a ray to the sun the highest caster can be: (top - height) / sin(elevation).
    const Transform<Enu, Light> anchorFromLight = rigidInverse(input.casters.lightFromAnchor);
    const double cameraHeight = anchorFromLight(Point<Light>{camera}).xyz.z;
    const glm::dvec3 up =
        rigidInverse(set.lightFromEcef)(input.casters.lightFromAnchor(Vector<Enu>{{0, 0, 1}})).xyz;
    const double perMetre = 1.0 / std::max(input.casters.sinElevation, 1e-4);
    block.reach =
        withW(stored * -up * perMetre, (input.casters.topMetres - cameraHeight) * perMetre);
    return block;
}

} // namespace

void SunPass::use(const ShadowSettings& settings, bool cascades) {
    const ShadowFilter filter = settings.filter;
    render::Program& program = !cascades                      ? unshadowed_
                               : filter == ShadowFilter::None ? none_
                               : filter == ShadowFilter::Pcss ? pcss_
                                                              : box_;
    if (program.id() == 0)
        program = render::Program("fullscreen.vert", "sun.frag",
                                  !cascades                      ? ""
                                  : filter == ShadowFilter::None ? "FILTER_NONE"
                                  : filter == ShadowFilter::Pcss ? "FILTER_PCSS"
                                                                 : "FILTER_BOX");
    program.use();
}

SunPass::SunPass() : block_(render::makeDynamicBuffer(sizeof(shader::SunBlock))) {
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    empty_ = render::VertexArray(id);
}

void SunPass::resize(int width, int height) {
    if (width == width_ && height == height_)
        return;
    width_ = width;
    height_ = height;
    visibility_ = render::makeTarget(GL_R16, width, height);
    cascade_ = render::makeTarget(GL_R8, width, height);
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    target_ = render::Framebuffer(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, visibility_.id(), 0);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT1, cascade_.id(), 0);
    const unsigned buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(id, 2, buffers);
}

void SunPass::draw(const render::VisibilityPass& seen, const SunPassInput& input,
                   const ShadowSettings& settings) {
    resize(seen.width(), seen.height());
    render::update(block_, sunBlock(input, settings));
    render::bindUniformBlock(BLOCK_VIEW, seen.viewBlock());
    render::bindUniformBlock(BLOCK_SUN, block_);
    render::bindTexture(TEX_DEPTH, seen.depth());
    render::bindTexture(TEX_NORMALS, seen.normals());
    if (input.maps != nullptr)
        render::bindTexture(TEX_CASCADES, input.maps->maps());
    glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
    glViewport(0, 0, width_, height_);
    glDisable(GL_DEPTH_TEST);
    use(settings, input.cascades != nullptr);
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

std::vector<float> SunPass::readVisibility() const {
    return render::readTopDown<float>(visibility_, width_, height_, 1, GL_RED, GL_FLOAT);
}

std::vector<std::uint8_t> SunPass::readCascades() const {
    return render::readTopDown<std::uint8_t>(cascade_, width_, height_, 1, GL_RED,
                                             GL_UNSIGNED_BYTE);
}

} // namespace gnomon
