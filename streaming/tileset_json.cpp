// tileset.json to nodes. Neither reading nor building recurses, so a file nested a hundred thousand
// tiles deep needs no more stack than a flat one.
#include "streaming/implicit.h"
#include "streaming/json_text.h"
#include "streaming/source.h"
#include "streaming/subtree.h"
#include "streaming/tileset.h"
#include "streaming/tileset_values.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

using namespace tilesetjson;

namespace {

// Beyond these a file's flaws are counted, not named one by one.
constexpr std::size_t kMaxWarnings = 100;
constexpr std::size_t kMaxLeftOut = 1000;

} // namespace

struct TileTreeBuilder {
    TileTree& tree;
    const std::string& path;

    // A tile, or one that was left out, by its place in the file.
    struct Place {
        TileIndex parent = kNoTile;
        std::uint32_t ordinal = 0;
    };
    struct Work {
        const json* value;
        TileIndex tile;
    };
    struct Content {
        std::string path;
        ContentKind kind = ContentKind::None;
        std::shared_ptr<const BoundingVolume> volume;
        std::optional<Error> error;
    };
    struct Above { // what a tile takes over
        std::uint32_t transform = 0;
        Refine refine = Refine::Replace;
        bool refineKnown = false;
        std::optional<double> geometricErrorMetres;
        UpAxis gltfUpAxis = UpAxis::Y;
        std::uint16_t level = 0;
    };
    std::vector<Place> places; // of the tiles in the tree, by index
    std::vector<Work> work;
    std::size_t dropped = 0; // warnings beyond kMaxWarnings
    std::size_t unnamed = 0; // tiles left out beyond kMaxLeftOut

    // "root.children[1].children[0]"; of a very deep tile its beginning is cut.
    std::string describe(Place place) const {
        constexpr int kShownLevels = 12;
        std::string text;
        for (int n = 0; place.parent != kNoTile; ++n, place = places[place.parent]) {
            if (n == kShownLevels)
                return std::string("root....").append(text, 1);
            text.insert(0, std::string(".children[").append(std::to_string(place.ordinal)) + "]");
        }
        return std::string("root") + text;
    }
    std::string subject(const Place& place) const { return path + ": " + describe(place); }

    void warn(const Place& place, const std::string& what) {
        if (tree.facts_.warnings.size() < kMaxWarnings)
            tree.facts_.warnings.push_back(subject(place) + ": " + what);
        else
            ++dropped;
    }
    Error refused(const Place& place, const std::string& why) const {
        return {subject(place), why, ErrorKind::Input};
    }
    void leaveOut(TileIndex tile, Error error) {
        if (tree.facts_.leftOut.size() < kMaxLeftOut)
            tree.facts_.leftOut.push_back({tile, std::move(error)});
        else
            ++unnamed;
    }

    // The tile's volume as the curved frame has it.
    Result<BoundingVolume> flatVolume(const json* value, const glm::dmat4& curvedFromTile) {
        return readVolume(value, Transform<Ecef, Tile>{curvedFromTile});
    }

    // Of a tile in a curved frame: by the map that touches it in the middle of the tile.
    Result<std::uint32_t> curvedTransform(const json& value, const Place& place,
                                          const glm::dmat4& curvedFromTile, std::uint32_t above) {
        const Result<BoundingVolume> flat =
            flatVolume(member(value, "boundingVolume"), curvedFromTile);
        if (!flat || std::holds_alternative<Region>(*flat))
            return above; // refused later, or knows where it is
        const auto near = tree.curved_->near(middleOf(*flat));
        if (!near)
            return refused(place, near.error().message());
        const Transform<Ecef, Tile> ecefFromTile{near->matrix * curvedFromTile};
        if (const char* flaw = flawOf(ecefFromTile.matrix))
            return refused(place, flaw);
        tree.transforms_.push_back(ecefFromTile);
        tree.curvedFromTile_.push_back(curvedFromTile);
        return std::uint32_t(tree.transforms_.size() - 1);
    }

