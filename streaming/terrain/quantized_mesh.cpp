#include "streaming/terrain/quantized_mesh_scene.h"
#include "streaming/terrain/terrain_data.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <list>

namespace gnomon {

Failure HeightShift::prepare(const std::array<double, 4>& extent) {
    if (heights_ == Heights::Ellipsoidal)
        return {};
    // The geoid's grid has a height every quarter of a degree.
    static constexpr double kStepDegrees = 0.25;
    static constexpr double kMostNodes = 129.0;
    const auto nodes = [](double from, double to) {
        return int(std::clamp(std::ceil((to - from) / kStepDegrees) + 1.0, 2.0, kMostNodes));
    };
    columns_ = nodes(extent[0], extent[2]);
    rows_ = nodes(extent[1], extent[3]);
    geoid_.clear();
    for (int j = 0; j < rows_; ++j)
        for (int i = 0; i < columns_; ++i) {
            const double lon = std::lerp(extent[0], extent[2], double(i) / (columns_ - 1));
            const double lat = std::lerp(extent[1], extent[3], double(j) / (rows_ - 1));
            const Result<double> height = egm96GeoidHeight(lon, lat);
            if (!height)
                return height.error();
            geoid_.push_back(*height);
        }
    return {};
}

double HeightShift::at(glm::dvec2 place) const {
    if (geoid_.empty())
        return raise_;
    const double x = std::clamp(place.x / kQuantizedMost, 0.0, 1.0) * (columns_ - 1);
    const double y = std::clamp(place.y / kQuantizedMost, 0.0, 1.0) * (rows_ - 1);
    const int i = std::min(int(x), columns_ - 2), j = std::min(int(y), rows_ - 2);
    const double* g = &geoid_[std::size_t(j * columns_ + i)];
    return raise_ + std::lerp(std::lerp(g[0], g[1], x - i),
                              std::lerp(g[columns_], g[columns_ + 1], x - i), y - j);
}

double HeightShift::least() const {
    return raise_ + (geoid_.empty() ? 0.0 : *std::min_element(geoid_.begin(), geoid_.end()));
}

double HeightShift::most() const {
    return raise_ + (geoid_.empty() ? 0.0 : *std::max_element(geoid_.begin(), geoid_.end()));
}

double QuantizedCore::errorOf(const QuantizedPlace& place) const {
    if (pyramid->has(place))
        if (const auto summary = pyramid->summary(place); summary && summary->geometricErrorMetres)
            return *summary->geometricErrorMetres;
    constexpr double kSamples = 65.0;
    constexpr double kQuarter = 0.25 * 2.0 * 3.14159265358979323846 * kEquatorialRadiusMetres;
    return std::ldexp(kQuarter / kSamples, -int(place.level + (pyramid->webMercator() ? 0 : 1)));
}

bool QuantizedScene::isNearAbove(const std::array<double, 4>& extent) const {
    for (const auto& ground : above) {
        const auto around = ground->extent();
        if (!around || overlap(*around, extent))
            return true;
    }
    return false;
}

QuantizedScene::Covered QuantizedScene::coverage(const std::array<double, 4>& extent) const {
    if (!isNearAbove(extent))
        return Covered::Nothing;
    constexpr int kLooks = 9; // a side
    std::vector<glm::dvec2> places;
    for (int j = 0; j < kLooks; ++j)
        for (int i = 0; i < kLooks; ++i)
            places.push_back({std::lerp(extent[0], extent[2], double(i) / (kLooks - 1)),
                              std::lerp(extent[1], extent[3], double(j) / (kLooks - 1))});
    std::vector<char> covered(places.size(), 0);
    std::vector<double> heights(places.size());
    for (const auto& ground : above) {
        ground->sample(places, heights);
        for (std::size_t i = 0; i < places.size(); ++i)
            covered[i] = covered[i] || !std::isnan(heights[i]);
    }
    const bool all = std::all_of(covered.begin(), covered.end(), [](char c) { return c != 0; });
    return all ? Covered::All : Covered::Part;
}

std::string nameOf(const QuantizedPlace& place) {
    return std::to_string(place.level) + "/" + std::to_string(place.x) + "/" +
           std::to_string(place.y);
}

std::optional<QuantizedPlace> quantizedPlaceNamed(const std::string& name) {
    std::uint32_t parts[3] = {};
    const char* at = name.data();
    const char* const end = name.data() + name.size();
    for (int i = 0; i < 3; ++i) {
        const auto [next, error] = std::from_chars(at, end, parts[i]);
        if (error != std::errc() || (i < 2 ? next == end || *next != '/' : next != end))
            return {};
        at = next + (i < 2 ? 1 : 0);
    }
    if (parts[0] > kDeepestLevel)
        return {};
    return QuantizedPlace{parts[0], parts[1], parts[2]};
}

namespace {

class QuantizedMaker : public ContentMaker {
  public:
    explicit QuantizedMaker(std::shared_ptr<const QuantizedScene> scene)
        : scene_(std::move(scene)) {}

