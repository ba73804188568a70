#include "streaming/feature_table.h"

#include "streaming/feature_columns.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

namespace gnomon {

namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kMostRows = 0xfffffffe; // so that none is kNoFeature

std::string dumped(const Json& value) {
    return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

PropertyValue valueOf(const Json& value) {
    switch (value.type()) {
    case Json::value_t::boolean:
        return value.get<bool>();
    case Json::value_t::number_integer:
        return value.get<std::int64_t>();
    case Json::value_t::number_unsigned:
        if (value.get<std::uint64_t>() <= std::uint64_t(INT64_MAX)) {
            return value.get<std::int64_t>();
        }
        return value.get<std::uint64_t>();
    case Json::value_t::number_float:
        return value.get<double>();
    case Json::value_t::string:
        return value.get<std::string>();
    case Json::value_t::array:
    case Json::value_t::object:
        return JsonText{dumped(value)};
    default:
        return std::monostate{};
    }
}

class ColumnTable : public FeatureTable {
  public:
    ColumnTable(std::string className, std::uint32_t rows, Columns columns)
        : class_(std::move(className)), rows_(rows), columns_(std::move(columns)) {}

    std::uint32_t rows() const override { return rows_; }
    std::vector<Property> row(std::uint32_t feature) const override {
        std::vector<Property> out;
        if (feature < rows_) {
            for (const auto& column : columns_) {
                out.push_back({column->name(), valueOf(column->at(feature))});
            }
        }
        return out;
    }
    std::vector<FeatureClass> classes() const override {
        FeatureClass one{class_, rows_, {}};
        for (const auto& column : columns_) {
            one.properties.push_back(column->name());
        }
        return {one};
    }
    std::size_t bytes() const override {
        std::size_t total = sizeof(ColumnTable) + class_.size();
        for (const auto& column : columns_) {
            total += sizeof column + column->bytes() + column->name().size();
        }
        return total;
    }

  private:
    std::string class_;
    std::uint32_t rows_;
    Columns columns_;
};

class JoinedTable : public FeatureTable {
  public:
    explicit JoinedTable(std::vector<std::shared_ptr<const FeatureTable>> tables)
        : tables_(std::move(tables)) {
        std::uint64_t end = 0;
        for (const auto& table : tables_) {
            end = std::min(end + table->rows(), kMostRows);
            ends_.push_back(std::uint32_t(end));
        }
    }
    std::uint32_t rows() const override { return ends_.back(); }
    std::vector<Property> row(std::uint32_t feature) const override {
        const auto at = std::upper_bound(ends_.begin(), ends_.end(), feature);
        if (at == ends_.end()) {
            return {};
        }
        const std::uint32_t first = at == ends_.begin() ? 0 : *(at - 1);
        return tables_[std::size_t(at - ends_.begin())]->row(feature - first);
    }
    std::vector<FeatureClass> classes() const override {
        std::vector<FeatureClass> all;
        for (const auto& table : tables_) {
            const auto more = table->classes();
            all.insert(all.end(), more.begin(), more.end());
        }
        return all;
    }
    std::size_t bytes() const override {
        std::size_t total = sizeof(JoinedTable);
        for (const auto& table : tables_) {
            total += sizeof table + table->bytes();
        }
        return total;
    }

  private:
    std::vector<std::shared_ptr<const FeatureTable>> tables_;
    std::vector<std::uint32_t> ends_;
};

// Letters and digits only, small: "gml:id", "gml_id" and "GmlId" are one.
std::string plainName(const std::string& name) {
    std::string out;
    for (const char c : name) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
            out.push_back(char(std::tolower(static_cast<unsigned char>(c))));
        }
    }
    return out;
}

} // namespace

std::shared_ptr<const FeatureTable> columnTable(std::string className, std::uint32_t rows,
                                                Columns columns) {
    return std::make_shared<ColumnTable>(std::move(className), rows, std::move(columns));
}

std::shared_ptr<const FeatureTable>
joinedTables(std::vector<std::shared_ptr<const FeatureTable>> tables) {
    std::erase(tables, nullptr);
    if (tables.empty()) {
        return nullptr;
    }
    return tables.size() == 1 ? tables.front() : std::make_shared<JoinedTable>(std::move(tables));
}

double asWritten(float value) {
    char text[32];
    double out = double(value);
    if (std::isfinite(value)) {
        const auto end = std::to_chars(std::begin(text), std::end(text), value).ptr;
        std::from_chars(text, end, out);
    }
    return out;
}

std::string shownName(std::string_view name) {
    constexpr std::size_t kMost = 80;
    std::string out(name.substr(0, kMost));
    for (char& c : out) {
        c = static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    }
    return name.size() > kMost ? out + "..." : out;
}

std::string idOf(const std::vector<Property>& row, std::uint32_t feature) {
    // In this order: what a city calls a building before what a tool numbered it.
    constexpr std::array<const char*, 14> kNames{
        "id",    "gmlid",     "identificatie", "uuid", "guid",      "bin",      "buildingid",
        "osmid", "elementid", "objectid",      "fid",  "featureid", "globalid", "name"};
    const auto textOf = [](const Property& property) -> std::string {
        if (const auto* text = std::get_if<std::string>(&property.value)) {
            return *text;
        }
        const bool none = std::holds_alternative<std::monostate>(property.value);
        return none ? std::string() : jsonOf(property.value);
    };
    for (const char* name : kNames) {
        for (const Property& property : row) {
            if (plainName(property.name) != name) {
                continue;
            }
            if (std::string text = textOf(property); !text.empty()) {
                return text;
            }
        }
    }
    for (const Property& property : row) { // "blockid"
        if (plainName(property.name).ends_with("id")) {
            if (std::string text = textOf(property); !text.empty()) {
                return text;
            }
        }
    }
    return std::to_string(feature);
}

std::string jsonOf(const PropertyValue& value) {
    return std::visit(
        [](const auto& v) -> std::string {
            using T = std::decay_t<decltype(v)>;
            if constexpr (std::is_same_v<T, std::monostate>) {
                return "null";
            } else if constexpr (std::is_same_v<T, JsonText>) {
                return v.text;
            } else {
                return dumped(Json(v)); // a number that is not finite is null
            }
        },
        value);
}

} // namespace gnomon
