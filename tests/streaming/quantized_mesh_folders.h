// Folders of quantized meshes with a layer.json, and what is shown of them.
#pragma once

#include "streaming/loader.h"
#include "streaming/terrain/quantized_mesh_scene.h"
#include "tests/streaming/quantized_mesh_support.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <set>

namespace gnomon {

// Smooth on the scale of all tiles here, and different everywhere.
inline double hills(double lon, double lat) {
    return 300.0 + 200.0 * std::sin(lon * 0.05) * std::cos(lat * 0.04) + 0.5 * lon + lat;
}

using Tiles = std::set<std::array<std::uint32_t, 3>>;

// Ranges of one tile each, by level.
inline std::string availableOf(const Tiles& tiles) {
    std::string levels;
    unsigned deepest = 0;
    for (const auto& t : tiles)
        deepest = std::max(deepest, t[0]);
    for (unsigned level = 0; level <= deepest; ++level) {
        levels += level ? ",[" : "[";
        bool first = true;
        for (const auto& [z, x, y] : tiles)
            if (z == level) {
                levels += std::string(first ? "" : ",") + "{\"startX\":" + std::to_string(x) +
                          ",\"endX\":" + std::to_string(x) + ",\"startY\":" + std::to_string(y) +
                          ",\"endY\":" + std::to_string(y) + "}";
                first = false;
            }
        levels += "]";
    }
    return "[" + levels + "]";
}

inline std::string layerText(const std::string& more) {
    return "{\"tilejson\":\"2.1.0\",\"format\":\"quantized-mesh-1.0\",\"version\":\"1.1.0\","
           "\"tiles\":[\"{z}/{x}/{y}.terrain?v={version}\"]," +
           more + "}";
}

struct PyramidSpec {
    bool webMercator = false, fromNorth = false, packed = false;
    int side = 8;
    HeightOf height = hills;
    std::function<void(const QuantizedPlace&, PlainTile&)> change;
};

inline void writeTiles(const std::string& folder, const Tiles& tiles,
                       const PyramidSpec& spec = {}) {
    for (const auto& [z, x, y] : tiles) {
        const QuantizedPlace place{z, x, y};
        PlainTile tile = gridTile(extentOf(place, spec.webMercator), spec.side, spec.height);
        if (spec.change)
            spec.change(place, tile);
        const std::uint32_t row = spec.fromNorth ? (1u << z) - 1 - y : y;
        const Bytes bytes = written(tile);
        writeFile(folder + "/" + std::to_string(z) + "/" + std::to_string(x) + "/" +
                      std::to_string(row) + ".terrain",
                  spec.packed ? gzipped(bytes) : bytes);
    }
}

// Levels 0 and 1 whole, one tile of level 1 with only two of its four below.
inline const Tiles kSparse = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {1, 2, 0}, {1, 3, 0},
                              {1, 0, 1}, {1, 1, 1}, {1, 2, 1}, {1, 3, 1}, {2, 4, 2}, {2, 5, 3}};

inline std::shared_ptr<const Terrain> opened(const std::string& path,
                                             const TerrainOptions& options = {}) {
    auto terrain = openQuantizedMesh(path, options);
    EXPECT_TRUE(terrain) << (terrain ? "" : terrain.error().message());
    return terrain ? *terrain : nullptr;
}

inline std::string refusal(const std::string& path) {
    const auto terrain = openQuantizedMesh(path, {});
    return terrain ? "was opened" : terrain.error().message();
}

// Everything as fine as it gets.
struct Shown {
    std::unique_ptr<StreamedTileset> tileset;
    std::vector<std::string> paths; // of the tiles drawn
    std::vector<std::shared_ptr<const TileContent>> contents;
    bool complete = false;
};

inline Shown shown(const MadeTileset& made, double pixelMetres = 1e-3) {
    Shown out;
    auto tileset = StreamedTileset::ofMade(made, "terrain", {});
    EXPECT_TRUE(tileset);
    out.tileset = std::move(*tileset);
    View view;
    view.eye = {{0, 0, 1e9}};
    view.forward = {{0, 0, -1}};
    view.pixelMetres = pixelMetres;
    const Settled settled = settle(*out.tileset, std::span(&view, 1), {1.0, false},
                                   std::chrono::steady_clock::now() + std::chrono::seconds(60));
    out.complete = settled.complete;
    for (const TileIndex tile : settled.selection.drawDepthFirst)
        if (const auto content = out.tileset->content(tile)) {
            out.paths.push_back(out.tileset->tree().node(tile).path);
            out.contents.push_back(content);
        }
    std::sort(out.paths.begin(), out.paths.end());
    return out;
}

// Square degrees that the ground covers, by its triangles without skirts.
inline double squareDegrees(const std::vector<std::shared_ptr<const TileContent>>& contents) {
    double sum = 0.0;
    for (const auto& content : contents)
        for (const Mesh& mesh : content->meshes)
            for (std::size_t i = 0; i < 3 * (mesh.triangles() - mesh.skirtTriangles); i += 3) {
                glm::dvec2 p[3];
                for (std::size_t k = 0; k < 3; ++k) {
                    const Geodetic g = geodeticOf(
                        {mesh.origin.xyz + glm::dvec3(mesh.positions[mesh.indices[i + k]])});
                    p[k] = {k == 0 ? g.longitudeDegrees
                                   : p[0].x + std::remainder(g.longitudeDegrees - p[0].x, 360.0),
                            g.latitudeDegrees};
                    // All longitudes meet at a pole; a triangle's corner there has none of its own.
                    if (std::abs(g.latitudeDegrees) > 89.9999999)
                        return std::nan("");
                }
                const glm::dvec2 a = p[1] - p[0], b = p[2] - p[0];
                sum += 0.5 * (a.x * b.y - a.y * b.x);
            }
    return sum;
}

} // namespace gnomon
