#include "shadows/lamp_pass.h"

#include "render/readback.h"
#include "shaders/interface.h"
#include "shadows/caster_draw.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gnomon {

static_assert(LAMP_GUARD_TEXELS == kLampGuardTexels);

namespace {

constexpr int kMostMapsOfALamp = 6;

// Whether two lamps have the same maps; power changes none.
bool sameMaps(const Lamp& a, const Lamp& b) {
    return a.position.xyz == b.position.xyz && a.facing.xyz == b.facing.xyz &&
           a.nearMetres == b.nearMetres && a.rangeMetres == b.rangeMetres;
}

// What a map was drawn from. Content is told by its owner, so that another at its old address is
// another; and is not kept alive.
struct CasterKey {
    std::weak_ptr<const TileContent> content;
    std::uint32_t mesh = 0;

    bool operator==(const CasterKey& o) const {
        return mesh == o.mesh && !content.owner_before(o.content) &&
               !o.content.owner_before(content);
    }
};

std::vector<CasterKey> keysOf(std::span<const LampCaster> casters) {
    std::vector<CasterKey> keys;
    for (const LampCaster& caster : casters)
        keys.push_back({caster.content, caster.mesh});
    return keys;
}

std::string definesOf(LampMethod method) {
    return method == LampMethod::Cube ? "LAMP_CUBE" : "";
}

float filterWidth(const ShadowSettings& settings) {
    switch (settings.filter) {
    case ShadowFilter::None:
        return 0.0f;
    case ShadowFilter::Pcf:
        return float(settings.pcfWidth);
    default: // a lamp is a point: nothing is soft but the map's own texels
        return 1.0f;
    }
}

// The least rectangle of pixels that holds a sphere, lower left first; all when the eye is near it.
std::array<int, 4> pixelsOf(const Camera& camera, const Lamp& lamp) {
    const Vector<Ecef> to = lamp.position - camera.position;
    const glm::dvec3 c(dot(to, camera.right), dot(to, camera.up), dot(to, camera.forward));
    glm::dvec2 low(1.0), high(-1.0);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const glm::dvec3 p = c + lamp.rangeMetres * side;
        if (p.z < render::kNearPlaneMetres)
            return {0, 0, camera.widthPixels, camera.heightPixels};
        const glm::dvec2 ndc(p.x / (p.z * camera.tanHalfWidth()),
                             p.y / (p.z * camera.tanHalfHeight()));
        low = glm::min(low, ndc);
        high = glm::max(high, ndc);
    }
    const auto pixel = [](double ndc, int size) {
        return int(std::floor((std::clamp(ndc, -1.0, 1.0) + 1.0) / 2.0 * size));
    };
    const int x = pixel(low.x, camera.widthPixels), y = pixel(low.y, camera.heightPixels);
    return {x, y, std::min(pixel(high.x, camera.widthPixels) + 1, camera.widthPixels) - x,
            std::min(pixel(high.y, camera.heightPixels) + 1, camera.heightPixels) - y};
}

} // namespace

// A live lamp, its layers, and what they were drawn from.
struct LampPass::Slot {
    std::size_t lamp = 0;
    Lamp drawn;
    LampMaps maps;
    std::array<int, kMostMapsOfALamp> layers{};
    Transform<LampFrame, Ecef> lampFromEcef;
    bool filled = false;
    double bendTexels = 0.0;
    std::vector<CasterKey> keys;
    std::uint64_t triangles = 0;
};

LampPass::LampPass() : block_(render::makeDynamicBuffer(sizeof(shader::LampBlock))) {
    unsigned id = 0;
    glCreateVertexArrays(1, &id);
    empty_ = render::VertexArray(id);
}

LampPass::~LampPass() = default;

const render::Program& LampPass::program(std::string_view fragment, const std::string& defines) {
    render::Program& program = programs_[std::string(fragment) + " " + defines];
    if (program.id() == 0)
        program = render::Program(fragment == "lamp.frag" ? "fullscreen.vert" : "lamp_depth.vert",
                                  fragment, defines);
    return program;
}

