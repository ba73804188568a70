#include "streaming/tileset.h"

#include "streaming/http/url.h"
#include "streaming/implicit.h"

#include <algorithm>
#include <cassert>

namespace gnomon {
namespace {

// Of very many files each may be wrong in very many ways: what is told of all of them together.
constexpr std::size_t kMostNames = 100, kMostWarnings = 1000, kMostLeftOut = 10'000;

void unite(std::vector<std::string>& to, const std::vector<std::string>& from) {
    for (const std::string& name : from)
        if (to.size() < kMostNames && std::find(to.begin(), to.end(), name) == to.end())
            to.push_back(name);
}

// Indices of a tree that is hung into another.
std::uint32_t shifted(std::uint32_t index, std::size_t by) {
    return index == kNoTile ? kNoTile : std::uint32_t(index + by);
}

} // namespace

TileTree TileTree::ofModel(const std::string& path, const BoundingVolume& volume,
                           const Transform<Ecef, Tile>& placement) {
    TileTree tree;
    tree.documents_.push_back({path, kNoTile});
    tree.transforms_.push_back(placement);
    TileNode node;
    node.content = ContentKind::Mesh;
    node.volume = volume;
    node.path = path;
    tree.nodes_.push_back(std::move(node));
    return tree;
}

Result<TileTree> TileTree::ofTiles(const std::string& name, std::span<const MadeTile> tiles) {
    const auto refused = [&](const std::string& why) { return Error{name, why}; };
    if (tiles.empty())
        return refused("there is nothing to make tiles of");
    if (tiles.size() > kMaxTiles)
        return refused("it would take more than " + std::to_string(kMaxTiles) + " tiles");
    TileTree tree;
    tree.documents_.push_back({name, kNoTile});
    tree.transforms_.push_back({});
    for (std::size_t i = 0; i < tiles.size(); ++i) {
        const MadeTile& made = tiles[i];
        TileNode node;
        node.content = made.content;
        node.refine = made.refine;
        node.geometricErrorMetres = made.geometricErrorMetres;
        node.volume = made.volume;
        node.path = made.path;
        node.parent = made.parent;
        if (i > 0) {
            assert(made.parent < i);
            TileNode& parent = tree.nodes_[made.parent];
            if (parent.childCount == 0)
                parent.firstChild = TileIndex(i);
            assert(parent.firstChild + parent.childCount == i);
            ++parent.childCount;
            node.level = std::uint16_t(std::min(parent.level + 1, 0xffff));
        }
        tree.nodes_.push_back(std::move(node));
    }
    return tree;
}

std::string TileTree::name(TileIndex i) const {
    const TileNode& node = nodes_[i];
    if (!node.path.empty())
        return textWithoutSecrets(node.path);
    return textWithoutSecrets(documents_[node.document].path) + ", tile " + std::to_string(i);
}

Inherited TileTree::inheritedBy(TileIndex tile) const {
    const TileNode& node = nodes_[tile];
    Inherited inherited{transforms_[node.transform], node.gltfUpAxis, node.refine, true,
                        node.level};
    if (curved_) {
        inherited.curved = curved_;
        inherited.curvedFromTile = curvedFromTile_[node.transform];
    }
    return inherited;
}

Failure TileTree::attachExternal(TileIndex tile, std::span<const std::byte> json) {
    Result<TileTree> external = parseExternal(json, nodes_[tile].path, inheritedBy(tile));
    if (!external)
        return external.error();
    return attachExternal(tile, std::move(*external));
}

Failure TileTree::attachExternal(TileIndex tile, TileTree external) {
    const std::string path = nodes_[tile].path;
    const auto refused = [&](const std::string& why) { return Error{path, why, ErrorKind::Input}; };
    unsigned depth = 0;
    for (std::uint32_t d = nodes_[tile].document; d != kNoTile; d = documents_[d].parent) {
        if (documents_[d].path == path)
            return refused("is an external tileset that contains itself");
        if (++depth > kMaxExternalDepth)
            return refused("external tilesets are nested deeper than " +
                           std::to_string(kMaxExternalDepth));
    }
    assert(external.curved_ == curved_); // by inheritedBy()
    if (nodes_[tile].childCount)
        return refused("is a tileset, but the tile has children of its own");
    full_ = full_ || nodes_.size() + external.nodes_.size() > kMaxTiles;
    if (nodes_.size() + external.nodes_.size() > kMaxTiles)
        return refused("the tileset has more than " + std::to_string(kMaxTiles) + " tiles");

    const std::size_t tiles = nodes_.size(), transforms = transforms_.size();
    const std::size_t documents = documents_.size(), tilings = implicitTilings_.size();
    for (std::size_t i = 0; i < external.nodes_.size(); ++i) {
        TileNode& node = external.nodes_[i];
        node.parent = node.parent == kNoTile ? tile : shifted(node.parent, tiles);
        node.firstChild = shifted(node.firstChild, tiles);
        node.nextContent = shifted(node.nextContent, tiles);
        node.implicitTiling = shifted(node.implicitTiling, tilings);
        node.transform = shifted(node.transform, transforms);
        node.document = shifted(node.document, documents);
        nodes_.push_back(std::move(node));
    }
    for (Document& document : external.documents_) {
        document.parent = document.parent == kNoTile ? nodes_[tile].document
                                                     : shifted(document.parent, documents);
        documents_.push_back(std::move(document));
    }
    transforms_.insert(transforms_.end(), external.transforms_.begin(), external.transforms_.end());
    curvedFromTile_.insert(curvedFromTile_.end(), external.curvedFromTile_.begin(),
                           external.curvedFromTile_.end());
    implicitTilings_.insert(implicitTilings_.end(), external.implicitTilings_.begin(),
                            external.implicitTilings_.end());
    for (const auto& [placeholder, at] : external.subtreeRoots_)
        subtreeRoots_[shifted(placeholder, tiles)] = at;
    for (LeftOut& leftOut : external.facts_.leftOut)
        if (facts_.leftOut.size() < kMostLeftOut)
            facts_.leftOut.push_back({shifted(leftOut.tile, tiles), std::move(leftOut.error)});
    unite(facts_.extensionsUsed, external.facts_.extensionsUsed);
    unite(facts_.extensionsRequired, external.facts_.extensionsRequired);
    for (std::string& warning : external.facts_.warnings)
        if (facts_.warnings.size() < kMostWarnings)
            facts_.warnings.push_back(std::move(warning));
    ++facts_.externals;

    nodes_[tile].content = ContentKind::ExternalTileset;
    nodes_[tile].state = LoadState::Ready;
    nodes_[tile].firstChild = TileIndex(tiles);
    nodes_[tile].childCount = 1;
    return std::nullopt;
}

} // namespace gnomon
