// The tree of a 3D Tiles 1.0/1.1 tileset: explicit children, external tilesets and implicit quadtree
// subtrees, which grow the tree as they are read. No I/O here: bytes come in, nodes come out.
#pragma once

#include "geo/bounds.h"
#include "geo/result.h"
#include "streaming/content.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

using TileIndex = std::uint32_t;
inline constexpr TileIndex kNoTile = 0xffffffffu;

enum class Refine { Add, Replace };

// What a tile's content uri leads to. Unknown until its bytes are there.
enum class ContentKind { None, Unknown, Mesh, ExternalTileset, Subtree };

enum class LoadState {
    Unloaded, // nothing asked for yet, or given up again
    Loading,
    Ready,  // content is in memory (or has none; or the external tileset or subtree is attached)
    Failed, // for good: left out, its siblings go on
};

struct TileNode {
    TileIndex parent = kNoTile;
    TileIndex firstChild = kNoTile; // children are consecutive
    std::uint32_t childCount = 0;
    std::uint16_t level = 0;
    Refine refine = Refine::Replace;
    ContentKind content = ContentKind::None;
    LoadState state = LoadState::Unloaded;
    double geometricErrorMetres = 0.0;
    BoundingVolume volume;                 // ECEF
    std::optional<BoundingVolume> contentVolume;
    Transform<Ecef, Tile> ecefFromTile;    // product of all transforms down to here
    UpAxis gltfUpAxis = UpAxis::Y;
    std::string path;                      // of the content, resolved; empty when none
    std::uint32_t implicitRoot = kNoTile;  // index into the tree's implicit tilings, kNoTile if none

    bool hasMesh() const {
        return content == ContentKind::Mesh || content == ContentKind::Unknown;
    }
};

struct TilesetFacts {
    std::string version, generator;
    std::vector<std::string> extensionsUsed, extensionsRequired;
    std::uint32_t subtrees = 0, externals = 0;
    std::vector<std::string> warnings;
};

// See tileset.cpp for the methods' checks; every failure names the file it is about.
class TileTree {
  public:
    // `placement` puts the root's frame on the Earth; identity when the tileset is in ECEF already.
    static Result<TileTree> parse(std::span<const std::byte> json, const std::string& path,
                                  const Transform<Ecef, Tile>& placement);

    const TileNode& node(TileIndex i) const { return nodes_[i]; }
    TileIndex size() const { return TileIndex(nodes_.size()); }
    static constexpr TileIndex root() { return 0; }
    const TilesetFacts& facts() const { return facts_; }

    // The content of `tile` proved to be a tileset of its own: hang its root below.
    Failure attachExternal(TileIndex tile, std::span<const std::byte> json);
    // `tile` stands for a subtree file (ContentKind::Subtree): replace it by the tiles it tells of.
    Failure attachSubtree(TileIndex tile, std::span<const std::byte> bytes);
    void setState(TileIndex tile, LoadState state) { nodes_[tile].state = state; }
    void setContentKind(TileIndex tile, ContentKind kind) { nodes_[tile].content = kind; }

  private:
    struct Implicit;
    std::vector<TileNode> nodes_;
    std::vector<std::shared_ptr<Implicit>> implicits_;
    TilesetFacts facts_;
    friend struct TileTreeBuilder;
};

} // namespace gnomon
