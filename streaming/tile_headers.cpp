#include "streaming/tile_headers.h"

#include "streaming/component_type.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

using Json = nlohmann::json;
using Span = std::span<const std::byte>;

std::uint32_t word(Span b, std::size_t i) {
    return std::to_integer<std::uint32_t>(b[i]) | std::to_integer<std::uint32_t>(b[i + 1]) << 8 |
           std::to_integer<std::uint32_t>(b[i + 2]) << 16 |
           std::to_integer<std::uint32_t>(b[i + 3]) << 24;
}

// Magic, version and length, which all of them begin with; cut to that length.
Span checkedTile(Span bytes, std::size_t headerBytes, const std::string& format) {
    if (bytes.size() < headerBytes) {
        throw BadContent{format + " header cut short"};
    }
    if (word(bytes, 4) != 1) {
        throw BadContent{format + " of version " + std::to_string(word(bytes, 4)) +
                         "; only 1 is supported"};
    }
    const std::uint32_t whole = word(bytes, 8);
    if (whole > bytes.size()) {
        throw BadContent{format + " says it has " + std::to_string(whole) + " bytes, but only " +
                         std::to_string(bytes.size()) + " are there"};
    }
    if (whole < headerBytes) {
        throw BadContent{format + " says it is shorter than its header"};
    }
    return bytes.first(whole);
}

struct Lengths {
    std::uint64_t header = 0;
    std::uint64_t tables[4] = {0, 0, 0, 0}; // feature JSON and binary, batch JSON and binary
};

// Two older headers of b3dm had 20 and 24 bytes. Read as today's, what follows them (JSON's '{"' or
// glTF's magic) gives a length no table has: at least this.
Lengths b3dmLengths(Span bytes, std::optional<std::uint32_t>& batchLength) {
    constexpr std::uint32_t kNoLength = 570425344;
    Lengths out{28, {word(bytes, 12), word(bytes, 16), word(bytes, 20), word(bytes, 24)}};
    if (out.tables[2] >= kNoLength) { // batch length, batch table JSON
        batchLength = word(bytes, 12);
        return {20, {0, 0, word(bytes, 16), 0}};
    }
    if (out.tables[3] >= kNoLength) { // batch table JSON, batch table binary, batch length
        batchLength = word(bytes, 20);
        return {24, {0, 0, word(bytes, 12), word(bytes, 16)}};
    }
    return out;
}

bool isAllNumbers(const Json& array) {
    return std::all_of(array.begin(), array.end(), [](const Json& v) { return v.is_number(); });
}

std::optional<std::uint64_t> unsignedIn(const Json& object, const char* key) {
    const auto it = object.is_object() ? object.find(key) : object.end();
    return it != object.end() && it->is_number_unsigned() ? std::optional(it->get<std::uint64_t>())
                                                          : std::nullopt;
}

// Tables are filled up to a multiple of eight bytes, by some writers with zeros.
Json parseTable(Span json, const std::string& format) {
    while (!json.empty() && json.back() == std::byte(0)) {
        json = json.first(json.size() - 1);
    }
    if (json.empty()) {
        return Json::object();
    }
    checkJsonDepth(json);
    const char* text = reinterpret_cast<const char*>(json.data());
    Json table = Json::parse(text, text + json.size(), nullptr, false);
    if (!table.is_object()) {
        throw BadContent{format + ": malformed feature table"};
    }
    return table;
}

} // namespace

