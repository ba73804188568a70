#include "viewer/lamps_file.h"

#include "viewer/input.h"
#include "viewer/json_read.h"

#include <cmath>

namespace gnomon {

namespace {

using Json = nlohmann::json;

// A city's street lamps are some 10^5, 200 bytes each.
constexpr std::size_t kMaxBytes = std::size_t(256) << 20;
constexpr double kMaxHeightMetres = 1e5;
constexpr double kMaxRangeMetres = 1e4;
constexpr double kMaxPower = 1e9;
constexpr double kPostMetres = 6.0;

void readPoint(const Json& geometry, FieldReader& read, LampsFile::Entry& entry) {
    if (!geometry.contains("coordinates") || !geometry.at("coordinates").is_array())
        return read.fail("\"coordinates\" must be a list");
    const Json& list = geometry.at("coordinates");
    bool numbers = list.size() >= 2 && list.size() <= 3;
    for (const Json& number : list)
        numbers = numbers && number.is_number();
    if (!numbers)
        return read.fail("\"coordinates\" must be [lon, lat] or [lon, lat, height]");
    entry.onLevel = list.size() == 2;
    entry.foot = {list[0].get<double>(), list[1].get<double>(),
                  entry.onLevel ? 0.0 : list[2].get<double>()};
    if (!ecefFromGeodetic(entry.foot) || std::abs(entry.foot.longitudeDegrees) > 360 ||
        std::abs(entry.foot.heightMetres) > kMaxHeightMetres)
        read.fail("\"coordinates\" are not a place on the Earth");
}

void readPower(const Json& properties, FieldReader& read, Lamp& lamp) {
    if (!properties.contains("power"))
        return;
    const Json& power = properties.at("power");
    if (!power.is_array()) {
        lamp.power = glm::vec3(float(read.numberOr("power", 100.0, 0.0, kMaxPower)));
        return;
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const bool good = power.size() == 3 && power[i].is_number() &&
                          power[i].get<double>() >= 0.0 && power[i].get<double>() <= kMaxPower;
        if (!good)
            return read.fail("\"power\" must be a number or [r, g, b], none negative");
        lamp.power[int(i)] = power[i].get<float>();
    }
}

Result<LampsFile::Entry> readFeature(const Json& feature, const std::string& where,
                                     const std::string& name) {
    static const Json kNone = Json::object();
    LampsFile::Entry entry;
    const bool has = feature.contains("properties") && feature.at("properties").is_object();
    const Json& properties = has ? feature.at("properties") : kNone;
    FieldReader read(properties, name, where);
    readPoint(feature.at("geometry"), read, entry);
    entry.heightMetres = read.numberOr("height", entry.onLevel ? kPostMetres : 0.0,
                                       -kMaxHeightMetres, kMaxHeightMetres);
    entry.lamp.rangeMetres =
        read.numberOr("range", entry.lamp.rangeMetres, 2 * entry.lamp.nearMetres, kMaxRangeMetres);
    readPower(properties, read, entry.lamp);
    if (const auto facing = read.optionalText("facing")) {
        entry.allRound = *facing == "all";
        if (*facing != "all" && *facing != "down")
            read.fail("\"facing\" must be \"down\" or \"all\"");
    }
    if (read.failure())
        return *read.failure();
    return entry;
}

} // namespace

Result<LampsFile> parseLampsFile(const std::string& text, const std::string& name) {
    const Result<Json> json = parseJson(text, name);
    if (!json)
        return json.error();
    if (!json->is_object() || !json->contains("features") || !json->at("features").is_array())
        return Error{name, "not a GeoJSON FeatureCollection: \"features\" must be a list"};
    LampsFile file;
    std::size_t number = 0;
    for (const Json& feature : json->at("features")) {
        const std::string where = "feature " + std::to_string(++number);
        if (!feature.is_object() || !feature.contains("geometry"))
            return Error{name, where + ": \"geometry\" is missing"};
        const Json& geometry = feature.at("geometry");
        if (!geometry.is_object() || !geometry.contains("type") || geometry.at("type") != "Point") {
            ++file.others;
            continue;
        }
        Result<LampsFile::Entry> entry = readFeature(feature, where, name);
        if (!entry)
            return entry.error();
        file.entries.push_back(std::move(*entry));
    }
    return file;
}

Result<LampsFile> readLampsFile(const std::string& path) {
    const Result<std::string> text = readTextFile(path, kMaxBytes);
    if (!text)
        return text.error();
    return parseLampsFile(*text, path);
}

Lamp placedLamp(const LampsFile::Entry& entry, double levelMetres) {
    Geodetic place = entry.foot;
    place.heightMetres += entry.heightMetres + (entry.onLevel ? levelMetres : 0.0);
    Lamp lamp = entry.lamp;
    lamp.position = ecefOf(place);
    lamp.facing = entry.allRound ? Vector<Ecef>{} : -ellipsoidNormal(lamp.position);
    return lamp;
}

} // namespace gnomon
