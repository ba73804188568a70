// The tree of a 3D Tiles 1.0/1.1 tileset: explicit children, external tilesets and implicit
// quadtree or octree subtrees, which grow the tree as they are read. No I/O here: bytes come in,
// nodes come out. What is wrong with one tile leaves that tile out and is kept in facts().leftOut;
// only a file that is no tileset at all, or a root that cannot be used, is an error.
#pragma once

#include "geo/bounds.h"
#include "geo/result.h"
#include "streaming/chunked_vector.h"
#include "streaming/content.h"
#include "streaming/curved_frame.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace gnomon {

using TileIndex = std::uint32_t;
inline constexpr TileIndex kNoTile = 0xffffffffu;
// A node takes about 400 bytes with its path, so a tree stays below 450 MB whatever its files say.
inline constexpr std::size_t kMaxTiles = std::size_t(1) << 20;
// Subtrees stop earlier: a file of a few bytes may tell of as many tiles as it likes.
inline constexpr std::size_t kMaxTilesOfSubtrees = kMaxTiles / 4 * 3;
// What one subtree file may add: a full quadtree of 10 levels is 349,525 tiles.
inline constexpr std::size_t kMaxTilesPerSubtree = std::size_t(1) << 19;
inline constexpr unsigned kMaxExternalDepth = 16;

enum class Refine : std::uint8_t { Add, Replace };

// What a tile's content uri leads to. Unknown until its bytes are there.
enum class ContentKind : std::uint8_t { None, Unknown, Mesh, ExternalTileset, Subtree };

enum class LoadState : std::uint8_t {
    Unloaded, // nothing asked for yet, or given up again
    Loading,
    Ready,  // content is in memory (or has none; or the external tileset or subtree is attached)
    Failed, // for good: left out, its siblings go on
};

struct TileNode {
    TileIndex parent = kNoTile;
    TileIndex firstChild = kNoTile; // children are consecutive
    std::uint32_t childCount = 0;
    TileIndex nextContent = kNoTile; // of several contents: the next, a childless node of its own
    std::uint32_t implicitTiling = kNoTile; // index into the tree's implicit tilings
    std::uint32_t transform = 0;            // index into the tree's transforms
    std::uint32_t document = 0;             // index into the tree's files
    std::uint16_t level = 0;                // stays at 65535 below that
    Refine refine = Refine::Replace;
    ContentKind content = ContentKind::None;
    LoadState state = LoadState::Unloaded;
    UpAxis gltfUpAxis = UpAxis::Y;
    double geometricErrorMetres = 0.0;
    BoundingVolume volume;                               // ECEF
    std::shared_ptr<const BoundingVolume> contentVolume; // ECEF; null when the file has none
    // ECEF; null when the file has none. The tile, and all below it, is there only for an eye
    // inside.
    std::shared_ptr<const BoundingVolume> viewerRequestVolume;
    std::string path; // of the content, resolved

    bool hasMesh() const { return content == ContentKind::Mesh || content == ContentKind::Unknown; }
    // The tree below is not known before this is loaded.
    bool isStructure() const {
        return content == ContentKind::ExternalTileset || content == ContentKind::Subtree;
    }
};

// A tile, or a content of one, that cannot be used. `tile` is kNoTile when it is not in the tree.
struct LeftOut {
    TileIndex tile = kNoTile;
    Error error;
};

struct TilesetFacts {
    std::string version, generator;
    std::vector<std::string> extensionsUsed, extensionsRequired;
    std::uint32_t subtrees = 0, externals = 0; // attached so far
    std::vector<std::string> warnings;         // lies that were put right
    std::vector<LeftOut> leftOut;
};

// What an external tileset takes over from the tile that refers to it.
struct Inherited {
    Transform<Ecef, Tile> ecefFromTile;
    UpAxis gltfUpAxis = UpAxis::Y;
    Refine refine = Refine::Replace;
    bool refineKnown = false;
    std::uint16_t level = 0;
    std::shared_ptr<const CurvedFrame> curved = {}; // then ecefFromTile is not asked
    glm::dmat4 curvedFromTile{1.0};
};