TileParts readTileParts(Span bytes) {
    TileParts out;
    out.format.assign(reinterpret_cast<const char*>(bytes.data()),
                      std::min<std::size_t>(bytes.size(), 4));
    const bool isI3dm = out.format == "i3dm";
    bytes = checkedTile(bytes, isI3dm ? 32 : 28, out.format);
    Lengths lengths{isI3dm ? 32u : 28u,
                    {word(bytes, 12), word(bytes, 16), word(bytes, 20), word(bytes, 24)}};
    if (out.format == "b3dm") {
        lengths = b3dmLengths(bytes, out.batchLength);
    }
    std::uint64_t offset = lengths.header;
    Span* const parts[4] = {&out.featureJson, &out.featureBinary, &out.batchJson, &out.batchBinary};
    for (int i = 0; i < 4; ++i) {
        if (lengths.tables[i] > bytes.size() - offset) {
            throw BadContent{out.format + " whose tables are longer than the file"};
        }
        *parts[i] = bytes.subspan(std::size_t(offset), std::size_t(lengths.tables[i]));
        offset += lengths.tables[i];
    }
    out.body = bytes.subspan(std::size_t(offset));
    if (isI3dm) {
        if (word(bytes, 28) > 1) {
            throw BadContent{"i3dm with a model of kind " + std::to_string(word(bytes, 28)) +
                             "; 0 (uri) and 1 (inside) exist"};
        }
        out.bodyIsUri = word(bytes, 28) == 0;
    }
    if (out.body.empty() && out.format != "pnts") {
        throw BadContent{out.format + " without a glTF inside"};
    }
    return out;
}

std::vector<Span> readComposite(Span bytes) {
    constexpr std::size_t kHeader = 16, kLeastTile = 12; // magic, version, length
    bytes = checkedTile(bytes, kHeader, "cmpt");
    const std::uint32_t count = word(bytes, 12);
    std::vector<Span> tiles;
    std::size_t offset = kHeader;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Span rest = bytes.subspan(offset);
        const std::uint32_t length = rest.size() >= kLeastTile ? word(rest, 8) : 0;
        if (length < kLeastTile || length > rest.size()) {
            throw BadContent{"cmpt whose part " + std::to_string(i + 1) + " of " +
                             std::to_string(count) + " is not all there"};
        }
        tiles.push_back(rest.first(length));
        offset += length;
    }
    return tiles;
}

glm::dvec3 octNormal(double x, double y) {
    double u = 2.0 * x - 1.0, v = 2.0 * y - 1.0;
    const double z = 1.0 - std::abs(u) - std::abs(v);
    if (z < 0.0) {
        const double before = u;
        u = std::copysign(1.0 - std::abs(v), u);
        v = std::copysign(1.0 - std::abs(before), v);
    }
    return glm::normalize(glm::dvec3(u, v, z));
}

double SemanticValues::at(std::size_t element, int component) const {
    const std::size_t i = element * std::size_t(components_) + std::size_t(component);
    return numbers_.empty() ? loadAs(type_, bytes_.data() + i * componentBytes(type_))
                            : numbers_[i];
}

struct TileSemantics::Table {
    Json json;

    const Json* find(const char* name) const {
        const auto it = json.find(name);
        return it != json.end() && !it->is_null() ? &*it : nullptr;
    }
};

TileSemantics::TileSemantics(const TileParts& parts, ByteBudget& budget)
    : format_(parts.format), binary_(parts.featureBinary) {
    // Every value of a parsed document takes at least two bytes of text and some 40 of memory.
    budget.take(parts.featureJson.size() / 2, 40, "JSON");
    table_ = std::make_unique<Table>(Table{parseTable(parts.featureJson, parts.format)});
}

TileSemantics::~TileSemantics() = default;

Span TileSemantics::binaryOf(const char* name, std::uint64_t offset, std::uint64_t count,
                             std::uint64_t bytesEach) const {
    if (offset > binary_.size() || count > (binary_.size() - offset) / bytesEach) {
        throw BadContent{format_ + ": " + name + " lies outside the feature table"};
    }
    return binary_.subspan(std::size_t(offset), std::size_t(count * bytesEach));
}

std::optional<std::uint32_t> TileSemantics::count(const char* name) const {
    const std::vector<double> value = numbers(name, 1, ComponentType::UnsignedInt);
    if (value.empty()) {
        return {};
    }
    if (!(value[0] >= 0.0 && value[0] < double(kNoFeature) && value[0] == std::floor(value[0]))) {
        throw BadContent{format_ + ": malformed " + name};
    }
    return std::uint32_t(value[0]);
}

