#include "viewer/scene_file.h"

#include "viewer/json_read.h"

#include <algorithm>
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

void readPlacing(const Json& object, FieldReader& read, LayerFacts& layer) {
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

// A text that one of the parsers of viewer/layer_facts.h understands.
template <class T, class Parse>
void readNamed(FieldReader& read, const char* key, std::optional<T>& into, const Parse& parse,
               const char* choices) {
    const auto text = read.optionalText(key);
    if (!text)
        return;
    into = parse(*text);
    if (!into)
        read.fail(std::string("\"") + key + "\" must be " + choices);
}

void readMoment(FieldReader& read, const char* key, std::optional<UtcTime>& into) {
    const auto text = read.optionalText(key);
    if (!text)
        return;
    const Result<UtcTime> moment = parseTime(*text);
    if (moment)
        into = *moment;
    else
        read.fail(std::string("\"") + key + "\": " + moment.error().message());
}

void readLook(FieldReader& read, LayerFacts& layer) {
    constexpr double kHighest = 10000.0;
    layer.heightMetres = read.optionalNumber("height", 0, kHighest);
    layer.widthMetres = read.optionalNumber("width", 0, kHighest);
    layer.heightAttribute = read.optionalText("height-attribute");
    readMoment(read, "from", layer.from);
    readMoment(read, "until", layer.until);
    layer.variable = read.optionalText("variable");
    readNamed(read, "kind", layer.waterKind, waterKindNamed, "depth or stage");
    readMoment(read, "start", layer.start);
    readNamed(read, "step", layer.stepSeconds, durationSeconds, "a time as in 1h, 15min or 300s");
    layer.dryMetres = read.optionalNumber("dry", 0, 100);
    readNamed(read, "colors", layer.colors, waterColorsNamed, "depth, speed or natural");
    layer.most = read.optionalNumber("most", 1e-6, 1e6);
    readNamed(read, "look", layer.look, terrainLookNamed, "plain, ramp or ramp-unlit");
    layer.hole = read.optionalText("hole");
    readNamed(read, "color", layer.color, colorNamed, "as in #5a5a60");
}

struct LayerKey {
    const char* key;
    InputKind kind;
};
constexpr std::array kLayerKeys = {
    LayerKey{"tileset", InputKind::Tileset}, LayerKey{"model", InputKind::Model},
    LayerKey{"terrain", InputKind::Terrain}, LayerKey{"imagery", InputKind::Imagery},
    LayerKey{"water", InputKind::Water},     LayerKey{"depth", InputKind::Water},
    LayerKey{"stage", InputKind::Water},     LayerKey{"buildings", InputKind::Buildings},
    LayerKey{"trees", InputKind::Trees},     LayerKey{"barriers", InputKind::Barriers},
    LayerKey{"lamps", InputKind::Lamps}};

// The layer's file, or its files, one a step of time.
std::vector<std::string> readPaths(const Json& value, const LayerKey& key, FieldReader& read) {
    std::vector<std::string> paths;
    if (value.is_string())
        paths.push_back(value.get<std::string>());
    else if (value.is_array() && key.kind == InputKind::Water)
        for (const Json& path : value)
            if (path.is_string())
                paths.push_back(path.get<std::string>());
    if (paths.empty() || (value.is_array() && paths.size() != value.size()))
        read.fail(std::string("\"") + key.key +
                  (key.kind == InputKind::Water ? "\" must be a path, or a list of them"
                                                : "\" must be a path"));
    return paths;
}

// Where the files that a scene names are.
struct Folders {
    std::string beside; // the scene file's own
    std::optional<std::string> data;

    std::string find(const std::string& path) const {
        if (isWebAddress(path))
            return path;
        const std::filesystem::path here = std::filesystem::path(beside) / path;
        std::error_code ignored;
        if (!data || std::filesystem::exists(here, ignored))
            return here.string();
        return (std::filesystem::path(*data) / path).string();
    }
};

Result<LayerDescription> readLayer(const Json& object, const Folders& folders,
                                   const std::string& name, std::size_t number,
                                   std::vector<Problem>& problems) {
    const std::string where = "layer " + std::to_string(number);
    FieldReader read(object, name, where);
    if (read.failure())
        return *read.failure();
    const LayerKey* named = nullptr;
    bool once = true;
    for (const LayerKey& key : kLayerKeys)
        if (object.contains(key.key)) {
            once = named == nullptr;
            named = &key;
        }
    if (named == nullptr || !once) {
        read.fail("needs one of \"tileset\", \"model\", \"terrain\", \"imagery\", \"water\", "
                  "\"buildings\", \"trees\", \"barriers\" and \"lamps\"");
        return *read.failure();
    }
    LayerDescription layer;
    readPlacing(object, read, layer);
    readLook(read, layer);
    std::vector<std::string> paths = readPaths(object.at(named->key), *named, read);
    if (read.failure())
        return *read.failure();
    warnOfOthers(
        read.others(
            {named->key,         "crs",  "heights", "place",    "up",   "raise", "height", "width",
             "height-attribute", "from", "until",   "variable", "kind", "start", "step",   "dry",
             "colors",           "most", "look",    "hole",     "color"}),
        name + ": " + where, problems);
    if (layer.hole)
        layer.hole = folders.find(*layer.hole);
    if (layer.hole && isWebAddress(*layer.hole))
        read.fail("\"hole\" must be a file");
    if (paths.size() > 1 && std::any_of(paths.begin(), paths.end(), isWebAddress))
        read.fail("of several steps each must be a file");
    if (read.failure())
        return *read.failure();
    layer.kind = named->kind;
    if (!layer.waterKind)
        layer.waterKind = waterKindNamed(named->key);
    layer.uri = paths.front();
    for (std::string& path : paths)
        path = folders.find(path);
    layer.path = paths.front();
    layer.steps.assign(paths.begin() + 1, paths.end());
    return layer;
}

} // namespace

Result<SceneFile> parseSceneFile(const std::string& text, const std::string& folder,
                                 const std::string& name,
                                 const std::optional<std::string>& dataFolder) {
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
        auto layer = readLayer(object, {folder, dataFolder}, name, ++number, scene.problems);
        if (!layer)
            return layer.error();
        scene.layers.push_back(std::move(*layer));
    }
    if (const auto time = read.optionalText("time")) {
        const Result<ZonedTime> moment = parseZonedTime(*time);
        if (!moment)
            return Error{name, "\"time\": " + moment.error().message()};
        scene.time = moment->utc;
        scene.timeZone = moment->zone;
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

Result<SceneFile> readSceneFile(const std::string& path,
                                const std::optional<std::string>& dataFolder) {
    const Result<std::string> text = readTextFile(path, kMaxBytes);
    if (!text)
        return text.error();
    return parseSceneFile(*text, splitPath(path).folder, path, dataFolder);
}

} // namespace gnomon