std::size_t LampPass::bytes() const {
    return std::size_t(texels_) * std::size_t(texels_) * layers_.size() * sizeof(float);
}

void LampPass::resize(int texels, int layers) {
    if (texels == texels_ && layers <= int(layers_.size()))
        return;
    slots_.clear(); // what they held is gone
    texels_ = texels;
    layers_.clear();
    maps_ = render::Texture();
    maps_ = render::makeTargetArray(GL_DEPTH_COMPONENT32F, texels, texels, layers);
    for (int i = 0; i < layers; ++i) {
        unsigned id = 0;
        glCreateFramebuffers(1, &id);
        layers_.emplace_back(id);
        glNamedFramebufferTextureLayer(id, GL_DEPTH_ATTACHMENT, maps_.id(), 0, i);
        glNamedFramebufferDrawBuffer(id, GL_NONE);
    }
}

// Layers for the live lamps; those that have some keep them.
void LampPass::assignLayers(const LampPassInput& input, const ShadowSettings& settings) {
    int needed = 0, texels = texels_;
    for (const std::size_t lamp : input.live) {
        const LampMaps maps = lampMaps(settings, input.lamps[lamp]);
        texels = maps.texels;
        needed += maps.count;
    }
    resize(texels, needed);
    std::erase_if(slots_, [&](const std::unique_ptr<Slot>& slot) {
        return std::find(input.live.begin(), input.live.end(), slot->lamp) == input.live.end() ||
               slot->maps.method != settings.lamps ||
               shinesAllRound(slot->drawn) != shinesAllRound(input.lamps[slot->lamp]);
    });
    std::vector<bool> taken(layers_.size(), false);
    for (const auto& slot : slots_)
        for (int i = 0; i < slot->maps.count; ++i)
            taken[std::size_t(slot->layers[std::size_t(i)])] = true;
    std::vector<std::unique_ptr<Slot>> ordered;
    for (const std::size_t lamp : input.live) {
        const auto there = std::find_if(slots_.begin(), slots_.end(), [&](const auto& slot) {
            return slot && slot->lamp == lamp;
        });
        if (there != slots_.end()) {
            ordered.push_back(std::move(*there));
            continue;
        }
        auto slot = std::make_unique<Slot>();
        slot->lamp = lamp;
        slot->maps = lampMaps(settings, input.lamps[lamp]);
        for (int i = 0; i < slot->maps.count; ++i) {
            const auto free = std::find(taken.begin(), taken.end(), false);
            slot->layers[std::size_t(i)] = int(free - taken.begin());
            *free = true;
        }
        ordered.push_back(std::move(slot));
    }
    slots_ = std::move(ordered);
}

void LampPass::drawMaps(const LampPassInput& input, const ShadowSettings& settings) {
    mapsDrawn_ = 0;
    triangles_ = 0;
    assignLayers(input, settings);
    for (const auto& slot : slots_) {
        const Lamp& lamp = input.lamps[slot->lamp];
        std::vector<LampCaster> casters = castersOf(lamp, input.casters);
        const bool same = slot->filled && sameMaps(slot->drawn, lamp) &&
                          slot->bendTexels == settings.lampEdgeTexels &&
                          slot->keys == keysOf(casters);
        slot->drawn = lamp;
        if (!same)
            fill(*slot, input, settings, std::move(casters));
        triangles_ += slot->triangles;
    }
}

void LampPass::fill(Slot& slot, const LampPassInput& input, const ShadowSettings& settings,
                    std::vector<LampCaster> casters) {
    slot.filled = true;
    slot.bendTexels = settings.lampEdgeTexels;
    slot.keys = keysOf(casters);
    slot.lampFromEcef = lampFromEcef(input.ecefFromAnchor, slot.drawn);
    const LampGeometry geometry = lampGeometry(slot.lampFromEcef, slot.drawn, slot.maps,
                                               input.meshAxes, slot.bendTexels, casters);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glDisable(GL_CULL_FACE);
    glViewport(0, 0, texels_, texels_);
    slot.triangles = 0;
    for (int map = 0; map < slot.maps.count; ++map) {
        drawMap(slot, map, geometry.maps[std::size_t(map)], casters);
        slot.triangles += geometry.maps[std::size_t(map)].corners.size() / 3;
        ++mapsDrawn_;
    }
}

