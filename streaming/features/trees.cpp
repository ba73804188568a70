#include "streaming/features/trees.h"

#include "streaming/features/feature_layer.h"
#include "streaming/features/trees_facts.h"
#include "streaming/features/vertex_color.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <unordered_map>

namespace gnomon {

namespace {

// What a node of the tree of tiles shows. Above Farthest there is nothing to show: a node of
// `Gather` only leads on.
enum class Stage : std::uint8_t { Near, Far, Farthest, Gather };

struct Node {
    std::size_t first = 0, count = 0; // of the trees in order
    Stage stage = Stage::Gather;
};

std::size_t mostTrees(Stage stage) {
    return kMostTreesNear << (2 * int(stage)); // a quarter goes to each of four children
}

// Independent numbers in [0, 1) from one seed.
double part(std::uint64_t seed, int which) {
    return double(seed >> (16 * which) & 0xffff) / 65536.0;
}

unsigned variantOf(const TreeFacts& tree) {
    return unsigned(part(tree.seed, 0) * treeVariants(tree.form));
}

// Calm greens, those of viewer/place; no two trees quite the same.
glm::dvec3 crownColor(const TreeFacts& tree) {
    const glm::dvec3 color =
        tree.form == TreeForm::Broad ? glm::dvec3(0.37, 0.46, 0.28) : glm::dvec3(0.22, 0.38, 0.25);
    const double warm = 0.06 * (part(tree.seed, 1) - 0.5);
    return color * (0.94 + 0.12 * part(tree.seed, 2)) + glm::dvec3(warm, 0.0, -0.5 * warm);
}
constexpr glm::dvec3 kTrunkColor(0.38, 0.32, 0.26);

double deviation(const TreeFacts& tree, Stage stage) {
    if (stage == Stage::Near)
        return 0.0;
    return treeDeviationMetres(tree.form, variantOf(tree),
                               stage == Stage::Far ? TreeDetail::Far : TreeDetail::Farthest,
                               tree.heightMetres, tree.crownRadiusMetres);
}

Transform<Ecef, Enu> ecefFromFoot(const TreeFacts& tree) {
    return ecefFromEnu({tree.lonLat.x, tree.lonLat.y, tree.footMetres});
}

// Around all of these trees, crowns and roots.
OrientedBox boxOf(std::span<const TreeFacts> trees) {
    std::vector<Point<Ecef>> points;
    points.reserve(trees.size() * 8);
    for (const TreeFacts& tree : trees) {
        const Transform<Ecef, Enu> foot = ecefFromFoot(tree);
        // The simpler crowns are a little wider and higher than the finest.
        const double r = 1.2 * tree.crownRadiusMetres, high = 1.1 * tree.heightMetres,
                     low = -1.1 * kTreeRootDepth * tree.heightMetres;
        for (int i = 0; i < 8; ++i)
            points.push_back(
                foot(Point<Enu>{{i & 1 ? r : -r, i & 2 ? r : -r, i & 4 ? high : low}}));
    }
    const TreeFacts& middle = trees[trees.size() / 2];
    return boxAround(points, ecefFromFoot(middle).axes());
}

// How many of these go to the first half, wherever trees are divided in two.
std::size_t halfOf(std::size_t count) {
    return (count + 1) / 2;
}

// Orders the trees so that those of a node stand together, and so on in halves within it; lays out
// the nodes, children behind their parents and side by side.
class Planner {
  public:
    explicit Planner(std::vector<TreeFacts>& trees) : trees_(trees) {
        const double west = trees.front().lonLat.x;
        const double across = std::cos(trees.front().lonLat.y * kRadiansPerDegree);
        for (const TreeFacts& tree : trees) // the short way round the Earth
            places_.emplace_back(std::remainder(tree.lonLat.x - west, 360.0) * across,
                                 tree.lonLat.y);
        order_.resize(trees.size());
        std::iota(order_.begin(), order_.end(), 0u);
    }

    std::vector<Node> run(std::vector<TileIndex>& parents) {
        std::vector<Node> nodes{
            {0, trees_.size(),
             trees_.size() > mostTrees(Stage::Farthest) ? Stage::Gather : Stage::Farthest}};
        parents = {kNoTile};
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (nodes[i].stage == Stage::Near)
                order(nodes[i].first, nodes[i].count);
            else
                for (const Node& child : childrenOf(nodes[i])) {
                    nodes.push_back(child);
                    parents.push_back(TileIndex(i));
                }
        std::vector<TreeFacts> sorted;
        sorted.reserve(trees_.size());
        for (const std::uint32_t i : order_)
            sorted.push_back(trees_[i]);
        trees_ = std::move(sorted);
        return nodes;
    }

