#include "shadows/sun_pass.h"

#include "render/readback.h"
#include "shaders/interface.h"
#include "shadows/bias.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

glm::vec4 filterBlock(const ShadowSettings& s) {
    switch (s.filter) {
    case ShadowFilter::None:
    case ShadowFilter::Jitter:
        return {};
    case ShadowFilter::Bilinear:
        return {1, 0, 0, 0};
    case ShadowFilter::Pcf:
        return {float(s.pcfWidth), 0, 0, 0};
    case ShadowFilter::Pcss:
    case ShadowFilter::PcssRatio:
        return {0, 0, float(s.blockerSamples), float(s.filterSamples)};
    }
    return {};
}

glm::vec4 withW(const glm::dvec3& v, double w) {
    return glm::vec4(glm::dvec4(v, w));
}

// A quad of a map that is a plane is believed to continue to the receiver; of terrain only where it
// stands as far over it as a neighbouring face would after so many texels.
constexpr float kRoughTexels = 5.0f;

// The depth map holds floats of [0, 1]: rounding of the vertex transform and the interpolation, a
// few units in the last place near 1; and lattice rounding of a vertex seen through a 45° slope.
double mapRounding(const Cascade& cascade, glm::ivec2 mapSize) {
    constexpr double kUlp = 1.0 / (1 << 24);
    return 8.0 * kUlp * cascade.depthRangeMetres +
           4.0 * kUlp * std::max(mapSize.x, mapSize.y) * cascade.texelMetres;
}

void setCascade(shader::SunBlock& block, std::size_t i, const Cascade& cascade,
                const glm::dvec3& cameraInLight, glm::ivec2 mapSize, double biasMetres) {
    const glm::dvec3 offset = windowFromLight(cascade, cameraInLight);
    block.cascadeOffset[i] = withW(offset, cascade.texelMetres);
    block.cascadeSplit[i] =
        glm::vec4(float(cascade.nearMetres), float(cascade.farMetres),
                  float(cascade.blendStartMetres), float(cascade.depthRangeMetres));
    const auto modulo = [](std::int64_t a, int n) { return float(((a % n) + n) % n); };
    block.cascadeOrigin[i] =
        glm::vec4(modulo(cascade.cornerX, mapSize.x), modulo(cascade.cornerY, mapSize.y),
                  float(mapRounding(cascade, mapSize)), float(biasMetres));
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
    block.fade =
        glm::vec4(float(set.rangeMetres), float(set.fadeMetres), float(set.cascades.size()), 0.0f);
    block.mapTexels = glm::vec4(glm::vec2(set.mapSize), input.rough ? kRoughTexels : 0.0f, 0.0f);
    const glm::dmat3 rows = glm::transpose(set.lightFromEcef.axes() * input.meshAxes);
    block.axisX = withW(rows[0], 0.0);
    block.axisY = withW(rows[1], 0.0);
    block.axisZ = withW(rows[2], 0.0);
    const glm::dvec3 camera = set.lightFromEcef(input.surfaceCamera.position).xyz;
    // Not the maps' own range, whose steps a moving camera crosses.
    block.eye.w = float(input.casters.lightMaxMetres - camera.z);
    for (std::size_t i = 0; i < set.cascades.size(); ++i)
        setCascade(block, i, set.cascades[i], camera, set.mapSize,
                   constantBiasMetres(settings, set.cascades[i].texelMetres));

    block.reach = glm::vec4(casterReach(input.casters, set.lightFromEcef, input.meshAxes,
                                        input.surfaceCamera.position));
    return block;
}

const char* filterDefines(ShadowFilter filter) {
    switch (filter) {
    case ShadowFilter::None:
        return "FILTER_NONE";
    case ShadowFilter::Bilinear:
    case ShadowFilter::Pcf:
        return "FILTER_BOX";
    case ShadowFilter::Jitter:
        return "FILTER_JITTER";
    case ShadowFilter::Pcss:
        return "FILTER_PCSS";
    case ShadowFilter::PcssRatio:
        return "FILTER_PCSS PENUMBRA_RATIO";
    }
    return "";
}