    Result<BoundingVolume> volumeOf(const json* value, std::uint32_t transform) {
        const Transform<Ecef, Tile>& ecefFromTile = tree.transforms_[transform];
        if (!tree.curved_)
            return readVolume(value, ecefFromTile);
        const glm::dmat4& curvedFromTile = tree.curvedFromTile_[transform];
        const Result<BoundingVolume> flat = flatVolume(value, curvedFromTile);
        if (!flat)
            return flat;
        const Transform<Ecef, Tile> near{ecefFromTile.matrix * glm::inverse(curvedFromTile)};
        return curvedVolume(*tree.curved_, near, *flat);
    }

    Result<std::uint32_t> transformOf(const json& value, const Place& place, const Above& above) {
        const glm::dmat4& before = tree.curved_ ? tree.curvedFromTile_[above.transform]
                                                : tree.transforms_[above.transform].matrix;
        const json* entry = member(value, "transform");
        if (!entry)
            return tree.curved_ ? curvedTransform(value, place, glm::dmat4(before), above.transform)
                                : above.transform;
        const auto n = finiteNumbers<16>(*entry);
        if (!n)
            return refused(place, "transform is not 16 finite numbers");
        glm::dmat4 local;
        for (int i = 0; i < 16; ++i)
            local[i / 4][i % 4] = (*n)[std::size_t(i)];
        if (local == glm::dmat4(1.0) && !tree.curved_)
            return above.transform;
        const glm::dmat4 product = before * local;
        for (const glm::dmat4& m : {local, product})
            if (const char* flaw = flawOf(m))
                return refused(place, flaw);
        if (tree.curved_)
            return curvedTransform(value, place, product, above.transform);
        tree.transforms_.push_back({product});
        return std::uint32_t(tree.transforms_.size() - 1);
    }

    double geometricErrorOf(const json& value, const Place& place, const Above& above,
                            double scale) {
        const json* entry = member(value, "geometricError");
        const auto number = finiteNumber(entry);
        if (!number) {
            const double instead = above.geometricErrorMetres.value_or(0.0) / 2.0;
            warn(place, std::string("geometricError is ") + (entry ? "no number" : "missing") +
                            ", half of the parent's is taken");
            return instead;
        }
        if (*number < 0.0) {
            warn(place, "geometricError is negative, 0 is taken");
            return 0.0;
        }
        const double metres = *number * scale;
        if (above.geometricErrorMetres && metres > *above.geometricErrorMetres) {
            // A rounded last digit is no lie worth a word.
            if (metres > *above.geometricErrorMetres * (1.0 + 1e-6))
                warn(place, "geometricError is larger than the parent's, which is taken");
            return *above.geometricErrorMetres;
        }
        return std::min(metres, kMaxCoordinateMetres);
    }

    Refine refineOf(const json& value, const Place& place, const Above& above) {
        if (const json* entry = member(value, "refine")) {
            const std::string text = entry->is_string() ? lowered(entry->get<std::string>()) : "";
            if (text == "add")
                return Refine::Add;
            if (text == "replace")
                return Refine::Replace;
            warn(place, "refine is neither ADD nor REPLACE, it is inherited");
        } else if (!above.refineKnown) {
            warn(place, "refine is missing, REPLACE is taken");
        }
        return above.refine;
    }

    // Every content the file names, in whichever of its forms.
    std::vector<const json*> contentsOf(const json& value, const Place& place) {
        std::vector<const json*> out;
        const json* several = member(value, "contents");
        if (!several)
            if (const json* multiple = extension(value, "3DTILES_multiple_contents")) {
                several = multiple->is_array() ? multiple : member(*multiple, "contents");
                if (!several)
                    several = member(*multiple, "content");
            }
        if (several && several->is_array())
            for (const json& entry : *several)
                out.push_back(&entry);
        else if (several)
            leaveOut(kNoTile, refused(place, "contents is not an array"));
        if (const json* one = member(value, "content")) {
            if (!out.empty())
                warn(place, "has both content and contents, all are taken");
            out.push_back(one);
        }
        return out;
    }

    static const std::string* uriOf(const json& content) {
        const json* uri = member(content, "uri");
        if (!uri || !uri->is_string())
            uri = member(content, "url"); // before 1.0
        return uri && uri->is_string() ? uri->get_ptr<const std::string*>() : nullptr;
    }

