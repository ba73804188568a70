#include "shadows/cascade_pass.h"

#include "shadows/bias.h"
#include "shadows/caster_draw.h"

#include <epoxy/gl.h>

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

namespace gnomon {

namespace {

// The light's axes along the meshes' own, scaled to texels and to stored depth.
void setRows(const CascadeSet& set, const Cascade& cascade) {
    const glm::dmat3 rows = glm::transpose(set.lightFromEcef.axes() * set.meshAxes);
    setUniform(0, rows[0] / cascade.texelMetres);
    setUniform(1, rows[1] / cascade.texelMetres);
    setUniform(2, rows[2] / cascade.depthRangeMetres);
    glUniform2f(4, 2.0f / float(set.mapSize.x), 2.0f / float(set.mapSize.y));
}

// Half the way between two stored depths is never more than a half.
float storedOffset(const ShadowSettings& settings, const Cascade& cascade) {
    return float(
        std::min(layerOffsetMetres(settings, cascade.texelMetres) / cascade.depthRangeMetres, 0.5));
}

void clearMap(const render::Framebuffer& target, bool color) {
    const float far[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glClearNamedFramebufferfv(target.id(), GL_DEPTH, 0, far);
    if (color)
        glClearNamedFramebufferfv(target.id(), GL_COLOR, 0, far);
}

// Where one caster may stand behind another. The flat ground is one sheet: about the others only.
std::optional<LightBox> overlapsOf(std::span<const render::DrawItem> casters,
                                   std::span<const LightBox> boxes) {
    std::optional<LightBox> all;
    for (std::size_t i = 0; i < casters.size(); ++i) {
        if (casters[i].tileId == 0)
            continue;
        if (!all)
            all = boxes[i];
        all->min = glm::min(all->min, boxes[i].min);
        all->max = glm::max(all->max, boxes[i].max);
    }
    return all;
}

// The texels of a page that a box touches, and one more on each side.
CascadePage cut(const Cascade& cascade, const CascadePage& page, const LightBox& box) {
    const glm::dvec3 low = pageFromLight(cascade, page, box.min);
    const glm::dvec3 high = pageFromLight(cascade, page, box.max);
    const auto texel = [&](double at, int first, int size) {
        return int(std::clamp(std::floor(at), double(first), double(first + size)));
    };
    CascadePage part = page;
    part.x = texel(low.x - 1.0, page.x, page.width);
    part.y = texel(low.y - 1.0, page.y, page.height);
    part.width = texel(high.x + 2.0, page.x, page.width) - part.x;
    part.height = texel(high.y + 2.0, page.y, page.height) - part.y;
    return part;
}

} // namespace

CascadePass::CascadePass()
    : nearest_{{"depth.vert", "depth.frag"}, {"depth.vert", "depth_alpha.frag"}} {}

std::size_t CascadePass::bytes() const {
    return std::size_t(mapSize_.x) * std::size_t(mapSize_.y) * targets_.size() * sizeof(float) +
           layers_.bytes();
}

int CascadePass::marksPerMap(const ShadowSettings& settings) {
    return settings.bias == ShadowBias::DualAtomic ? 2 : 1;
}

void CascadePass::resize(glm::ivec2 mapSize, int count, ShadowBias bias) {
    if (mapSize == mapSize_ && count == int(targets_.size()) && bias == bias_)
        return;
    mapSize_ = mapSize;
    bias_ = bias;
    targets_.clear();
    maps_ = render::Texture(); // freed before the next is made
    layers_.prepare(bias, mapSize);
    maps_ = render::makeTargetArray(hasTwoLayers(bias) ? GL_R32F : GL_DEPTH_COMPONENT32F, mapSize.x,
                                    mapSize.y, count);
    glTextureParameteri(maps_.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTextureParameteri(maps_.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
    for (int i = 0; i < count; ++i)
        targets_.push_back(target(i));
}

render::Framebuffer CascadePass::target(int cascade) const {
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    if (!hasTwoLayers(bias_)) {
        glNamedFramebufferTextureLayer(id, GL_DEPTH_ATTACHMENT, maps_.id(), 0, cascade);
        glNamedFramebufferDrawBuffer(id, GL_NONE);
        return render::Framebuffer(id);
    }
    glNamedFramebufferTextureLayer(id, GL_COLOR_ATTACHMENT0, maps_.id(), 0, cascade);
    if (layers_.peels())
        glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, layers_.depth().id(), 0);
    return render::Framebuffer(id);
}

std::vector<DrawnCasters> CascadePass::draw(const CascadeSet& set, const ShadowSettings& settings,
                                            std::span<const render::DrawItem> casters,
                                            render::GpuTimer& timer) {
    resize(set.mapSize, int(set.cascades.size()), settings.bias);
    std::vector<LightBox> boxes;
    boxes.reserve(casters.size());
    for (const render::DrawItem& item : casters)
        boxes.push_back(lightBox(set.lightFromEcef, item.mesh->box));

    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glEnable(GL_DEPTH_CLAMP); // what stands nearer to the sun than the range still casts
    glViewport(0, 0, set.mapSize.x, set.mapSize.y);
    std::vector<DrawnCasters> drawn;
    for (std::size_t i = 0; i < set.cascades.size(); ++i) {
        const Cascade& cascade = set.cascades[i];
        Map map{set,     cascade, targets_[i], cullOf(settings),
                casters, boxes,   0.0f,        DrawnCasters(casters.size(), false)};
        glBindFramebuffer(GL_FRAMEBUFFER, targets_[i].id());
        if (hasTwoLayers(settings.bias)) {
            map.layerOffset = storedOffset(settings, cascade);
            drawLayers(map, timer);
        } else {
            clearMap(targets_[i], false);
            drawPages(map, nearest_);
        }
        timer.mark();
        drawn.push_back(std::move(map.drawn));
    }
    glDisable(GL_DEPTH_CLAMP);
    return drawn;
}

void CascadePass::drawLayers(Map& map, render::GpuTimer& timer) {
    if (layers_.peels()) {
        clearMap(map.target, true);
        drawPages(map, layers_.startFirst());
        drawPages(map, layers_.startSecond(), true);
    } else {
        drawPages(map, layers_.startBoth());
        timer.mark();
        layers_.resolve(map.layerOffset);
    }
    layers_.finish();
}

void CascadePass::drawPages(Map& map, const CasterPrograms& programs, bool overlapsOnly) const {
    glEnable(GL_SCISSOR_TEST);
    const std::optional<LightBox> overlaps =
        overlapsOnly ? overlapsOf(map.casters, map.boxes) : std::nullopt;
    const CascadePages pages = pagesOf(map.cascade, map.set.mapSize);
    for (int p = 0; p < pages.count; ++p) {
        CascadePage page = pages.pages[std::size_t(p)];
        if (overlapsOnly)
            page = overlaps ? cut(map.cascade, page, *overlaps) : CascadePage{};
        if (page.width > 0 && page.height > 0)
            drawPage(map, page, programs);
    }
    glDisable(GL_SCISSOR_TEST);
}

void CascadePass::drawPage(Map& map, const CascadePage& page,
                           const CasterPrograms& programs) const {
    glScissor(page.x, page.y, page.width, page.height);
    CasterDraw draw;
    draw.casters = map.casters;
    draw.cull = map.cull;
    draw.opaque = &programs.opaque;
    draw.alphaTested = &programs.alphaTested;
    draw.wants = [&](std::size_t i) {
        const bool wanted = touches(map.cascade, page, map.boxes[i]);
        if (wanted)
            map.drawn[i] = true;
        return wanted;
    };
    draw.start = [&] {
        setRows(map.set, map.cascade);
        if (&programs != &nearest_ && layers_.peels())
            layers_.setOffset(map.layerOffset);
    };
    draw.place = [&](const render::DrawItem& item) {
        const glm::dvec3 light = map.set.lightFromEcef(item.mesh->origin).xyz;
        glm::dvec3 offset = pageFromLight(map.cascade, page, light);
        offset.z /= map.cascade.depthRangeMetres;
        setUniform(3, offset);
    };
    drawCasters(draw);
}

std::vector<float> CascadePass::read(int cascade) const {
    std::vector<float> texels(std::size_t(mapSize_.x) * std::size_t(mapSize_.y));
    glGetTextureSubImage(maps_.id(), 0, 0, 0, cascade, mapSize_.x, mapSize_.y, 1,
                         hasTwoLayers(bias_) ? GL_RED : GL_DEPTH_COMPONENT, GL_FLOAT,
                         int(texels.size() * sizeof(float)), texels.data());
    return texels;
}

} // namespace gnomon
