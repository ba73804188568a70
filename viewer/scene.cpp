#include "viewer/scene.h"

#include "viewer/input.h"
#include "viewer/lamps_file.h"
#include "viewer/open_made.h"
#include "viewer/open_tileset.h"
#include "viewer/scene_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

namespace gnomon {

namespace {

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

// The layers' bounds and the water's.
Sphere boundsOf(const std::vector<OpenedLayer>& opened, const std::vector<WaterLayer>& waters) {
    std::vector<Sphere> spheres;
    for (const OpenedLayer& layer : opened)
        spheres.push_back(layer.bounds);
    for (const WaterLayer& water : waters)
        spheres.push_back(water.surface->bounds());
    Sphere all = spheres.front();
    for (const Sphere& sphere : spheres)
        all = around(all, sphere);
    return all;
}

void setAnchor(Scene& scene, const std::vector<OpenedLayer>& opened) {
    const Sphere all = boundsOf(opened, scene.waters);
    HeightRange range{std::numeric_limits<double>::infinity(),
                      -std::numeric_limits<double>::infinity()};
    for (const OpenedLayer& layer : opened)
        if (layer.heights)
            range = {std::min(range.base, layer.heights->base),
                     std::max(range.top, layer.heights->top)};
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
    for (const WaterLayer& water : scene.waters)
        scene.radiusMetres =
            std::max(scene.radiusMetres, reachFrom(scene, water.surface->bounds()));
}

// What is to be opened, in the order it was named.
struct Asked {
    Input input;
    LayerFacts facts;
};

using Clock = std::chrono::steady_clock;
constexpr std::chrono::duration<double> kLongestPatience{1e8}; // three years; a clock can hold it

class SceneOpener {
  public:
    explicit SceneOpener(const SceneOptions& options) : options_(options) {
        if (options.patience)
            deadline_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::min(*options.patience, kLongestPatience));
    }

    void openInput(const std::string& argument) {
        const Result<Input> input =
            patiently([&] { return identifyInput(argument, {}, openWeb()); });
        if (!input)
            return fail(input.error());
        if (input->kind == InputKind::SceneFile)
            return openSceneFile(input->path);
        asked_.push_back({*input, options_});
    }
    void openServed(const Input& input, const std::shared_ptr<const Source>& source) {
        Opening opening = this->opening();
        add(openTileset(input, source, input.path, options_, opening));
    }

    Result<Scene> finish() {
        openAsked();
        for (const auto& source : webSources_)
            source->forget();
        if (passing_)
            return *passing_;
        if (opened_.empty() && scene_.waters.empty() && !(options_.unplaced && anythingFound_))
            return first_.value_or(Error{"INPUT", "nothing to open", ErrorKind::Usage});
        if (!options_.unplaced) {
            setAnchor(scene_, opened_);
            placeLamps();
        }
        for (OpenedLayer& layer : opened_)
            scene_.layers.push_back(std::move(layer.layer));
        for (WaterLayer& water : scene_.waters)
            if (!water.surface->data().stepsAreAbsolute() && scene_.time)
                water.startSeconds = scene_.time->seconds;
        std::sort(scene_.credits.begin(), scene_.credits.end());
        scene_.credits.erase(std::unique(scene_.credits.begin(), scene_.credits.end()),
                             scene_.credits.end());
        return std::move(scene_);
    }

  private:
    // One client for all inputs, made when the first is on the web.
    OpenWeb openWeb() {
        return [this](const std::string& url) -> Result<std::shared_ptr<const WebSource>> {
            if (!web_) {
                auto client = HttpClient::create(options_.http);
                if (!client)
                    return client.error();
                web_ = std::move(*client);
            }
            auto source = httpSource(web_, url);
            if (source)
                webSources_.push_back(*source);
            return source;
        };
    }
    void fail(const Error& error) {
        if (!first_)
            first_ = error;
        if (deadline_ && error.kind == ErrorKind::Transient && !passing_)
            passing_ = error;
        scene_.problems.push_back({Problem::Severity::Error, error.subject, error.reason});
    }
    Opening opening() {
        return {options_.loader, options_.unplaced, asked_.size() > 1, scene_.problems,
                scene_.credits,  options_.progress, deadline_};
    }
    // Again while its fault may pass and there is time.
    template <class Work>
    auto patiently(const Work& work) -> decltype(work()) {
        std::chrono::milliseconds pause{200}, longest{5000};
        for (;;) {
            auto result = work();
            if (result || result.error().kind != ErrorKind::Transient || !deadline_ ||
                Clock::now() + pause >= *deadline_)
                return result;
            std::this_thread::sleep_for(pause);
            pause = std::min(2 * pause, longest);
        }
    }
    template <class T, class Keep>
    void keep(Result<T> opened, const Keep& keepIt) {
        if (!opened)
            return fail(opened.error());
        anythingFound_ = true;
        keepIt(std::move(*opened));
    }
    void add(Result<OpenedLayer> layer) {
        keep(std::move(layer), [&](OpenedLayer opened) { opened_.push_back(std::move(opened)); });
    }

