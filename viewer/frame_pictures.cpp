// What is read back of the frame drawn last: pictures, and what measures its shadows.
#include "shadows/plane_finder.h"
#include "viewer/frame_state.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

template <class T>
void takeWhere(const std::vector<bool>& chosen, const std::vector<T>& from, std::vector<T>& to) {
    for (std::size_t i = 0; i < to.size(); ++i)
        if (chosen[i])
            to[i] = from[i];
}

void setSky(const std::vector<float>& viewDepth, std::vector<float>& visibility) {
    for (std::size_t i = 0; i < visibility.size(); ++i)
        if (std::isinf(viewDepth[i]))
            visibility[i] = -1.0f;
}

} // namespace

Picture FrameRenderer::picture() {
    return {state_->last.camera.widthPixels, state_->last.camera.heightPixels,
            state_->compositePass.read()};
}

FrameRenderer::State::NearestSurfaces FrameRenderer::State::nearestSurfaces() const {
    NearestSurfaces nearest{visibilityPass.readViewDepth(), visibilityPass.readNormals(), {}};
    nearest.water.assign(nearest.viewDepth.size(), false);
    if (!waterPass.any())
        return nearest;
    const std::vector<float> depth = waterPass.readViewDepth();
    const std::vector<std::uint16_t> normals = waterPass.readNormals();
    for (std::size_t i = 0; i < depth.size(); ++i) {
        if (std::isinf(depth[i]))
            continue;
        nearest.water[i] = true;
        nearest.viewDepth[i] = depth[i];
        std::copy_n(&normals[4 * i], 4, &nearest.normals[4 * i]);
    }
    return nearest;
}

FloatPicture FrameRenderer::aov(Aov which) {
    State& s = *state_;
    FloatPicture out{s.last.camera.widthPixels, s.last.camera.heightPixels, 1, {}};
    const State::NearestSurfaces nearest = s.nearestSurfaces();
    switch (which) {
    case Aov::Sun:
        out.values = s.sun.readVisibility();
        if (s.waterPass.any())
            takeWhere(nearest.water, s.waterSun.readVisibility(), out.values);
        setSky(nearest.viewDepth, out.values);
        break;
    case Aov::Depth:
        out.values = nearest.viewDepth;
        break;
    case Aov::Cascade: {
        std::vector<std::uint8_t> cascades = s.sun.readCascades();
        if (s.waterPass.any())
            takeWhere(nearest.water, s.waterSun.readCascades(), cascades);
        out.values.assign(cascades.begin(), cascades.end());
        break;
    }
    case Aov::Tile: {
        const std::vector<std::uint32_t> ids = s.visibilityPass.readTiles();
        out.values.assign(ids.begin(), ids.end());
        break;
    }
    case Aov::Normal:
        out.channels = 3;
        out.values = s.normals(nearest);
        break;
    }
    return out;
}

std::vector<float> FrameRenderer::State::normals(const NearestSurfaces& nearest) const {
    const glm::dmat3 enuFromStored =
        glm::transpose(ecefFromEnu(geodeticOf(last.camera.position)).axes()) * meshAxes();
    std::vector<float> values;
    for (std::size_t i = 0; i < nearest.viewDepth.size(); ++i) {
        const auto signedOf = [&](std::size_t c) {
            const double share = nearest.normals[4 * i + c] / 65535.0;
            return std::int16_t(std::lround((share * 2.0 - 1.0) * 32767.0));
        };
        const glm::dvec3 n = std::isinf(nearest.viewDepth[i])
                                 ? glm::dvec3(0.0)
                                 : enuFromStored * decodeOct({signedOf(0), signedOf(1)});
        values.insert(values.end(), {float(n.x), float(n.y), float(n.z)});
    }
    return values;
}

FloatPicture FrameRenderer::opaqueSun() {
    State& s = *state_;
    FloatPicture out{s.last.camera.widthPixels, s.last.camera.heightPixels, 1,
                     s.sun.readVisibility()};
    setSky(s.visibilityPass.readViewDepth(), out.values);
    return out;
}

std::vector<ResidentTile> FrameRenderer::residentTiles() const {
    return state_->residentTiles(state_->last.selections);
}

std::vector<ResidentTile>
FrameRenderer::State::residentTiles(const std::vector<Selection>& selections) const {
    std::vector<ResidentTile> tiles;
    if (groundContent)
        tiles.push_back({groundContent, 0});
    for (std::size_t layer = 0; layer < selections.size(); ++layer)
        for (const TileIndex index : selections[layer].draw)
            if (auto content = scene.layers[layer].tileset->content(index))
                if (const auto id = cache.idOf(layer, index))
                    tiles.push_back({std::move(content), *id});
    return tiles;
}

std::vector<std::vector<MeshId>> FrameRenderer::drawnCasters() const {
    const State& s = *state_;
    std::vector<std::vector<MeshId>> lists;
    for (const DrawnCasters& drawn : s.last.drawn) {
        std::vector<MeshId>& list = lists.emplace_back();
        for (std::size_t i = 0; i < drawn.size(); ++i)
            if (drawn[i])
                list.push_back(
                    {s.last.items[i].tileId,
                     std::uint32_t(s.last.items[i].mesh - s.last.items[i].tile->meshes().data())});
        std::sort(list.begin(), list.end());
    }
    return lists;
}

FloatPicture FrameRenderer::texels() {
    State& s = *state_;
    FloatPicture out{s.last.camera.widthPixels, s.last.camera.heightPixels, 1, {}};
    const std::vector<std::uint8_t> which = s.sun.readCascades();
    const std::vector<float> depth = s.visibilityPass.readViewDepth();
    const std::vector<Cascade>& cascades = s.last.cascades.cascades;
    const SeenSurfaces seen{s.last.surfaceCamera, s.meshAxes(), depth, {}};
    const SurfaceReader read(seen);
    const glm::dvec3 shift =
        glm::transpose(s.meshAxes()) * (s.last.surfaceCamera.position - s.last.camera.position).xyz;
    for (std::size_t i = 0; i < which.size(); ++i) {
        std::size_t c = which[i];
        if (c >= kFirstProjective && c - kFirstProjective < s.last.projective.size()) {
            const int x = int(i) % out.width, y = int(i) / out.width;
            out.values.push_back(
                float(texelMetres(s.last.projective[c - kFirstProjective], s.last.towardsSun,
                                  read.position(x, y) + shift)));
            continue;
        }
        if (c >= cascades.size()) {
            out.values.push_back(0.0f);
            continue;
        }
        // Where two are mixed, the coarser.
        if (depth[i] > cascades[c].blendStartMetres && c + 1 < cascades.size())
            ++c;
        out.values.push_back(float(cascades[c].texelMetres));
    }
    return out;
}

FloatPicture FrameRenderer::lampVisibility(std::size_t lamp) {
    State& s = *state_;
    if (auto shadow = s.lamps.shadowOf(s.visibilityPass, lamp))
        return {s.last.camera.widthPixels, s.last.camera.heightPixels, 1,
                std::move(shadow->visibility)};
    return {};
}

FloatPicture FrameRenderer::lampTexels(std::size_t lamp) {
    State& s = *state_;
    if (auto shadow = s.lamps.shadowOf(s.visibilityPass, lamp))
        return {s.last.camera.widthPixels, s.last.camera.heightPixels, 1,
                std::move(shadow->texelMetres)};
    return {};
}

const std::vector<std::string>& FrameRenderer::tileNames() const {
    return state_->cache.names();
}

} // namespace gnomon
