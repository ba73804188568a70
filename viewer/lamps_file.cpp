#include "viewer/lamps_file.h"

#include "viewer/input.h"
#include "viewer/json_read.h"

#include <cmath>
#include <fstream>

namespace gnomon {

namespace {

using Json = nlohmann::json;

// A city's street lamps are some 10^5, 200 bytes each.
constexpr std::size_t kMaxBytes = std::size_t(256) << 20;
constexpr double kMaxHeightMetres = 1e5;
constexpr double kMaxRangeMetres = 1e4;
constexpr double kMaxPower = 1e9;
constexpr double kPostMetres = 6.0;

void checkPlace(const LampsFile::Entry& entry, FieldReader& read) {
    if (!ecefFromGeodetic(entry.foot) || std::abs(entry.foot.longitudeDegrees) > 360 ||
        std::abs(entry.foot.heightMetres) > kMaxHeightMetres)
        read.fail("\"coordinates\" are not a place on the Earth");
}

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
    checkPlace(entry, read);
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

// Height, range, power and facing; the place is known already.
void readProperties(FieldReader& read, const Json& properties, LampsFile::Entry& entry) {
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
}

Result<LampsFile::Entry> readFeature(const Json& feature, const std::string& where,
                                     const std::string& name) {
    static const Json kNone = Json::object();
    LampsFile::Entry entry;
    const bool has = feature.contains("properties") && feature.at("properties").is_object();
    const Json& properties = has ? feature.at("properties") : kNone;
    FieldReader read(properties, name, where);
    readPoint(feature.at("geometry"), read, entry);
    readProperties(read, properties, entry);
    if (read.failure())
        return *read.failure();
    return entry;
}

// Three numbers, as GDAL writes a list, or as people do: "(3:1,0.8,0.5)", "[1, 0.8, 0.5]".
std::optional<Json> listIn(std::string text) {
    if (const auto counted = text.find(':'); text.starts_with('(') && counted != text.npos)
        text.erase(0, counted + 1);
    Json list = Json::array();
    std::string number;
    for (const char c : text + ",") {
        if (c != ',' && c != ']' && c != ')') {
            number += c == '[' || c == '(' ? ' ' : c;
            continue;
        }
        Feature one;
        one.attributes = {{"", number}};
        if (const auto value = one.number(""))
            list.push_back(*value);
        else if (number.find_first_not_of(' ') != number.npos)
            return std::nullopt;
        number.clear();
    }
    return list.size() == 3 ? std::optional(list) : std::nullopt;
}

// What a lamp is told by, as GeoJSON would have it: other formats know neither lists nor, some of
// them, numbers.
Json propertiesOf(const Feature& feature) {
    Json properties = Json::object();
    for (const char* key : {"height", "range", "power", "facing"}) {
        const AttributeValue* value = feature.attribute(key);
        const std::string* text = value ? std::get_if<std::string>(value) : nullptr;
        if (const auto number = feature.number(key))
            properties[key] = *number;
        else if (text && !text->empty())
            properties[key] = listIn(*text).value_or(Json(*text));
        else if (value && std::holds_alternative<bool>(*value))
            properties[key] = std::get<bool>(*value);
    }
    return properties;
}

void addLamps(const Feature& feature, const std::string& name, LampsFile& file) {
    const Json properties = propertiesOf(feature);
    for (const FeaturePart& part : feature.parts)
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring) {
                FieldReader read(properties, name, "feature " + feature.id);
                LampsFile::Entry entry;
                entry.onLevel = std::isnan(p.z);
                entry.foot = {p.x, p.y, entry.onLevel ? 0.0 : p.z};
                checkPlace(entry, read);
                readProperties(read, properties, entry);
                if (read.failure())
                    file.leftOut.push_back(*read.failure());
                else
                    file.entries.push_back(entry);
            }
}

void noteCeiling(LampsFile& file) {
    int hemispheres = 0;
    for (const LampsFile::Entry& entry : file.entries)
        hemispheres += entry.allRound ? 2 : 1;
    if (hemispheres > kMaxLampHemispheres)
        file.notes.push_back(
            std::to_string(file.entries.size()) + " lamps, of which at most " +
            std::to_string(kMaxLampHemispheres) +
            " are lit at once (all round: half as many), those that give most light where the eye "
            "is");
}

bool isJson(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    char first = 0;
    return in >> first && (first == '{' || first == '[');
}

// In degrees, as the format has it, and in no other system.
bool isPlainGeoJson(const std::string& json, const FeatureOptions& options) {
    return json.find("\"crs\"") == json.npos && json.find("\"CityObjects\"") == json.npos &&
           !options.crs && options.heights == Heights::Ellipsoidal && options.raiseMetres == 0.0;
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
    file.crs = "EPSG:4326";
    noteCeiling(file);
    return file;
}

LampsFile lampsOf(const FeatureFile& features, const std::string& name) {
    LampsFile file;
    file.notes = features.notes;
    file.leftOut = features.leftOut;
    file.crs = features.crs;
    for (const Feature& feature : features.features) {
        if (feature.shape == FeatureShape::Point)
            addLamps(feature, name, file);
        else
            ++file.others;
    }
    noteCeiling(file);
    return file;
}

Result<LampsFile> readLampsFile(const std::string& path, const FeatureOptions& options) {
    if (isJson(path)) {
        const Result<std::string> text = readTextFile(path, kMaxBytes);
        if (!text)
            return text.error();
        if (isPlainGeoJson(*text, options))
            return parseLampsFile(*text, path);
    }
    const Result<FeatureFile> features = readFeatures(path, options);
    if (!features)
        return features.error();
    LampsFile file = lampsOf(*features, path);
    if (file.entries.empty() && !file.leftOut.empty())
        return file.leftOut.front();
    return file;
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
