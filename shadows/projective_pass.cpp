#include "shadows/projective_pass.h"

#include "shaders/interface.h"
#include "shadows/caster_draw.h"
#include "shadows/light_basis.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cassert>

namespace gnomon {

namespace {

static_assert(kMaxPlanes == MAX_PROJECTIVE);
// Maps grow by whole steps of texels, so that a camera that moves seldom makes new textures.
constexpr int kSizeStep = 64;

glm::vec4 withW(const glm::dvec3& v, double w) {
    return glm::vec4(glm::dvec4(v, w));
}

void setMap(shader::ProjectiveBlock& block, std::size_t i, const ProjectiveMap& map,
            const glm::dmat3& axes) {
    // Every row but depth's vanishes along the light: two numbers and a constant are left.
    const auto across = [&](const glm::dvec4& row) {
        return glm::dvec3(glm::dot(glm::dvec3(row), axes[0]), glm::dot(glm::dvec3(row), axes[1]),
                          row.w);
    };
    block.projectiveX[i] = withW(0.5 * map.width * across(map.x + map.w), map.width);
    block.projectiveY[i] = withW(0.5 * map.height * across(map.y + map.w), map.height);
    block.projectiveW[i] = withW(across(map.w), map.minW);
    block.projectiveDepth[i] = glm::vec4(map.depth);
    block.projectivePlane[i] = withW(map.plane.normal, map.plane.offsetMetres);
    block.projectiveLimits[i] =
        glm::vec4(float(map.plane.toleranceMetres), float(map.plane.tolerancePerW),
                  float(map.storedRounding / map.depthScale), float(map.depthScale));
}

// Clip coordinates of a box's corners all lie beyond one side of the map.
bool outside(const ProjectiveMap& map, const OrientedBox& box, const ProjectiveInput& input) {
    const glm::dmat3 stored = glm::transpose(input.meshAxes);
    const glm::dvec4 centre(stored * (box.centre - input.camera.position).xyz, 1.0);
    const glm::dmat3 half = stored * box.halfAxes;
    // The largest that a row gives anywhere in the box.
    const auto most = [&](const glm::dvec4& row) {
        const glm::dvec3 along = glm::dvec3(row) * half;
        return glm::dot(row, centre) + std::abs(along.x) + std::abs(along.y) + std::abs(along.z);
    };
    return most(map.w + map.x) < 0.0 || most(map.w - map.x) < 0.0 || most(map.w + map.y) < 0.0 ||
           most(map.w - map.y) < 0.0 || most(map.w) < map.minW || most(map.depth) < 0.0;
}

void setRows(const ProjectiveMap& map) {
    setUniform(0, glm::dvec3(map.x));
    setUniform(1, glm::dvec3(map.y));
    setUniform(2, glm::dvec3(map.depth) * map.depthScale);
    setUniform(3, glm::dvec3(map.w));
    glUniform1f(6, float(map.minW));
}

} // namespace

ProjectivePass::ProjectivePass()
    : opaque_("projective.vert", "depth.frag"), alphaTested_("projective.vert", "depth_alpha.frag"),
      block_(render::makeDynamicBuffer(sizeof(shader::ProjectiveBlock))) {}

std::size_t ProjectivePass::bytes() const {
    return std::size_t(width_) * std::size_t(height_) * targets_.size() * sizeof(float);
}

void ProjectivePass::resize(std::span<const ProjectiveMap> maps) {
    int width = 1, height = 1;
    for (const ProjectiveMap& map : maps) {
        width = std::max(width, map.width);
        height = std::max(height, map.height);
    }
    width = (width + kSizeStep - 1) / kSizeStep * kSizeStep;
    height = (height + kSizeStep - 1) / kSizeStep * kSizeStep;
    if (width == width_ && height == height_ && maps.size() == targets_.size())
        return;
    width_ = width;
    height_ = height;
    targets_.clear();
    maps_ = render::Texture();
    maps_ = render::makeTargetArray(GL_DEPTH_COMPONENT32F, width, height,
                                    std::max(int(maps.size()), 1));
    for (std::size_t i = 0; i < maps.size(); ++i) {
        unsigned id = 0;
        glCreateFramebuffers(1, &id);
        targets_.emplace_back(id);
        glNamedFramebufferTextureLayer(id, GL_DEPTH_ATTACHMENT, maps_.id(), 0, int(i));
        glNamedFramebufferDrawBuffer(id, GL_NONE);
    }
}

std::vector<DrawnCasters> ProjectivePass::draw(const ProjectiveInput& input,
                                               const ShadowSettings& settings,
                                               std::span<const render::DrawItem> casters,
                                               render::GpuTimer& timer) {
    assert(input.maps.size() <= std::size_t(kMaxPlanes));
    resize(input.maps);
    drawn_.assign(input.maps.begin(), input.maps.end());

    shader::ProjectiveBlock block{};
    const glm::dmat3 axes = lightAxes(input.towardsSun);
    block.projectiveAxisX = withW(axes[0], 0.0);
    block.projectiveAxisY = withW(axes[1], 0.0);
    block.projectiveSize =
        glm::vec4(float(width_), float(height_), float(input.maps.size()), float(kSamePlaneCosine));
    const glm::dvec3 shift =
        glm::transpose(input.meshAxes) * (input.surfaceCamera.position - input.camera.position).xyz;
    for (std::size_t i = 0; i < input.maps.size(); ++i)
        setMap(block, i, seenFrom(input.maps[i], shift), axes);
    render::update(block_, block);

    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glEnable(GL_DEPTH_CLAMP);    // what stands nearer to the sun than the range still casts
    glEnable(GL_CLIP_DISTANCE0); // at the least w
    std::vector<DrawnCasters> drawn;
    for (std::size_t i = 0; i < input.maps.size(); ++i) {
        const float far = 0.0f;
        glClearNamedFramebufferfv(targets_[i].id(), GL_DEPTH, 0, &far);
        glBindFramebuffer(GL_FRAMEBUFFER, targets_[i].id());
        glViewport(0, 0, input.maps[i].width, input.maps[i].height);
        drawMap(input, input.maps[i], cullOf(settings), casters,
                drawn.emplace_back(casters.size(), false));
        timer.mark();
    }
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_DEPTH_CLAMP);
    return drawn;
}

