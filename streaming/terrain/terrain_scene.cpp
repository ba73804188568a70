#include "streaming/terrain/terrain_data.h"

#include <glm/common.hpp>

#include <cmath>
#include <cstdio>

namespace gnomon {

namespace {

// Textures of tiles: 4 MB at most, and as sharp as the drape where a tile is small enough.
constexpr int kMostTexels = 1024;
// Polygons have no pixels of their own: their edges are drawn as fine as this share of a cell.
constexpr double kPolygonTexelCells = 0.25;
// A texel this much too large is taken for the drape's own.
constexpr double kGenerous = 1.5;

} // namespace

double TerrainData::heightError(int level, const TileHeights& heights) const {
    if (level <= 0)
        return 0.0;
    // A chord of length d lies d² / 8R below the ellipsoid; the longest is a cell's diagonal.
    const double cell = cellMetres(level);
    return double(heights.error) + 2.0 * cell * cell / (8.0 * kPolarRadiusMetres);
}

double TerrainData::heightError(int level, glm::ivec2 tile) const {
    if (level <= 0)
        return 0.0;
    const TileHeights* heights = known(level, tile);
    TileHeights usual;
    if (heights == nullptr)
        usual.error = float(usualError[std::size_t(level)]);
    return heightError(level, heights != nullptr ? *heights : usual);
}

bool overlap(const GeographicBox& a, const GeographicBox& b) {
    if (a[1] > b[3] || b[1] > a[3])
        return false;
    const double aEast = a[2] < a[0] ? a[2] + 360.0 : a[2];
    const double bEast = b[2] < b[0] ? b[2] + 360.0 : b[2];
    for (const double turn : {-360.0, 0.0, 360.0})
        if (a[0] + turn <= bEast && b[0] <= aEast + turn)
            return true;
    return false;
}

HeightLevels::Span TerrainScene::span(int level, glm::ivec2 tile) const {
    if (level >= 0)
        return data->levels.span(level, tile);
    const int cells = cellsOf(level);
    const glm::ivec2 most = data->levels.pixels - 1;
    return {glm::min(tile * cells, most), glm::min((tile + 1) * cells, most)};
}

GeographicBox TerrainScene::boxOf(int level, glm::ivec2 tile) const {
    const HeightLevels::Span s = span(level, tile);
    const glm::dvec2 first(s.first), size(s.last - s.first);
    GeographicBox box{0, 0, 0, 0};
    double middle = 0.0, west = 0.0, east = 0.0;
    bool any = false;
    constexpr int kSides = 4;
    for (int j = 0; j <= kSides; ++j)
        for (int i = 0; i <= kSides; ++i) {
            const glm::dvec2 share(double(i) / kSides, double(j) / kSides);
            const Result<PlacedPixel> place = data->place->at(first + share * size, 0.0);
            if (!place)
                continue;
            const glm::dvec2 p = place->lonLat();
            if (!any) {
                middle = p.x;
                box[1] = box[3] = p.y;
            }
            any = true;
            const double off = std::remainder(p.x - middle, 360.0);
            west = std::min(west, off);
            east = std::max(east, off);
            box[1] = std::min(box[1], p.y);
            box[3] = std::max(box[3], p.y);
        }
    // Sides bulge between these points; a tenth of the tile is far more than they do.
    const double slackX = 0.1 * (east - west), slackY = 0.1 * (box[3] - box[1]);
    if (east - west + 2.0 * slackX >= 360.0)
        return {-180.0, box[1] - slackY, 180.0, box[3] + slackY};
    return {middle + west - slackX, box[1] - slackY, middle + east + slackX, box[3] + slackY};
}

bool TerrainScene::isDraped(const GeographicBox& box) const {
    for (const auto& drape : drapes)
        if (overlap(box, drape->extent()))
            return true;
    return false;
}

TerrainScene::Texels TerrainScene::texelsOf(int level, glm::ivec2 tile) const {
    const HeightLevels::Span s = span(level, tile);
    const GeographicBox box = boxOf(level, tile);
    double finest = std::numeric_limits<double>::infinity();
    for (const auto& drape : drapes)
        if (overlap(box, drape->extent()))
            finest = std::min(finest, drape->texelMetres());
    if (!(finest > 0.0) || std::isinf(finest))
        finest = kPolygonTexelCells * data->longerCellMetres;
    const Result<PlacedPixel> corner = data->place->at(glm::dvec2(s.first), 0.0);
    const Result<PlacedPixel> across = data->place->at({s.last.x, s.first.y}, 0.0);
    const Result<PlacedPixel> down = data->place->at({s.first.x, s.last.y}, 0.0);
    const auto metres = [&](const Result<PlacedPixel>& to) {
        return corner && to ? length(to->ecef() - corner->ecef()) : 0.0;
    };
    Texels out;
    const glm::dvec2 sides(metres(across), metres(down));
    for (int axis = 0; axis < 2; ++axis) {
        out.count[axis] =
            int(std::clamp(std::ceil(sides[axis] / finest) + 1.0, 2.0, double(kMostTexels)));
        out.metres = std::max(out.metres, sides[axis] / (out.count[axis] - 1));
    }
    out.coarse = out.metres > kGenerous * finest;
    return out;
}

std::string nameOf(int level, glm::ivec2 tile) {
    return std::to_string(level) + "/" + std::to_string(tile.x) + "/" + std::to_string(tile.y);
}

std::optional<TileName> tileNamed(const TerrainScene& scene, const std::string& path) {
    TileName name;
    int end = 0;
    if (std::sscanf(path.c_str(), "%d/%d/%d%n", &name.level, &name.tile.x, &name.tile.y, &end) !=
            3 ||
        std::size_t(end) != path.size())
        return std::nullopt;
    const HeightLevels& levels = scene.data->levels;
    if (name.level < TerrainScene::kLowestLevel || name.level > levels.top())
        return std::nullopt;
    const int parts = name.level < 0 ? 1 << -name.level : 1;
    const glm::ivec2 count = levels.tiles(std::max(name.level, 0)) * parts;
    if (name.tile.x < 0 || name.tile.y < 0 || name.tile.x >= count.x || name.tile.y >= count.y)
        return std::nullopt;
    const HeightLevels::Span span = scene.span(name.level, name.tile);
    if (span.first.x >= span.last.x || span.first.y >= span.last.y)
        return std::nullopt;
    return name;
}

} // namespace gnomon
