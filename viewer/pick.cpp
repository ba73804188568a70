#include "viewer/pick.h"

#include "streaming/raycast.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// A pixel's depth is that of its middle, in float; a triangle seen at a grazing angle runs through
// much depth within what rounding may turn the ray by.
double toleranceMetres(double depthMetres) {
    return 0.01 + 1e-3 * depthMetres;
}

} // namespace

std::optional<Picked> pick(const Camera& camera, const PixelFacts& pixel,
                           const std::vector<ResidentTile>& tiles, const glm::dmat3& meshAxes) {
    if (!std::isfinite(pixel.depthMetres) || pixel.depthMetres < 0.0) {
        return {};
    }
    const double x = 2.0 * pixel.x / std::max(camera.widthPixels, 1) - 1.0;
    const double y = 1.0 - 2.0 * pixel.y / std::max(camera.heightPixels, 1);
    const Vector<Ecef> ray = camera.forward + x * camera.tanHalfWidth() * camera.right +
                             y * camera.tanHalfHeight() * camera.up;
    Picked picked;
    picked.tile = pixel.tile;
    picked.at = camera.position + pixel.depthMetres * ray;
    const auto tile = std::find_if(tiles.begin(), tiles.end(),
                                   [&](const ResidentTile& one) { return one.id == pixel.tile; });
    if (tile == tiles.end() || !tile->content) {
        return picked;
    }
    const double far = pixel.depthMetres * length(ray);
    const auto off = [&](const RayHit& hit) { return std::abs(hit.metres - far); };
    const auto hits = castRay(*tile->content, meshAxes, camera.position, normalize(ray));
    const auto nearest =
        std::min_element(hits.begin(), hits.end(),
                         [&](const RayHit& a, const RayHit& b) { return off(a) < off(b); });
    // The depth may be that of water before the tile.
    const auto behind = std::find_if(hits.begin(), hits.end(), [&](const RayHit& hit) {
        return hit.metres >= far - toleranceMetres(far);
    });
    const bool isSurface = nearest != hits.end() && off(*nearest) <= toleranceMetres(far);
    const auto hit = isSurface ? nearest : behind;
    if (hit == hits.end()) {
        return picked;
    }
    picked.feature = hit->feature;
    const auto& features = tile->content->features;
    if (features && picked.feature < features->rows()) {
        picked.properties = features->row(picked.feature);
        picked.id = idOf(picked.properties, picked.feature);
    }
    return picked;
}

std::optional<Picked> pick(FrameRenderer& renderer, const Camera& camera, int x, int y) {
    const FloatPicture tiles = renderer.aov(Aov::Tile), depths = renderer.aov(Aov::Depth);
    if (x < 0 || y < 0 || x >= tiles.width || y >= tiles.height || depths.width != tiles.width ||
        depths.height != tiles.height) {
        return {};
    }
    const std::size_t i = std::size_t(y) * std::size_t(tiles.width) + std::size_t(x);
    const PixelFacts pixel{x + 0.5, y + 0.5, std::uint32_t(tiles.values[i]),
                           double(depths.values[i])};
    return pick(camera, pixel, renderer.residentTiles(), renderer.meshAxes());
}

} // namespace gnomon
