#include "streaming/terrain/terrain_data.h"

#include <cmath>

namespace gnomon {

namespace {

// Trees below a tile are told when they are asked for once there would be more tiles than this.
constexpr double kMostVirtualTiles = 20000;

class TreeMaker {
  public:
    explicit TreeMaker(const TerrainScene& scene) : scene_(scene), data_(*scene.data) {
        for (const auto& ground : scene.above) {
            const auto* terrain = dynamic_cast<const Terrain*>(ground.get());
            above_.push_back(terrain != nullptr ? &terrain->facts() : nullptr);
        }
    }

    std::vector<MadeTile> whole() {
        const int top = data_.levels.top();
        tellVirtual_ = double(data_.tiles[0].tiles.size()) * virtualShare() <= kMostVirtualTiles;
        add(kNoTile, top, {0, 0});
        grow();
        return std::move(tiles_);
    }

    // The tree below a tile whose content is drawn already: an empty root and its parts.
    Result<std::vector<MadeTile>> below(const TileName& name) {
        tellVirtual_ = name.level <= 0;
        HeightScan scan;
        if (name.level > 0) {
            Result<HeightScan> looked = scanTile(data_.raster, data_.levels, name.level, name.tile);
            if (!looked)
                return looked.error();
            scan = std::move(*looked);
            scanned_ = &scan;
        }
        add(kNoTile, name.level, name.tile);
        tiles_[0].content = ContentKind::None;
        tiles_[0].path.clear();
        grow();
        scanned_ = nullptr;
        return std::move(tiles_);
    }

  private:
    struct Place {
        int level;
        glm::ivec2 tile;
    };

    const TileHeights* heightsOf(int level, glm::ivec2 tile) const {
        const int at = std::max(level, 0);
        const glm::ivec2 there = level < 0 ? tile / (1 << -level) : tile;
        if (scanned_ != nullptr && std::size_t(at) < scanned_->levels.size()) {
            const LevelTiles& tiles = scanned_->levels[std::size_t(at)];
            const glm::ivec2 off = there - tiles.first;
            const bool inside =
                off.x >= 0 && off.y >= 0 && off.x < tiles.count.x && off.y < tiles.count.y;
            return inside ? &tiles.at(there) : nullptr;
        }
        return data_.known(at, there);
    }

    // How many tiles finer textures would add to one of level 0, roughly.
    double virtualShare() const {
        double share = 0.0;
        if (scene_.drapes.empty() || data_.knownFrom > 0)
            return share;
        for (int level = 0; level > TerrainScene::kLowestLevel; --level) {
            if (!coarseSomewhere(level))
                break;
            share += std::ldexp(1.0, 2 * (1 - level));
        }
        return share;
    }
    bool coarseSomewhere(int level) const {
        const double side = data_.facts.cellMetres * TerrainScene::cellsOf(level);
        constexpr double kMostTexels = 1024;
        return scene_.finestTexelMetres > 0.0 && side / kMostTexels > scene_.finestTexelMetres;
    }

    void add(TileIndex parent, int level, glm::ivec2 tile) {
        MadeTile made;
        made.parent = parent;
        made.path = nameOf(level, tile);
        const TileHeights* heights = heightsOf(level, tile);
        const Nodes nodes = nodesOf(level, tile);
        const GeographicBox box = anyOthers() ? scene_.boxOf(level, tile) : GeographicBox{};
        double low = heights != nullptr ? double(heights->low) : data_.lowest;
        double high = heights != nullptr ? double(heights->high) : data_.highest;
        if (!(low <= high))
            low = high = data_.lowest;
        made.volume = volumeOf(nodes, low, high, box);
        made.geometricErrorMetres = errorOf(level, tile, heights, box);
        tiles_.push_back(made);
        places_.push_back({level, tile});
    }

    bool anyOthers() const { return !scene_.above.empty() || !scene_.drapes.empty(); }

    double errorOf(int level, glm::ivec2 tile, const TileHeights* heights,
                   const GeographicBox& box) const {
        double error = 0.0;
        if (level > 0) {
            error = heights != nullptr ? data_.heightError(level, *heights)
                                       : data_.heightError(level, tile);
            // Where ground ends, the rim is off by up to a cell sideways.
            if (heights == nullptr || heights->rim || straddles(level, tile, box))
                error = std::max(error, data_.cellMetres(level));
        }
        if (!scene_.drapes.empty() && scene_.isDraped(box)) {
            const TerrainScene::Texels texels = scene_.texelsOf(level, tile);
            if (texels.coarse && level > TerrainScene::kLowestLevel)
                error = std::max(error, texels.metres);
        }
        return error;
    }

