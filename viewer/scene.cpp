#include "viewer/scene.h"

#include "viewer/input.h"
#include "viewer/lamps_file.h"
#include "viewer/raster_tiles.h"
#include "viewer/scene_file.h"
#include "viewer/scene_placement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace gnomon {

namespace {

// Enough to know where the ground is and which way is up; the same tiles are drawn later anyway.
constexpr std::size_t kContentsLookedAt = 4;
// A vertex in twenty may lie below the base: cellars, moats, stray points.
constexpr double kBelowBase = 0.05;

struct HeightRange {
    double base = 0.0, top = 0.0;
};

struct OpenedLayer {
    Layer layer;
    Sphere bounds;
    std::optional<Geodetic> origin;     // of its own frame, when that stands upright on the Earth
    std::optional<HeightRange> heights; // above the ellipsoid; of the contents looked at
};

struct Opening {
    const LoaderOptions& loader;
    bool unplaced;
    std::vector<Problem>& problems;

    void note(const std::string& uri, const std::string& reason) {
        problems.push_back({Problem::Severity::Note, uri, reason});
    }
    void warn(const std::string& uri, const std::string& reason) {
        problems.push_back({Problem::Severity::Warning, uri, reason});
    }
};

std::string inWords(const glm::dvec3& p) {
    char text[96];
    std::snprintf(text, sizeof text, "%.6g, %.6g, %.6g", p.x, p.y, p.z);
    return text;
}

Result<Transform<Ecef, Tile>> frameFromCrs(const PlacingOptions& options, const Sphere& local) {
    const Result<CrsToEcef> crs = CrsToEcef::create(*options.crs, options.heights);
    if (!crs)
        return Error{"--crs", crs.error().message(), ErrorKind::Usage};
    glm::dvec3 centre = local.centre.xyz;
    Result<Transform<Ecef, Tile>> frame = crs->ecefFromCrsNear(centre);
    if (!frame || options.raiseMetres == 0.0)
        return frame;
    glm::dmat4 raised(1.0);
    raised[3] = glm::dvec4(0, 0, options.raiseMetres, 1);
    return *frame * Transform<Tile, Tile>{raised};
}

Transform<Ecef, Tile> frameFromPlace(const Input& input, const PlacingOptions& options,
                                     StreamedTileset& local, Opening& opening) {
    FrameUp up = options.up == ModelUp::Y ? FrameUp::Y : FrameUp::Z;
    if (input.kind == InputKind::Model) {
        // glTF says y is up, and decoding has turned that to z.
        up = options.up == ModelUp::Z ? FrameUp::MinusY : FrameUp::Z;
    } else if (options.up == ModelUp::Auto &&
               upFromGeometry(firstContents(local, 1)) == ModelUp::Y) {
        up = FrameUp::Y;
        opening.note(input.uri, "up axis y found from its geometry; --up z overrides");
    }
    const Sphere bounds = boundingSphere(local.tree().node(TileTree::root()).volume);
    const double fromOrigin = glm::length(bounds.centre.xyz);
    constexpr double kFar = 10.0; // times its own size: hardly meant
    if (fromOrigin > kFar * 2.0 * bounds.radiusMetres)
        opening.warn(input.uri, "it lies " + std::to_string(std::llround(fromOrigin)) +
                                    " m from its own origin, which is what --place puts at the "
                                    "place given; perhaps it needs --crs");
    return placedFrame(*options.placement, options.raiseMetres, up);
}

Result<Transform<Ecef, Tile>> frameFor(const Input& input, const PlacingOptions& options,
                                       StreamedTileset& local, Opening& opening) {
    if (options.placement)
        return frameFromPlace(input, options, local, opening);
    const Sphere bounds = boundingSphere(local.tree().node(TileTree::root()).volume);
    if (options.crs)
        return frameFromCrs(options, bounds);
    return Error{input.uri, "not on the Earth: it has a frame of its own (centred at " +
                                inWords(bounds.centre.xyz) +
                                "); say where it is with --place LON,LAT,H or --crs EPSG:n"};
}

// Heights above the ellipsoid near `centre`, to second order: about a millimetre per kilometre off,
// and the same for a place moved rigidly over the Earth, which exact heights are not.
class HeightsNear {
  public:
    explicit HeightsNear(Point<Ecef> centre)
        : centre_(centre), up_(ellipsoidNormal(centre)), height_(geodeticOf(centre).heightMetres) {}
    double operator()(Point<Ecef> p) const {
        constexpr double kMeanRadiusMetres = 6371000.0;
        const Vector<Ecef> d = p - centre_;
        const double above = dot(d, up_);
        return height_ + above + (dot(d, d) - above * above) / (2.0 * kMeanRadiusMetres);
    }

