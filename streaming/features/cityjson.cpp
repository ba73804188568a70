// CityJSON 1.0 to 2.0 and CityJSON text sequences (https://www.cityjson.org/specs/): buildings with
// all their parts as surfaces in space, each object at the highest level of detail it has.
#include "streaming/features/features_read.h"
#include "streaming/gltf_document.h"
#include "streaming/soup.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <span>

namespace gnomon {

namespace {

using Json = nlohmann::json;

// urn:ogc:def:crs:EPSG::7415 and https://www.opengis.net/def/crs/EPSG/0/7415 are EPSG:7415.
std::string shortCrs(const std::string& reference) {
    const char separator = reference.starts_with("urn:") ? ':' : '/';
    std::vector<std::string> parts;
    for (std::size_t at = 0; at <= reference.size();) {
        const std::size_t end = std::min(reference.find(separator, at), reference.size());
        parts.push_back(reference.substr(at, end - at));
        at = end + 1;
    }
    // authority, version (may be empty), code
    return parts.size() >= 3 && !parts.back().empty() ? parts[parts.size() - 3] + ":" + parts.back()
                                                      : reference;
}

std::optional<glm::dvec3> threeNumbers(const Json& json) {
    if (!json.is_array() || json.size() != 3)
        return {};
    glm::dvec3 out(0.0);
    for (int i = 0; i < 3; ++i) {
        if (!json[std::size_t(i)].is_number())
            return {};
        out[i] = json[std::size_t(i)].get<double>();
    }
    return out;
}

const Json* member(const Json& object, const char* key) {
    if (!object.is_object())
        return nullptr;
    const auto found = object.find(key);
    return found == object.end() ? nullptr : &*found;
}

std::string textOf(const Json* json) {
    return json != nullptr && json->is_string() ? json->get<std::string>() : std::string{};
}

// "2.2", 2, 1.3; none says nothing, so it is the least.
double detailOf(const Json& geometry) {
    const Json* lod = member(geometry, "lod");
    if (lod != nullptr && lod->is_number())
        return lod->get<double>();
    const std::string text = textOf(lod);
    double value = -1.0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

// How many arrays stand around the surfaces of a geometry; none for points and lines.
std::optional<int> depthOf(const std::string& type) {
    if (type == "MultiSurface" || type == "CompositeSurface")
        return 1;
    if (type == "Solid")
        return 2;
    if (type == "MultiSolid" || type == "CompositeSolid")
        return 3;
    return {};
}

// Buildings, what they consist of and what extensions make of them; not what is inside.
bool isBuilding(const std::string& type) {
    const std::set<std::string> kInside = {"BuildingRoom", "BuildingFurniture", "BuildingStorey",
                                           "BuildingUnit"};
    return (type.starts_with("Building") && !kInside.contains(type)) ||
           (type.starts_with('+') && type.find("Building") != type.npos);
}

AttributeValue valueOf(const Json& json) {
    if (json.is_boolean())
        return json.get<bool>();
    if (json.is_number())
        return json.get<double>();
    if (json.is_string())
        return json.get<std::string>();
    if (json.is_null())
        return {};
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// What the objects of one file, or of one line of a sequence, share.
struct Vertices {
    glm::dvec3 scale{1.0}, translate{0.0};
    std::vector<glm::dvec3> positions;

    void readTransform(const Json& root) {
        const Json* transform = member(root, "transform");
        if (transform == nullptr)
            return;
        const Json *s = member(*transform, "scale"), *t = member(*transform, "translate");
        const auto readScale = s != nullptr ? threeNumbers(*s) : std::nullopt;
        const auto readTranslate = t != nullptr ? threeNumbers(*t) : std::nullopt;
        if (!readScale || !readTranslate)
            throw BadContent{"its transform is not three numbers of scale and of translate"};
        scale = *readScale;
        translate = *readTranslate;
    }
    void readPositions(const Json& root) {
        positions.clear();
        const Json* array = member(root, "vertices");
        if (array == nullptr || !array->is_array())
            throw BadContent{"it has no vertices"};
        positions.reserve(array->size());
        for (const Json& vertex : *array) {
            const auto p = threeNumbers(vertex);
            if (!p)
                throw BadContent{"vertex " + std::to_string(positions.size()) +
                                 " is not three numbers"};
            positions.push_back(*p * scale + translate);
        }
    }
};

class CityReader {
  public:
    explicit CityReader(FeatureFile& file) : file_(file) {}

    void readWhole(const Json& root) {
        readHeader(root);
        vertices_.readPositions(root);
        readObjects(root);
    }
    void readHeader(const Json& root) {
        vertices_.readTransform(root);
        const Json* metadata = member(root, "metadata");
        if (metadata == nullptr)
            return;
        raw_.crs = textOf(member(*metadata, "referenceSystem"));
        if (!raw_.crs.empty())
            raw_.crs = raw_.crsName = shortCrs(raw_.crs);
        // Of before 1.0.
        if (const Json* crs = member(*metadata, "crs"); crs != nullptr && raw_.crs.empty())
            if (const Json* epsg = member(*crs, "epsg"); epsg != nullptr && epsg->is_number())
                raw_.crs = raw_.crsName = "EPSG:" + std::to_string(epsg->get<long long>());
    }
    void readLine(const Json& line) {
        if (textOf(member(line, "type")) != "CityJSONFeature")
            return;
        vertices_.readTransform(line);
        vertices_.readPositions(line);
        readObjects(line);
    }
    RawFeatures finish() {
        if (!others_.empty()) {
            std::string line;
            for (const auto& [type, count] : others_)
                line += (line.empty() ? "" : ", ") + std::to_string(count) + " " + type;
            file_.notes.push_back("only its buildings are read; left out: " + line);
        }
        if (templates_ > 0)
            file_.notes.push_back(std::to_string(templates_) +
                                  " shapes that refer to templates are left out");
        return std::move(raw_);
    }

  private:
    void readObjects(const Json& root) {
        const Json* objects = member(root, "CityObjects");
        if (objects == nullptr || !objects->is_object())
            throw BadContent{"it has no CityObjects"};
        for (const auto& [id, object] : objects->items()) {
            const std::string type = textOf(member(object, "type"));
            if (!isBuilding(type)) {
                ++others_[type.empty() ? "object without a type" : type];
                continue;
            }
            const Json* parents = member(object, "parents");
            const bool isPart =
                parents != nullptr && parents->is_array() && !parents->empty() &&
                parents->front().is_string() &&
                objects->contains(parents->front().get<std::string>()) &&
                isBuilding(textOf(member((*objects)[parents->front().get<std::string>()], "type")));
            if (!isPart)
                readBuilding(id, object, *objects);
        }
    }

    // It and its parts, and theirs: one feature.
    void readBuilding(const std::string& id, const Json& building, const Json& objects) {
        std::vector<const Json*> family{&building};
        std::set<const Json*> known{&building};
        for (std::size_t i = 0; i < family.size(); ++i) {
            const Json* children = member(*family[i], "children");
            if (children == nullptr || !children->is_array())
                continue;
            for (const Json& child : *children) {
                const auto found =
                    child.is_string() ? objects.find(child.get<std::string>()) : objects.end();
                if (found != objects.end() && isBuilding(textOf(member(*found, "type"))) &&
                    known.insert(&*found).second)
                    family.push_back(&*found);
            }
        }
        Feature feature;
        feature.id = id;
        std::vector<const Json*> shapes;
        double most = -1.0;
        for (const Json* object : family) {
            addAttributes(feature, *object);
            if (const Json* shape = finest(*object)) {
                shapes.push_back(shape);
                most = std::max(most, detailOf(*shape));
            }
        }
        // A footprint (LoD 0) beside bodies is the same building once more; alone it is put up.
        feature.shape = most < 1.0 && most >= 0.0 ? FeatureShape::Polygon : FeatureShape::Surface;
        for (const Json* shape : shapes)
            if (detailOf(*shape) >= std::min(most, 1.0))
                addShape(feature, *shape);
        if (feature.parts.empty()) {
            file_.notes.push_back(id + " has no surfaces");
            return;
        }
        raw_.features.push_back(std::move(feature));
    }

    void addAttributes(Feature& feature, const Json& object) {
        const Json* attributes = member(object, "attributes");
        if (attributes == nullptr || !attributes->is_object())
            return;
        for (const auto& [name, value] : attributes->items())
            if (feature.attribute(name) == nullptr) // the building's own before its parts'
                feature.attributes.emplace_back(name, valueOf(value));
    }

    const Json* finest(const Json& object) {
        const Json* geometries = member(object, "geometry");
        const Json* best = nullptr;
        if (geometries == nullptr || !geometries->is_array())
            return nullptr;
        for (const Json& geometry : *geometries) {
            const std::string type = textOf(member(geometry, "type"));
            templates_ += type == "GeometryInstance";
            if (depthOf(type) && (best == nullptr || detailOf(geometry) > detailOf(*best)))
                best = &geometry;
        }
        return best;
    }

    void addShape(Feature& feature, const Json& shape) {
        if (const Json* boundaries = member(shape, "boundaries"))
            addSurfaces(feature, *boundaries, *depthOf(textOf(member(shape, "type"))));
    }

    // `depth` arrays down stand the surfaces, each an array of rings.
    void addSurfaces(Feature& feature, const Json& boundaries, int depth) {
        if (!boundaries.is_array())
            throw BadContent{feature.id + ": its boundaries are no arrays"};
        if (depth > 0) {
            for (const Json& inner : boundaries)
                addSurfaces(feature, inner, depth - 1);
            return;
        }
        FeaturePart part;
        for (const Json& ring : boundaries) {
            FeatureRing vertices = ringOf(feature.id, ring);
            if (vertices.size() >= 3)
                part.push_back(std::move(vertices));
            else if (part.empty())
                return;
        }
        if (!part.empty())
            feature.parts.push_back(std::move(part));
    }

    FeatureRing ringOf(const std::string& id, const Json& ring) const {
        if (!ring.is_array())
            throw BadContent{id + ": its boundaries are no arrays"};
        FeatureRing vertices;
        for (const Json& index : ring) {
            if (!index.is_number_unsigned() ||
                index.get<std::uint64_t>() >= vertices_.positions.size())
                throw BadContent{id + ": refers to a vertex that is not there"};
            vertices.push_back(vertices_.positions[std::size_t(index.get<std::uint64_t>())]);
        }
        if (vertices.size() > 1 && vertices.front() == vertices.back())
            vertices.pop_back();
        return vertices;
    }

    FeatureFile& file_;
    Vertices vertices_;
    RawFeatures raw_;
    std::map<std::string, std::size_t> others_;
    std::size_t templates_ = 0;
};

Json parsed(std::string_view text, const char* what) {
    checkJsonDepth(std::as_bytes(std::span(text)));
    Json json = Json::parse(text.begin(), text.end(), nullptr, false);
    if (!json.is_object())
        throw BadContent{std::string(what) + " is not JSON"};
    return json;
}

// The first line of a sequence is a CityJSON object of its own, more follow.
bool isSequence(std::string_view text) {
    const std::size_t end = text.find('\n');
    const std::size_t next = end == text.npos ? end : text.find_first_not_of(" \t\r\n", end);
    return next != text.npos && text[next] == '{' && text.find("\"CityJSONFeature\"") != text.npos;
}

void readSequence(std::string_view text, CityReader& reader, const std::string& path,
                  FeatureFile& file) {
    std::size_t number = 0;
    ManyLines broken("lines that cannot be used");
    for (std::size_t at = 0; at < text.size(); ++number) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = text.substr(at, end - at);
        at = end + 1;
        if (line.find_first_not_of(" \t\r\x1e") == line.npos)
            continue;
        try {
            const Json json = parsed(line.substr(line.front() == '\x1e' ? 1 : 0), "it");
            if (number == 0)
                reader.readHeader(json);
            else
                reader.readLine(json);
        } catch (const BadContent& bad) {
            if (broken.add())
                file.leftOut.push_back({path + ", line " + std::to_string(number + 1), bad.reason});
        }
    }
    if (const auto rest = broken.rest())
        file.leftOut.push_back({path, *rest});
}

} // namespace

Failure readCityJson(const std::string& path, const std::string& text,
                     std::vector<RawFeatures>& out, FeatureFile& file) {
    std::string_view view = text;
    if (view.starts_with("\xef\xbb\xbf"))
        view.remove_prefix(3);
    CityReader reader(file);
    try {
        if (isSequence(view))
            readSequence(view, reader, path, file);
        else
            reader.readWhole(parsed(view, "the file"));
    } catch (const BadContent& bad) {
        return Error{path, "is CityJSON that cannot be used: " + bad.reason};
    }
    if (file.format.empty())
        file.format = "CityJSON";
    out.push_back(reader.finish());
    return {};
}

} // namespace gnomon
