#include "streaming/terrain/terrain_patch.h"

#include <glm/common.hpp>

#include <cmath>

namespace gnomon {

namespace {

// The grid's lines through the tile, and the heights on them.
Failure sample(const TerrainScene& scene, const TileName& name, TerrainPatch& patch,
               PixelLines& lines) {
    const TerrainData& data = *scene.data;
    const int level = std::max(name.level, 0);
    const LevelGrid grid = data.levels.at(level);
    const int cells = TerrainScene::cellsOf(name.level);
    const glm::ivec2 first = name.tile * cells;
    const glm::ivec2 all(grid.across.cells(), grid.down.cells());
    patch.cells = glm::min(first + cells, all) - first;
    patch.before = glm::ivec2(first.x > 0, first.y > 0);
    patch.after = glm::ivec2(first.x + patch.cells.x < all.x, first.y + patch.cells.y < all.y);
    const glm::ivec2 from = first - patch.before;
    const glm::ivec2 count = patch.cells + 1 + patch.before + patch.after;
    patch.heights.resize(std::size_t(count.x) * std::size_t(count.y));
    if (const Failure wrong = data.samples->read(level, from, count, patch.heights))
        return wrong;
    const auto lay = [](const LevelAxis& axis, int start, int number, int before, int inner,
                        std::vector<double>& at, std::vector<bool>& exact) {
        for (int i = 0; i < number; ++i) {
            at.push_back(axis.position(start + i));
            exact.push_back(i == before || i == before + inner);
        }
    };
    lay(grid.across, from.x, count.x, patch.before.x, patch.cells.x, lines.columns,
        lines.exactColumn);
    lay(grid.down, from.y, count.y, patch.before.y, patch.cells.y, lines.rows, lines.exactRow);
    patch.columns = lines.columns;
    patch.rows = lines.rows;
    return {};
}

void takeAbove(const TerrainScene& scene, const TileName& name, TerrainPatch& patch) {
    const GeographicBox box = scene.boxOf(name.level, name.tile);
    std::vector<glm::dvec2> lonLat;
    std::vector<double> heights;
    for (const auto& ground : scene.above) {
        const auto* terrain = dynamic_cast<const Terrain*>(ground.get());
        if (terrain != nullptr && !overlap(terrain->facts().extent, box))
            continue;
        if (lonLat.empty()) {
            for (const PlacedPixel& p : patch.places)
                lonLat.push_back(p.lonLat());
            patch.covered.assign(lonLat.size(), 0);
            heights.resize(lonLat.size());
        }
        ground->sample(lonLat, heights);
        for (std::size_t i = 0; i < lonLat.size(); ++i)
            if (!patch.covered[i] && !std::isnan(heights[i]) &&
                !std::isnan(patch.places[i].heightMetres)) {
                patch.covered[i] = 1;
                patch.places[i].heightMetres = heights[i];
            }
    }
}

} // namespace

bool TerrainPatch::draws(glm::ivec2 a, glm::ivec2 b, glm::ivec2 c) const {
    if (!has(a.x, a.y) || !has(b.x, b.y) || !has(c.x, c.y))
        return false;
    return covered.empty() ||
           !(covered[index(a.x, a.y)] && covered[index(b.x, b.y)] && covered[index(c.x, c.y)]);
}

glm::dvec3 TerrainPatch::normal(int column, int row) const {
    const PlacedPixel& own = places[index(column, row)];
    const auto along = [&](glm::ivec2 step) {
        const glm::ivec2 at(column, row);
        const glm::ivec2 ahead = at + step, behind = at - step;
        const bool hasAhead = has(ahead.x, ahead.y), hasBehind = has(behind.x, behind.y);
        const bool level = !hasAhead && !hasBehind; // alone: as if the ground went on flat
        const auto end = [&](glm::ivec2 p, bool there) {
            if (!inside(p.x, p.y) || !(there || level))
                return positions[index(column, row)];
            const std::size_t other = index(p.x, p.y);
            return there ? positions[other] : places[other].ecefAt(own.heightMetres).xyz;
        };
        return end(ahead, hasAhead) - end(behind, hasBehind);
    };
    const glm::dvec3 n = glm::cross(along({1, 0}), along({0, 1}));
    const double size = glm::length(n);
    if (!(size > 0.0))
        return own.up;
    return glm::dot(n, own.up) < 0.0 ? -n / size : n / size;
}

Result<TerrainPatch> makePatch(const TerrainScene& scene, const TileName& name) {
    TerrainPatch patch;
    PixelLines lines;
    if (const Failure wrong = sample(scene, name, patch, lines))
        return *wrong;
    Result<std::vector<PlacedPixel>> places = scene.data->place->at(lines, patch.heights);
    if (!places)
        return places.error();
    patch.places = std::move(*places);
    if (!scene.above.empty())
        takeAbove(scene, name, patch);
    patch.positions.reserve(patch.places.size());
    for (const PlacedPixel& place : patch.places)
        patch.positions.push_back(place.ecef().xyz);
    return patch;
}

} // namespace gnomon