  private:
    Point<Ecef> centre_;
    Vector<Ecef> up_;
    double height_;
};

std::optional<HeightRange> heightsOf(StreamedTileset& tileset, Point<Ecef> centre) {
    const HeightsNear heightOf(centre);
    std::vector<double> heights;
    for (const auto& content : firstContents(tileset, kContentsLookedAt))
        for (const Mesh& mesh : content->meshes)
            for (const glm::vec3& p : mesh.positions)
                heights.push_back(heightOf({mesh.origin.xyz + glm::dvec3(p)}));
    if (heights.empty())
        return std::nullopt;
    std::sort(heights.begin(), heights.end());
    return HeightRange{heights[std::size_t(kBelowBase * double(heights.size()))], heights.back()};
}

// `path` is one in `source`.
Result<OpenedLayer> openLayer(const Input& input, const std::shared_ptr<const Source>& source,
                              const std::string& path, const PlacingOptions& options,
                              Opening opening) {
    auto tileset = StreamedTileset::open(source, path, Transform<Ecef, Tile>{}, opening.loader);
    if (!tileset)
        return tileset.error();
    OpenedLayer opened;
    opened.layer.uri = input.uri;
    opened.layer.kind = nameOf(input.kind);
    if (!standsOnEarth((*tileset)->tree().node(TileTree::root()).volume)) {
        const auto frame = frameFor(input, options, **tileset, opening);
        if (!frame && opening.unplaced) {
            opening.warn(input.uri, frame.error().reason);
            opened.layer.onEarth = false;
            opened.layer.tileset = std::move(*tileset);
            return opened;
        }
        if (!frame)
            return frame.error();
        tileset = StreamedTileset::open(source, path, *frame, opening.loader);
        if (!tileset)
            return tileset.error();
        if (!standsOnEarth((*tileset)->tree().node(TileTree::root()).volume))
            return Error{input.uri, "what was said about its place puts it off the Earth's "
                                    "surface; check --place or --crs"};
        opened.layer.placedByUser = true;
    } else if (options.placement || options.crs || options.raiseMetres != 0.0) {
        opening.warn(input.uri, "it has its own place on the Earth; --place, --crs and --raise "
                                "are not applied to it");
    }
    opened.layer.tileset = std::move(*tileset);
    opened.bounds = boundingSphere(opened.layer.tileset->tree().node(TileTree::root()).volume);
    opened.origin = uprightOrigin(opened.layer.tileset->tree().ecefFromTile(TileTree::root()));
    if (opened.layer.placedByUser && options.placement) {
        opened.origin = options.placement->origin;
        opened.origin->heightMetres += options.raiseMetres;
    }
    if (!opening.unplaced) // then nobody asks for the scene's anchor
        opened.heights = heightsOf(*opened.layer.tileset, opened.bounds.centre);
    return opened;
}

// The smallest sphere around two.
Sphere around(const Sphere& a, const Sphere& b) {
    const Vector<Ecef> between = b.centre - a.centre;
    const double distance = length(between);
    if (distance + b.radiusMetres <= a.radiusMetres)
        return a;
    if (distance + a.radiusMetres <= b.radiusMetres)
        return b;
    const double radius = 0.5 * (a.radiusMetres + distance + b.radiusMetres);
    return {a.centre + (radius - a.radiusMetres) / distance * between, radius};
}

// Farthest point of a layer from the anchor, seen from above.
double reachFrom(const Scene& scene, const BoundingVolume& volume) {
    const Transform<Enu, Ecef> anchorFromEcef = rigidInverse(scene.ecefFromAnchor);
    const auto across = [&](Point<Ecef> p) {
        return glm::length(glm::dvec2(anchorFromEcef(p).xyz));
    };
    if (const Sphere* sphere = std::get_if<Sphere>(&volume))
        return across(sphere->centre) + sphere->radiusMetres;
    const Region* region = std::get_if<Region>(&volume);
    double farthest = 0.0;
    for (const Point<Ecef>& corner : corners(region ? region->box : std::get<OrientedBox>(volume)))
        farthest = std::max(farthest, across(corner));
    return farthest;
}

// Where the first upright frame has its origin, if that is among what is shown: then a place moved
// rigidly over the Earth is the same scene, to rounding. Else the middle of all bounds.
Geodetic anchorFor(const std::vector<OpenedLayer>& opened, const Sphere& all,
                   const HeightRange& range) {
    // An origin this far below or above what stands there is no level to count heights from.
    constexpr double kOffLevelMetres = 100.0;
    for (const OpenedLayer& layer : opened)
        if (layer.origin && length(ecefOf(*layer.origin) - all.centre) <= all.radiusMetres &&
            layer.origin->heightMetres >= range.base - kOffLevelMetres &&
            layer.origin->heightMetres <= range.top + kOffLevelMetres)
            return *layer.origin;
    Geodetic anchor = geodeticOf(all.centre);
    if (range.base <= range.top)
        anchor.heightMetres = range.base;
    return anchor;
}

void setAnchor(Scene& scene, const std::vector<OpenedLayer>& opened) {
    Sphere all = opened.front().bounds;
    HeightRange range{std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
    for (const OpenedLayer& layer : opened) {
        all = around(all, layer.bounds);
        if (layer.heights)
            range = {std::min(range.base, layer.heights->base),
                     std::max(range.top, layer.heights->top)};
    }
    scene.anchor = anchorFor(opened, all, range);
    if (range.base <= range.top)
        scene.heightMetres = std::max(range.top - scene.anchor.heightMetres, 0.0);
    scene.ecefFromAnchor = ecefFromEnu(scene.anchor);
    for (const OpenedLayer& layer : opened)
        layer.layer.tileset->setMeshAxes(scene.ecefFromAnchor.axes());
    for (const OpenedLayer& layer : opened)
        scene.radiusMetres =
            std::max(scene.radiusMetres,
                     reachFrom(scene, layer.layer.tileset->tree().node(TileTree::root()).volume));
}

// What the command line says wins over what the scene file says.
PlacingOptions merged(const SceneOptions& options, const LayerDescription& layer) {
    PlacingOptions placing;
    placing.crs = options.crs ? options.crs : layer.crs;
    placing.heights = options.heights != Heights::Ellipsoidal
                          ? options.heights
                          : layer.heights.value_or(Heights::Ellipsoidal);
    placing.placement = options.placement ? options.placement : layer.placement;
    placing.up = options.up != ModelUp::Auto ? options.up : layer.up.value_or(ModelUp::Auto);
    placing.raiseMetres =
        options.raiseMetres != 0.0 ? options.raiseMetres : layer.raiseMetres.value_or(0.0);
    return placing;
}

class SceneOpener {
  public:
    explicit SceneOpener(const SceneOptions& options) : options_(options) {}

    void openInput(const std::string& argument) {
        const Result<Input> input = identifyInput(argument);
        if (!input)
            return fail(input.error());
        if (input->kind == InputKind::SceneFile)
            return openSceneFile(input->path);
        if (input->kind == InputKind::Lamps)
            return openLamps(input->path);
        openOne(*input, merged(options_, {}));
    }
    void openServed(const Input& input, const std::shared_ptr<const Source>& source) {
        add(openLayer(input, source, input.path, merged(options_, {}), opening()));
    }

    Result<Scene> finish() {
        if (opened_.empty())
            return first_.value_or(Error{"INPUT", "nothing to open", ErrorKind::Usage});
        if (!options_.unplaced) {
            setAnchor(scene_, opened_);
            for (const LampsFile::Entry& entry : lamps_)
                scene_.lamps.push_back(placedLamp(entry, scene_.anchor.heightMetres));
        }
        for (OpenedLayer& layer : opened_)
            scene_.layers.push_back(std::move(layer.layer));
        return std::move(scene_);
    }

  private:
    void fail(const Error& error) {
        if (!first_)
            first_ = error;
        scene_.problems.push_back({Problem::Severity::Error, error.subject, error.reason});
    }

    void openOne(const Input& input, const PlacingOptions& placing) {
        if (input.kind == InputKind::Terrain)
            return openTerrain(input, placing);
        const SplitPath split = splitPath(input.path);
        add(openLayer(input, fileSource(split.folder), split.name, placing, opening()));
    }

    Opening opening() { return {options_.loader, options_.unplaced, scene_.problems}; }
    void add(Result<OpenedLayer> layer) {
        if (!layer)
            return fail(layer.error());
        opened_.push_back(std::move(*layer));
    }

    void openTerrain(const Input& input, const PlacingOptions& placing) {
        const Result<RasterTiles> tiles = rasterTiles(input.path, placing);
        if (!tiles)
            return fail(tiles.error());
        for (const Problem& note : tiles->notes)
            scene_.problems.push_back(note);
        if (placing.placement)
            opening().warn(input.uri, "it has its own place on the Earth; --place is not applied "
                                      "to it");
        if (placing.crs && tiles->crs != *placing.crs)
            opening().warn(input.uri, "it names its own system, " + tiles->crs +
                                          "; --crs is not applied to it");
        add(openLayer(input, tiles->source, tiles->path, {}, opening()));
        if (!opened_.empty() && opened_.back().layer.uri == input.uri) {
            opened_.back().layer.crs = tiles->crs;
            opened_.back().layer.size = {tiles->columns, tiles->rows};
        }
    }

    void openLamps(const std::string& path) {
        const Result<LampsFile> file = readLampsFile(path);
        if (!file)
            return fail(file.error());
        lamps_.insert(lamps_.end(), file->entries.begin(), file->entries.end());
        if (file->others > 0)
            opening().warn(path, std::to_string(file->others) +
                                     " features are no points, so they are left out");
    }

    void openSceneFile(const std::string& path) {
        Result<SceneFile> file = readSceneFile(path);
        if (!file)
            return fail(file.error());
        for (const Problem& problem : file->problems) {
            if (!first_ && problem.severity == Problem::Severity::Error)
                first_ = Error{problem.uri, problem.reason};
            scene_.problems.push_back(problem);
        }
        for (const LayerDescription& layer : file->layers) {
            if (layer.kind == InputKind::Lamps) {
                openLamps(layer.path);
                continue;
            }
            Result<Input> input = identifyInput(layer.path, layer.kind);
            if (!input) {
                fail(input.error());
            } else if (layer.kind && input->kind != *layer.kind) {
                fail({layer.path, std::string("this is a ") + nameOf(input->kind) + ", not a " +
                                      nameOf(*layer.kind)});
            } else {
                openOne(*input, merged(options_, layer));
            }
        }
        if (file->layers.empty() && !first_)
            fail({path, "it names no layers"});
        if (!scene_.time)
            scene_.time = file->time;
        if (!scene_.camera)
            scene_.camera = file->camera;
        if (!scene_.ground)
            scene_.ground = file->ground;
    }

    const SceneOptions& options_;
    Scene scene_;
    std::vector<OpenedLayer> opened_;
    std::vector<LampsFile::Entry> lamps_;
    Failure first_;
};

} // namespace

bool Layer::stands(std::optional<UtcTime> time) const {
    return !time || ((!from || time->seconds >= from->seconds) &&
                     (!until || time->seconds < until->seconds));
}

double WaterLayer::secondsAt(std::optional<UtcTime> time) const {
    const FloodData& data = surface->data();
    if (!time)
        return data.stepSeconds().back();
    return data.stepsAreAbsolute() ? time->seconds : time->seconds - startSeconds;
}

Result<Scene> openScene(const SceneOptions& options) {
    SceneOpener opener(options);
    for (const std::string& input : options.inputs)
        opener.openInput(input);
    return opener.finish();
}

Result<Scene> openScene(const SceneOptions& options, std::shared_ptr<const Source> source,
                        const Input& input) {
    SceneOpener opener(options);
    opener.openServed(input, source);
    return opener.finish();
}

} // namespace gnomon
