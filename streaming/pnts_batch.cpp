#include "streaming/pnts_batch.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <limits>

namespace gnomon {

namespace {

using Json = nlohmann::ordered_json; // columns keep their order

constexpr const char* kExtension = "3DTILES_draco_point_compression";

Json parse(const TileParts& parts, ByteBudget& budget) {
    // Every value of a parsed document takes at least two bytes of text and some 40 of memory.
    budget.take(parts.batchJson.size() / 2, 40, "JSON");
    checkJsonDepth(parts.batchJson);
    const char* text = reinterpret_cast<const char*>(parts.batchJson.data());
    return Json::parse(text, text + parts.batchJson.size(), nullptr, false);
}

template <class T>
void put(Bytes& out, double value) {
    T stored{};
    if constexpr (std::numeric_limits<T>::is_integer) {
        constexpr double kLeast = double(std::numeric_limits<T>::lowest()),
                         kMost = double(std::numeric_limits<T>::max());
        stored = T(value > kLeast ? std::min(value, kMost) : kLeast); // NaN is the least
    } else {
        stored = T(value);
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(&stored);
    out.insert(out.end(), bytes, bytes + sizeof stored);
}

using Put = void (*)(Bytes&, double);

Put putOf(const Json& column) {
    static const std::map<std::string, Put> kinds{
        {"BYTE", &put<std::int8_t>},   {"UNSIGNED_BYTE", &put<std::uint8_t>},
        {"SHORT", &put<std::int16_t>}, {"UNSIGNED_SHORT", &put<std::uint16_t>},
        {"INT", &put<std::int32_t>},   {"UNSIGNED_INT", &put<std::uint32_t>},
        {"FLOAT", &put<float>},        {"DOUBLE", &put<double>},
    };
    const auto said = column.find("componentType");
    const auto kind = said != column.end() && said->is_string()
                          ? kinds.find(said->get<std::string>())
                          : kinds.end();
    return kind != kinds.end() ? kind->second : nullptr;
}

} // namespace

std::map<std::string, std::uint32_t> dracoColumns(const TileParts& parts, ByteBudget& budget) {
    const std::string_view text(reinterpret_cast<const char*>(parts.batchJson.data()),
                                parts.batchJson.size());
    std::map<std::string, std::uint32_t> out;
    if (text.find(kExtension) == std::string_view::npos) {
        return out;
    }
    const Json table = parse(parts, budget);
    const Json::json_pointer where(std::string("/extensions/") + kExtension + "/properties");
    if (!table.is_object() || !table.contains(where) || !table[where].is_object()) {
        return out;
    }
    for (const auto& [name, id] : table[where].items()) {
        if (!id.is_number_unsigned() || id.get<std::uint64_t>() >= kNoFeature) {
            throw BadContent{std::string("pnts: malformed ") + kExtension + " of the batch table"};
        }
        out.emplace(name, id.get<std::uint32_t>());
    }
    return out;
}

PlainBatchTable plainBatchTable(const TileParts& parts,
                                const std::map<std::string, const DracoAttribute*>& columns,
                                ByteBudget& budget) {
    PlainBatchTable out{{}, Bytes(parts.batchBinary.begin(), parts.batchBinary.end())};
    Json table = parse(parts, budget);
    for (const auto& [name, attribute] : columns) {
        const auto column = table.find(name);
        const Put store = column != table.end() && column->is_object() ? putOf(*column) : nullptr;
        if (!store) {
            continue; // the table is read without it, and says so
        }
        constexpr std::size_t kAlignment = 8;
        budget.take(attribute->values.size() + 1, kAlignment, "batch table");
        out.binary.resize((out.binary.size() + kAlignment - 1) / kAlignment * kAlignment);
        (*column)["byteOffset"] = out.binary.size();
        for (const double value : attribute->values) {
            store(out.binary, value);
        }
    }
    table["extensions"].erase(kExtension);
    const std::string text = table.dump(-1, ' ', false, Json::error_handler_t::replace);
    const auto bytes = std::as_bytes(std::span(text));
    out.json.assign(bytes.begin(), bytes.end());
    return out;
}

} // namespace gnomon
