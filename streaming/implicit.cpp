#include "streaming/implicit.h"

#include "streaming/source.h"
#include "streaming/subtree.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace gnomon {
namespace {

BoundingVolume boxPart(const OrientedBox& root, const glm::dvec3& centre, const glm::dvec3& half) {
    OrientedBox part;
    part.centre = {root.centre.xyz + root.halfAxes * centre};
    for (int axis = 0; axis < 3; ++axis)
        part.halfAxes[axis] = root.halfAxes[axis] * half[axis];
    return part;
}

BoundingVolume regionPart(const Region& root, const glm::dvec3& from, const glm::dvec3& to) {
    double width = root.eastDegrees - root.westDegrees;
    if (width < 0.0)
        width += 360.0;
    const auto longitude = [&](double share) {
        const double degrees = root.westDegrees + share * width;
        return degrees > 180.0 ? degrees - 360.0 : degrees;
    };
    const auto between = [](double a, double b, double share) { return a + share * (b - a); };
    return makeRegion(longitude(from.x), between(root.southDegrees, root.northDegrees, from.y),
                      longitude(to.x), between(root.southDegrees, root.northDegrees, to.y),
                      between(root.minHeightMetres, root.maxHeightMetres, from.z),
                      between(root.minHeightMetres, root.maxHeightMetres, to.z));
}

struct Coordinates {
    std::uint32_t x = 0, y = 0, z = 0;
};

// The lowest bit of x, y (and z) each comes from the lowest bits of the Morton index.
Coordinates fromMorton(std::uint64_t morton, unsigned levels, unsigned dimensions) {
    Coordinates c;
    for (unsigned level = 0; level < levels; ++level) {
        c.x |= std::uint32_t((morton >> (dimensions * level)) & 1) << level;
        c.y |= std::uint32_t((morton >> (dimensions * level + 1)) & 1) << level;
        if (dimensions == 3)
            c.z |= std::uint32_t((morton >> (dimensions * level + 2)) & 1) << level;
    }
    return c;
}

} // namespace

BoundingVolume implicitVolume(const BoundingVolume& rootVolume, Subdivision subdivision,
                              std::uint32_t level, std::uint32_t x, std::uint32_t y,
                              std::uint32_t z) {
    const bool splitsHeight = subdivision == Subdivision::Octree;
    const double share = std::ldexp(1.0, -int(level));
    const glm::dvec3 from(x * share, y * share, splitsHeight ? z * share : 0.0);
    const glm::dvec3 size(share, share, splitsHeight ? share : 1.0);
    if (const auto* region = std::get_if<Region>(&rootVolume))
        return level == 0 ? rootVolume : regionPart(*region, from, from + size);
    const auto& box = std::get<OrientedBox>(rootVolume);
    return boxPart(box, 2.0 * from + size - 1.0, size);
}

std::string fillTemplate(const std::string& text, std::uint32_t level, std::uint32_t x,
                         std::uint32_t y, std::uint32_t z) {
    std::string out;
    out.reserve(text.size() + 16);
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t open = text.find('{', i);
        const std::size_t close = open == std::string::npos ? open : text.find('}', open);
        if (close == std::string::npos)
            return out.append(text, i);
        out.append(text, i, open - i);
        const std::string_view name = std::string_view(text).substr(open + 1, close - open - 1);
        if (name == "level")
            out += std::to_string(level);
        else if (name == "x")
            out += std::to_string(x);
        else if (name == "y")
            out += std::to_string(y);
        else if (name == "z")
            out += std::to_string(z);
        else
            out.append(text, open, close - open + 1);
        i = close + 1;
    }
    return out;
}

// Every tile holds a template filled in, so where those are long there may be fewer.
static std::size_t mostTiles(const ImplicitTiling& tiling) {
    constexpr std::size_t kBytesATile = 512; // with a path of ordinary length
    constexpr std::size_t kNumbers = 40;     // four of them
    std::size_t longest = tiling.subtreeUri.size();
    for (const std::string& uri : tiling.contentUris)
        longest = std::max(longest, uri.size());
    longest += tiling.documentPath.size() + kNumbers;
    return kMaxTilesOfSubtrees * kBytesATile / std::max(kBytesATile, sizeof(TileNode) + longest);
}

// Turns one placeholder into the tiles of its subtree.
struct SubtreeBuilder {
    TileTree& tree;
    const Subtree& subtree;
    TileIndex rootTile;
    TileTree::ImplicitCoordinates at; // of the subtree's root
    std::shared_ptr<const ImplicitTiling> tiling;
    const unsigned children, dimensions;

    SubtreeBuilder(TileTree& t, const Subtree& s, TileIndex tile)
        : tree(t), subtree(s), rootTile(tile), at(t.subtreeRoots_.at(tile)),
          tiling(t.implicitTilings_[t.nodes_[tile].implicitTiling]),
          children(childrenOf(tiling->subdivision)),
          dimensions(tiling->subdivision == Subdivision::Octree ? 3 : 2) {}