void LampPass::drawMap(const Slot& slot, int map, const LampMapTriangles& triangles,
                       std::span<const LampCaster> casters) {
    const unsigned target = layers_[std::size_t(slot.layers[std::size_t(map)])].id();
    const float far = 1.0f;
    glClearNamedFramebufferfv(target, GL_DEPTH, 0, &far);
    if (triangles.corners.empty())
        return;
    const render::Buffer corners =
        render::makeBuffer(triangles.corners.size() * sizeof(glm::vec3), triangles.corners.data());
    const render::Buffer planeBuffer =
        render::makeBuffer(triangles.planes.size() * sizeof(glm::vec4), triangles.planes.data());
    unsigned id = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
    const render::Texture planes(id);
    glTextureBuffer(planes.id(), GL_RGBA32F, planeBuffer.id());
    glCreateVertexArrays(1, &id);
    const render::VertexArray vertices(id);
    glVertexArrayVertexBuffer(vertices.id(), 0, corners.id(), 0, sizeof(glm::vec3));
    glEnableVertexArrayAttrib(vertices.id(), 0);
    glVertexArrayAttribFormat(vertices.id(), 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vertices.id(), 0, 0);

    glBindFramebuffer(GL_FRAMEBUFFER, target);
    glBindVertexArray(vertices.id());
    render::bindTexture(TEX_LAMP_PLANES, planes);
    const auto start = [&](const char* alpha) {
        program("lamp_depth.frag", definesOf(slot.maps.method) + alpha).use();
        glUniform1i(1, map);
        glUniform3f(2, float(slot.drawn.nearMetres), float(slot.drawn.rangeMetres), float(texels_));
    };
    start("");
    glUniform1i(0, 0);
    glDrawArrays(GL_TRIANGLES, 0, int(3 * triangles.opaque));
    int plane = 4 * int(triangles.opaque);
    bool started = false;
    for (const LampMapTriangles::AlphaRange& range : triangles.alpha) {
        if (range.count > 0) {
            if (!started)
                start(" LAMP_ALPHA");
            started = true;
            const LampCaster& caster = casters[range.caster];
            const render::GpuMaterial& material =
                caster.tile->material(caster.tile->meshes()[caster.mesh]);
            caster.tile->bindTextures(material);
            glUniform2f(kAlphaTestLocation, material.look.baseColor.a, material.look.alphaCutoff);
            glUniform1i(0, plane);
            glDrawArrays(GL_TRIANGLES, int(3 * range.first), int(3 * range.count));
        }
        plane += 6 * int(range.count);
    }
}

void LampPass::setLamp(const Slot& slot, const LampPassInput& input,
                       const ShadowSettings& settings) {
    const Lamp& lamp = slot.drawn;
    const glm::dmat3 rows = glm::transpose(slot.lampFromEcef.axes() * input.meshAxes);
    const glm::dvec3 camera = slot.lampFromEcef(input.surfaceCamera.position).xyz;
    const auto row = [&](int i) { return glm::vec4(glm::dvec4(rows[i], camera[i])); };
    shader::LampBlock block{};
    block.lampX = row(0);
    block.lampY = row(1);
    block.lampZ = row(2);
    block.lampPower = glm::vec4(input.lamps[slot.lamp].power * float(input.exposure),
                                shinesAllRound(lamp) ? 1.0f : 0.0f);
    block.lampReach = glm::vec4(float(lamp.nearMetres), float(lamp.rangeMetres), float(texels_),
                                filterWidth(settings));
    for (int i = 0; i < kMostMapsOfALamp; ++i)
        block.lampLayers[i / 4][i % 4] = float(slot.layers[std::size_t(i)]);
    if (slot.maps.method == LampMethod::Paraboloid)
        block.lampLayers[1].z = float(slot.bendTexels);
    render::update(block_, block);
    render::bindUniformBlock(BLOCK_LAMP, block_);
}

