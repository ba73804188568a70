#include "streaming/tileset_values.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace gnomon::tilesetjson {
namespace {

// A column this much shorter than another has no direction left in double.
constexpr double kSingular = 1e-12;

bool isWithinReach(const glm::dvec3& v) {
    return std::abs(v.x) < kMaxCoordinateMetres && std::abs(v.y) < kMaxCoordinateMetres &&
           std::abs(v.z) < kMaxCoordinateMetres; // false for NaN
}

bool isWithinReach(const BoundingVolume& volume) {
    if (const auto* box = std::get_if<OrientedBox>(&volume))
        return isWithinReach(box->centre.xyz) && isWithinReach(box->halfAxes[0]) &&
               isWithinReach(box->halfAxes[1]) && isWithinReach(box->halfAxes[2]);
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return isWithinReach(sphere->centre.xyz) && sphere->radiusMetres < kMaxCoordinateMetres;
    return true;
}

bool endsWith(const std::string& text, std::string_view ending) {
    return text.size() >= ending.size() &&
           std::string_view(text).substr(text.size() - ending.size()) == ending;
}

Result<BoundingVolume> readRegion(const json& value) {
    const auto refused = [](const char* why) { return Error{"", why, ErrorKind::Input}; };
    const auto n = finiteNumbers<6>(value);
    if (!n)
        return refused("boundingVolume.region is not 6 finite numbers");
    const double west = (*n)[0] / kRadiansPerDegree, south = (*n)[1] / kRadiansPerDegree;
    const double east = (*n)[2] / kRadiansPerDegree, north = (*n)[3] / kRadiansPerDegree;
    if (south > north)
        return refused("boundingVolume.region has its south north of its north");
    // Exporters round pi, hence the slack.
    if (std::abs(south) > 90.001 || std::abs(north) > 90.001 || std::abs(west) > 360.001 ||
        std::abs(east) > 360.001)
        return refused("boundingVolume.region is not in radians of longitude and latitude");
    if (!(std::abs((*n)[4]) < kMaxCoordinateMetres && std::abs((*n)[5]) < kMaxCoordinateMetres))
        return refused("boundingVolume.region has heights beyond 1e12 m");
    return BoundingVolume(makeRegion(west, south, east, north, std::min((*n)[4], (*n)[5]),
                                     std::max((*n)[4], (*n)[5])));
}

} // namespace

const json* member(const json& object, const char* key) {
    if (!object.is_object())
        return nullptr;
    const auto it = object.find(key);
    return it == object.end() ? nullptr : &*it;
}

const json* extension(const json& object, const char* key) {
    const json* extensions = member(object, "extensions");
    return extensions ? member(*extensions, key) : nullptr;
}

std::optional<double> finiteNumber(const json* value) {
    if (!value || !value->is_number())
        return std::nullopt;
    const double number = value->get<double>();
    return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::optional<std::int64_t> integer(const json* value) {
    const auto number = finiteNumber(value);
    if (!number || *number != std::floor(*number) || std::abs(*number) > 9e15)
        return std::nullopt;
    return std::int64_t(*number);
}

std::string lowered(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

std::string shown(std::string text) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20)
            c = '?';
    if (text.size() > 200)
        text = text.substr(0, 200) + "...";
    return text;
}

std::vector<std::string> strings(const json* value) {
    std::vector<std::string> out;
    if (value && value->is_array())
        for (const json& entry : *value)
            if (entry.is_string())
                out.push_back(shown(entry.get<std::string>()));
    return out;
}

double largestScale(const glm::dmat4& m) {
    return std::max({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])),
                     glm::length(glm::dvec3(m[2]))});
}

const char* flawOf(const glm::dmat4& m) {
    for (int column = 0; column < 4; ++column)
        if (!isWithinReach(glm::dvec3(m[column])))
            return "transform goes beyond 1e12 m";
    if (std::abs(m[0].w) + std::abs(m[1].w) + std::abs(m[2].w) + std::abs(m[3].w - 1.0) > 1e-9)
        return "transform is not affine";
    const double largest = largestScale(m);
    const double volume = std::abs(glm::determinant(glm::dmat3(m)));
    if (!(volume > kSingular * largest * largest * largest))
        return "transform is singular";
    return nullptr;
}

