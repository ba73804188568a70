#include "viewer/inspection.h"

#include "viewer/input.h"
#include "viewer/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace gnomon {

namespace {

// Reading every step of a large result to sum it up would take longer than one likes to wait.
constexpr double kMostSummed = 2e8; // nodes times steps

class Inspector {
  public:
    Inspector(const SceneOptions& options, const InspectionOptions& also)
        : options_(options), also_(also) {}

    Inspection look() {
        SceneOptions options = options_;
        options.unplaced = true; // info is worth having also where nobody said where a thing stands
        ProgressBar bar("opening");
        options.progress = [&](const std::string&, double share) {
            bar.update(std::size_t(100.0 * share), 100);
        };
        Result<Scene> scene = openScene(options);
        bar.finish();
        if (!scene) {
            lookAlone(options);
            return std::move(found_);
        }
        found_.problems = scene->problems;
        for (Layer& layer : scene->layers)
            found_.inputs.push_back(look(layer));
        for (const Scene::Painted& painted : scene->imagery)
            found_.inputs.push_back(look(painted));
        for (const WaterLayer& water : scene->waters)
            found_.inputs.push_back(look(water));
        if (!scene->lamps.empty())
            found_.problems.push_back(
                {Problem::Severity::Note, "lamps", std::to_string(scene->lamps.size()) + " lamps"});
        if (also_.at)
            found_.at = lookAt(*scene);
        if (found_.at && !found_.at->building)
            lookAtTiles(*scene, *found_.at);
        return std::move(found_);
    }

  private:
    // Nothing could be opened: each input's own reason.
    void lookAlone(SceneOptions options) {
        for (const std::string& input : options_.inputs) {
            options.inputs = {input};
            const Result<Scene> scene = openScene(options);
            if (!scene)
                fail(scene.error());
        }
    }
    void fail(const Error& error) {
        if (!found_.firstFailure)
            found_.firstFailure = error.kind;
        found_.problems.push_back({Problem::Severity::Error, error.subject, error.reason});
    }

    InspectedInput look(Layer& layer) {
        InspectedInput input;
        input.uri = layer.uri;
        input.kind = layer.kind;
        if (layer.onEarth)
            input.crs = layer.placedByUser && options_.crs ? *options_.crs : "EPSG:4978";
        if (layer.crs)
            input.crs = layer.crs;
        input.size = layer.size;
        if ((layer.placedByUser && options_.heights == Heights::Egm96) ||
            layer.heights == Heights::Egm96)
            input.heights = "egm96";
        input.tileset = layer.tileset->tree().facts();
        if (layer.terrain)
            return lookAtTerrain(layer, std::move(input));
        ProgressBar bar("contents");
        input.inventory = takeInventory(
            *layer.tileset, [&](std::size_t done, std::size_t total) { bar.update(done, total); });
        bar.finish();
        for (const FailedTile& failed : input.inventory.failures) {
            input.missing.push_back(failed.error);
            found_.problems.push_back(
                {Problem::Severity::Error, failed.error.subject, failed.error.reason});
        }
        for (const std::string& warning : input.inventory.warnings)
            found_.problems.push_back({Problem::Severity::Warning, layer.uri, warning});
        if (layer.buildings)
            input.numbers.emplace_back("buildings", double(layer.buildings->size()));
        return input;
    }

    // Its tiles are made when they are seen; to make them all only to count them would take long.
    static InspectedInput lookAtTerrain(const Layer& layer, InspectedInput input) {
        const TerrainFacts& facts = layer.terrain->facts();
        const TileTree& tree = layer.tileset->tree();
        input.inventory.tiles = tree.size();
        for (TileIndex i = 0; i < tree.size(); ++i)
            input.inventory.levels =
                std::max(input.inventory.levels, std::uint32_t(tree.node(i).level) + 1);
        input.inventory.refine.insert(Refine::Replace);
        const auto& [west, south, east, north] = facts.extent;
        input.inventory.bounds =
            makeRegion(west, south, east, north, facts.minHeightMetres, facts.maxHeightMetres);
        input.inventory.copyrights.insert(facts.credits.begin(), facts.credits.end());
        input.numbers = {{"cell_metres", facts.cellMetres},
                         {"data_share", facts.dataShare},
                         {facts.errorIsBound ? "root_error_bound" : "root_error_estimate",
                          facts.rootErrorMetres}};
        return input;
    }