    Coordinates absolute(unsigned depth, std::uint64_t morton) const {
        const Coordinates local = fromMorton(morton, depth, dimensions);
        return {(at.x << depth) + local.x, (at.y << depth) + local.y, (at.z << depth) + local.z};
    }

    // The part's volume; in a curved frame with a transform of its own.
    void setVolume(TileNode& node, std::uint32_t level, const Coordinates& c) {
        const bool curved = tree.curved_ && tiling->flatVolume &&
                            !std::holds_alternative<Region>(*tiling->flatVolume);
        BoundingVolume part = implicitVolume(curved ? *tiling->flatVolume : tiling->rootVolume,
                                             tiling->subdivision, level, c.x, c.y, c.z);
        const auto near =
            curved ? tree.curved_->near(middleOf(part)) : Result<Transform<Ecef, Tile>>(Error{});
        if (near) {
            const glm::dmat4 curvedFromTile = tree.curvedFromTile_[node.transform];
            node.transform = std::uint32_t(tree.transforms_.size());
            tree.transforms_.push_back({near->matrix * curvedFromTile});
            tree.curvedFromTile_.push_back(curvedFromTile);
            node.volume = curvedVolume(*tree.curved_, *near, part);
        } else { // also where the projection ends: then by the root's map
            node.volume = curved ? implicitVolume(tiling->rootVolume, tiling->subdivision, level,
                                                  c.x, c.y, c.z)
                                 : std::move(part);
        }
    }

    TileNode makeNode(TileIndex parent, unsigned depth, const Coordinates& c) {
        const TileNode& root = tree.nodes_[rootTile];
        const std::uint32_t level = at.level + depth;
        TileNode node;
        node.parent = parent;
        node.implicitTiling = root.implicitTiling;
        node.transform = root.transform;
        node.document = root.document;
        node.level = std::uint16_t(std::min<std::uint32_t>(root.level + depth, 0xffffu));
        node.refine = root.refine;
        node.gltfUpAxis = root.gltfUpAxis;
        node.geometricErrorMetres = std::ldexp(tiling->rootGeometricErrorMetres, -int(level));
        setVolume(node, level, c);
        return node;
    }

    // Puts a content into `tile`, or into a node of its own behind it.
    void addContent(TileIndex tile, const std::string& uriTemplate, unsigned depth,
                    const Coordinates& c) {
        const std::string uri = fillTemplate(uriTemplate, at.level + depth, c.x, c.y, c.z);
        Result<std::string> path = resolveUri(tiling->documentPath, uri);
        TileIndex holder = tile;
        if (tree.nodes_[tile].content != ContentKind::None) {
            TileNode extra = tree.nodes_[tile];
            extra.parent = tile;
            extra.firstChild = kNoTile;
            extra.childCount = 0;
            holder = TileIndex(tree.nodes_.size());
            tree.nodes_[tile].nextContent = holder;
            tree.nodes_.push_back(std::move(extra));
        }
        TileNode& node = tree.nodes_[holder];
        node.content = ContentKind::Mesh;
        node.state = path ? LoadState::Unloaded : LoadState::Failed;
        node.path = path ? std::move(*path) : uri;
        if (!path)
            tree.facts_.leftOut.push_back({holder, path.error()});
    }

    void fillTile(TileIndex tile, unsigned depth, std::uint64_t indexInSubtree,
                  const Coordinates& c) {
        tree.nodes_[tile].content = ContentKind::None;
        tree.nodes_[tile].state = LoadState::Ready;
        tree.nodes_[tile].path.clear();
        const std::size_t n = std::min(tiling->contentUris.size(), subtree.contents.size());
        for (std::size_t i = 0; i < n; ++i)
            if (subtree.contents[i][indexInSubtree] && !tiling->contentUris[i].empty())
                addContent(tile, tiling->contentUris[i], depth, c);
    }

    void addPlaceholder(TileIndex parent, const Coordinates& c) {
        const std::uint32_t level = at.level + tiling->subtreeLevels;
        const TileIndex tile = TileIndex(tree.nodes_.size());
        TileNode node = makeNode(parent, tiling->subtreeLevels, c);
        const std::string uri = fillTemplate(tiling->subtreeUri, level, c.x, c.y, c.z);
        Result<std::string> path = resolveUri(tiling->documentPath, uri);
        node.content = ContentKind::Subtree;
        node.state = path ? LoadState::Unloaded : LoadState::Failed;
        node.path = path ? std::move(*path) : uri;
        if (!path)
            tree.facts_.leftOut.push_back({tile, path.error()});
        tree.nodes_.push_back(std::move(node));
        tree.subtreeRoots_[tile] = {level, c.x, c.y, c.z};
    }