enum class Subdivision : std::uint8_t { Quadtree, Octree };
struct Subtree; // streaming/subtree.h
struct ImplicitTiling;

// A tile of a tree that is made, not read; see streaming/content_maker.h.
struct MadeTile {
    TileIndex parent = kNoTile; // an earlier one; kNoTile for the root, which is the first
    Refine refine = Refine::Replace;
    ContentKind content = ContentKind::Mesh; // None, Mesh or ExternalTileset (ContentMaker::below)
    double geometricErrorMetres = 0.0;
    BoundingVolume volume; // ECEF
    std::string path;      // what its maker knows it by; empty without content
};

// See tileset_json.cpp for the checks; every failure names the file it is about.
class TileTree {
  public:
    // `placement` puts the root's frame on the Earth; identity when the tileset is in ECEF already.
    static Result<TileTree> parse(std::span<const std::byte> json, const std::string& path,
                                  const TilePlacement& placement);
    static Result<TileTree> parseExternal(std::span<const std::byte> json, const std::string& path,
                                          const Inherited& inherited);
    // A single model as a tileset of one tile.
    static TileTree ofModel(const std::string& path, const BoundingVolume& volume,
                            const Transform<Ecef, Tile>& placement);

    // Children of one tile stand together, behind those of tiles before it. `name` stands for the
    // whole in messages.
    static Result<TileTree> ofTiles(const std::string& name, std::span<const MadeTile> tiles);

    const TileNode& node(TileIndex i) const { return nodes_[i]; }
    TileIndex size() const { return TileIndex(nodes_.size()); }
    static constexpr TileIndex root() { return 0; }
    const TilesetFacts& facts() const { return facts_; }
    // Something could not be attached because there are too many tiles already.
    bool isFull() const { return full_; }
    const Transform<Ecef, Tile>& ecefFromTile(TileIndex i) const {
        return transforms_[nodes_[i].transform];
    }
    // The content's path, or a description by file and place for a tile that has none.
    std::string name(TileIndex i) const;

    // The content of `tile` proved to be a tileset of its own: hang its root below.
    Inherited inheritedBy(TileIndex tile) const;
    Failure attachExternal(TileIndex tile, std::span<const std::byte> json);
    Failure attachExternal(TileIndex tile, TileTree external);

    // `tile` stands for a subtree file (ContentKind::Subtree): it becomes the subtree's root tile.
    Subdivision subdivision(TileIndex tile) const;
    unsigned subtreeLevels(TileIndex tile) const;
    Failure attachSubtree(TileIndex tile, const Subtree& subtree);

    void setState(TileIndex tile, LoadState state) { nodes_[tile].state = state; }
    void setContentKind(TileIndex tile, ContentKind kind) { nodes_[tile].content = kind; }

  private:
    struct Document {
        std::string path;
        std::uint32_t parent = kNoTile;
    };
    struct ImplicitCoordinates {
        std::uint32_t level = 0, x = 0, y = 0, z = 0;
    };
    ChunkedVector<TileNode> nodes_;
    std::vector<Transform<Ecef, Tile>> transforms_;
    std::shared_ptr<const CurvedFrame> curved_; // null: the transforms say all
    std::vector<glm::dmat4> curvedFromTile_;    // beside the transforms, where `curved_` is
    std::vector<Document> documents_;
    std::vector<std::shared_ptr<const ImplicitTiling>> implicitTilings_;
    std::unordered_map<TileIndex, ImplicitCoordinates> subtreeRoots_; // of subtrees not attached
    TilesetFacts facts_;
    bool full_ = false;
    friend struct TileTreeBuilder;
    friend struct SubtreeBuilder;
};

// "{level}/{x}_{y}.glb" with the numbers put in.
std::string fillTemplate(const std::string& text, std::uint32_t level, std::uint32_t x,
                         std::uint32_t y, std::uint32_t z);

} // namespace gnomon