    Result<TileContent> make(const std::string& path, const DecodeOptions& options) const override {
        const auto place = quantizedPlaceNamed(path);
        if (!place)
            return Error{path, "is no tile of this terrain"};
        return makeQuantizedTile(*scene_, *place, options);
    }
    Result<std::vector<MadeTile>> below(const std::string& path) const override {
        const auto place = quantizedPlaceNamed(path);
        if (!place)
            return Error{path, "is no tile of this terrain"};
        return quantizedTilesBelow(*scene_, *place);
    }
    std::string describe(const std::string& path) const override {
        return scene_->core->path + " (tile " + path + ")";
    }

  private:
    std::shared_ptr<const QuantizedScene> scene_;
};

class QuantizedTerrain : public Terrain {
  public:
    explicit QuantizedTerrain(std::shared_ptr<const QuantizedCore> core) : core_(std::move(core)) {}

    const TerrainFacts& facts() const override { return core_->facts; }

    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        const QuantizedPyramid& pyramid = *core_->pyramid;
        std::optional<QuantizedPlace> last;
        std::array<double, 4> extent{};
        std::shared_ptr<const QuantizedHeights> surface;
        for (std::size_t i = 0; i < lonLat.size(); ++i) {
            heights[i] = std::numeric_limits<double>::quiet_NaN();
            glm::dvec2 p = lonLat[i];
            if (!std::isfinite(p.x) || !(std::abs(p.y) <= 90.0))
                continue;
            p.x = std::remainder(p.x, 360.0);
            const bool inside =
                last && p.x > extent[0] && p.x < extent[2] && p.y > extent[1] && p.y < extent[3];
            if (!inside) {
                last = finestAt(p);
                if (!last)
                    continue;
                extent = extentOf(*last, pyramid.webMercator());
                surface = surfaceAt(*last);
            }
            if (surface)
                heights[i] = surface->at(p);
        }
    }

    MadeTileset tiles(std::vector<std::shared_ptr<const GroundHeights>> above,
                      std::vector<std::shared_ptr<const Drape>> drapes) const override {
        auto scene = std::make_shared<QuantizedScene>();
        scene->core = core_;
        scene->above = std::move(above);
        scene->drapes = std::move(drapes);
        return {quantizedTiles(*scene), std::make_shared<QuantizedMaker>(scene)};
    }

  private:
    static bool holds(const std::array<double, 4>& e, glm::dvec2 p) {
        return p.x >= e[0] && p.x <= e[2] && p.y >= e[1] && p.y <= e[3];
    }
    // The deepest tile there is at a place; the last of those that meet there.
    std::optional<QuantizedPlace> finestAt(glm::dvec2 p) const {
        const QuantizedPyramid& pyramid = *core_->pyramid;
        std::optional<QuantizedPlace> found;
        for (const QuantizedPlace& root : pyramid.roots())
            if (holds(extentOf(root, pyramid.webMercator()), p))
                found = root;
        for (bool deeper = found.has_value(); deeper && found->level < kDeepestLevel;) {
            deeper = false;
            const QuantizedPlace above = *found;
            for (unsigned i = 0; i < 4; ++i)
                if (holds(extentOf(above.child(i), pyramid.webMercator()), p) &&
                    pyramid.has(above.child(i))) {
                    found = above.child(i);
                    deeper = true;
                }
        }
        return found;
    }

    // The last used are kept.
    std::shared_ptr<const QuantizedHeights> surfaceAt(const QuantizedPlace& place) const {
        {
            const std::lock_guard lock(mutex_);
            for (auto it = kept_.begin(); it != kept_.end(); ++it)
                if (it->first == place) {
                    kept_.splice(kept_.begin(), kept_, it);
                    return kept_.front().second;
                }
        }
        Result<QuantizedTile> tile = core_->pyramid->read(place);
        std::shared_ptr<const QuantizedHeights> surface;
        if (tile) {
            const std::array<double, 4> extent = extentOf(place, core_->pyramid->webMercator());
            QuantizedPart part = wholeOf(std::move(*tile));
            HeightShift shift(core_->heights, core_->raiseMetres);
            if (shift.prepare(extent))
                return nullptr;
            for (std::size_t i = 0; i < part.heights.size(); ++i)
                part.heights[i] += shift.at(part.places[i]);
            surface = std::make_shared<const QuantizedHeights>(std::move(part), extent);
        }
        constexpr std::size_t kMostKept = 64, kMostBytes = std::size_t(96) << 20;
        const std::lock_guard lock(mutex_);
        kept_.push_front({place, surface}); // also that there is none
        std::size_t bytes = 0, count = 0;
        for (auto it = kept_.begin(); it != kept_.end();) {
            bytes += it->second ? it->second->bytes() : 0;
            const bool keep = ++count == 1 || (count <= kMostKept && bytes <= kMostBytes);
            it = keep ? std::next(it) : kept_.erase(it);
        }
        return surface;
    }

