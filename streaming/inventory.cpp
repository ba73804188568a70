#include "streaming/inventory.h"

#include <algorithm>

namespace gnomon {
namespace {

// Contents decoded at a time, so that memory stays small whatever the tileset's size.
constexpr std::size_t kWindow = 32;
constexpr std::chrono::milliseconds kPatience(1000);
constexpr std::size_t kMostProperties = 1000; // of a class: nobody reads more

// The shortest way round that covers both; heights and latitudes simply.
Region united(const Region& a, const Region& b) {
    const auto width = [](double west, double east) {
        return east < west ? east - west + 360.0 : east - west;
    };
    const double aWidth = width(a.westDegrees, a.eastDegrees);
    const double bWidth = width(b.westDegrees, b.eastDegrees);
    const double fromA = std::max(aWidth, width(a.westDegrees, b.westDegrees) + bWidth);
    const double fromB = std::max(bWidth, width(b.westDegrees, a.westDegrees) + aWidth);
    double west = fromA <= fromB ? a.westDegrees : b.westDegrees;
    const double span = std::min(fromA, fromB);
    double east = west + span;
    if (span >= 360.0) {
        west = -180.0;
        east = 180.0;
    } else if (east > 180.0) {
        east -= 360.0;
    }
    return makeRegion(west, std::min(a.southDegrees, b.southDegrees), east,
                      std::max(a.northDegrees, b.northDegrees),
                      std::min(a.minHeightMetres, b.minHeightMetres),
                      std::max(a.maxHeightMetres, b.maxHeightMetres));
}

void unite(std::optional<Region>& to, const std::optional<Region>& from) {
    if (from)
        to = to ? united(*to, *from) : *from;
}

// What is kept of a content until all are there: results must not depend on the order of arrival.
struct Found {
    ContentFacts facts;
    std::optional<Region> bounds;
    std::size_t bytes = 0;
    std::vector<FeatureClass> classes;
};

Found examine(const TileContent& content) {
    Found found{content.facts, std::nullopt, content.bytes(), {}};
    if (content.features)
        found.classes = content.features->classes();
    for (const Mesh& mesh : content.meshes)
        unite(found.bounds, geographicExtent(BoundingVolume(mesh.box)));
    return found;
}

std::vector<LoadRequest> requests(std::span<const TileIndex> tiles) {
    std::vector<LoadRequest> out;
    for (const TileIndex tile : tiles)
        out.push_back({tile, double(out.size())});
    return out;
}

// Decodes `tiles` on the workers, a few at a time.
void decodeAll(StreamedTileset& tileset, std::span<const TileIndex> tiles,
               std::map<TileIndex, Found>& found, const Progress& progress, std::size_t total) {
    std::vector<TileIndex> pending(tiles.begin(), tiles.end());
    std::size_t next = 0;
    std::vector<TileIndex> window;
    while (next < pending.size() || !window.empty()) {
        while (next < pending.size() && window.size() < kWindow)
            window.push_back(pending[next++]);
        tileset.request(requests(window));
        tileset.wait(kPatience);
        tileset.poll();
        std::erase_if(window, [&](TileIndex tile) {
            const LoadState state = tileset.tree().node(tile).state;
            if (state == LoadState::Unloaded || state == LoadState::Loading)
                return false;
            if (const auto content = tileset.content(tile))
                found[tile] = examine(*content);
            tileset.release(tile);
            return true;
        });
        if (progress)
            progress(found.size(), total);
    }
}

void add(Inventory& inventory, const std::string& name, const Found& found) {
    const ContentFacts& facts = found.facts;
    ++inventory.contents[facts.format];
    inventory.triangles += facts.triangles;
    inventory.duplicates += facts.duplicates;
    inventory.degenerate += facts.degenerate;
    inventory.invalid += facts.invalid;
    inventory.closedTriangles += facts.closedTriangles;
    inventory.components += facts.components;
    inventory.closedComponents += facts.closedComponents;
    inventory.decodedBytes += found.bytes;
    inventory.areaVector += facts.areaVector;
    inventory.extensions.insert(facts.extensions.begin(), facts.extensions.end());
    if (!facts.copyright.empty())
        inventory.copyrights.insert(facts.copyright);
    for (const std::string& warning : facts.warnings)
        inventory.warnings.push_back(name + ": " + warning);
    unite(inventory.bounds, found.bounds);
    for (const FeatureClass& one : found.classes) {
        Inventory::Features& features = inventory.features[one.name];
        features.rows += one.rows;
        for (const std::string& property : one.properties)
            if (features.properties.size() < kMostProperties &&
                std::find(features.properties.begin(), features.properties.end(), property) ==
                    features.properties.end())
                features.properties.push_back(property);
    }
}

} // namespace

Failure expandAll(StreamedTileset& tileset) {
    const TileTree& tree = tileset.tree();
    TileIndex seen = 0; // nodes below are settled: structure only ever comes after
    std::vector<TileIndex> open;
    for (;;) {
        for (; seen < tree.size(); ++seen)
            if (tree.node(seen).isStructure())
                open.push_back(seen);
        std::erase_if(open, [&](TileIndex tile) {
            const TileNode& node = tree.node(tile);
            return !node.isStructure() || node.state == LoadState::Ready ||
                   node.state == LoadState::Failed;
        });
        if (open.empty())
            return std::nullopt;
        // An attached subtree's root may be one content more, never structure again.
        tileset.request(requests(open));
        tileset.waitForAll(); // the whole round at once: the same tree every time
        tileset.poll();
        if (tree.isFull())
            return Error{tileset.path(), "has too many tiles to look at them all"};
    }
}

Inventory takeInventory(StreamedTileset& tileset, const Progress& progress) {
    const TileTree& tree = tileset.tree();
    Inventory inventory;
    std::map<TileIndex, Found> found;
    TileIndex seen = 0;
    // A content whose name does not tell may turn out to be one more tileset: then go on.
    do {
        if (const Failure failure = expandAll(tileset))
            inventory.failures.push_back({kNoTile, *failure, false});
        std::vector<TileIndex> todo;
        for (; seen < tree.size(); ++seen) {
            if (!tree.node(seen).hasMesh())
                continue;
            if (const auto content = tileset.content(seen))
                found[seen] = examine(*content);
            else
                todo.push_back(seen);
        }
        decodeAll(tileset, todo, found, progress, found.size() + todo.size());
    } while (seen < tree.size());

    for (const auto& [tile, content] : found)
        add(inventory, tree.name(tile), content);
    for (TileIndex i = 0; i < tree.size(); ++i) {
        inventory.levels = std::max<std::uint32_t>(inventory.levels, tree.node(i).level + 1u);
        inventory.refine.insert(tree.node(i).refine);
    }
    inventory.tiles = tree.size();
    inventory.subtrees = tree.facts().subtrees;
    inventory.externals = tree.facts().externals;
    inventory.extensions.insert(tree.facts().extensionsUsed.begin(),
                                tree.facts().extensionsUsed.end());
    inventory.warnings.insert(inventory.warnings.begin(), tree.facts().warnings.begin(),
                              tree.facts().warnings.end());
    std::vector<FailedTile> failures = tileset.failures();
    std::stable_sort(failures.begin(), failures.end(),
                     [](const FailedTile& a, const FailedTile& b) { return a.tile < b.tile; });
    inventory.failures.insert(inventory.failures.end(), failures.begin(), failures.end());
    return inventory;
}

} // namespace gnomon