    static InspectedInput look(const Scene::Painted& painted) {
        InspectedInput input;
        input.uri = painted.uri;
        input.kind = "imagery";
        const auto [west, south, east, north] = painted.drape->extent();
        input.inventory.bounds = makeRegion(west, south, east, north, 0.0, 0.0);
        if (std::isfinite(painted.drape->texelMetres()))
            input.numbers = {{"texel_metres", painted.drape->texelMetres()}};
        return input;
    }

    InspectedInput look(const WaterLayer& water) {
        const FloodData& data = water.surface->data();
        const FloodGeometry& geometry = data.geometry();
        InspectedInput input;
        input.uri = water.uri;
        input.kind = water.kind;
        input.crs = data.crs;
        input.heights = water.heights == Heights::Egm96 ? "egm96" : "ellipsoidal";
        if (geometry.columns > 0)
            input.size = {geometry.columns, geometry.rows};
        const auto [west, south, east, north] = water.surface->extent();
        const double height = geodeticOf(water.surface->bounds().centre).heightMetres;
        input.inventory.bounds = makeRegion(west, south, east, north, height, height);
        input.inventory.copyrights.insert(data.credits.begin(), data.credits.end());
        input.numbers = {{"nodes", double(geometry.lonLat.size())},
                         {"deepest", water.surface->deepestMetres()}};
        if (data.hasVelocity())
            input.numbers.emplace_back("fastest", water.surface->fastest());
        const std::vector<double>& steps = data.stepSeconds();
        for (const double seconds : steps)
            input.steps.push_back(data.stepsAreAbsolute() ? formatUtc({seconds})
                                                          : inSeconds(seconds));
        if (double(geometry.lonLat.size()) * double(steps.size()) > kMostSummed)
            return input;
        for (const double seconds : steps) {
            const Result<WaterTotals> totals = water.surface->totals(seconds);
            if (!totals) {
                found_.problems.push_back(
                    {Problem::Severity::Error, totals.error().subject, totals.error().reason});
                break;
            }
            input.totals.push_back(*totals);
        }
        return input;
    }

    static std::string inSeconds(double seconds) {
        char text[32];
        std::snprintf(text, sizeof text, "+%g s", seconds);
        return text;
    }

    InspectedPlace lookAt(const Scene& scene) {
        InspectedPlace place;
        const glm::dvec2 lonLat = *also_.at;
        if (scene.groundHeights)
            if (const double ground = scene.groundHeights->at(lonLat); !std::isnan(ground))
                place.ground = ground;
        for (const WaterLayer& water : scene.waters) {
            const auto time = also_.time ? also_.time : scene.time;
            const auto found = water.surface->at(water.secondsAt(time), lonLat);
            if (!found) {
                found_.problems.push_back(
                    {Problem::Severity::Error, found.error().subject, found.error().reason});
                continue;
            }
            if (!*found || (place.waterLevel && *place.waterLevel >= (*found)->levelMetres))
                continue;
            place.waterLevel = (*found)->levelMetres;
            place.depth = (*found)->depthMetres;
            place.interpolated = (*found)->interpolated;
            if ((*found)->velocity)
                place.speed = glm::length(glm::dvec2(*(*found)->velocity));
        }
        for (const Layer& layer : scene.layers)
            if (layer.buildings && !place.building)
                place.building = layer.buildings->at(lonLat);
        return place;
    }

    // The highest feature of all tilesets over the place.
    void lookAtTiles(const Scene& scene, InspectedPlace& place) {
        constexpr std::chrono::seconds kPatience(60);
        const auto deadline = std::chrono::steady_clock::now() + kPatience;
        for (const Layer& layer : scene.layers) {
            if (layer.terrain || layer.buildings || !layer.onEarth)
                continue;
            bool complete = true;
            // Of a scene that is not to be drawn, meshes are along ECEF's axes.
            auto found = featureAt(*layer.tileset, *also_.at, glm::dmat3(1.0), deadline, &complete);
            if (!complete)
                found_.problems.push_back({Problem::Severity::Warning, layer.uri,
                                           "not all tiles over the place could be had"});
            if (!found || (place.feature && place.feature->topMetres >= found->topMetres))
                continue;
            place.feature = std::move(found);
            place.tileset = layer.uri;
        }
    }

    const SceneOptions& options_;
    const InspectionOptions& also_;
    Inspection found_;
};

} // namespace

Inspection inspect(const SceneOptions& options, const InspectionOptions& also) {
    return Inspector(options, also).look();
}

} // namespace gnomon