    std::optional<Content> contentOf(const json& value, const Place& place,
                                     std::uint32_t transform) {
        const std::string* uri = uriOf(value);
        if (!uri) {
            leaveOut(kNoTile, refused(place, "content has no uri"));
            return std::nullopt;
        }
        Content content;
        Result<std::string> resolved = resolveUri(path, *uri);
        if (resolved) {
            content.path = std::move(*resolved);
            content.kind = kindByName(content.path);
        } else {
            content.path = shown(*uri);
            content.kind = ContentKind::Mesh;
            content.error = refused(place, resolved.error().reason);
        }
        if (const json* volume = member(value, "boundingVolume")) {
            Result<BoundingVolume> read = volumeOf(volume, transform);
            if (read)
                content.volume = std::make_shared<const BoundingVolume>(std::move(*read));
            else
                warn(place, "content." + read.error().reason + ", it is ignored");
        }
        return content;
    }

    // Without the uris; the reason when it cannot be used.
    Result<ImplicitTiling> implicitOf(const json& value, const Place& place) {
        ImplicitTiling tiling;
        const json* scheme = member(value, "subdivisionScheme");
        const std::string name =
            scheme && scheme->is_string() ? lowered(scheme->get<std::string>()) : "";
        if (name != "quadtree" && name != "octree")
            return refused(place,
                           "implicitTiling.subdivisionScheme is neither QUADTREE nor OCTREE");
        tiling.subdivision = name == "octree" ? Subdivision::Octree : Subdivision::Quadtree;

        const auto levels = integer(member(value, "subtreeLevels"));
        if (!levels || *levels < 1)
            return refused(place, "implicitTiling.subtreeLevels is no positive integer");
        if (!subtreeSize(tiling.subdivision, *levels))
            return refused(place, "implicitTiling.subtreeLevels " + std::to_string(*levels) +
                                      " makes subtrees of more than " +
                                      std::to_string(kMaxSubtreeBits) + " tiles");
        tiling.subtreeLevels = unsigned(*levels);

        auto available = integer(member(value, "availableLevels"));
        if (!available)
            if (const auto deepest = integer(member(value, "maximumLevel"))) // before 1.1
                available = *deepest + 1;
        if (!available || *available < 1)
            return refused(place, "implicitTiling.availableLevels is no positive integer");
        if (*available > std::int64_t(kMaxImplicitLevels))
            warn(place, "implicitTiling.availableLevels " + std::to_string(*available) +
                            " is more than 31, which is taken");
        tiling.availableLevels =
            std::uint32_t(std::min(*available, std::int64_t(kMaxImplicitLevels)));

        const json* subtrees = member(value, "subtrees");
        const std::string* uri = subtrees ? uriOf(*subtrees) : nullptr;
        if (!uri)
            return refused(place, "implicitTiling.subtrees has no uri");
        tiling.subtreeUri = *uri;
        return tiling;
    }

    Failure makeImplicit(const json& value, const json& implicit, const Place& place,
                         TileNode& node) {
        Result<ImplicitTiling> tiling = implicitOf(implicit, place);
        if (!tiling)
            return tiling.error();
        if (std::holds_alternative<Sphere>(node.volume))
            return refused(place, "implicitTiling needs a box or a region, not a sphere");
        // One that cannot be used keeps its place, since subtrees count contents, but stays empty:
        // it is wrong once, not for every tile.
        for (const json* content : contentsOf(value, place)) {
            const std::string* uri = uriOf(*content);
            const Result<std::string> resolved =
                uri ? resolveUri(path, fillTemplate(*uri, 0, 0, 0, 0))
                    : Error{path, "content has no uri"};
            if (!resolved)
                leaveOut(kNoTile, refused(place, resolved.error().reason));
            tiling->contentUris.push_back(resolved ? *uri : std::string());
        }
        if (const json* children = member(value, "children"); children && !children->empty())
            warn(place, "has both implicitTiling and children, the children are ignored");
        tiling->documentPath = path;
        tiling->rootVolume = node.volume;
        if (tree.curved_)
            if (auto flat = flatVolume(member(value, "boundingVolume"),
                                       tree.curvedFromTile_[node.transform]))
                tiling->flatVolume = std::move(*flat);
        tiling->rootGeometricErrorMetres = node.geometricErrorMetres;
        Result<std::string> subtree =
            resolveUri(path, fillTemplate(tiling->subtreeUri, 0, 0, 0, 0));
        if (!subtree)
            return refused(place, subtree.error().reason);
        node.content = ContentKind::Subtree;
        node.path = std::move(*subtree);
        node.implicitTiling = std::uint32_t(tree.implicitTilings_.size());
        tree.implicitTilings_.push_back(std::make_shared<const ImplicitTiling>(std::move(*tiling)));
        return std::nullopt;
    }