bool TileSemantics::flag(const char* name) const {
    const Json* value = table_->find(name);
    return value && value->is_boolean() && value->get<bool>();
}

std::vector<double> TileSemantics::numbers(const char* name, std::size_t components,
                                           ComponentType type) const {
    const Json* value = table_->find(name);
    if (!value) {
        return {};
    }
    if (components == 1 && value->is_number()) {
        return {value->get<double>()};
    }
    if (value->is_array() && value->size() == components && isAllNumbers(*value)) {
        return value->get<std::vector<double>>();
    }
    const auto offset = unsignedIn(*value, "byteOffset");
    if (!offset) {
        throw BadContent{format_ + ": malformed " + name};
    }
    const Span bytes = binaryOf(name, *offset, components, componentBytes(type));
    std::vector<double> out;
    for (std::size_t i = 0; i < components; ++i) {
        out.push_back(loadAs(type, bytes.data() + i * componentBytes(type)));
    }
    return out;
}

std::optional<glm::dvec3> TileSemantics::vec3(const char* name) const {
    const std::vector<double> v = numbers(name, 3, ComponentType::Float);
    return v.empty() ? std::nullopt : std::optional(glm::dvec3(v[0], v[1], v[2]));
}

std::optional<SemanticValues> TileSemantics::values(const char* name, std::size_t count,
                                                    int components, ComponentType type) const {
    const Json* value = table_->find(name);
    if (!value) {
        return {};
    }
    SemanticValues out;
    out.type_ = type;
    out.components_ = components;
    if (value->is_array()) {
        if (value->size() / std::size_t(components) < count || !isAllNumbers(*value)) {
            throw BadContent{format_ + ": " + name + " has values for too few of " +
                             std::to_string(count)};
        }
        out.numbers_ = value->get<std::vector<double>>();
        return out;
    }
    const auto offset = unsignedIn(*value, "byteOffset");
    if (!offset) {
        throw BadContent{format_ + ": malformed " + name};
    }
    out.bytes_ = binaryOf(name, *offset, count, std::uint64_t(components) * componentBytes(type));
    return out;
}

std::optional<SemanticValues> TileSemantics::batchIds(std::size_t count) const {
    const Json* value = table_->find("BATCH_ID");
    ComponentType type = ComponentType::UnsignedShort; // when nothing is said
    if (value && value->is_object() && value->contains("componentType")) {
        const Json& said = (*value)["componentType"];
        const std::string name = said.is_string() ? said.get<std::string>() : std::string();
        if (name == "UNSIGNED_BYTE") {
            type = ComponentType::UnsignedByte;
        } else if (name == "UNSIGNED_INT") {
            type = ComponentType::UnsignedInt;
        } else if (name != "UNSIGNED_SHORT") {
            throw BadContent{format_ + ": BATCH_ID of an unknown type"};
        }
    }
    return values("BATCH_ID", count, 1, type);
}

std::optional<DracoSemantics> TileSemantics::draco() const {
    const Json* extensions = table_->find("extensions");
    if (!extensions || !extensions->is_object() ||
        !extensions->contains("3DTILES_draco_point_compression")) {
        return {};
    }
    const Json& said = (*extensions)["3DTILES_draco_point_compression"];
    const auto offset = unsignedIn(said, "byteOffset"), length = unsignedIn(said, "byteLength");
    const bool whole = offset && length && said.contains("properties");
    if (!whole || !said["properties"].is_object()) {
        throw BadContent{format_ + ": malformed 3DTILES_draco_point_compression"};
    }
    DracoSemantics out;
    out.bytes = binaryOf("3DTILES_draco_point_compression", *offset, *length, 1);
    for (const auto& [name, id] : said["properties"].items()) {
        if (!id.is_number_unsigned() || id.get<std::uint64_t>() >= kNoFeature) {
            throw BadContent{format_ + ": malformed 3DTILES_draco_point_compression"};
        }
        out.uniqueIds.emplace(name, id.get<std::uint32_t>());
    }
    return out;
}

} // namespace gnomon
