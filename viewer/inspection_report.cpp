// How `gnomon info` says what it found: as JSON (docs: the command line), and as lines to read.
#include "viewer/inspection.h"

#include "streaming/http/url.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <set>

namespace gnomon {

namespace {

using Json = nlohmann::ordered_json;

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
        json["missing"].push_back({{"uri", textWithoutSecrets(error.subject)},
                                   {"reason", textWithoutSecrets(error.reason)}});
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
    json["features"] = Json::array();
    for (const auto& [name, features] : inventory.features)
        json["features"].push_back({{"class", name.empty() ? Json(nullptr) : Json(name)},
                                    {"rows", features.rows},
                                    {"properties", features.properties}});
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
    for (const auto& [name, features] : inventory.features) {
        std::string properties;
        for (const std::string& property : features.properties)
            properties += (properties.empty() ? ": " : ", ") + property;
        line(text, "features",
             std::to_string(features.rows) + (name.empty() ? "" : " of class " + name) +
                 properties);
    }
    if (!inventory.copyrights.empty())
        line(text, "credits", joined(inventory.copyrights));
    for (const Error& error : input.missing)
        line(text, "missing", textWithoutSecrets(error.subject + " (" + error.reason + ")"));
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

Json number(const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
}

// Above the ground where that is known, else above its own lowest vertex.
double heightOf(const TileFeature& feature, const std::optional<double>& ground) {
    return feature.topMetres - ground.value_or(feature.baseMetres);
}

Json featureJson(const InspectedPlace& place) {
    const TileFeature& feature = *place.feature;
    constexpr std::size_t kMostShown = 1000; // of one thing: nobody reads more
    Json attributes = Json::object();
    for (const auto& [name, value] : feature.properties) {
        if (attributes.size() == kMostShown)
            break;
        // Text of a file, so it may be no JSON after all.
        Json parsed = Json::parse(jsonOf(value), nullptr, false);
        attributes[name] = parsed.is_discarded() ? Json(nullptr) : std::move(parsed);
    }
    return {{"id", feature.id},
            {"tileset", place.tileset},
            {"tile", feature.tile},
            {"feature", feature.feature},
            {"ground", number(place.ground)},
            {"base", feature.baseMetres},
            {"top", feature.topMetres},
            {"height", heightOf(feature, place.ground)},
            {"attributes", attributes}};
}

Json placeJson(const InspectedPlace& place) {
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
    if (place.feature)
        json["building"] = featureJson(place);
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
    if (const auto& feature = place.feature) {
        line(text, "building",
             feature->id + ", up to " + metres(feature->topMetres) + ", " +
                 metres(heightOf(*feature, place.ground)) + " above " +
                 (place.ground ? "the ground" : "its base") + ", in " + feature->tile);
        for (const auto& [name, value] : feature->properties)
            line(text, "", name + ": " + jsonOf(value));
    }
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
                                        {"uri", textWithoutSecrets(problem.uri)},
                                        {"reason", textWithoutSecrets(problem.reason)}});
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

} // namespace gnomon