    std::shared_ptr<const QuantizedCore> core_;
    mutable std::mutex mutex_;
    mutable std::list<std::pair<QuantizedPlace, std::shared_ptr<const QuantizedHeights>>> kept_;
};

// Heights of some tiles over the extent, finer ones where few are enough.
void findHeights(QuantizedCore& core) {
    constexpr std::size_t kMostLooked = 64;
    const QuantizedPyramid& pyramid = *core.pyramid;
    std::vector<QuantizedPlace> places = pyramid.roots();
    for (;;) {
        std::vector<QuantizedPlace> finer;
        for (const QuantizedPlace& place : places)
            for (unsigned i = 0; i < 4 && place.level < kDeepestLevel; ++i)
                if (overlap(extentOf(place.child(i), pyramid.webMercator()), pyramid.extent()) &&
                    pyramid.has(place.child(i)))
                    finer.push_back(place.child(i));
        if (finer.empty() || finer.size() > kMostLooked)
            break;
        places = std::move(finer);
    }
    bool any = false;
    for (std::size_t i = 0; i < std::min(places.size(), kMostLooked); ++i)
        if (const auto summary = pyramid.summary(places[i])) {
            const QuantizedHeader& h = summary->header;
            core.lowest = any ? std::min(core.lowest, h.minHeightMetres) : h.minHeightMetres;
            core.highest = any ? std::max(core.highest, h.maxHeightMetres) : h.maxHeightMetres;
            any = true;
        }
}

void findFacts(QuantizedCore& core, const HeightShift& shift) {
    const QuantizedPyramid& pyramid = *core.pyramid;
    TerrainFacts& facts = core.facts;
    facts.crs = pyramid.webMercator() ? "EPSG:3857" : "EPSG:4326";
    facts.extent = pyramid.extent();
    facts.minHeightMetres = core.lowest + shift.least();
    facts.maxHeightMetres = core.highest + shift.most();
    if (core.look != TerrainLook::Plain)
        facts.rampHeights = {core.lowest, core.highest};
    facts.errorIsBound = false;
    for (const QuantizedPlace& root : pyramid.roots())
        facts.rootErrorMetres = std::max(facts.rootErrorMetres, core.errorOf(root));
    // As if a tile had the usual 65 samples a side.
    const glm::dvec2 side = metresOf(facts.extent);
    const double degrees =
        std::ldexp(pyramid.webMercator() ? 360.0 : 180.0, -int(pyramid.deepestLevel()));
    const double tiles = std::max(1.0, (facts.extent[2] - facts.extent[0]) / degrees);
    facts.cellMetres = std::min(side.x, side.y) / tiles / 64.0;
    facts.notes = pyramid.notes();
    facts.credits = pyramid.credits();
}

} // namespace

namespace {

Result<std::shared_ptr<const Terrain>>
terrainOf(Result<std::unique_ptr<const QuantizedPyramid>> pyramid, const std::string& path,
          const TerrainOptions& options) {
    if (!pyramid)
        return pyramid.error();
    auto core = std::make_shared<QuantizedCore>();
    core->path = path;
    core->look = options.look;
    core->heights = options.heights;
    core->raiseMetres = options.raiseMetres;
    core->pyramid = std::move(*pyramid);
    HeightShift shift(options.heights, options.raiseMetres);
    if (const Failure wrong = shift.prepare(core->pyramid->extent()))
        return *wrong;
    findHeights(*core);
    findFacts(*core, shift);
    return std::shared_ptr<const Terrain>(std::make_shared<QuantizedTerrain>(std::move(core)));
}

} // namespace

Result<std::shared_ptr<const Terrain>> openQuantizedMesh(const std::string& path,
                                                         const TerrainOptions& options) {
    return terrainOf(QuantizedPyramid::open(path), path, options);
}

Result<std::shared_ptr<const Terrain>> openQuantizedMesh(std::shared_ptr<const Source> source,
                                                         const std::string& path,
                                                         const TerrainOptions& options) {
    const std::string shown = source->describe(path);
    return terrainOf(QuantizedPyramid::open(std::move(source), path), shown, options);
}

} // namespace gnomon
