#include "viewer/camera_keys.h"
#include "viewer/json_read.h"

namespace gnomon {

namespace {

Result<PathKey> readKeyframe(const nlohmann::json& object, const std::string& name,
                             std::size_t number, double defaultFovDegrees) {
    FieldReader read(object, name, "keyframe " + std::to_string(number));
    PathKey key;
    key.t = read.number("t", -kMaxPathSeconds, kMaxPathSeconds);
    key.place.longitudeDegrees = read.number("lon", -360, 360);
    key.place.latitudeDegrees = read.number("lat", -90, 90);
    key.place.heightMetres = read.number("height", -kMaxPathMetres, kMaxPathMetres);
    key.orientation.headingDegrees = read.number("heading", -3600, 3600);
    key.orientation.pitchDegrees = read.number("pitch", -90, 90);
    key.orientation.rollDegrees = read.numberOr("roll", 0, -3600, 3600);
    key.fovDegrees = read.numberOr("fov", defaultFovDegrees, 0.01, 179);
    if (const auto time = read.optionalText("time")) {
        const Result<ZonedTime> moment = parseZonedTime(*time);
        if (moment)
            key.time = *moment;
        else
            read.fail("\"time\": " + moment.error().message());
    }
    read.refuseOthers({"t", "lon", "lat", "height", "heading", "pitch", "roll", "fov", "time"});
    if (read.failure())
        return *read.failure();
    return key;
}

} // namespace

Result<PathKeys> pathKeysFromJson(const std::string& text, const std::string& name,
                                  double defaultFovDegrees) {
    const Result<nlohmann::json> root = parseJson(text, name);
    if (!root)
        return root.error();
    FieldReader read(*root, name);
    PathKeys path;
    const auto interpolation = read.optionalText("interpolation").value_or("smooth");
    if (interpolation != "smooth" && interpolation != "linear")
        read.fail("\"interpolation\" must be smooth or linear");
    path.interpolation = interpolation == "linear" ? Interpolation::Linear : Interpolation::Smooth;
    if (!read.failure() && (!read.has("keyframes") || !root->at("keyframes").is_array() ||
                            root->at("keyframes").empty()))
        read.fail("\"keyframes\" must be a list of at least one");
    if (read.failure())
        return *read.failure();
    for (const auto& object : root->at("keyframes")) {
        const std::size_t number = path.keys.size();
        const Result<PathKey> key = readKeyframe(object, name, number, defaultFovDegrees);
        if (!key)
            return key.error();
        if (number > 0 && !(key->t > path.keys.back().t))
            return Error{name, "keyframe " + std::to_string(number) +
                                   ": \"t\" must be later than that of the one before"};
        path.keys.push_back(*key);
    }
    return path;
}

} // namespace gnomon
