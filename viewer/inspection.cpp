#include "viewer/inspection.h"

#include "viewer/input.h"
#include "viewer/progress.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace gnomon {

namespace {

using Json = nlohmann::ordered_json;

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

    const SceneOptions& options_;
    const InspectionOptions& also_;
    Inspection found_;
};

Json boundsJson(const std::optional<Region>& bounds) {
    if (!bounds)
        return nullptr;
    return {{"west", bounds->westDegrees},           {"south", bounds->southDegrees},
            {"east", bounds->eastDegrees},           {"north", bounds->northDegrees},
            {"min_height", bounds->minHeightMetres}, {"max_height", bounds->maxHeightMetres}};
}

std::string refineOf(const Inventory& inventory) {
    const bool add = inventory.refine.count(Refine::Add) > 0;
    const bool replace = inventory.refine.count(Refine::Replace) > 0;
    return add && replace ? "ADD+REPLACE" : add ? "ADD" : "REPLACE";
}

std::set<std::string> extensionsOf(const InspectedInput& input) {
    std::set<std::string> all = input.inventory.extensions;
    all.insert(input.tileset.extensionsUsed.begin(), input.tileset.extensionsUsed.end());
    return all;
}

Json inputJson(const InspectedInput& input) {
    const Inventory& inventory = input.inventory;
    Json json = {{"uri", input.uri}, {"kind", input.kind}};
    json["version"] = input.tileset.version;
    json["crs"] = input.crs ? Json(*input.crs) : Json(nullptr);
    json["heights"] = input.heights;
    json["tiles"] = inventory.tiles;
    json["subtrees"] = inventory.subtrees;
    json["contents"] = Json::object();
    for (const auto& [format, count] : inventory.contents)
        json["contents"][format] = count;
    json["missing"] = Json::array();
    for (const Error& error : input.missing)
        json["missing"].push_back({{"uri", error.subject}, {"reason", error.reason}});
    json["triangles"] = inventory.triangles;
    json["duplicates"] = inventory.duplicates;
    json["closed_share"] =
        inventory.triangles == 0
            ? Json(nullptr)
            : Json(double(inventory.closedTriangles) / double(inventory.triangles));
    json["levels"] = inventory.levels;
    json["refine"] = refineOf(inventory);
    json["bounds"] = boundsJson(inventory.bounds);
    json["size"] = input.size ? Json(*input.size) : Json(nullptr);
    json["steps"] = input.steps;
    for (const auto& [name, number] : input.numbers)
        json[name] = number;
    if (!input.totals.empty()) {
        const auto list = [&](double WaterTotals::*member) {
            Json values = Json::array();
            for (const WaterTotals& totals : input.totals)
                values.push_back(totals.*member);
            return values;
        };
        json["wet_area"] = list(&WaterTotals::wetAreaSquareMetres);
        json["wet_area_shown"] = list(&WaterTotals::shownAreaSquareMetres);
        json["volume"] = list(&WaterTotals::volumeCubicMetres);
        json["volume_shown"] = list(&WaterTotals::shownVolumeCubicMetres);
    }
    json["extensions"] = extensionsOf(input);
    json["credits"] = inventory.copyrights;
    return json;
}

void line(std::string& text, const char* name, const std::string& value) {
    char start[32];
    std::snprintf(start, sizeof start, "  %-12s", name);
    text += start + value + "\n";
}

std::string joined(const std::set<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : ", ") + word;
    return text;
}

std::string boundsText(const std::optional<Region>& bounds) {
    if (!bounds)
        return "not on the Earth";
    char text[160];
    std::snprintf(text, sizeof text, "%.6f, %.6f to %.6f, %.6f degrees, %.1f to %.1f m",
                  bounds->westDegrees, bounds->southDegrees, bounds->eastDegrees,
                  bounds->northDegrees, bounds->minHeightMetres, bounds->maxHeightMetres);
    return text;
}

// Of kinds whose contents are not looked at one by one.
std::string madeText(const InspectedInput& input) {
    std::string text = input.uri + ": " + input.kind + "\n";
    line(text, "place", boundsText(input.inventory.bounds));
    if (input.crs)
        line(text, "system", *input.crs + ", heights " + input.heights);
    if (input.size)
        line(text, "size",
             std::to_string((*input.size)[0]) + " x " + std::to_string((*input.size)[1]));
    if (input.inventory.tiles > 0)
        line(text, "tiles",
             std::to_string(input.inventory.tiles) + " on " +
                 std::to_string(input.inventory.levels) + " levels");
    for (const auto& [name, number] : input.numbers) {
        char value[32];
        std::snprintf(value, sizeof value, "%.6g", number);
        line(text, name.c_str(), value);
    }
    for (std::size_t i = 0; i < input.steps.size(); ++i) {
        std::string step = input.steps[i];
        if (i < input.totals.size()) {
            char totals[96];
            std::snprintf(totals, sizeof totals, "  %.6g m2 wet, %.6g m3",
                          input.totals[i].wetAreaSquareMetres, input.totals[i].volumeCubicMetres);
            step += totals;
        }
        line(text, i == 0 ? "steps" : "", step);
    }
    if (!input.inventory.copyrights.empty())
        line(text, "credits", joined(input.inventory.copyrights));
    return text;
}