  private:
    std::vector<Node> childrenOf(const Node& node) {
        const Stage below =
            node.stage == Stage::Gather && node.count > 4 * mostTrees(Stage::Farthest)
                ? Stage::Gather
                : Stage(int(node.stage) - 1);
        if (node.count <= mostTrees(below))
            return {{node.first, node.count, below}};
        std::vector<Node> children;
        const std::size_t half = halve(node.first, node.count);
        for (const auto& [first, count] :
             {std::pair(node.first, half), std::pair(node.first + half, node.count - half)}) {
            const std::size_t quarter = halve(first, count);
            children.push_back({first, quarter, below});
            children.push_back({first + quarter, count - quarter, below});
        }
        return children;
    }

    void order(std::size_t first, std::size_t count) {
        constexpr std::size_t kFew = 16; // fewer are never a mesh of their own
        if (count <= kFew)
            return;
        const std::size_t half = halve(first, count);
        order(first, half);
        order(first + half, count - half);
    }

    // Across the longer side; returns how many go to the first half.
    std::size_t halve(std::size_t first, std::size_t count) {
        glm::dvec2 low(1e9), high(-1e9);
        for (std::size_t i = first; i < first + count; ++i) {
            low = glm::min(low, places_[order_[i]]);
            high = glm::max(high, places_[order_[i]]);
        }
        const int axis = high.x - low.x >= high.y - low.y ? 0 : 1;
        const auto begin = order_.begin() + std::ptrdiff_t(first);
        const std::size_t half = halfOf(count);
        std::nth_element(begin, begin + std::ptrdiff_t(half), begin + std::ptrdiff_t(count),
                         [&](std::uint32_t a, std::uint32_t b) {
                             const glm::dvec2 &p = places_[a], &q = places_[b];
                             return p[axis] != q[axis] ? p[axis] < q[axis] : a < b;
                         });
        return half;
    }