    // What others stand on comes first, and what is painted on that before.
    void openAsked() {
        Opening opening = this->opening();
        for (const Asked& asked : asked_)
            if (asked.input.kind == InputKind::Imagery)
                keep(openImagery(asked.input, asked.facts, opening),
                     [&](Scene::Painted painted) { scene_.imagery.push_back(std::move(painted)); });
        openTerrains(opening);
        for (const Asked& asked : asked_)
            openOne(asked, opening);
        chooseFlatGround();
        // As they were named: terrain was only opened before the others.
        const auto place = [&](const OpenedLayer& layer) {
            return std::find_if(asked_.begin(), asked_.end(), [&](const Asked& asked) {
                return asked.input.uri == layer.layer.uri;
            });
        };
        std::stable_sort(
            opened_.begin(), opened_.end(),
            [&](const OpenedLayer& a, const OpenedLayer& b) { return place(a) < place(b); });
    }

    void openTerrains(Opening& opening) {
        std::vector<OpenedTerrain> terrains;
        for (const Asked& asked : asked_)
            if (asked.input.kind == InputKind::Terrain)
                keep(openTerrain(asked.input, asked.facts, opening),
                     [&](OpenedTerrain terrain) { terrains.push_back(std::move(terrain)); });
        if (terrains.empty() && !scene_.imagery.empty() && !options_.unplaced)
            opening.warn(scene_.imagery.front().uri,
                         "imagery lies on terrain, of which there is none here, so it is not seen");
        std::vector<Ground> grounds;
        for (Result<OpenedLayer>& layer : terrainLayers(terrains, scene_.imagery, opening)) {
            if (layer)
                grounds.push_back(layer->layer.terrain);
            add(std::move(layer));
        }
        const auto flat = options_.groundMetres ? options_.groundMetres : fileGround();
        if (flat)
            grounds.push_back(flatGround(*flat));
        if (!grounds.empty())
            scene_.groundHeights = stackedGround(grounds);
        standOn_ = grounds.empty() ? flatGround(0.0) : scene_.groundHeights;
        // Terrain is ground enough; what was put up without any stands on the ellipsoid.
        if (!scene_.ground && !terrains.empty())
            scene_.ground = GroundChoice{false, std::nullopt};
    }
    std::optional<double> fileGround() const {
        return scene_.ground ? scene_.ground->heightMetres : std::nullopt;
    }

    void openOne(const Asked& asked, Opening& opening) {
        const auto& [input, facts] = asked;
        const auto add = [this](Result<OpenedLayer> layer) { this->add(std::move(layer)); };
        switch (input.kind) {
        case InputKind::Tileset:
        case InputKind::Model: {
            if (input.source)
                return add(patiently(
                    [&] { return openTileset(input, input.source, input.path, facts, opening); }));
            const SplitPath split = splitPath(input.path);
            return add(openTileset(input, fileSource(split.folder), split.name, facts, opening));
        }
        case InputKind::Buildings:
            return add(openBuildings(input, facts, scene_.groundHeights, opening));
        case InputKind::Trees:
            return add(openTrees(input, facts, standOn_, opening));
        case InputKind::Barriers:
            return keep(openBarriers(input, facts, standOn_, opening),
                        [&](std::vector<OpenedLayer> layers) {
                            for (OpenedLayer& layer : layers)
                                opened_.push_back(std::move(layer));
                        });
        case InputKind::Water:
            return keep(openWater(input, facts, standOn_, opening),
                        [&](WaterLayer water) { scene_.waters.push_back(std::move(water)); });
        case InputKind::Lamps:
            return openLamps(asked, opening);
        case InputKind::Terrain:
        case InputKind::Imagery:
        case InputKind::SceneFile:
            return;
        }
    }
    // Without terrain or a height, what has no heights of its own was put on the ellipsoid: that is
    // the ground shown then. Where others stand on is found from their bases.
    void chooseFlatGround() {
        constexpr double kOnEllipsoidMetres = 2.0;
        if (scene_.groundHeights || scene_.ground)
            return;
        const bool flat = std::any_of(opened_.begin(), opened_.end(), [](const OpenedLayer& layer) {
            return layer.layer.kind != nameOf(InputKind::Tileset) &&
                   layer.layer.kind != nameOf(InputKind::Model) && layer.heights &&
                   std::abs(layer.heights->base) < kOnEllipsoidMetres;
        });
        if (flat || !scene_.waters.empty())
            scene_.ground = GroundChoice{false, 0.0};
    }

