#include "streaming/terrain/quantized_mesh_scene.h"

#include <cmath>

namespace gnomon {

namespace {

// Told at once; what lies below them when it is asked for.
constexpr unsigned kLevelsAtOnce = 3;
// Where other ground begins the tile is cut into cells no smaller than this.
constexpr double kFinestRoomMetres = 1.0;

class TreeMaker {
  public:
    explicit TreeMaker(const QuantizedScene& scene)
        : scene_(scene), core_(*scene.core), pyramid_(*core_.pyramid) {}

    std::vector<MadeTile> whole() {
        const std::vector<QuantizedPlace>& roots = pyramid_.roots();
        if (roots.size() == 1) {
            add(kNoTile, roots[0]);
        } else {
            addEmptyRoot();
            for (const QuantizedPlace& root : roots)
                add(0, root);
        }
        grow();
        return std::move(tiles_);
    }

    // An empty root, since the tile itself is drawn already, and its parts.
    std::vector<MadeTile> below(const QuantizedPlace& place) {
        add(kNoTile, place);
        tiles_[0].content = ContentKind::None;
        tiles_[0].path.clear();
        grow();
        return std::move(tiles_);
    }

  private:
    struct Node {
        QuantizedPlace place;
        unsigned depth = 0;
        bool hasParts = false;
        bool isTile = true;
    };

    void addEmptyRoot() {
        MadeTile made;
        made.content = ContentKind::None;
        double low = core_.facts.minHeightMetres, high = core_.facts.maxHeightMetres;
        std::array<double, 4> all{180, 90, -180, -90};
        for (const QuantizedPlace& root : pyramid_.roots()) {
            const std::array<double, 4> e = extentOf(root, pyramid_.webMercator());
            all = {std::min(all[0], e[0]), std::min(all[1], e[1]), std::max(all[2], e[2]),
                   std::max(all[3], e[3])};
            made.geometricErrorMetres =
                std::max(made.geometricErrorMetres, 2.0 * core_.errorOf(root));
            low = std::min(low, core_.facts.minHeightMetres - core_.errorOf(root));
            high = std::max(high, core_.facts.maxHeightMetres + core_.errorOf(root));
        }
        made.volume = makeRegion(all[0], all[1], all[2], all[3], low, high);
        tiles_.push_back(made);
        nodes_.push_back({{}, 0, false, false});
    }

    void add(TileIndex parent, const QuantizedPlace& place) {
        const std::array<double, 4> extent = extentOf(place, pyramid_.webMercator());
        const PictureNeed picture = pictureNeed(scene_.drapes, extent, metresOf(extent));
        double error = 0.0;
        const QuantizedScene::Covered covered = scene_.coverage(extent);
        if (covered != QuantizedScene::Covered::All && place.level < kDeepestLevel) {
            error = picture.errorMetres;
            if (pyramid_.hasChild(place))
                error = std::max(error, core_.errorOf(place));
            const glm::dvec2 size = metresOf(extent);
            const double cell = std::max(size.x, size.y) / kRoomCells;
            if (covered == QuantizedScene::Covered::Part && cell > kFinestRoomMetres)
                error = std::max(error, cell);
        }
        MadeTile made;
        made.parent = parent;
        made.path = nameOf(place);
        made.geometricErrorMetres = error;
        made.volume = volumeOf(place, extent);
        const unsigned depth = parent == kNoTile ? 0 : nodes_[parent].depth + 1;
        tiles_.push_back(std::move(made));
        nodes_.push_back({place, depth, error > 0.0, true});
    }

    // By the heights of the tile it is cut from, and by how much those may be off.
    BoundingVolume volumeOf(const QuantizedPlace& place,
                            const std::array<double, 4>& extent) const {
        double low = core_.lowest, high = core_.highest, slack = 0.0;
        if (const auto source = pyramid_.sourceOf(place)) {
            slack = core_.errorOf(*source);
            if (const auto summary = pyramid_.summary(*source)) {
                low = summary->header.minHeightMetres;
                high = summary->header.maxHeightMetres;
            }
        }
        HeightShift shift(core_.heights, core_.raiseMetres);
        shift.prepare(extent); // it did at opening
        low += shift.least() - slack;
        high += shift.most() + slack;
        for (const auto& ground : scene_.above)
            if (const auto* terrain = dynamic_cast<const Terrain*>(ground.get()))
                if (scene_.isNearAbove(extent)) {
                    low = std::min(low, terrain->facts().minHeightMetres);
                    high = std::max(high, terrain->facts().maxHeightMetres);
                }
        return makeRegion(extent[0], extent[1], extent[2], extent[3], low, high);
    }

    void grow() {
        for (std::size_t i = 0; i < tiles_.size(); ++i) {
            const Node node = nodes_[i];
            if (!node.isTile || !node.hasParts)
                continue;
            if (node.depth >= kLevelsAtOnce) {
                addBelow(TileIndex(i));
                continue;
            }
            for (unsigned child = 0; child < 4; ++child)
                add(TileIndex(i), node.place.child(child));
        }
        for (std::size_t i = tiles_.size(); i-- > 1;) {
            double& above = tiles_[tiles_[i].parent].geometricErrorMetres;
            above = std::max(above, tiles_[i].geometricErrorMetres);
        }
    }

    void addBelow(TileIndex parent) {
        MadeTile made;
        made.parent = parent;
        made.content = ContentKind::ExternalTileset;
        made.geometricErrorMetres = tiles_[parent].geometricErrorMetres;
        made.volume = tiles_[parent].volume;
        made.path = tiles_[parent].path;
        tiles_.push_back(std::move(made));
        nodes_.push_back({nodes_[parent].place, nodes_[parent].depth + 1, false, false});
    }

    const QuantizedScene& scene_;
    const QuantizedCore& core_;
    const QuantizedPyramid& pyramid_;
    std::vector<MadeTile> tiles_;
    std::vector<Node> nodes_;
};

} // namespace

std::vector<MadeTile> quantizedTiles(const QuantizedScene& scene) {
    return TreeMaker(scene).whole();
}

std::vector<MadeTile> quantizedTilesBelow(const QuantizedScene& scene,
                                          const QuantizedPlace& place) {
    return TreeMaker(scene).below(place);
}

} // namespace gnomon