    struct Placed {
        std::uint64_t morton;
        TileIndex tile;
    };

    // The children of one tile, side by side. Contents come after them, since a second content of
    // a tile is a node too.
    void addChildren(const Placed& parent, unsigned depth, std::uint64_t firstOfLevel,
                     std::vector<Placed>& placed) {
        const bool isPlaceholder = depth == tiling->subtreeLevels;
        const std::size_t before = placed.size();
        const TileIndex first = TileIndex(tree.nodes_.size());
        for (unsigned child = 0; child < children; ++child) {
            const std::uint64_t morton = parent.morton * children + child;
            if (isPlaceholder ? !subtree.children[morton] : !subtree.tiles[firstOfLevel + morton])
                continue;
            const Coordinates c = absolute(depth, morton);
            if (isPlaceholder) {
                addPlaceholder(parent.tile, c);
            } else {
                placed.push_back({morton, TileIndex(tree.nodes_.size())});
                tree.nodes_.push_back(makeNode(parent.tile, depth, c));
            }
        }
        const auto count = std::uint32_t(tree.nodes_.size() - first);
        tree.nodes_[parent.tile].firstChild = count ? first : kNoTile;
        tree.nodes_[parent.tile].childCount = count;
        for (std::size_t i = before; i < placed.size(); ++i)
            fillTile(placed[i].tile, depth, firstOfLevel + placed[i].morton,
                     absolute(depth, placed[i].morton));
    }

    // A subtree without any content has no availability of contents either. Said once a tileset.
    void checkContents() {
        const std::size_t told = subtree.contents.size(), named = tiling->contentUris.size();
        if (told == 0 || told == named)
            return;
        const std::string warning = tiling->documentPath + ": a tile names " +
                                    std::to_string(named) + " contents, its subtrees tell of " +
                                    std::to_string(told);
        auto& all = tree.facts_.warnings;
        if (std::find(all.begin(), all.end(), warning) == all.end())
            all.push_back(warning);
    }

    void build() {
        tree.subtreeRoots_.erase(rootTile);
        checkContents();
        if (!subtree.tiles[0]) {
            tree.nodes_[rootTile].content = ContentKind::None;
            tree.nodes_[rootTile].state = LoadState::Ready;
            tree.facts_.warnings.push_back(tree.nodes_[rootTile].path +
                                           ": the subtree's own root tile is not available");
            tree.nodes_[rootTile].path.clear();
            return;
        }
        fillTile(rootTile, 0, 0, absolute(0, 0));
        std::vector<Placed> level{{0, rootTile}};
        std::uint64_t firstOfLevel = 0, tilesOfLevel = 1;
        for (unsigned depth = 1; depth <= tiling->subtreeLevels; ++depth) {
            if (at.level + depth >= tiling->availableLevels)
                break;
            firstOfLevel += tilesOfLevel;
            tilesOfLevel *= children;
            std::vector<Placed> next;
            for (const Placed& parent : level)
                addChildren(parent, depth, firstOfLevel, next);
            level = std::move(next);
        }
    }
};

Subdivision TileTree::subdivision(TileIndex tile) const {
    return implicitTilings_[nodes_[tile].implicitTiling]->subdivision;
}

unsigned TileTree::subtreeLevels(TileIndex tile) const {
    return implicitTilings_[nodes_[tile].implicitTiling]->subtreeLevels;
}

Failure TileTree::attachSubtree(TileIndex tile, const Subtree& subtree) {
    const std::string path = nodes_[tile].path;
    if (nodes_[tile].content != ContentKind::Subtree || !subtreeRoots_.count(tile))
        return Error{path, "is not a subtree that is waited for", ErrorKind::Input};
    SubtreeBuilder builder(*this, subtree, tile);
    const auto size = subtreeSize(builder.tiling->subdivision, builder.tiling->subtreeLevels);
    assert(size); // checked when the tiling was read
    std::uint64_t more = subtree.tiles.available(size->tiles);
    for (const Availability& content : subtree.contents) // at worst a node for each content
        more += content.available(size->tiles);
    more += subtree.children.available(size->children);
    if (more > kMaxTilesPerSubtree)
        return Error{path,
                     "tells of " + std::to_string(more) + " tiles and contents; at most " +
                         std::to_string(kMaxTilesPerSubtree) + " are accepted in one subtree",
                     ErrorKind::Input};
    const std::size_t most = mostTiles(*builder.tiling);
    full_ = full_ || nodes_.size() + more > most;
    if (nodes_.size() + more > most)
        return Error{path, "the tileset has more than " + std::to_string(most) + " tiles",
                     ErrorKind::Input};
    builder.build();
    ++facts_.subtrees;
    return std::nullopt;
}

} // namespace gnomon
