#include "streaming/terrain/terrain.h"

#include "streaming/terrain/height_estimate.h"
#include "streaming/terrain/terrain_data.h"

#include <algorithm>
#include <cmath>
#include <thread>

namespace gnomon {

namespace {

class TileMaker : public ContentMaker {
  public:
    explicit TileMaker(std::shared_ptr<const TerrainScene> scene) : scene_(std::move(scene)) {}

    Result<TileContent> make(const std::string& path, const DecodeOptions& options) const override {
        const std::optional<TileName> name = tileNamed(*scene_, path);
        if (!name)
            return Error{path, "is no tile of this terrain"};
        return makeTerrainTile(*scene_, *name, options);
    }
    Result<std::vector<MadeTile>> below(const std::string& path) const override {
        const std::optional<TileName> name = tileNamed(*scene_, path);
        if (!name)
            return Error{path, "is no tile of this terrain"};
        return terrainTilesBelow(*scene_, *name);
    }
    std::string describe(const std::string& path) const override {
        return scene_->data->path + " (tile " + path + ")";
    }

  private:
    std::shared_ptr<const TerrainScene> scene_;
};

// Positions of a level's tiles are multiples of this power of two: the finest that 24 bits hold
// over the largest of its meshes.
std::vector<double> latticesOf(const TerrainData& data) {
    std::vector<double> out;
    constexpr int kFloatBits = 24;
    for (int level = 0; level <= data.levels.top(); ++level) {
        double relief = 0.0;
        for (const TileHeights& tile : data.tiles[std::size_t(level)].tiles)
            relief = std::max(relief, double(tile.high) - double(tile.low));
        if (level < data.knownFrom)
            relief = data.highest - data.lowest;
        // A mesh is 256 m or 32 cells wide, whichever is more; half of that to either side of its
        // origin, across and down.
        const double side = std::max(kMaxMeshExtentMetres, 32.0 * data.cellMetres(level));
        const double reach = std::sqrt(side * side / 2.0 + relief * relief);
        out.push_back(std::ldexp(1.0, std::ilogb(std::max(reach, 1.0)) + 1 - kFloatBits));
    }
    return out;
}

class RasterTerrain : public Terrain {
  public:
    explicit RasterTerrain(std::shared_ptr<const TerrainData> data) : data_(std::move(data)) {}

    const TerrainFacts& facts() const override { return data_->facts; }

    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        std::vector<glm::dvec2> pixels(lonLat.size());
        data_->place->pixelsOf(lonLat, pixels);
        const std::span<double> out = heights.first(lonLat.size());
        data_->samples->between(pixels, out);
        data_->place->heightsAt(lonLat, pixels, out);
    }

    MadeTileset tiles(std::vector<std::shared_ptr<const GroundHeights>> above,
                      std::vector<std::shared_ptr<const Drape>> drapes) const override {
        auto scene = std::make_shared<TerrainScene>();
        scene->data = data_;
        scene->above = std::move(above);
        scene->drapes = std::move(drapes);
        for (const auto& drape : scene->drapes)
            if (const double texel = drape->texelMetres(); std::isfinite(texel) && texel > 0.0)
                scene->finestTexelMetres = scene->finestTexelMetres == 0.0
                                               ? texel
                                               : std::min(scene->finestTexelMetres, texel);
        scene->lattice = latticesOf(*data_);
        return terrainTiles(scene, std::make_shared<TileMaker>(scene));
    }

