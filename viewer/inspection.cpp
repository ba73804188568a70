#include "viewer/inspection.h"

#include "viewer/input.h"
#include "viewer/progress.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <set>

namespace gnomon {

namespace {

using Json = nlohmann::ordered_json;

class Inspector {
  public:
    explicit Inspector(const SceneOptions& options) : options_(options) {}

    void look(const std::string& argument) {
        SceneOptions one = options_;
        one.inputs = {argument};
        one.unplaced = true; // info is worth having also where nobody said where a thing stands
        Result<Scene> scene = openScene(one);
        if (!scene)
            return fail(scene.error());
        for (const Problem& problem : scene->problems)
            found_.problems.push_back(problem);
        for (Layer& layer : scene->layers)
            found_.inputs.push_back(look(layer));
    }
    Inspection take() { return std::move(found_); }

  private:
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
        if ((layer.placedByUser || layer.crs) && options_.heights == Heights::Egm96)
            input.heights = "egm96";
        ProgressBar bar("contents");
        input.inventory = takeInventory(
            *layer.tileset, [&](std::size_t done, std::size_t total) { bar.update(done, total); });
        bar.finish();
        input.tileset = layer.tileset->tree().facts();
        for (const FailedTile& failed : input.inventory.failures) {
            input.missing.push_back(failed.error);
            found_.problems.push_back(
                {Problem::Severity::Error, failed.error.subject, failed.error.reason});
        }
        for (const std::string& warning : input.inventory.warnings)
            found_.problems.push_back({Problem::Severity::Warning, layer.uri, warning});
        return input;
    }

    const SceneOptions& options_;
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
    json["steps"] = Json::array();
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

std::string inputText(const InspectedInput& input) {
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

const char* nameOf(Problem::Severity severity) {
    return severity == Problem::Severity::Error ? "error" : "warning";
}

} // namespace

std::string Inspection::json() const {
    Json json = {{"inputs", Json::array()}, {"problems", Json::array()}};
    for (const InspectedInput& input : inputs)
        json["inputs"].push_back(inputJson(input));
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
    return text;
}

Inspection inspect(const SceneOptions& options) {
    Inspector inspector(options);
    for (const std::string& input : options.inputs)
        inspector.look(input);
    return inspector.take();
}

} // namespace gnomon