    std::vector<TreeFacts>& trees_;
    std::vector<glm::dvec2> places_; // degrees, as wide as high
    std::vector<std::uint32_t> order_;
};

// Meshes are no wider than this, for culling, where that leaves enough triangles in each to be
// worth a draw.
constexpr double kChunkMetres = kMaxMeshExtentMetres;
std::size_t fewestInMesh(TreeDetail detail) {
    constexpr std::size_t kTriangles = 4096;
    return kTriangles / treeShape(TreeForm::Broad, 0, detail).triangles.size();
}

bool isWide(std::span<const TreeFacts> trees) {
    const Point<Ecef> first = ecefFromFoot(trees.front()).origin();
    glm::dvec3 low(0.0), high(0.0);
    for (const TreeFacts& tree : trees) {
        const glm::dvec3 p = (ecefFromFoot(tree).origin() - first).xyz;
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    return glm::length(high - low) > kChunkMetres;
}

// One mesh of several trees.
class Copier {
  public:
    Copier(std::span<const TreeFacts> trees, TreeDetail detail, const glm::dmat3& meshAxes)
        : boxAxes_(ecefFromFoot(trees[trees.size() / 2]).axes()), meshAxes_(meshAxes) {
        mesh_.origin = boxOf(trees).centre;
        for (const TreeFacts& tree : trees)
            add(tree, treeShape(tree.form, variantOf(tree), detail));
    }

    Mesh take() {
        const glm::dvec3 half = (high_ - low_) / 2.0;
        mesh_.box.centre = mesh_.origin + Vector<Ecef>{boxAxes_ * ((low_ + high_) / 2.0)};
        mesh_.box.halfAxes =
            glm::dmat3(boxAxes_[0] * half.x, boxAxes_[1] * half.y, boxAxes_[2] * half.z);
        mesh_.closedTriangles = mesh_.triangles();
        return std::move(mesh_);
    }

  private:
    void add(const TreeFacts& tree, const TreeShape& shape) {
        const double heading = 2.0 * std::numbers::pi * part(tree.seed, 3);
        const double c = std::cos(heading), s = std::sin(heading);
        const Transform<Ecef, Enu> foot = ecefFromFoot(tree);
        // Sums of small numbers only: the Earth's radius never enters.
        const glm::dmat3 stored = glm::transpose(meshAxes_);
        const glm::dmat3 axes = stored * foot.axes() * glm::dmat3({c, s, 0}, {-s, c, 0}, {0, 0, 1});
        const glm::dvec3 offset = stored * (foot.origin() - mesh_.origin).xyz;
        const glm::dvec3 size(tree.crownRadiusMetres, tree.crownRadiusMetres, tree.heightMetres);
        const glm::dvec3 crown = crownColor(tree);
        const auto first = std::uint32_t(mesh_.positions.size());
        for (std::size_t i = 0; i < shape.positions.size(); ++i) {
            mesh_.positions.emplace_back(offset + axes * (size * shape.positions[i]));
            mesh_.normals.push_back(encodeOct(glm::normalize(axes * (shape.normals[i] / size))));
            mesh_.colors.push_back(
                linearRgba(shape.isTrunk[i] ? kTrunkColor : crown, shape.shade[i]));
            stretch(glm::dvec3(mesh_.positions.back()));
        }
        for (const auto& t : shape.triangles) {
            const glm::dvec3& a = shape.positions[t[0]];
            const glm::dvec3 face =
                glm::cross(size * (shape.positions[t[1]] - a), size * (shape.positions[t[2]] - a));
            mesh_.faceNormals.push_back(encodeOct(glm::normalize(axes * face)));
            for (const std::uint32_t v : t)
                mesh_.indices.push_back(first + v);
        }
    }

    void stretch(const glm::dvec3& p) {
        const glm::dvec3 inBox = glm::transpose(boxAxes_) * (meshAxes_ * p);
        low_ = glm::min(low_, inBox);
        high_ = glm::max(high_, inBox);
        mesh_.radiusMetres = std::max(mesh_.radiusMetres, glm::length(p));
    }

    glm::dmat3 boxAxes_, meshAxes_;
    glm::dvec3 low_{std::numeric_limits<double>::infinity()}, high_{-low_};
    Mesh mesh_;
};

class TreeMaker : public ContentMaker {
  public:
    TreeMaker(std::string name, std::vector<TreeFacts> trees)
        : name_(std::move(name)), trees_(std::move(trees)) {}

    void add(const std::string& path, const Node& node) { nodes_.emplace(path, node); }
    std::span<const TreeFacts> treesOf(const Node& node) const {
        return std::span(trees_).subspan(node.first, node.count);
    }

    Result<TileContent> make(const std::string& path, const DecodeOptions& options) const override {
        const auto at = nodes_.find(path);
        if (at == nodes_.end())
            return Error{describe(path), "there is no such tile"};
        const Node& node = at->second;
        TileContent content;
        content.materials.emplace_back();
        addMeshes(treesOf(node), TreeDetail(int(node.stage)),
                  options.meshAxes.value_or(glm::dmat3(1.0)), content);
        content.facts.format = "trees";
        for (const Mesh& mesh : content.meshes)
            content.facts.triangles += mesh.triangles();
        content.facts.closedTriangles = content.facts.triangles; // as the shapes are: a test asks
        content.facts.components = content.facts.closedComponents = std::uint32_t(node.count);
        return content;
    }
    std::string describe(const std::string& path) const override { return name_ + ", " + path; }

  private:
    static void addMeshes(std::span<const TreeFacts> trees, TreeDetail detail,
                          const glm::dmat3& meshAxes, TileContent& content) {
        const std::size_t half = halfOf(trees.size());
        if (half >= fewestInMesh(detail) && isWide(trees)) {
            addMeshes(trees.first(half), detail, meshAxes, content);
            addMeshes(trees.subspan(half), detail, meshAxes, content);
            return;
        }
        content.meshes.push_back(Copier(trees, detail, meshAxes).take());
    }

    std::string name_;
    std::vector<TreeFacts> trees_; // those of a node side by side
    std::unordered_map<std::string, Node> nodes_;
};

MadeTileset tilesOf(const std::string& name, std::vector<TreeFacts> trees) {
    std::vector<TileIndex> parents;
    const std::vector<Node> nodes = Planner(trees).run(parents);
    const auto maker = std::make_shared<TreeMaker>(name, std::move(trees));
    MadeTileset made;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const Node& node = nodes[i];
        MadeTile tile;
        tile.parent = parents[i];
        tile.volume = boxOf(maker->treesOf(node));
        for (const TreeFacts& tree : maker->treesOf(node))
            tile.geometricErrorMetres = std::max(
                tile.geometricErrorMetres, deviation(tree, std::min(node.stage, Stage::Farthest)));
        if (node.stage == Stage::Gather) {
            tile.content = ContentKind::None;
        } else {
            tile.path = "trees " + std::to_string(node.first) + " to " +
                        std::to_string(node.first + node.count - 1) +
                        (node.stage == Stage::Near  ? ", near"
                         : node.stage == Stage::Far ? ", far"
                                                    : ", farthest");
            maker->add(tile.path, node);
        }
        made.tiles.push_back(std::move(tile));
    }
    made.maker = maker;
    return made;
}

} // namespace

Result<Trees> Trees::of(FeatureFile file, const std::string& name, const TreeOptions& options,
                        const std::shared_ptr<const GroundHeights>& ground) {
    Trees trees;
    trees.file = std::move(file);
    const std::size_t before = trees.file.leftOut.size();
    std::vector<TreeFacts> all = treesOf(trees.file, options, ground);
    nameLeftOut(trees.file, before, name);
    trees.file.features.clear();
    trees.file.features.shrink_to_fit();
    trees.count = all.size();
    if (all.empty())
        return nothingOf(trees.file, name, "trees");
    trees.tiles = tilesOf(name, std::move(all));
    return trees;
}

Result<Trees> Trees::open(const std::string& path, const TreeOptions& options,
                          const std::shared_ptr<const GroundHeights>& ground) {
    return openFeatureLayer<Trees>(path, options, ground);
}

} // namespace gnomon
