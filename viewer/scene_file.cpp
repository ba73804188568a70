#include "viewer/scene_file.h"

#include "viewer/json_read.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

namespace gnomon {

namespace {

constexpr std::size_t kMaxBytes = std::size_t(16) << 20;
constexpr double kMaxHeightMetres = 1e8; // beyond the Moon's distance nothing of ours stands

using Json = nlohmann::json;

std::optional<GroundChoice> readGround(const Json& field) {
    if (field == "auto")
        return GroundChoice{};
    if (field == "none")
        return GroundChoice{false, std::nullopt};
    if (field.is_number() && std::abs(field.get<double>()) <= kMaxHeightMetres)
        return GroundChoice{false, field.get<double>()};
    return std::nullopt;
}

Result<SceneCamera> readCamera(const Json& object, const std::string& name) {
    FieldReader read(object, name, "camera");
    SceneCamera camera;
    camera.position.longitudeDegrees = read.number("lon", -360, 360);
    camera.position.latitudeDegrees = read.number("lat", -90, 90);
    camera.position.heightMetres = read.number("height", -kMaxHeightMetres, kMaxHeightMetres);
    camera.orientation.headingDegrees = read.numberOr("heading", 0, -3600, 3600);
    camera.orientation.pitchDegrees = read.numberOr("pitch", 0, -90, 90);
    camera.orientation.rollDegrees = read.numberOr("roll", 0, -3600, 3600);
    camera.fovDegrees = read.optionalNumber("fov", 0.01, 179);
    read.refuseOthers({"lon", "lat", "height", "heading", "pitch", "roll", "fov"});
    if (read.failure())
        return *read.failure();
    return camera;
}

// [lon, lat, height] or [lon, lat, height, heading]
std::optional<Placement> readPlacement(const Json& list) {
    if (!list.is_array() || list.size() < 3 || list.size() > 4)
        return std::nullopt;
    for (const Json& number : list)
        if (!number.is_number())
            return std::nullopt;
    Placement place;
    place.origin = {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
    place.headingDegrees = list.size() == 4 ? list[3].get<double>() : 0.0;
    if (!ecefFromGeodetic(place.origin) || std::abs(place.origin.longitudeDegrees) > 360)
        return std::nullopt;
    return place;
}

void readPlacing(const Json& object, FieldReader& read, LayerDescription& layer) {
    layer.crs = read.optionalText("crs");
    layer.raiseMetres = read.optionalNumber("raise", -kMaxHeightMetres, kMaxHeightMetres);
    if (const auto heights = read.optionalText("heights")) {
        if (*heights == "egm96")
            layer.heights = Heights::Egm96;
        else if (*heights == "ellipsoidal")
            layer.heights = Heights::Ellipsoidal;
        else
            read.fail("\"heights\" must be ellipsoidal or egm96");
    }
    if (const auto up = read.optionalText("up")) {
        if (*up == "y" || *up == "z")
            layer.up = *up == "y" ? ModelUp::Y : ModelUp::Z;
        else if (*up != "auto")
            read.fail("\"up\" must be auto, y or z");
    }
    if (object.contains("place")) {
        layer.placement = readPlacement(object.at("place"));
        if (!layer.placement)
            read.fail("\"place\" must be [lon, lat, height] or [lon, lat, height, heading]");
    }
}

void warnOfOthers(const std::vector<std::string>& keys, const std::string& where,
                  std::vector<Problem>& problems) {
    for (const std::string& key : keys)
        problems.push_back(
            {Problem::Severity::Warning, where, "\"" + key + "\" is not known, so it is ignored"});
}

constexpr std::array kLaterKinds = {"terrain", "imagery",   "depth", "stage",
                                    "water",   "buildings", "trees", "barriers"};

// Empty when the layer is of a kind that cannot be opened yet, which is then among the problems.
Result<std::optional<LayerDescription>> readLayer(const Json& object, const std::string& folder,
                                                  const std::string& name, std::size_t number,
                                                  std::vector<Problem>& problems) {
    const std::string where = "layer " + std::to_string(number);
    FieldReader read(object, name, where);
    if (read.failure())
        return *read.failure();
    for (const char* later : kLaterKinds)
        if (object.contains(later)) {
            problems.push_back({Problem::Severity::Error, name + ": " + where,
                                std::string("layers of the kind \"") + later +
                                    "\" cannot be opened yet; it is left out"});
            return std::optional<LayerDescription>();
        }
    LayerDescription layer;
    const auto tileset = read.optionalText("tileset");
    const auto model = read.optionalText("model");
    const auto lamps = read.optionalText("lamps");
    if (tileset.has_value() + model.has_value() + lamps.has_value() != 1)
        read.fail("needs one of \"tileset\", \"model\" and \"lamps\"");
    readPlacing(object, read, layer);
    if (read.failure())
        return *read.failure();
    warnOfOthers(
        read.others({"tileset", "model", "lamps", "crs", "heights", "place", "up", "raise"}),
        name + ": " + where, problems);
    layer.kind = tileset ? InputKind::Tileset : model ? InputKind::Model : InputKind::Lamps;
    layer.uri = tileset ? *tileset : model ? *model : *lamps;
    const bool remote = layer.uri.starts_with("http://") || layer.uri.starts_with("https://");
    layer.path = remote ? layer.uri : (std::filesystem::path(folder) / layer.uri).string();
    return std::optional(layer);
}

} // namespace

Result<SceneFile> parseSceneFile(const std::string& text, const std::string& folder,
                                 const std::string& name) {
    const Result<Json> json = parseJson(text, name);
    if (!json)
        return json.error();
    FieldReader read(*json, name);
    if (!read.failure() && (!read.has("layers") || !json->at("layers").is_array()))
        read.fail("\"layers\" must be a list");
    if (read.failure())
        return *read.failure();
    SceneFile scene;
    warnOfOthers(read.others({"layers", "time", "camera", "ground"}), name, scene.problems);
    std::size_t number = 0;
    for (const Json& object : json->at("layers")) {
        auto layer = readLayer(object, folder, name, ++number, scene.problems);
        if (!layer)
            return layer.error();
        if (*layer)
            scene.layers.push_back(std::move(**layer));
    }
    if (const auto time = read.optionalText("time")) {
        const Result<UtcTime> utc = parseTime(*time);
        if (!utc)
            return Error{name, "\"time\": " + utc.error().message()};
        scene.time = *utc;
    }
    if (read.failure())
        return *read.failure();
    if (read.has("camera")) {
        Result<SceneCamera> camera = readCamera(json->at("camera"), name);
        if (!camera)
            return camera.error();
        scene.camera = *camera;
    }
    if (read.has("ground")) {
        scene.ground = readGround(json->at("ground"));
        if (!scene.ground)
            return Error{name, "\"ground\" must be \"auto\", \"none\" or a height in metres"};
    }
    return scene;
}

Result<SceneFile> readSceneFile(const std::string& path) {
    const Result<std::string> text = readTextFile(path, kMaxBytes);
    if (!text)
        return text.error();
    return parseSceneFile(*text, splitPath(path).folder, path);
}

} // namespace gnomon