  private:
    std::shared_ptr<const TerrainData> data_;
};

// The raster's own system, else the one given.
Failure findSystem(TerrainData& data, const TerrainOptions& options) {
    const std::optional<std::string>& own = data.raster.crs();
    if (!own && !options.crs)
        return Error{data.path, "does not name its coordinate reference system; give it with --crs "
                                "EPSG:n"};
    const auto place = [&](const std::string& crs) -> Failure {
        auto made = TerrainPlace::create(data.raster, crs, options.heights, options.raiseMetres);
        if (!made)
            return made.error();
        const glm::dvec2 middle = 0.5 * glm::dvec2(data.levels.pixels - 1);
        if (const Result<PlacedPixel> there = (*made)->at(middle, 0.0); !there)
            return there.error();
        data.place = std::move(*made);
        return {};
    };
    Failure wrong;
    if (own) {
        wrong = place(*own);
        data.facts.crs = data.raster.crsName();
        if (!wrong || !options.crs)
            return wrong ? Failure(Error{data.path, wrong->message()}) : Failure();
        data.facts.notes.push_back("the system it names cannot be used (" + wrong->message() +
                                   "); " + *options.crs + " was taken, as given");
    }
    data.facts.crs = *options.crs;
    if (const Failure given = place(*options.crs))
        return Error{"--crs", given->message(), ErrorKind::Usage};
    return {};
}

Failure readHeights(TerrainData& data, const TerrainOptions& options) {
    const glm::ivec2 size = data.levels.pixels;
    const bool all = std::int64_t(size.x) * size.y <= options.mostPixelsRead ||
                     data.levels.top() < kWholeTileLevel;
    TerrainFacts& facts = data.facts;
    facts.errorIsBound = all;
    if (all) {
        const unsigned threads = std::max(std::thread::hardware_concurrency(), 1u);
        Result<HeightScan> scan = scanHeights(data.raster, data.levels, threads, options.progress);
        if (!scan)
            return scan.error();
        data.tiles = std::move(scan->levels);
        facts.dataShare = double(scan->pixelsWithData) / (double(size.x) * double(size.y));
        data.samples = std::make_unique<HeightSamples>(data.raster, data.levels,
                                                       std::move(scan->coarse), 1 << 30);
        return {};
    }
    Result<CoarseHeights> coarse =
        HeightSamples::readCoarse(data.raster, data.levels, options.progress);
    if (!coarse)
        return coarse.error();
    Result<HeightEstimate> estimate = estimateHeights(data.raster, data.levels, *coarse);
    if (!estimate)
        return estimate.error();
    data.tiles = std::move(estimate->levels);
    data.usualError = std::move(estimate->usualError);
    data.knownFrom = kWholeTileLevel;
    facts.dataShare = estimate->dataShare;
    data.samples = std::make_unique<HeightSamples>(data.raster, data.levels, std::move(*coarse),
                                                   kWholeTileLevel);
    facts.notes.push_back(
        "too large to be read at opening: how far coarse tiles are off is "
        "estimated from a part of it" +
        std::string(facts.hasOverviews ? "" : "; with overviews (gdaladdo) it would open faster"));
    return {};
}

// Range, cell size and extent, on the Earth.
void describe(TerrainData& data) {
    TerrainFacts& facts = data.facts;
    const TileHeights& root = data.tiles.back().tiles.front();
    data.lowest = double(root.low);
    data.highest = double(root.high);
    if (data.look != TerrainLook::Plain)
        facts.rampHeights = {data.lowest, data.highest};
    const glm::dvec2 last(data.levels.pixels - 1);
    const auto at = [&](glm::dvec2 pixel) { return data.place->at(pixel, 0.0); };
    const glm::dvec2 middle = 0.5 * last;
    const auto side = [&](glm::dvec2 step) {
        const Result<PlacedPixel> a = at(middle - 0.5 * step), b = at(middle + 0.5 * step);
        return a && b ? length(b->ecef() - a->ecef()) : 0.0;
    };
    const double across = side({1, 0}), down = side({0, 1});
    facts.cellMetres = std::min(across, down);
    data.longerCellMetres = std::max(across, down);
    facts.minHeightMetres = std::numeric_limits<double>::infinity();
    facts.maxHeightMetres = -facts.minHeightMetres;
    constexpr int kSides = 32;
    double west = 0, east = 0, south = 90, north = -90, first = 0;
    bool any = false;
    for (int j = 0; j <= kSides; ++j)
        for (int i = 0; i <= kSides; ++i) {
            const Result<PlacedPixel> place =
                data.place->at(last * glm::dvec2(i, j) / double(kSides), data.lowest);
            if (!place)
                continue;
            const glm::dvec2 p = place->lonLat();
            first = any ? first : p.x;
            any = true;
            const double off = std::remainder(p.x - first, 360.0);
            west = std::min(west, off);
            east = std::max(east, off);
            south = std::min(south, p.y);
            north = std::max(north, p.y);
            facts.minHeightMetres = std::min(facts.minHeightMetres, place->heightMetres);
            facts.maxHeightMetres =
                std::max(facts.maxHeightMetres, place->heightMetres + data.highest - data.lowest);
        }
    facts.extent = {first + west, south, first + east, north};
    facts.rootErrorMetres = data.heightError(data.levels.top(), root);
}

} // namespace

Result<std::shared_ptr<const Terrain>> Terrain::open(const std::string& path,
                                                     const TerrainOptions& options) {
    Result<Raster> raster = Raster::open(path, {options.variable, false, false});
    if (!raster)
        return raster.error();
    auto data = std::make_shared<TerrainData>(std::move(*raster));
    data->path = path;
    data->look = options.look;
    TerrainFacts& facts = data->facts;
    facts.columns = data->levels.pixels.x;
    facts.rows = data->levels.pixels.y;
    facts.hasOverviews = !data->raster.overviewFactors().empty();
    facts.credits = data->raster.credits();
    facts.notes = data->raster.notes();
    if (facts.columns < 2 || facts.rows < 2)
        return Error{path, "is one pixel wide: a surface takes two"};
    if (const Failure wrong = findSystem(*data, options))
        return *wrong;
    if (const Failure wrong = readHeights(*data, options))
        return *wrong;
    const TileHeights& root = data->tiles.back().tiles.front();
    if (!(root.low <= root.high))
        return Error{path, "has no data anywhere: all its pixels are empty"};
    if (!root.surface)
        return Error{path, "has single pixels with data only: no three of them make a surface"};
    describe(*data);
    return std::shared_ptr<const Terrain>(std::make_shared<RasterTerrain>(std::move(data)));
}

} // namespace gnomon