    static const json* implicitIn(const json& value) {
        if (const json* implicit = member(value, "implicitTiling"))
            return implicit;
        return extension(value, "3DTILES_implicit_tiling");
    }

    // Where a tile's own facts end and its content begins.
    Result<TileNode> makeNode(const json& value, const Place& place, const Above& above) {
        if (!value.is_object())
            return refused(place, "is no object");
        Result<std::uint32_t> transform = transformOf(value, place, above);
        if (!transform)
            return transform.error();
        TileNode node;
        node.parent = place.parent;
        node.transform = *transform;
        node.level = above.level;
        node.gltfUpAxis = above.gltfUpAxis;
        const Transform<Ecef, Tile> ecefFromTile = tree.transforms_[node.transform];
        Result<BoundingVolume> volume = volumeOf(member(value, "boundingVolume"), node.transform);
        if (!volume)
            return refused(place, volume.error().reason);
        node.volume = std::move(*volume);
        if (const json* request = member(value, "viewerRequestVolume")) {
            Result<BoundingVolume> read = volumeOf(request, node.transform);
            if (read)
                node.viewerRequestVolume = std::make_shared<const BoundingVolume>(std::move(*read));
            else
                warn(place, "viewerRequestVolume: " + read.error().reason + ", it is ignored");
        }
        node.refine = refineOf(value, place, above);
        node.geometricErrorMetres =
            geometricErrorOf(value, place, above, largestScale(ecefFromTile.matrix));
        node.state = LoadState::Ready;
        return node;
    }

    void append(TileNode node, const Place& place) {
        tree.nodes_.push_back(std::move(node));
        places.push_back(place);
    }

    static void put(const Content& content, TileNode& node) {
        node.content = content.kind;
        node.path = content.path;
        node.contentVolume = content.volume;
        node.state = content.error ? LoadState::Failed : LoadState::Unloaded;
    }

    // The tile's contents: into the tile, and what is more into nodes behind it. An external
    // tileset beside children becomes one more child (returned), so that nothing is lost.
    std::vector<TileNode> addContents(TileIndex tile, const json& value, bool hasChildren) {
        const Place place = places[tile];
        std::vector<TileNode> asChildren;
        for (const json* entry : contentsOf(value, place)) {
            const auto content = contentOf(*entry, place, tree.nodes_[tile].transform);
            if (!content)
                continue;
            const bool taken = tree.nodes_[tile].content != ContentKind::None;
            if (content->kind == ContentKind::ExternalTileset && (taken || hasChildren)) {
                TileNode child = bareCopy(tile);
                put(*content, child);
                asChildren.push_back(std::move(child));
                continue;
            }
            TileIndex holder = tile;
            if (taken) {
                TileNode extra = bareCopy(tile);
                extra.nextContent = tree.nodes_[tile].nextContent;
                extra.level = tree.nodes_[tile].level;
                holder = tree.size();
                tree.nodes_[tile].nextContent = holder;
                append(std::move(extra), place);
            }
            put(*content, tree.nodes_[holder]);
            if (content->error)
                leaveOut(holder, *content->error);
        }
        return asChildren;
    }

    TileNode bareCopy(TileIndex tile) const {
        TileNode copy = tree.nodes_[tile];
        copy.parent = tile;
        copy.firstChild = copy.nextContent = kNoTile;
        copy.childCount = 0;
        copy.level = below(copy.level);
        return copy;
    }

    static std::uint16_t below(std::uint16_t level) {
        return level == 0xffff ? level : std::uint16_t(level + 1);
    }

