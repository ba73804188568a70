// What a tree of tiles promises to those who walk it without looking.
#pragma once

#include "tests/fuzz/fuzz.h"

#include "streaming/selection.h"
#include "streaming/tileset.h"

namespace gnomon::fuzz {

inline void checkNode(const TileTree& tree, TileIndex i) {
    const TileNode& node = tree.node(i);
    if (i == TileTree::root())
        demand(node.parent == kNoTile, "the root has no parent");
    else
        demand(node.parent < i, "parents come before their children");
    demand(node.childCount == 0 ||
               (node.firstChild < tree.size() && node.childCount <= tree.size() - node.firstChild),
           "children are in the tree");
    for (TileIndex c = 0; c < node.childCount; ++c) {
        demand(node.firstChild + c > i, "children come after their parent");
        demand(tree.node(node.firstChild + c).parent == i, "children know their parent");
    }
    demand(std::isfinite(node.geometricErrorMetres) && node.geometricErrorMetres >= 0.0,
           "a geometric error is a length");
    demand(isSound(node.volume) && (!node.contentVolume || isSound(*node.contentVolume)),
           "volumes are finite");
    demand(isFinite(tree.ecefFromTile(i).origin().xyz) &&
               isFinite(tree.ecefFromTile(i).axes()[0]) &&
               isFinite(tree.ecefFromTile(i).axes()[1]) && isFinite(tree.ecefFromTile(i).axes()[2]),
           "transforms are finite");
    // One that could not be resolved keeps its uri, to be named, and is never read.
    demand(node.content == ContentKind::None || node.state == LoadState::Failed ||
               staysInside(node.path),
           "a content's path stays inside the folder");
    demandReadable(tree.name(i));
}

// Chains of further contents end, and no two share a node.
inline void checkContents(const TileTree& tree) {
    std::vector<bool> followed(tree.size());
    for (TileIndex i = 0; i < tree.size(); ++i) {
        const TileIndex next = tree.node(i).nextContent;
        if (next == kNoTile)
            continue;
        demand(next < tree.size() && !followed[next], "a further content belongs to one tile");
        followed[next] = true;
        demand(tree.node(next).childCount == 0, "a further content has no children");
    }
    std::size_t inChains = 0, chained = 0;
    for (TileIndex i = 0; i < tree.size(); ++i) {
        inChains += followed[i];
        for (TileIndex c = followed[i] ? kNoTile : tree.node(i).nextContent; c != kNoTile;
             c = tree.node(c).nextContent)
            ++chained;
    }
    demand(inChains == chained, "a chain of contents is no ring");
}

inline void checkTree(const TileTree& tree) {
    demand(tree.size() >= 1 && tree.size() <= kMaxTiles, "a tree has 1 to kMaxTiles tiles");
    checkContents(tree);
    std::size_t children = 0;
    for (TileIndex i = 0; i < tree.size(); ++i) {
        checkNode(tree, i);
        children += tree.node(i).childCount;
    }
    demand(children < tree.size(), "every tile hangs in one place");
    for (const std::string& warning : tree.facts().warnings)
        demandReadable(warning);
    for (const LeftOut& leftOut : tree.facts().leftOut) {
        demand(leftOut.tile == kNoTile || leftOut.tile < tree.size(), "left out of this tree");
        demandReadable(leftOut.error);
    }
}

inline void checkAscending(const std::vector<TileIndex>& tiles, const TileTree& tree) {
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        demand(tiles[i] < tree.size(), "a selected tile is in the tree");
        demand(i == 0 || tiles[i - 1] < tiles[i], "selected once, in order");
    }
}

inline void checkSelection(const TileTree& tree) {
    View everything;
    everything.eye = boundingSphere(tree.node(TileTree::root()).volume).centre;
    everything.forward = {{1, 0, 0}};
    everything.pixelsPerRadian = 1e6;
    View some = everything;
    some.eye.xyz += glm::dvec3(100, 20, 3);
    some.planes = {{{{0, 0, 1}}, some.eye}, {{{0.6, 0.8, 0}}, some.eye}};
    some.pixelsPerRadian = 500;
    View light;
    light.forward = {{0, 0, -1}};
    light.pixelMetres = 0.5;
    const std::vector<View> views = {everything, some, light};
    for (std::size_t n = 1; n <= views.size(); ++n) {
        const Selection selection = select(tree, std::span(views).first(n), {16.0, n == 2});
        checkAscending(selection.draw, tree);
        checkAscending(selection.wanted, tree);
        checkAscending(selection.failed, tree);
        demand(selection.visited <= n * tree.size() + n, "no tile is looked at twice a view");
        demand(selection.drawDepthFirst.size() == selection.draw.size(), "one order, another");
        std::vector<TileIndex> load;
        for (const LoadRequest& request : selection.load) {
            demand(!std::isnan(request.priority), "a priority can be compared");
            load.push_back(request.tile);
        }
        std::sort(load.begin(), load.end());
        checkAscending(load, tree);
    }
}

} // namespace gnomon::fuzz