    void openLamps(const Asked& asked, Opening& opening) {
        const std::string& path = asked.input.path;
        const Result<LampsFile> file = readLampsFile(path, featureOptions(asked.facts));
        if (!file)
            return fail(file.error());
        anythingFound_ = true;
        lamps_.insert(lamps_.end(), file->entries.begin(), file->entries.end());
        if (!asked.input.guess.empty())
            opening.note(asked.input.uri, asked.input.guess);
        for (const std::string& note : file->notes)
            opening.note(path, note);
        for (const Error& error : file->leftOut)
            opening.leftOut(error);
        if (file->others > 0)
            opening.warn(path, std::to_string(file->others) +
                                   " features are no points, so they are left out");
    }
    void placeLamps() {
        for (const LampsFile::Entry& entry : lamps_) {
            double level = scene_.anchor.heightMetres;
            if (scene_.groundHeights) {
                const double ground = scene_.groundHeights->at(
                    {entry.foot.longitudeDegrees, entry.foot.latitudeDegrees});
                level = std::isnan(ground) ? level : ground;
            }
            scene_.lamps.push_back(placedLamp(entry, level));
        }
    }

    void openSceneFile(const std::string& path) {
        Result<SceneFile> file = readSceneFile(path, options_.dataFolder);
        if (!file)
            return fail(file.error());
        for (const Problem& problem : file->problems) {
            if (!first_ && problem.severity == Problem::Severity::Error)
                first_ = Error{problem.uri, problem.reason};
            scene_.problems.push_back(problem);
        }
        for (const LayerDescription& layer : file->layers) {
            Result<Input> input =
                patiently([&] { return identifyInput(layer.path, layer.kind, openWeb()); });
            if (!input) {
                fail(input.error());
                continue;
            }
            input->steps.insert(input->steps.end(), layer.steps.begin(), layer.steps.end());
            LayerFacts facts = options_; // the command line wins
            asked_.push_back({*input, facts.orElse(layer)});
        }
        if (file->layers.empty() && !first_)
            fail({path, "it names no layers"});
        if (!scene_.time) {
            scene_.time = file->time;
            scene_.timeZone = file->timeZone;
        }
        if (!scene_.camera)
            scene_.camera = file->camera;
        if (!scene_.ground)
            scene_.ground = file->ground;
    }

    const SceneOptions& options_;
    Scene scene_;
    std::vector<Asked> asked_;
    std::vector<OpenedLayer> opened_;
    std::vector<LampsFile::Entry> lamps_;
    Ground standOn_; // the scene's ground, or the ellipsoid
    bool anythingFound_ = false;
    Failure first_, passing_;
    std::optional<Clock::time_point> deadline_;
    std::shared_ptr<HttpClient> web_;
    std::vector<std::shared_ptr<const WebSource>> webSources_;
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

namespace {

// All layers within one budget of memory.
SceneOptions withLedger(SceneOptions options) {
    if (!options.loader.ledger)
        options.loader.ledger = std::make_shared<MemoryLedger>(options.loader.memoryBytes);
    if (options.patience)
        options.loader.attempts = std::numeric_limits<unsigned>::max();
    return options;
}

} // namespace

Result<Scene> openScene(const SceneOptions& asked) {
    const SceneOptions options = withLedger(asked);
    SceneOpener opener(options);
    for (const std::string& input : options.inputs)
        opener.openInput(input);
    return opener.finish();
}

Result<Scene> openScene(const SceneOptions& asked, std::shared_ptr<const Source> source,
                        const Input& input) {
    const SceneOptions options = withLedger(asked);
    SceneOpener opener(options);
    opener.openServed(input, source);
    return opener.finish();
}

} // namespace gnomon