std::string inputText(const InspectedInput& input) {
    if (input.kind == "terrain" || input.kind == "imagery" || input.kind == "depth" ||
        input.kind == "stage")
        return madeText(input);
    const Inventory& inventory = input.inventory;
    std::string contents, text = input.uri + ": " + input.kind + " " + input.tileset.version + "\n";
    for (const auto& [format, count] : inventory.contents)
        contents += (contents.empty() ? "" : ", ") + std::to_string(count) + " " + format;
    line(text, "place", boundsText(inventory.bounds));
    line(text, "tiles",
         std::to_string(inventory.tiles) + " on " + std::to_string(inventory.levels) + " levels, " +
             refineOf(inventory) +
             (inventory.subtrees > 0 ? ", " + std::to_string(inventory.subtrees) + " subtrees"
                                     : ""));
    line(text, "contents", contents.empty() ? "none" : contents);
    std::string triangles = std::to_string(inventory.triangles);
    if (inventory.triangles > 0) {
        char share[64];
        std::snprintf(share, sizeof share, ", %.1f %% of them in closed bodies",
                      100.0 * double(inventory.closedTriangles) / double(inventory.triangles));
        triangles += share;
    }
    if (inventory.duplicates > 0)
        triangles += ", besides " + std::to_string(inventory.duplicates) + " duplicates";
    line(text, "triangles", triangles);
    if (const auto extensions = extensionsOf(input); !extensions.empty())
        line(text, "extensions", joined(extensions));
    if (!inventory.copyrights.empty())
        line(text, "credits", joined(inventory.copyrights));
    for (const Error& error : input.missing)
        line(text, "missing", error.subject + " (" + error.reason + ")");
    return text;
}

Json valueJson(const AttributeValue& value) {
    return std::visit(
        [](const auto& v) -> Json {
            if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::monostate>)
                return nullptr;
            else
                return v;
        },
        value);
}

Json placeJson(const InspectedPlace& place) {
    const auto number = [](const std::optional<double>& value) {
        return value ? Json(*value) : Json(nullptr);
    };
    Json json = {{"ground", number(place.ground)},
                 {"water_level", number(place.waterLevel)},
                 {"depth", number(place.depth)},
                 {"building", nullptr}};
    if (place.speed)
        json["speed"] = *place.speed;
    if (place.interpolated)
        json["interpolated"] = true;
    if (const auto& building = place.building) {
        Json attributes = Json::object();
        for (const auto& [name, value] : building->attributes)
            attributes[name] = valueJson(value);
        json["building"] = {{"id", building->id},
                            {"ground", building->groundMetres},
                            {"top", building->topMetres},
                            {"height_assumed", building->heightAssumed},
                            {"attributes", attributes}};
    }
    return json;
}

std::string placeText(const InspectedPlace& place) {
    const auto metres = [](const std::optional<double>& value) {
        char text[32];
        std::snprintf(text, sizeof text, "%.3f m", value.value_or(0.0));
        return std::string(value ? text : "none");
    };
    std::string text = "there:\n";
    line(text, "ground", metres(place.ground));
    line(text, "water", metres(place.waterLevel) + (place.interpolated ? " (interpolated)" : ""));
    line(text, "depth", metres(place.depth));
    if (place.building)
        line(text, "building",
             place.building->id + ", up to " + metres(place.building->topMetres) +
                 (place.building->heightAssumed ? " (height assumed)" : ""));
    return text;
}

const char* nameOf(Problem::Severity severity) {
    return severity == Problem::Severity::Error ? "error" : "warning";
}

} // namespace

std::string Inspection::json() const {
    Json json = {{"inputs", Json::array()}, {"problems", Json::array()}};
    for (const InspectedInput& input : inputs)
        json["inputs"].push_back(inputJson(input));
    if (at)
        json["at"] = placeJson(*at);
    for (const Problem& problem : problems)
        if (problem.severity != Problem::Severity::Note)
            json["problems"].push_back({{"severity", nameOf(problem.severity)},
                                        {"uri", problem.uri},
                                        {"reason", problem.reason}});
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string Inspection::text() const {
    std::string text;
    for (const InspectedInput& input : inputs)
        text += inputText(input);
    if (at)
        text += placeText(*at);
    return text;
}

Inspection inspect(const SceneOptions& options, const InspectionOptions& also) {
    return Inspector(options, also).look();
}

} // namespace gnomon