const char* biasDefines(ShadowBias bias) {
    switch (bias) {
    case ShadowBias::ReceiverPlane:
    case ShadowBias::FrontFace:
        return "";
    case ShadowBias::Slope:
        return " BIAS_SLOPE";
    case ShadowBias::Normal:
        return " BIAS_NORMAL";
    case ShadowBias::Constant: // of the layers it is 0: their maps are moved instead
    case ShadowBias::Midpoint:
    case ShadowBias::DualPeel:
    case ShadowBias::DualAtomic:
        return " BIAS_CONSTANT";
    }
    return "";
}

// Penumbrae may be so much wider than the three texels of sun.frag's dense disc that narrow ones
// among them need to be told apart; where they are not that is a fifth of the pass saved. By what
// stands in the scene, not by the maps' depth range, whose steps a moving camera crosses.
bool hasWidePenumbrae(const SunPassInput& input, const ShadowSettings& settings) {
    constexpr double kWideTexels = 16.0;
    const double tanSun = std::tan(0.5 * settings.lightDiameterDegrees * kRadiansPerDegree);
    const double widestMetres = tanSun * std::max(input.casters.topMetres, 0.0) /
                                std::max(input.casters.sinElevation, 1e-4);
    const std::vector<Cascade>& cascades = input.cascades->cascades;
    return std::any_of(cascades.begin(), cascades.end(), [&](const Cascade& cascade) {
        return widestMetres > kWideTexels * cascade.texelMetres;
    });
}

} // namespace

void SunPass::use(const ShadowSettings& settings, const SunPassInput& input) {
    std::string defines;
    if (input.cascades != nullptr)
        defines = std::string(filterDefines(settings.filter)) + biasDefines(settings.bias);
    if (settings.filter == ShadowFilter::Pcss && input.cascades != nullptr &&
        hasWidePenumbrae(input, settings))
        defines += " WIDE_PENUMBRAE";
    if (input.projective != nullptr) {
        defines += " PROJECTIVE";
        input.projective->bind();
    }
    render::Program& program = programs_[defines];
    if (program.id() == 0)
        program = render::Program("fullscreen.vert", "sun.frag", defines);
    program.use();
}

SunPass::SunPass() : block_(render::makeDynamicBuffer(sizeof(shader::SunBlock))) {
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    empty_ = render::VertexArray(id);
}

void SunPicture::resize(int width, int height) {
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

void SunPass::draw(const SunReceivers& seen, const SunPassInput& input,
                   const ShadowSettings& settings, SunPicture& into) {
    into.resize(seen.width, seen.height);
    render::update(block_, sunBlock(input, settings));
    render::bindUniformBlock(BLOCK_VIEW, seen.viewBlock);
    render::bindUniformBlock(BLOCK_SUN, block_);
    render::bindTexture(TEX_DEPTH, seen.depth);
    render::bindTexture(TEX_NORMALS, seen.normals);
    if (input.maps != nullptr)
        render::bindTexture(TEX_CASCADES, input.maps->maps());
    glBindFramebuffer(GL_FRAMEBUFFER, into.target_.id());
    glViewport(0, 0, seen.width, seen.height);
    glScissor(seen.bounds.x, seen.bounds.y, seen.bounds.width, seen.bounds.height);
    glEnable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    use(settings, input);
    glBindVertexArray(empty_.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_SCISSOR_TEST);
}

std::vector<float> SunPicture::readVisibility() const {
    return render::readTopDown<float>(visibility_, width_, height_, 1, GL_RED, GL_FLOAT);
}

std::vector<std::uint8_t> SunPicture::readCascades() const {
    return render::readTopDown<std::uint8_t>(cascade_, width_, height_, 1, GL_RED,
                                             GL_UNSIGNED_BYTE);
}

} // namespace gnomon
