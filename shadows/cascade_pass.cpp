#include "shadows/cascade_pass.h"

#include "shadows/caster_draw.h"

#include <epoxy/gl.h>

namespace gnomon {

namespace {

// The light's axes along the meshes' own, scaled to texels and to stored depth.
void setRows(const CascadeSet& set, const Cascade& cascade) {
    const glm::dmat3 rows = glm::transpose(set.lightFromEcef.axes() * set.meshAxes);
    setUniform(0, rows[0] / cascade.texelMetres);
    setUniform(1, rows[1] / cascade.texelMetres);
    setUniform(2, rows[2] / cascade.depthRangeMetres);
    glUniform1f(4, 2.0f / float(set.mapSize));
}

} // namespace

CascadePass::CascadePass()
    : opaque_("depth.vert", "depth.frag"), alphaTested_("depth.vert", "depth_alpha.frag") {}

std::size_t CascadePass::bytes() const {
    return std::size_t(mapSize_) * std::size_t(mapSize_) * targets_.size() * sizeof(float);
}

void CascadePass::resize(int mapSize, int count) {
    if (mapSize == mapSize_ && count == int(targets_.size()))
        return;
    mapSize_ = mapSize;
    targets_.clear();
    maps_ = render::Texture();
    maps_ = render::makeTargetArray(GL_DEPTH_COMPONENT32F, mapSize, mapSize, count);
    glTextureParameteri(maps_.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(maps_.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
    for (int i = 0; i < count; ++i) {
        unsigned id = 0;
        glCreateFramebuffers(1, &id);
        targets_.emplace_back(id);
        glNamedFramebufferTextureLayer(id, GL_DEPTH_ATTACHMENT, maps_.id(), 0, i);
        glNamedFramebufferDrawBuffer(id, GL_NONE);
    }
}

std::vector<DrawnCasters> CascadePass::draw(const CascadeSet& set, const ShadowSettings& settings,
                                            std::span<const render::DrawItem> casters,
                                            render::GpuTimer& timer) {
    resize(set.mapSize, int(set.cascades.size()));
    std::vector<LightBox> boxes;
    boxes.reserve(casters.size());
    for (const render::DrawItem& item : casters)
        boxes.push_back(lightBox(set.lightFromEcef, item.mesh->box));

    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glEnable(GL_DEPTH_CLAMP); // what stands nearer to the sun than the range still casts
    glEnable(GL_SCISSOR_TEST);
    glViewport(0, 0, set.mapSize, set.mapSize);
    std::vector<DrawnCasters> drawn;
    for (std::size_t i = 0; i < set.cascades.size(); ++i) {
        const Cascade& cascade = set.cascades[i];
        glBindFramebuffer(GL_FRAMEBUFFER, targets_[i].id());
        glScissor(0, 0, set.mapSize, set.mapSize);
        const float far = 0.0f;
        glClearNamedFramebufferfv(targets_[i].id(), GL_DEPTH, 0, &far);
        const CascadePages pages = pagesOf(cascade, set.mapSize);
        DrawnCasters inCascade(casters.size(), false);
        for (int p = 0; p < pages.count; ++p)
            drawPage(set, cascade, pages.pages[std::size_t(p)], cullOf(settings), casters, boxes,
                     inCascade);
        drawn.push_back(std::move(inCascade));
        timer.mark();
    }
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_CLAMP);
    return drawn;
}

void CascadePass::drawPage(const CascadeSet& set, const Cascade& cascade, const CascadePage& page,
                           ShadowCull cull, std::span<const render::DrawItem> casters,
                           std::span<const LightBox> boxes, DrawnCasters& drawn) {
    glScissor(page.x, page.y, page.width, page.height);
    CasterDraw draw;
    draw.casters = casters;
    draw.cull = cull;
    draw.opaque = &opaque_;
    draw.alphaTested = &alphaTested_;
    draw.wants = [&](std::size_t i) {
        const bool wanted = touches(cascade, page, boxes[i]);
        if (wanted)
            drawn[i] = true;
        return wanted;
    };
    draw.start = [&] { setRows(set, cascade); };
    draw.place = [&](const render::DrawItem& item) {
        const glm::dvec3 light = set.lightFromEcef(item.mesh->origin).xyz;
        glm::dvec3 offset = pageFromLight(cascade, page, light);
        offset.z /= cascade.depthRangeMetres;
        setUniform(3, offset);
    };
    drawCasters(draw);
}

std::vector<float> CascadePass::read(int cascade) const {
    std::vector<float> texels(std::size_t(mapSize_) * std::size_t(mapSize_));
    glGetTextureSubImage(maps_.id(), 0, 0, 0, cascade, mapSize_, mapSize_, 1, GL_DEPTH_COMPONENT,
                         GL_FLOAT, int(texels.size() * sizeof(float)), texels.data());
    return texels;
}

} // namespace gnomon
