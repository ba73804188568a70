#include "shadows/caster_draw.h"

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

bool alphaTests(const render::DrawItem& item) {
    const render::GpuMaterial& material = item.tile->material(*item.mesh);
    return material.look.alphaTest && material.texture >= 0;
}

void drawKind(const CasterDraw& draw, bool alpha) {
    bool started = false;
    const render::GpuTile* bound = nullptr;
    for (std::size_t i = 0; i < draw.casters.size(); ++i) {
        const render::DrawItem& item = draw.casters[i];
        if (alphaTests(item) != alpha || !draw.wants(i))
            continue;
        if (!started) {
            started = true;
            (alpha ? draw.alphaTested : draw.opaque)->use();
            draw.start();
        }
        if (item.tile != bound) {
            bound = item.tile;
            glBindVertexArray((alpha ? item.tile->vertices() : item.tile->positionsOnly()).id());
        }
        if (alpha) {
            const render::GpuMaterial& material = item.tile->material(*item.mesh);
            item.tile->bindTextures(material);
            glUniform2f(kAlphaTestLocation, material.look.baseColor.a, material.look.alphaCutoff);
        }
        draw.place(item);
        drawFaces(*item.mesh, draw.cull);
    }
}

} // namespace

void drawCasters(const CasterDraw& draw) {
    drawKind(draw, false);
    drawKind(draw, true);
    glDisable(GL_CULL_FACE);
}

void setUniform(int location, const glm::dvec3& v) {
    glUniform3f(location, float(v.x), float(v.y), float(v.z));
}

} // namespace gnomon