ContentKind kindByName(const std::string& path) {
    const std::string name = lowered(path.substr(0, path.find('?'))); // of the web, with a query
    if (endsWith(name, ".json"))
        return ContentKind::ExternalTileset;
    for (const char* ending : {".b3dm", ".glb", ".gltf", ".i3dm", ".cmpt", ".pnts"})
        if (endsWith(name, ending))
            return ContentKind::Mesh;
    return ContentKind::Unknown;
}

Result<BoundingVolume> readVolume(const json* value, const Transform<Ecef, Tile>& ecefFromTile) {
    const auto refused = [](std::string why) {
        return Error{"", std::move(why), ErrorKind::Input};
    };
    if (!value || !value->is_object())
        return refused("has no boundingVolume");
    BoundingVolume local;
    if (const json* box = member(*value, "box")) {
        const auto n = finiteNumbers<12>(*box);
        if (!n)
            return refused("boundingVolume.box is not 12 finite numbers");
        const auto& b = *n;
        local = OrientedBox{{glm::dvec3(b[0], b[1], b[2])},
                            glm::dmat3(b[3], b[4], b[5], b[6], b[7], b[8], b[9], b[10], b[11])};
    } else if (const json* region = member(*value, "region")) {
        return readRegion(*region);
    } else if (const json* sphere = member(*value, "sphere")) {
        const auto n = finiteNumbers<4>(*sphere);
        if (!n)
            return refused("boundingVolume.sphere is not 4 finite numbers");
        if ((*n)[3] < 0.0)
            return refused("boundingVolume.sphere has a negative radius");
        local = Sphere{{glm::dvec3((*n)[0], (*n)[1], (*n)[2])}, (*n)[3]};
    } else if (extension(*value, "3DTILES_bounding_volume_S2")) {
        return refused("boundingVolume is an S2 cell, which is not supported");
    } else {
        return refused("boundingVolume has neither box, region nor sphere");
    }
    if (!isWithinReach(local))
        return refused("boundingVolume goes beyond 1e12 m");
    BoundingVolume volume = transformed(local, ecefFromTile);
    if (!isWithinReach(volume))
        return refused("boundingVolume goes beyond 1e12 m");
    return volume;
}

Failure readHead(const json& document, const std::string& path, TilesetFacts& facts) {
    // Those that are read, and those whose absence from a picture nobody sees.
    constexpr std::array<std::string_view, 6> kKnownExtensions{
        "3DTILES_content_gltf", "3DTILES_implicit_tiling",       "3DTILES_multiple_contents",
        "3DTILES_metadata",     "3DTILES_batch_table_hierarchy", "3DTILES_draco_point_compression"};
    const auto bad = [&](const std::string& why) { return Error{path, why, ErrorKind::Input}; };
    if (!document.is_object())
        return bad("is not a JSON object");
    const json* asset = member(document, "asset");
    const json* version = asset ? member(*asset, "version") : nullptr;
    if (!version || !version->is_string())
        return bad("is no tileset: asset.version is missing");
    facts.version = shown(version->get<std::string>());
    if (facts.version != "0.0" && facts.version != "1.0" && facts.version != "1.1")
        return bad("has asset version " + facts.version + "; 0.0, 1.0 and 1.1 are known");
    if (const json* generator = member(*asset, "generator"); generator && generator->is_string())
        facts.generator = shown(generator->get<std::string>());
    facts.extensionsUsed = strings(member(document, "extensionsUsed"));
    facts.extensionsRequired = strings(member(document, "extensionsRequired"));
    for (const std::string& name : facts.extensionsRequired)
        if (std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) ==
            kKnownExtensions.end())
            return bad("requires the extension " + name + ", which is not supported");
    if (!member(document, "root"))
        return bad("has no root");
    return std::nullopt;
}

UpAxis upAxisOf(const json& document, UpAxis inherited) {
    const json* axis = member(document.at("asset"), "gltfUpAxis");
    const std::string name = axis && axis->is_string() ? lowered(axis->get<std::string>()) : "";
    return name == "x" ? UpAxis::X : name == "y" ? UpAxis::Y : name == "z" ? UpAxis::Z : inherited;
}

} // namespace gnomon::tilesetjson
