#include "viewer/open_made.h"

#include "streaming/features/barriers.h"
#include "streaming/features/trees.h"

#include <algorithm>
#include <set>

namespace gnomon {

namespace {

void sayOf(const Input& input, const std::vector<std::string>& notes,
           const std::vector<std::string>& credits, Opening& opening) {
    if (!input.guess.empty())
        opening.note(input.uri, input.guess);
    for (const std::string& note : notes)
        opening.note(input.uri, note);
    opening.credits.insert(opening.credits.end(), credits.begin(), credits.end());
}

void sayOf(const Input& input, const FeatureFile& file, Opening& opening) {
    sayOf(input, file.notes, file.credits, opening);
    for (const Error& error : file.leftOut)
        opening.leftOut(error);
}

Result<OpenedLayer> layerOf(const Input& input, const LayerFacts& facts, const MadeTileset& made,
                            Opening& opening) {
    auto tileset = StreamedTileset::ofMade(made, input.uri, opening.loader);
    if (!tileset)
        return tileset.error();
    OpenedLayer opened;
    opened.layer.uri = input.uri;
    opened.layer.kind = nameOf(input.kind);
    opened.layer.heights = facts.heights.value_or(Heights::Ellipsoidal);
    opened.bounds = boundingSphere((*tileset)->tree().node(TileTree::root()).volume);
    opened.layer.tileset = std::move(*tileset);
    return opened;
}

Result<OpenedLayer> standingLayer(const Input& input, const LayerFacts& facts,
                                  const MadeTileset& made, Opening& opening) {
    Result<OpenedLayer> opened = layerOf(input, facts, made, opening);
    if (!opened || opening.unplaced)
        return opened;
    const auto heights = heightsOf(*opened->layer.tileset, opened->bounds.centre, opening);
    if (!heights)
        return heights.error();
    opened->heights = *heights;
    return opened;
}

Ground holeIn(const Ground& terrain, const std::string& path, Opening& opening) {
    const Result<FeatureFile> file = readFeatures(path, {});
    if (!file) {
        opening.leftOut(file.error());
        return nullptr;
    }
    std::vector<std::vector<glm::dvec2>> rings;
    for (const Feature& feature : file->features)
        for (const FeaturePart& part : feature.parts)
            for (const FeatureRing& ring : part) {
                std::vector<glm::dvec2>& flat = rings.emplace_back();
                for (const glm::dvec3& vertex : ring)
                    flat.emplace_back(vertex);
            }
    return groundWithin(terrain, std::move(rings));
}

} // namespace

FeatureOptions featureOptions(const LayerFacts& facts) {
    return {facts.crs, facts.heights.value_or(Heights::Ellipsoidal),
            facts.raiseMetres.value_or(0.0)};
}

Result<OpenedTerrain> openTerrain(const Input& input, const LayerFacts& facts, Opening& opening) {
    TerrainOptions options;
    options.crs = facts.crs;
    options.heights = facts.heights.value_or(Heights::Ellipsoidal);
    options.raiseMetres = facts.raiseMetres.value_or(0.0);
    options.look = facts.look.value_or(TerrainLook::Plain);
    options.variable = facts.variable;
    if (opening.progress)
        options.progress = [&](double share) { opening.progress(input.uri, share); };
    const bool isMesh = input.path.ends_with(".terrain") || input.path.ends_with(".json");
    auto terrain = input.source ? openQuantizedMesh(input.source, input.path, options)
                   : isMesh     ? openQuantizedMesh(input.path, options)
                                : Terrain::open(input.path, options);
    if (!terrain)
        return terrain.error();
    const TerrainFacts& found = (*terrain)->facts();
    sayOf(input, found.notes, found.credits, opening);
    if (facts.placement)
        opening.warn(input.uri, "it has its own place on the Earth; --place is not applied to it");
    OpenedTerrain opened{input, facts, std::move(*terrain), nullptr};
    if (facts.hole)
        opened.hole = holeIn(opened.terrain, *facts.hole, opening);
    return opened;
}

std::vector<Result<OpenedLayer>> terrainLayers(std::vector<OpenedTerrain> terrains,
                                               const std::vector<Scene::Painted>& drapes,
                                               Opening& opening) {
    std::vector<std::shared_ptr<const Drape>> paint;
    for (const Scene::Painted& painted : drapes)
        paint.push_back(painted.drape);
    std::stable_sort(terrains.begin(), terrains.end(),
                     [](const OpenedTerrain& a, const OpenedTerrain& b) {
                         return a.terrain->facts().cellMetres < b.terrain->facts().cellMetres;
                     });
    std::vector<Result<OpenedLayer>> layers;
    std::vector<Ground> above;
    for (const OpenedTerrain& opened : terrains) {
        const TerrainFacts& facts = opened.terrain->facts();
        std::vector<Ground> over = above;
        if (opened.hole)
            over.push_back(opened.hole);
        Result<OpenedLayer> layer =
            layerOf(opened.input, opened.facts, opened.terrain->tiles(over, paint), opening);
        if (layer) {
            layer->layer.terrain = opened.terrain;
            layer->layer.crs = facts.crs;
            layer->layer.size = {facts.columns, facts.rows};
            layer->heights = {facts.minHeightMetres, facts.maxHeightMetres};
        }
        layers.push_back(std::move(layer));
        above.push_back(opened.terrain);
    }
    return layers;
}

Result<Scene::Painted> openImagery(const Input& input, const LayerFacts& facts, Opening& opening) {
    DrapeOptions options;
    options.crs = facts.crs;
    if (facts.color)
        options.color = *facts.color;
    std::vector<std::string> notes;
    auto drape = openDrape(input.path, options, notes);
    sayOf(input, notes, {}, opening);
    if (!drape)
        return drape.error();
    return Scene::Painted{input.uri, std::move(*drape)};
}

Result<OpenedLayer> openBuildings(const Input& input, const LayerFacts& facts, const Ground& ground,
                                  Opening& opening) {
    auto buildings = Buildings::open(
        input.path, {featureOptions(facts), facts.heightMetres, facts.heightAttribute}, ground);
    if (!buildings)
        return buildings.error();
    sayOf(input, (*buildings)->file(), opening);
    Result<OpenedLayer> opened = standingLayer(input, facts, (*buildings)->tiles(), opening);
    if (opened) {
        opened->layer.crs = (*buildings)->file().crs;
        opened->layer.buildings = std::move(*buildings);
    }
    return opened;
}

Result<OpenedLayer> openTrees(const Input& input, const LayerFacts& facts, const Ground& ground,
                              Opening& opening) {
    auto trees = Trees::open(input.path, {featureOptions(facts), facts.heightMetres}, ground);
    if (!trees)
        return trees.error();
    sayOf(input, trees->file, opening);
    Result<OpenedLayer> opened = standingLayer(input, facts, trees->tiles, opening);
    if (opened)
        opened->layer.crs = trees->file.crs;
    return opened;
}

Result<std::vector<OpenedLayer>> openBarriers(const Input& input, const LayerFacts& facts,
                                              const Ground& ground, Opening& opening) {
    auto barriers = Barriers::open(
        input.path,
        {featureOptions(facts), facts.heightMetres, facts.widthMetres, facts.from, facts.until},
        ground);
    if (!barriers)
        return barriers.error();
    sayOf(input, barriers->file, opening);
    std::vector<OpenedLayer> layers;
    for (const BarrierGroup& group : barriers->groups) {
        Result<OpenedLayer> opened = standingLayer(input, facts, group.tiles, opening);
        if (!opened)
            return opened.error();
        opened->layer.crs = barriers->file.crs;
        opened->layer.from = group.from;
        opened->layer.until = group.until;
        layers.push_back(std::move(*opened));
    }
    return layers;
}

Result<WaterLayer> openWater(const Input& input, const LayerFacts& facts, const Ground& ground,
                             Opening& opening) {
    FloodOptions options;
    options.kind = input.waterKind ? input.waterKind : facts.waterKind;
    options.variable = facts.variable;
    options.crs = facts.crs;
    options.heights = facts.heights.value_or(Heights::Ellipsoidal);
    options.raiseMetres = facts.raiseMetres.value_or(0.0);
    options.start = facts.start;
    options.stepSeconds = facts.stepSeconds;
    std::vector<std::string> paths{input.path};
    paths.insert(paths.end(), input.steps.begin(), input.steps.end());
    auto data = openFlood(paths, options);
    if (!data)
        return data.error();
    WaterSurfaceOptions surfaceOptions;
    if (facts.dryMetres)
        surfaceOptions.dryMetres = *facts.dryMetres;
    auto surface = WaterSurface::create(*data, ground, surfaceOptions);
    const FloodData& flood = surface ? (*surface)->data() : **data;
    sayOf(input, flood.notes, flood.credits, opening);
    for (const Error& error : flood.leftOut)
        opening.leftOut(error);
    if (!surface)
        return surface.error();
    WaterLayer layer;
    layer.uri = input.uri;
    layer.kind = flood.kind() == WaterKind::Depth ? "depth" : "stage";
    layer.surface = std::move(*surface);
    layer.heights = options.heights;
    layer.look = {facts.colors.value_or(WaterColors::Depth), facts.most};
    if (layer.look.colors == WaterColors::Speed && !flood.hasVelocity()) {
        opening.warn(input.uri, "it holds no velocities, so it is coloured by depth");
        layer.look.colors = WaterColors::Depth;
    }
    return layer;
}

} // namespace gnomon
