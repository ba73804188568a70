#include "shadows/cascade_pass.h"

#include "shaders/interface.h"

#include <epoxy/gl.h>

namespace gnomon {

namespace {

// Which faces of a range of triangles are drawn.
enum class Faces { All, BackOnly, FrontOnly };

Faces facesOf(ShadowCull cull, bool closed) {
    switch (cull) {
    case ShadowCull::Auto:
        return closed ? Faces::FrontOnly : Faces::All;
    case ShadowCull::FrontOfClosed:
        return closed ? Faces::BackOnly : Faces::All;
    case ShadowCull::None:
        return Faces::All;
    case ShadowCull::Front:
        return Faces::BackOnly;
    case ShadowCull::Back:
        return Faces::FrontOnly;
    }
    return Faces::All;
}

void setFaces(Faces faces) {
    if (faces == Faces::All) {
        glDisable(GL_CULL_FACE);
        return;
    }
    glEnable(GL_CULL_FACE);
    glCullFace(faces == Faces::BackOnly ? GL_FRONT : GL_BACK);
}

void drawRange(const render::GpuMesh& mesh, std::uint32_t skip, std::uint32_t count) {
    if (count == 0)
        return;
    glDrawElementsBaseVertex(
        GL_TRIANGLES, int(count), GL_UNSIGNED_INT,
        reinterpret_cast<const void*>(std::uintptr_t(mesh.firstIndex + skip) * 4), mesh.baseVertex);
}

void drawFaces(const render::GpuMesh& mesh, ShadowCull cull) {
    const Faces closed = facesOf(cull, true), open = facesOf(cull, false);
    if (closed == open || mesh.openIndices == 0 || mesh.closedIndices == 0) {
        setFaces(mesh.closedIndices == 0 ? open : closed);
        drawRange(mesh, 0, mesh.closedIndices + mesh.openIndices);
        return;
    }
    setFaces(closed);
    drawRange(mesh, 0, mesh.closedIndices);
    setFaces(open);
    drawRange(mesh, mesh.closedIndices, mesh.openIndices);
}

void setUniform(int location, const glm::dvec3& v) {
    glUniform3f(location, float(v.x), float(v.y), float(v.z));
}

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

std::vector<std::uint32_t> CascadePass::draw(const CascadeSet& set, ShadowCull cull,
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
    std::vector<std::uint32_t> drawn;
    for (std::size_t i = 0; i < set.cascades.size(); ++i) {
        const Cascade& cascade = set.cascades[i];
        glBindFramebuffer(GL_FRAMEBUFFER, targets_[i].id());
        glScissor(0, 0, set.mapSize, set.mapSize);
        const float far = 0.0f;
        glClearNamedFramebufferfv(targets_[i].id(), GL_DEPTH, 0, &far);
        const CascadePages pages = pagesOf(cascade, set.mapSize);
        std::uint32_t count = 0;
        for (int p = 0; p < pages.count; ++p)
            count += drawPage(set, cascade, pages.pages[std::size_t(p)], cull, casters, boxes);
        drawn.push_back(count);
        timer.mark();
    }
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_CLAMP);
    glDisable(GL_CULL_FACE);
    return drawn;
}

std::uint32_t CascadePass::drawPage(const CascadeSet& set, const Cascade& cascade,
                                    const CascadePage& page, ShadowCull cull,
                                    std::span<const render::DrawItem> casters,
                                    std::span<const LightBox> boxes) {
    glScissor(page.x, page.y, page.width, page.height);
    std::uint32_t drawn = 0;
    // Opaque casters first, then those whose texture decides.
    for (const bool alpha : {false, true}) {
        bool started = false;
        const render::GpuTile* bound = nullptr;
        for (std::size_t i = 0; i < casters.size(); ++i) {
            const render::DrawItem& item = casters[i];
            const render::GpuMaterial& material = item.tile->material(*item.mesh);
            if ((material.look.alphaTest && material.texture >= 0) != alpha ||
                !touches(cascade, page, boxes[i]))
                continue;
            if (!started) {
                started = true;
                (alpha ? alphaTested_ : opaque_).use();
                setRows(set, cascade);
            }
            if (item.tile != bound) {
                bound = item.tile;
                glBindVertexArray(
                    (alpha ? item.tile->vertices() : item.tile->positionsOnly()).id());
            }
            if (alpha) {
                item.tile->bindTextures(material);
                glUniform2f(5, material.look.baseColor.a, material.look.alphaCutoff);
            }
            const glm::dvec3 light = set.lightFromEcef(item.mesh->origin).xyz;
            glm::dvec3 offset = pageFromLight(cascade, page, light);
            offset.z /= cascade.depthRangeMetres;
            setUniform(3, offset);
            drawFaces(*item.mesh, cull);
            ++drawn;
        }
    }
    return drawn;
}

std::vector<float> CascadePass::read(int cascade) const {
    std::vector<float> texels(std::size_t(mapSize_) * std::size_t(mapSize_));
    glGetTextureSubImage(maps_.id(), 0, 0, 0, cascade, mapSize_, mapSize_, 1, GL_DEPTH_COMPONENT,
                         GL_FLOAT, int(texels.size() * sizeof(float)), texels.data());
    return texels;
}

} // namespace gnomon
