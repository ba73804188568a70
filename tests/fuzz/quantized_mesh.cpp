// One tile of a quantized mesh.
#include "tests/fuzz/fuzz.h"

#include "streaming/terrain/quantized_mesh_tile.h"

namespace gnomon::fuzz {

namespace {

void checkHeader(const QuantizedHeader& header) {
    // Centre and sphere are as in the file, and judged where they are used.
    demand(std::isfinite(header.minHeightMetres) && std::isfinite(header.maxHeightMetres) &&
               header.minHeightMetres <= header.maxHeightMetres,
           "heights are a range");
}

void checkAvailable(const std::optional<std::vector<TileRanges>>& levels) {
    if (!levels)
        return;
    demand(levels->size() <= 32, "levels there can be");
    for (const TileRanges& ranges : *levels)
        for (const TileRange& range : ranges)
            demand(range.startX <= range.endX && range.startY <= range.endY, "ranges go upwards");
}

void check(const QuantizedTile& tile) {
    checkHeader(tile.header);
    const std::size_t n = tile.u.size();
    demand(tile.v.size() == n && tile.height.size() == n, "three numbers a vertex");
    for (std::size_t i = 0; i < n; ++i)
        demand(tile.u[i] <= kQuantizedMost && tile.v[i] <= kQuantizedMost &&
                   tile.height[i] <= kQuantizedMost,
               "vertices lie in the tile");
    demand(tile.indices.size() % 3 == 0, "whole triangles");
    for (const std::uint32_t index : tile.indices)
        demand(index < n, "an index names a vertex");
    demand(tile.normals.empty() || tile.normals.size() == n, "no normals or one a vertex");
    demand(tile.edgeVertices <= 4 * n + 4, "sides are made of the tile's vertices");
    checkAvailable(tile.availableBelow);
    demand(!tile.geometricErrorMetres ||
               (std::isfinite(*tile.geometricErrorMetres) && *tile.geometricErrorMetres >= 0),
           "a geometric error is a length");
    for (const std::string& warning : tile.warnings)
        demandReadable(warning);
}

} // namespace

void fuzzOne(Span bytes) {
    if (const auto tile = decodeQuantizedTile(bytes, "9/1/2.terrain"))
        check(*tile);
    else
        demandReadable(tile.error());
    if (const auto summary = readQuantizedSummary(bytes, "9/1/2.terrain")) {
        checkHeader(summary->header);
        checkAvailable(summary->availableBelow);
    } else {
        demandReadable(summary.error());
    }
}

} // namespace gnomon::fuzz
