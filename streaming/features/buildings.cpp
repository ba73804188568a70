#include "streaming/features/buildings.h"

#include "streaming/features/buildings_model.h"
#include "streaming/features/feature_layer.h"
#include "streaming/split.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>

namespace gnomon {

namespace {

// What a node shows itself; what has no more than kMostInLeaf goes into one.
constexpr std::size_t kOwn = 400, kMostInLeaf = 700;
// A building that is missing is a worse fault than an outline a little off, so its size counts as
// an error so many times: at 16 pixels of error, what is left out is smaller than 4.
constexpr double kErrorPerSize = 4.0;

struct Extent {
    double west = std::numeric_limits<double>::infinity(), south = west, low = west;
    double east = -std::numeric_limits<double>::infinity(), north = east, high = east;

    void add(const Extent& o) {
        west = std::min(west, o.west);
        south = std::min(south, o.south);
        low = std::min(low, o.low);
        east = std::max(east, o.east);
        north = std::max(north, o.north);
        high = std::max(high, o.high);
    }
};

struct Node {
    TileIndex parent = kNoTile;
    std::size_t first = 0, own = 0, all = 0; // of `order`: its own, then those below
    Extent extent;                           // of all
    std::vector<std::uint32_t> children;
};

class BuildingSet {
  public:
    BuildingSet(std::vector<BuildingBody> bodies, std::string name)
        : bodies_(std::move(bodies)), name_(std::move(name)) {
        order_.resize(bodies_.size());
        std::iota(order_.begin(), order_.end(), 0u);
        start_ = bodies_.front().west;
        nodes_.push_back({kNoTile, 0, 0, bodies_.size(), {}, {}});
        for (std::size_t i = 0; i < nodes_.size(); ++i)
            plan(std::uint32_t(i));
    }

    std::vector<MadeTile> tiles() const {
        std::vector<MadeTile> tiles;
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            const Node& node = nodes_[i];
            MadeTile tile;
            tile.parent = node.parent;
            tile.refine = Refine::Add;
            const auto below =
                std::span(order_).subspan(node.first + node.own, node.all - node.own);
            for (const std::uint32_t b : below)
                tile.geometricErrorMetres =
                    std::max(tile.geometricErrorMetres, kErrorPerSize * bodies_[b].sizeMetres);
            const Extent& e = node.extent;
            tile.volume =
                makeRegion(around(e.west), e.south, around(e.east), e.north, e.low, e.high).box;
            tile.path = std::to_string(i);
            tiles.push_back(std::move(tile));
        }
        return tiles;
    }

    Result<TileContent> make(const std::string& path, const DecodeOptions& options) const {
        std::size_t index = nodes_.size();
        const char* end = path.data() + path.size();
        const auto [stop, error] = std::from_chars(path.data(), end, index);
        if (error != std::errc() || stop != end || index >= nodes_.size())
            return Error{describe(path), "there is no such tile"};
        const Node& node = nodes_[index];
        const Extent& e = node.extent;
        BuildingTriangles triangles(
            ecefOf({around((e.west + e.east) / 2.0), (e.south + e.north) / 2.0, e.low}));
        for (const std::uint32_t b : std::span(order_).subspan(node.first, node.own))
            triangles.add(bodies_[b], b);
        return contentOf(triangles, options);
    }
    std::string describe(const std::string& path) const { return name_ + ", tile " + path; }

    const BuildingBody* at(glm::dvec2 lonLat) const {
        const BuildingBody* best = nullptr;
        if (std::isfinite(lonLat.x) && std::isfinite(lonLat.y))
            find(0, lonLat, best);
        return best;
    }
    const std::vector<BuildingBody>& bodies() const { return bodies_; }

  private:
    // Longitudes go on from `start_`, so that a city at 180 degrees is in one piece.
    double onward(double longitude) const {
        return start_ + std::remainder(longitude - start_, 360.0);
    }
    static double around(double longitude) { return std::remainder(longitude, 360.0); }

    Extent extentOf(const BuildingBody& body) const {
        const double west = onward(body.west);
        return {west,
                body.south,
                std::min(body.baseMetres, body.topMetres),
                west + (body.east - body.west),
                body.north,
                std::max(body.baseMetres, body.topMetres)};
    }
    glm::dvec2 middle(std::uint32_t b) const {
        const BuildingBody& body = bodies_[b];
        return {onward((body.west + body.east) / 2.0), (body.south + body.north) / 2.0};
    }

    // The largest stay, the others go to four children by place.
    void plan(std::uint32_t index) {
        Node node = nodes_[index];
        const auto begin = order_.begin() + std::ptrdiff_t(node.first);
        for (std::size_t i = 0; i < node.all; ++i)
            node.extent.add(extentOf(bodies_[order_[node.first + i]]));
        node.own = node.all <= kMostInLeaf ? node.all : kOwn;
        std::nth_element(begin, begin + std::ptrdiff_t(node.own - 1),
                         begin + std::ptrdiff_t(node.all), [&](std::uint32_t a, std::uint32_t b) {
                             const double s = bodies_[a].sizeMetres, t = bodies_[b].sizeMetres;
                             return s != t ? s > t : a < b;
                         });
        std::sort(begin, begin + std::ptrdiff_t(node.own)); // the file's order
        if (node.own < node.all) {
            const std::size_t first = node.first + node.own, count = node.all - node.own;
            const std::size_t half = halve(first, count);
            for (const auto& [start, length] :
                 {std::pair(first, half), std::pair(first + half, count - half)}) {
                const std::size_t quarter = halve(start, length);
                for (const auto& [f, n] :
                     {std::pair(start, quarter), std::pair(start + quarter, length - quarter)})
                    if (n > 0) {
                        node.children.push_back(std::uint32_t(nodes_.size()));
                        nodes_.push_back({index, f, 0, n, {}, {}});
                    }
            }
        }
        nodes_[index] = std::move(node);
    }

