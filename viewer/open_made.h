// Opens the layers that are made from what people hold: terrain, imagery, buildings, trees,
// barriers, water.
#pragma once

#include "viewer/open_tileset.h"

namespace gnomon {

struct OpenedTerrain {
    Input input;
    LayerFacts facts;
    std::shared_ptr<const Terrain> terrain;
    std::shared_ptr<const GroundHeights> hole; // where other ground is shown; may be null
};
// From a raster, or from a quantized mesh.
Result<OpenedTerrain> openTerrain(const Input& input, const LayerFacts& facts, Opening& opening);
// The finest on top, where several overlap; `drapes` are painted on all of them.
std::vector<Result<OpenedLayer>> terrainLayers(std::vector<OpenedTerrain> terrains,
                                               const std::vector<Scene::Painted>& drapes,
                                               Opening& opening);

Result<Scene::Painted> openImagery(const Input& input, const LayerFacts& facts, Opening& opening);

FeatureOptions featureOptions(const LayerFacts& facts);

// On `ground`.
using Ground = std::shared_ptr<const GroundHeights>;
Result<OpenedLayer> openBuildings(const Input& input, const LayerFacts& facts, const Ground& ground,
                                  Opening& opening);
Result<OpenedLayer> openTrees(const Input& input, const LayerFacts& facts, const Ground& ground,
                              Opening& opening);
// A layer for each time that some stand over.
Result<std::vector<OpenedLayer>> openBarriers(const Input& input, const LayerFacts& facts,
                                              const Ground& ground, Opening& opening);
Result<WaterLayer> openWater(const Input& input, const LayerFacts& facts, const Ground& ground,
                             Opening& opening);

} // namespace gnomon