void LampPass::bindSeen(const render::VisibilityPass& seen, const ShadowSettings& settings) {
    render::bindUniformBlock(BLOCK_VIEW, seen.viewBlock());
    render::bindTexture(TEX_DEPTH, seen.depth());
    render::bindTexture(TEX_NORMALS, seen.normals());
    render::bindTexture(TEX_LAMP_MAPS, maps_);
    program("lamp.frag", definesOf(settings.lamps)).use();
    glBindVertexArray(empty_.id());
    glViewport(0, 0, seen.width(), seen.height());
    glDisable(GL_DEPTH_TEST);
}

void LampPass::draw(const render::VisibilityPass& seen, const LampPassInput& input,
                    const ShadowSettings& settings) {
    if (seen.width() != width_ || seen.height() != height_) {
        width_ = seen.width();
        height_ = seen.height();
        light_ = render::makeTarget(GL_RGBA16F, width_, height_);
        unsigned id = 0;
        glCreateFramebuffers(1, &id);
        lightTarget_ = render::Framebuffer(id);
        glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT0, light_.id(), 0);
    }
    const float none[4] = {0, 0, 0, 0};
    glClearNamedFramebufferfv(lightTarget_.id(), GL_COLOR, 0, none);
    if (slots_.empty())
        return;
    bindSeen(seen, settings);
    glBindFramebuffer(GL_FRAMEBUFFER, lightTarget_.id());
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glEnable(GL_SCISSOR_TEST);
    for (const auto& slot : slots_) {
        const auto [x, y, width, height] = pixelsOf(input.surfaceCamera, slot->drawn);
        if (width <= 0 || height <= 0)
            continue;
        glScissor(x, y, width, height);
        setLamp(*slot, input, settings);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
}

const LampPass::Slot* LampPass::slotOf(std::size_t lamp) const {
    for (const auto& slot : slots_)
        if (slot->lamp == lamp)
            return slot.get();
    return nullptr;
}

std::optional<LampPicture> LampPass::shadowOf(const render::VisibilityPass& seen,
                                              const LampPassInput& input, std::size_t lamp,
                                              const ShadowSettings& settings) {
    const Slot* slot = slotOf(lamp);
    if (slot == nullptr)
        return std::nullopt;
    const render::Texture picture = render::makeTarget(GL_RG32F, seen.width(), seen.height());
    unsigned id = 0;
    glCreateFramebuffers(1, &id);
    const render::Framebuffer target(id);
    glNamedFramebufferTexture(id, GL_COLOR_ATTACHMENT1, picture.id(), 0);
    const unsigned buffers[] = {GL_NONE, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(id, 2, buffers);
    bindSeen(seen, settings);
    glBindFramebuffer(GL_FRAMEBUFFER, id);
    setLamp(*slot, input, settings);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    const std::vector<float> both =
        render::readTopDown<float>(picture, seen.width(), seen.height(), 2, GL_RG, GL_FLOAT);
    LampPicture out;
    for (std::size_t i = 0; i < both.size(); i += 2) {
        out.visibility.push_back(both[i]);
        out.texelMetres.push_back(both[i + 1]);
    }
    return out;
}

std::vector<float> LampPass::read(std::size_t lamp, int map) const {
    const Slot* slot = slotOf(lamp);
    if (slot == nullptr || map < 0 || map >= slot->maps.count)
        return {};
    std::vector<float> texels(std::size_t(texels_) * std::size_t(texels_));
    glGetTextureSubImage(maps_.id(), 0, 0, 0, slot->layers[std::size_t(map)], texels_, texels_, 1,
                         GL_DEPTH_COMPONENT, GL_FLOAT, int(texels.size() * sizeof(float)),
                         texels.data());
    const float near = float(slot->drawn.nearMetres), range = float(slot->drawn.rangeMetres);
    for (float& t : texels)
        t = t >= 1.0f ? std::numeric_limits<float>::infinity() : near + t * (range - near);
    return texels;
}

} // namespace gnomon