    // Part of the tile lies on ground of another, part does not.
    bool straddles(int level, glm::ivec2 tile, const GeographicBox& box) const {
        bool near = false;
        for (const TerrainFacts* facts : above_)
            near = near || facts == nullptr || overlap(facts->extent, box);
        if (!near)
            return false;
        constexpr int kLooks = 9;
        const HeightLevels::Span s = scene_.span(level, tile);
        std::vector<glm::dvec2> places;
        for (int j = 0; j < kLooks; ++j)
            for (int i = 0; i < kLooks; ++i) {
                const glm::dvec2 share(double(i) / (kLooks - 1), double(j) / (kLooks - 1));
                const Result<PlacedPixel> place = data_.place->at(
                    glm::dvec2(s.first) + share * glm::dvec2(s.last - s.first), 0.0);
                if (place)
                    places.push_back(place->lonLat());
            }
        std::vector<double> heights(places.size());
        std::size_t covered = 0;
        std::vector<bool> there(places.size(), false);
        for (const auto& ground : scene_.above) {
            ground->sample(places, heights);
            for (std::size_t i = 0; i < places.size(); ++i)
                there[i] = there[i] || !std::isnan(heights[i]);
        }
        for (const bool one : there)
            covered += one ? 1 : 0;
        return covered < places.size();
    }

    // Places of the tile, at the raster's height 0.
    struct Nodes {
        int side = 0;
        std::vector<PlacedPixel> places;
    };
    Nodes nodesOf(int level, glm::ivec2 tile) const {
        const HeightLevels::Span s = scene_.span(level, tile);
        const double metres =
            data_.longerCellMetres * std::max(s.last.x - s.first.x, s.last.y - s.first.y);
        Nodes nodes;
        nodes.side = metres < 10e3 ? 3 : metres < 500e3 ? 5 : 17;
        for (int j = 0; j < nodes.side; ++j)
            for (int i = 0; i < nodes.side; ++i) {
                const glm::dvec2 share(double(i) / (nodes.side - 1), double(j) / (nodes.side - 1));
                const Result<PlacedPixel> place = data_.place->at(
                    glm::dvec2(s.first) + share * glm::dvec2(s.last - s.first), 0.0);
                nodes.places.push_back(place ? *place : PlacedPixel{glm::dvec3(0.0), 0.0});
            }
        return nodes;
    }

    BoundingVolume volumeOf(const Nodes& nodes, double low, double high,
                            const GeographicBox& box) const {
        std::vector<Point<Ecef>> points;
        const auto usable = [](const PlacedPixel& p) { return glm::length(p.up) > 0.5; };
        const auto span = [&](double from, double to) {
            for (const PlacedPixel& p : nodes.places)
                if (usable(p)) {
                    points.push_back(p.ecefAt(p.heightMetres + from));
                    points.push_back(p.ecefAt(p.heightMetres + to));
                }
        };
        span(low, high);
        for (std::size_t i = 0; i < scene_.above.size(); ++i)
            takeAbove(i, nodes, box, points);
        if (points.empty()) // the CRS has no place for any: cannot be reached by a tile
            return Sphere{};
        const PlacedPixel& middle = nodes.places[nodes.places.size() / 2];
        const Point<Ecef> centre = usable(middle) ? middle.ecef() : points.front();
        OrientedBox out = boxAround(points, ecefFromEnu(geodeticOf(centre)).axes());
        const double pad = bulge(nodes) + 1e-3;
        for (int axis = 0; axis < 3; ++axis) {
            const double half = glm::length(out.halfAxes[axis]);
            const glm::dvec3 unit = half > 0.0 ? out.halfAxes[axis] / half
                                               : ecefFromEnu(geodeticOf(centre)).axes()[axis];
            out.halfAxes[axis] = unit * (half + pad);
        }
        return out;
    }

