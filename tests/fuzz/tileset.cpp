// tileset.json, and what hangs below it: further parts of the input, after zero bytes, are attached
// as external tilesets and subtrees, and the tree that results is selected from.
// words: streaming/tileset*.cpp streaming/implicit.cpp streaming/subtree.cpp
#include "tests/fuzz/tree_promises.h"

#include "streaming/json_text.h"
#include "streaming/subtree.h"

namespace gnomon::fuzz {

namespace {

constexpr std::size_t kMostTiles = 20000; // larger trees are slow, not different
constexpr std::size_t kMostAttached = 12;

void attach(TileTree& tree, TileIndex tile, Span part) {
    if (tree.node(tile).content == ContentKind::Subtree) {
        auto subtree = parseSubtree(part, tree.node(tile).path, tree.subdivision(tile),
                                    tree.subtreeLevels(tile), {});
        if (!subtree) {
            demandReadable(subtree.error());
            return;
        }
        if (const Failure failure = tree.attachSubtree(tile, *subtree))
            demandReadable(*failure);
    } else if (const Failure failure = tree.attachExternal(tile, part)) {
        demandReadable(*failure);
    }
}

} // namespace

void fuzzOne(Span bytes) {
    const std::vector<Span> parts = partsOf(bytes);
    if (sniffJson(parts[0]) == JsonKind::Gltf)
        return; // the loader takes it for a model
    auto tree = TileTree::parse(parts[0], "a/b/tileset.json", {});
    if (!tree) {
        demandReadable(tree.error());
        return;
    }
    checkTree(*tree);
    std::size_t attached = 0;
    for (TileIndex tile = 0; tile < tree->size() && attached < kMostAttached; ++tile) {
        const TileNode& node = tree->node(tile);
        if (node.content == ContentKind::None || node.content == ContentKind::Mesh ||
            node.state != LoadState::Unloaded || tree->size() > kMostTiles)
            continue;
        // Also itself: a cycle must end by itself.
        attach(*tree, tile, parts[attached++ % parts.size()]);
    }
    checkTree(*tree);
    if (tree->size() <= kMostTiles)
        checkSelection(*tree);
}

} // namespace gnomon::fuzz