void ProjectivePass::drawMap(const ProjectiveInput& input, const ProjectiveMap& map,
                             ShadowCull cull, std::span<const render::DrawItem> casters,
                             DrawnCasters& drawn) {
    const glm::dmat3 stored = glm::transpose(input.meshAxes);
    for (std::size_t i = 0; i < casters.size(); ++i)
        drawn[i] = !outside(map, casters[i].mesh->box, input);
    CasterDraw draw;
    draw.casters = casters;
    draw.cull = cull;
    draw.opaque = &opaque_;
    draw.alphaTested = &alphaTested_;
    draw.wants = [&](std::size_t i) { return bool(drawn[i]); };
    draw.start = [&] { setRows(map); };
    draw.place = [&](const render::DrawItem& item) {
        const glm::dvec4 origin(stored * (item.mesh->origin - input.camera.position).xyz, 1.0);
        glUniform4f(4, float(glm::dot(map.x, origin)), float(glm::dot(map.y, origin)),
                    float(glm::dot(map.depth, origin) * map.depthScale),
                    float(glm::dot(map.w, origin)));
    };
    drawCasters(draw);
}

void ProjectivePass::bind() const {
    render::bindUniformBlock(BLOCK_PROJECTIVE, block_);
    render::bindTexture(TEX_PROJECTIVE, maps_);
}

std::vector<float> ProjectivePass::read(std::size_t map) const {
    const ProjectiveMap& m = drawn_[map];
    std::vector<float> texels(std::size_t(m.width) * std::size_t(m.height));
    glGetTextureSubImage(maps_.id(), 0, 0, 0, int(map), m.width, m.height, 1, GL_DEPTH_COMPONENT,
                         GL_FLOAT, int(texels.size() * sizeof(float)), texels.data());
    return texels;
}

} // namespace gnomon
