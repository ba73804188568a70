#include "streaming/features/barriers.h"

#include "streaming/features/barriers_solid.h"
#include "streaming/features/feature_layer.h"
#include "streaming/features/vertex_color.h"
#include "streaming/split.h"

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>

namespace gnomon {

namespace {

// A tile of them: some 2 MB decoded.
constexpr std::size_t kMostTriangles = 16384;

glm::dvec3 colorOf(BarrierMaterial material) {
    switch (material) {
    case BarrierMaterial::Earth:
        return {0.47, 0.52, 0.33};
    case BarrierMaterial::Sand:
        return {0.74, 0.65, 0.47};
    case BarrierMaterial::Wall:
        break;
    }
    return {0.64, 0.63, 0.60};
}

using Solids = std::vector<BarrierSolid>;

OrientedBox boxOf(std::span<const BarrierSolid> solids) {
    std::vector<Point<Ecef>> points;
    for (const BarrierSolid& solid : solids)
        for (const glm::dvec3& p : solid.positions)
            points.push_back(solid.origin + Vector<Ecef>{p});
    const Geodetic middle = geodeticOf(solids[solids.size() / 2].origin);
    return boxAround(points, ecefFromEnu(middle).axes());
}

std::size_t trianglesOf(std::span<const BarrierSolid> solids) {
    std::size_t count = 0;
    for (const BarrierSolid& solid : solids)
        count += solid.triangles.size();
    return count;
}

struct Range {
    std::size_t first = 0, count = 0;
};

class BarrierMaker : public ContentMaker {
  public:
    BarrierMaker(std::string name, Solids solids)
        : name_(std::move(name)), solids_(std::move(solids)) {}

    // Lays out the tiles: halves until few enough triangles are left. Each solid is in one tile.
    std::vector<MadeTile> plan() {
        std::vector<MadeTile> tiles;
        std::vector<Range> ranges{{0, solids_.size()}};
        std::vector<TileIndex> parents{kNoTile};
        for (std::size_t i = 0; i < ranges.size(); ++i) {
            const Range range = ranges[i];
            MadeTile tile;
            tile.parent = parents[i];
            if (range.count > 1 && trianglesOf(in(range)) > kMostTriangles) {
                tile.content = ContentKind::None;
                const std::size_t half = halve(range);
                ranges.push_back({range.first, half});
                ranges.push_back({range.first + half, range.count - half});
                parents.insert(parents.end(), 2, TileIndex(i));
            } else {
                tile.path = "barriers " + std::to_string(range.first) + " to " +
                            std::to_string(range.first + range.count - 1);
                ranges_.emplace(tile.path, range);
            }
            tile.volume = boxOf(in(range));
            tiles.push_back(std::move(tile));
        }
        return tiles;
    }

    Result<TileContent> make(const std::string& path, const DecodeOptions& options) const override {
        const auto at = ranges_.find(path);
        if (at == ranges_.end())
            return Error{describe(path), "there is no such tile"};
        Transform<Ecef, Tile> ecefFromTile;
        const Point<Ecef> centre = boxOf(in(at->second)).centre;
        ecefFromTile.matrix[3] = glm::dvec4(centre.xyz, 1.0);
        Soup soup;
        CleanSoup cleaned;
        cleaned.origin = centre;
        for (const BarrierSolid& solid : in(at->second))
            add(solid, centre, soup, cleaned);
        cleaned.local = soup.positions;
        cleaned.triangles = soup.triangles;
        TileContent content;
        content.materials.emplace_back();
        content.meshes = split(soup, cleaned, ecefFromTile, options.meshAxes);
        content.facts = factsOf(cleaned);
        content.facts.format = "barriers";
        return content;
    }
    std::string describe(const std::string& path) const override { return name_ + ", " + path; }

  private:
    std::span<const BarrierSolid> in(const Range& range) const {
        return std::span(solids_).subspan(range.first, range.count);
    }