    // Across the longer side; returns how many go to the first half.
    std::size_t halve(std::size_t first, std::size_t count) {
        if (count < 2)
            return count;
        glm::dvec2 low(1e9), high(-1e9);
        const double across = std::cos(bodies_.front().south * kRadiansPerDegree);
        for (std::size_t i = first; i < first + count; ++i) {
            low = glm::min(low, middle(order_[i]));
            high = glm::max(high, middle(order_[i]));
        }
        const int axis = (high.x - low.x) * across >= high.y - low.y ? 0 : 1;
        const auto begin = order_.begin() + std::ptrdiff_t(first);
        const std::size_t half = (count + 1) / 2;
        std::nth_element(begin, begin + std::ptrdiff_t(half), begin + std::ptrdiff_t(count),
                         [&](std::uint32_t a, std::uint32_t b) {
                             const glm::dvec2 p = middle(a), q = middle(b);
                             return p[axis] != q[axis] ? p[axis] < q[axis] : a < b;
                         });
        return half;
    }

    void find(std::uint32_t index, glm::dvec2 lonLat, const BuildingBody*& best) const {
        const Node& node = nodes_[index];
        double x = onward(lonLat.x);
        x = x < node.extent.west ? x + 360.0 : x > node.extent.east ? x - 360.0 : x;
        if (x < node.extent.west || x > node.extent.east || lonLat.y < node.extent.south ||
            lonLat.y > node.extent.north)
            return;
        for (const std::uint32_t b : std::span(order_).subspan(node.first, node.own))
            if ((best == nullptr || bodies_[b].topMetres > best->topMetres) &&
                covers(bodies_[b], lonLat))
                best = &bodies_[b];
        for (const std::uint32_t child : node.children)
            find(child, lonLat, best);
    }

    static TileContent contentOf(const BuildingTriangles& triangles, const DecodeOptions& options) {
        TileContent content;
        content.meshes =
            split(triangles.soup, triangles.clean, triangles.ecefFromTile, options.meshAxes);
        content.materials.emplace_back();
        content.facts = factsOf(triangles.clean);
        content.facts.format = "buildings";
        return content;
    }

    std::vector<BuildingBody> bodies_;
    std::string name_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
    double start_ = 0.0;
};

class BuildingMaker : public ContentMaker {
  public:
    explicit BuildingMaker(std::shared_ptr<const BuildingSet> set) : set_(std::move(set)) {}
    Result<TileContent> make(const std::string& path, const DecodeOptions& options) const override {
        try {
            return set_->make(path, options);
        } catch (const std::exception&) { // out of memory
            return Error{describe(path), "does not fit into memory"};
        }
    }
    std::string describe(const std::string& path) const override { return set_->describe(path); }

  private:
    std::shared_ptr<const BuildingSet> set_;
};

BuildingFound foundOf(const BuildingBody& body) {
    return {body.id, body.attributes, body.groundMetres, body.topMetres, body.heightAssumed};
}

class OpenedBuildings : public Buildings {
  public:
    OpenedBuildings(std::shared_ptr<const BuildingSet> set, FeatureFile file)
        : set_(std::move(set)), file_(std::move(file)) {}

    MadeTileset tiles() const override {
        return {set_->tiles(), std::make_shared<BuildingMaker>(set_)};
    }
    std::optional<BuildingFound> at(glm::dvec2 lonLat) const override {
        const BuildingBody* body = set_->at(lonLat);
        return body != nullptr ? std::optional(foundOf(*body)) : std::nullopt;
    }
    BuildingFound building(std::uint32_t feature) const override {
        return foundOf(set_->bodies()[feature]);
    }
    std::size_t size() const override { return set_->bodies().size(); }
    const FeatureFile& file() const override { return file_; }

  private:
    std::shared_ptr<const BuildingSet> set_;
    FeatureFile file_;
};

} // namespace

Result<std::shared_ptr<const Buildings>>
Buildings::of(FeatureFile file, const std::string& name, const BuildingOptions& options,
              const std::shared_ptr<const GroundHeights>& ground) {
    try {
        std::vector<BuildingBody> bodies = bodiesOf(file, name);
        if (bodies.empty())
            return Error{name, file.leftOut.empty() ? "holds no outline or surface of a building"
                                                    : "holds no building that can be used: " +
                                                          file.leftOut.front().message()};
        if (Failure failure = findHeights(bodies, options, name, file))
            return *failure;
        standOnGround(bodies, options, ground, file);
        auto set = std::make_shared<const BuildingSet>(std::move(bodies), name);
        return std::shared_ptr<const Buildings>(
            std::make_shared<OpenedBuildings>(std::move(set), std::move(file)));
    } catch (const std::exception&) { // out of memory, no thread to be had
        return Error{name, "its buildings do not fit into memory"};
    }
}

Result<std::shared_ptr<const Buildings>>
Buildings::open(const std::string& path, const BuildingOptions& options,
                const std::shared_ptr<const GroundHeights>& ground) {
    return openFeatureLayer<Buildings>(path, options, ground);
}

} // namespace gnomon