    // The tile's vertices take over heights of the ground above them.
    void takeAbove(std::size_t index, const Nodes& nodes, const GeographicBox& box,
                   std::vector<Point<Ecef>>& points) const {
        const TerrainFacts* facts = above_[index];
        if (facts != nullptr && !overlap(facts->extent, box))
            return;
        for (const PlacedPixel& p : nodes.places) {
            if (glm::length(p.up) < 0.5)
                continue;
            if (facts != nullptr) {
                points.push_back(p.ecefAt(facts->minHeightMetres));
                points.push_back(p.ecefAt(facts->maxHeightMetres));
            } else if (const double h = scene_.above[index]->at(p.lonLat()); !std::isnan(h)) {
                points.push_back(p.ecefAt(h));
            }
        }
    }

    // How far the tile's sides and ground bend away from straight lines between nodes: an eighth
    // of the second difference, for a smooth curve; twice that is taken.
    double bulge(const Nodes& nodes) const {
        double most = 0.0;
        const auto at = [&](int i, int j) {
            return nodes.places[std::size_t(j * nodes.side + i)].ecef().xyz;
        };
        for (int j = 0; j < nodes.side; ++j)
            for (int i = 1; i + 1 < nodes.side; ++i) {
                most = std::max(most, glm::length(at(i - 1, j) - 2.0 * at(i, j) + at(i + 1, j)));
                most = std::max(most, glm::length(at(j, i - 1) - 2.0 * at(j, i) + at(j, i + 1)));
            }
        return most / 4.0;
    }

    void grow() {
        for (std::size_t i = 0; i < tiles_.size(); ++i) {
            if (tiles_[i].content == ContentKind::ExternalTileset)
                continue;
            const Place place = places_[i];
            if (isCut(i, place))
                addBelow(TileIndex(i), place);
            else
                addChildren(TileIndex(i), place);
        }
        for (std::size_t i = tiles_.size(); i-- > 1;) {
            double& above = tiles_[tiles_[i].parent].geometricErrorMetres;
            above = std::max(above, tiles_[i].geometricErrorMetres);
        }
    }

    bool isFinest(const Place& place) const {
        if (place.level > 0)
            return false;
        if (scene_.drapes.empty() || place.level == TerrainScene::kLowestLevel)
            return true;
        return !scene_.isDraped(scene_.boxOf(place.level, place.tile)) ||
               !scene_.texelsOf(place.level, place.tile).coarse;
    }

    bool isCut(std::size_t index, const Place& place) const {
        if (index == 0 && tiles_[0].content == ContentKind::None)
            return false; // this is the tree below
        if (scanned_ == nullptr && data_.knownFrom > 0 && place.level == data_.knownFrom)
            return true;
        return place.level == 0 && !tellVirtual_ && !isFinest(place);
    }

    void addBelow(TileIndex parent, const Place& place) {
        MadeTile made;
        made.parent = parent;
        made.content = ContentKind::ExternalTileset;
        made.geometricErrorMetres = tiles_[parent].geometricErrorMetres;
        made.volume = tiles_[parent].volume;
        made.path = nameOf(place.level, place.tile);
        tiles_.push_back(made);
        places_.push_back(place);
    }

    void addChildren(TileIndex parent, const Place& place) {
        if (isFinest(place))
            return;
        const int level = place.level - 1;
        for (int j = 0; j < 2; ++j)
            for (int i = 0; i < 2; ++i) {
                const glm::ivec2 tile = place.tile * 2 + glm::ivec2(i, j);
                const HeightLevels::Span s = scene_.span(level, tile);
                if (s.first.x >= s.last.x || s.first.y >= s.last.y)
                    continue;
                const TileHeights* heights = heightsOf(level, tile);
                if (heights == nullptr || heights->surface)
                    add(parent, level, tile);
            }
    }

    const TerrainScene& scene_;
    const TerrainData& data_;
    std::vector<const TerrainFacts*> above_; // null for ground that is no terrain
    const HeightScan* scanned_ = nullptr;
    bool tellVirtual_ = true;
    std::vector<MadeTile> tiles_;
    std::vector<Place> places_;
};

} // namespace

MadeTileset terrainTiles(std::shared_ptr<const TerrainScene> scene,
                         std::shared_ptr<const ContentMaker> maker) {
    return {TreeMaker(*scene).whole(), std::move(maker)};
}

Result<std::vector<MadeTile>> terrainTilesBelow(const TerrainScene& scene, const TileName& name) {
    return TreeMaker(scene).below(name);
}

} // namespace gnomon