    // The children of one tile, side by side.
    Failure expand(const Work& item) {
        const json& value = *item.value;
        if (implicitIn(value))
            return std::nullopt;
        const json* children = member(value, "children");
        if (children && !children->is_array()) {
            leaveOut(kNoTile, refused(places[item.tile], "children is no array"));
            children = nullptr;
        }
        std::vector<TileNode> more = addContents(item.tile, value, children && !children->empty());
        if (tree.nodes_.size() + (children ? children->size() : 0) > kMaxTiles)
            return Error{path, "has more than " + std::to_string(kMaxTiles) + " tiles",
                         ErrorKind::Input};
        const TileNode& node = tree.nodes_[item.tile];
        const Above above{node.transform,  node.refine,      true, node.geometricErrorMetres,
                          node.gltfUpAxis, below(node.level)};
        const TileIndex first = tree.size();
        for (std::uint32_t i = 0; children && i < children->size(); ++i)
            addTile((*children)[i], {item.tile, i}, above);
        for (TileNode& extra : more)
            append(std::move(extra), places[item.tile]);
        tree.nodes_[item.tile].childCount = tree.size() - first;
        tree.nodes_[item.tile].firstChild = tree.size() == first ? kNoTile : first;
        return std::nullopt;
    }

    Failure addTile(const json& value, const Place& place, const Above& above) {
        Result<TileNode> made = makeNode(value, place, above);
        Failure failure;
        if (!made)
            failure = made.error();
        else if (const json* implicit = implicitIn(value))
            failure = makeImplicit(value, *implicit, place, *made);
        if (failure) {
            leaveOut(kNoTile, *failure);
            return failure;
        }
        if (made->content == ContentKind::Subtree) {
            made->state = LoadState::Unloaded;
            tree.subtreeRoots_[tree.size()] = {};
        }
        work.push_back({&value, tree.size()});
        append(std::move(*made), place);
        return std::nullopt;
    }

    Failure build(const json& document, const Inherited& inherited) {
        if (Failure failure = readHead(document, path, tree.facts_))
            return failure;
        tree.documents_.push_back({path, kNoTile});
        tree.transforms_.push_back(inherited.ecefFromTile);
        if (inherited.curved) {
            tree.curved_ = inherited.curved;
            tree.curvedFromTile_.push_back(inherited.curvedFromTile);
        }
        Above above;
        above.refine = inherited.refine;
        above.refineKnown = inherited.refineKnown;
        above.gltfUpAxis = upAxisOf(document, inherited.gltfUpAxis);
        above.level = inherited.level;
        // Only in place of a missing one: half of twice the tileset's own error.
        const json& root = document.at("root");
        const auto ownError = finiteNumber(member(document, "geometricError"));
        if (ownError && !finiteNumber(member(root, "geometricError")))
            above.geometricErrorMetres =
                2.0 * std::max(*ownError, 0.0) * largestScale(inherited.ecefFromTile.matrix);
        if (Failure failure = addTile(root, {}, above))
            return failure;
        for (std::size_t next = 0; next < work.size(); ++next)
            if (Failure failure = expand(Work(work[next])))
                return failure;
        if (dropped)
            tree.facts_.warnings.push_back(path + ": " + std::to_string(dropped) +
                                           " more warnings");
        if (unnamed)
            tree.facts_.leftOut.push_back(
                {kNoTile,
                 {path, std::to_string(unnamed) + " more tiles cannot be used", ErrorKind::Input}});
        return std::nullopt;
    }
};

Result<TileTree> TileTree::parseExternal(std::span<const std::byte> bytes, const std::string& path,
                                         const Inherited& inherited) {
    TileTree tree;
    json document = json::parse(asText(bytes), nullptr, false);
    if (document.is_discarded()) {
        document = json::parse(withoutNonFinite(asText(bytes)), nullptr, false);
        if (document.is_discarded())
            return Error{path, "is not JSON", ErrorKind::Input};
        tree.facts_.warnings.push_back(path + ": has numbers that are not finite");
    }
    TileTreeBuilder builder{tree, path, {}, {}};
    if (Failure failure = builder.build(document, inherited))
        return *failure;
    return tree;
}

Result<TileTree> TileTree::parse(std::span<const std::byte> bytes, const std::string& path,
                                 const TilePlacement& placement) {
    Inherited inherited;
    inherited.ecefFromTile = placement.frame;
    inherited.curved = placement.curved;
    return parseExternal(bytes, path, inherited);
}

} // namespace gnomon