    // Across the longest side of the box around their origins.
    std::size_t halve(const Range& range) {
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        for (const BarrierSolid& solid : in(range)) {
            low = glm::min(low, solid.origin.xyz);
            high = glm::max(high, solid.origin.xyz);
        }
        const glm::dvec3 size = high - low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto begin = solids_.begin() + std::ptrdiff_t(range.first);
        std::stable_sort(begin, begin + std::ptrdiff_t(range.count),
                         [&](const BarrierSolid& a, const BarrierSolid& b) {
                             return a.origin.xyz[axis] < b.origin.xyz[axis];
                         });
        return range.count / 2;
    }

    static void add(const BarrierSolid& solid, Point<Ecef> centre, Soup& soup, CleanSoup& cleaned) {
        const glm::dvec3 offset = (solid.origin - centre).xyz;
        const std::uint32_t color = linearRgba(colorOf(solid.material));
        const auto first = std::uint32_t(soup.positions.size());
        for (const glm::dvec3& p : solid.positions) {
            soup.positions.push_back(offset + p);
            soup.normals.emplace_back(0.0f); // faces are flat
            soup.uvs.emplace_back(0.0f);
            soup.colors.push_back(color);
            soup.features.push_back(kNoFeature);
        }
        for (const auto& t : solid.triangles)
            soup.triangles.push_back({{first + t[0], first + t[1], first + t[2]}, 0, Soup::Colors});
        cleaned.closed.insert(cleaned.closed.end(), solid.closed.begin(), solid.closed.end());
        const auto closed = std::size_t(std::ranges::count(solid.closed, 1));
        cleaned.closedTriangles += closed;
        ++cleaned.components;
        cleaned.closedComponents += closed == solid.triangles.size();
    }

    std::string name_;
    Solids solids_; // those of a tile side by side
    std::unordered_map<std::string, Range> ranges_;
};

// Those that stand over one time, put up.
struct Standing {
    Solids solids;
    std::optional<UtcTime> from, until;
    std::size_t count = 0;
};

std::vector<Standing> putUp(const std::vector<BarrierFacts>& barriers, const GroundHeights& ground,
                            FeatureFile& file) {
    constexpr double kAlways = std::numeric_limits<double>::infinity();
    std::map<std::pair<double, double>, Standing> groups;
    for (const BarrierFacts& barrier : barriers) {
        Result<Solids> solids = solidsOf(barrier, ground);
        if (!solids) {
            leaveOutBarrier(file, barrier.id, solids.error().reason);
            continue;
        }
        Standing& group = groups[{barrier.from ? barrier.from->seconds : -kAlways,
                                  barrier.until ? barrier.until->seconds : kAlways}];
        group.from = barrier.from;
        group.until = barrier.until;
        ++group.count;
        for (BarrierSolid& solid : *solids)
            group.solids.push_back(std::move(solid));
    }
    std::vector<Standing> out;
    for (auto& [time, group] : groups)
        out.push_back(std::move(group));
    return out;
}

} // namespace

Result<Barriers> Barriers::of(FeatureFile file, const std::string& name,
                              const BarrierOptions& options,
                              const std::shared_ptr<const GroundHeights>& ground) {
    Barriers barriers;
    barriers.file = std::move(file);
    const std::size_t before = barriers.file.leftOut.size();
    const std::vector<BarrierFacts> all = barriersOf(barriers.file, options);
    barriers.file.features.clear();
    barriers.file.features.shrink_to_fit();
    const auto stands = ground ? ground : flatGround(0.0);
    for (Standing& standing : putUp(all, *stands, barriers.file)) {
        BarrierGroup& group = barriers.groups.emplace_back();
        group.from = standing.from;
        group.until = standing.until;
        group.count = standing.count;
        const auto maker = std::make_shared<BarrierMaker>(name, std::move(standing.solids));
        group.tiles.tiles = maker->plan();
        group.tiles.maker = maker;
    }
    nameLeftOut(barriers.file, before, name);
    if (barriers.groups.empty())
        return nothingOf(barriers.file, name, "barriers");
    return barriers;
}

Result<Barriers> Barriers::open(const std::string& path, const BarrierOptions& options,
                                const std::shared_ptr<const GroundHeights>& ground) {
    return openFeatureLayer<Barriers>(path, options, ground);
}

} // namespace gnomon
