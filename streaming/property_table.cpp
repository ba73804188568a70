#include "streaming/property_table.h"

#include "streaming/gltf_parts.h"
#include "streaming/json_slices.h"
#include "streaming/json_text.h"
#include "streaming/property_column.h"
#include "streaming/soup.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <set>

namespace gnomon {

namespace {

using Json = nlohmann::json;
using Kind = PropertyLayout::Kind;

const Json* member(const Json& object, const char* key) {
    if (!object.is_object()) {
        return nullptr;
    }
    const auto it = object.find(key);
    return it == object.end() ? nullptr : &*it;
}

std::string textIn(const Json& object, const char* key, const std::string& without = {}) {
    const Json* value = member(object, key);
    return value && value->is_string() ? value->get<std::string>() : without;
}

bool isTrue(const Json& object, const char* key) {
    const Json* value = member(object, key);
    return value && value->is_boolean() && value->get<bool>();
}

std::optional<std::uint64_t> countIn(const Json& object, const char* key) {
    const Json* value = member(object, key);
    return value && value->is_number_unsigned() ? std::optional(value->get<std::uint64_t>())
                                                : std::nullopt;
}

// Thrown inside this file only: why a column cannot be read.
struct BadColumn {
    std::string reason;
};

// A number, or numbers in arrays of arrays, one behind another.
void flatten(const Json& value, std::vector<double>& out, int depth = 0) {
    constexpr std::size_t kMost = 4096;
    if (value.is_number() && out.size() < kMost) {
        out.push_back(value.get<double>());
    } else if (value.is_array() && depth < 2) {
        for (const Json& part : value) {
            flatten(part, out, depth + 1);
        }
    } else {
        throw BadColumn{"its offset or scale is no number"};
    }
}

std::uint64_t product(std::uint64_t a, std::uint64_t b) {
    if (b != 0 && a > std::numeric_limits<std::uint64_t>::max() / b) {
        throw BadColumn{"it has more values than can be counted"};
    }
    return a * b;
}

// What a schema says of one property.
class LayoutReader {
  public:
    LayoutReader(const Json& schema, ByteBudget& budget) : schema_(schema), budget_(budget) {}

    // `own` is the table's part, which may have offset and scale of its own.
    PropertyLayout read(const Json& property, const Json& own) {
        PropertyLayout layout;
        setType(property, layout);
        layout.isArray = isTrue(property, "array");
        if (layout.isArray) {
            layout.arrayLength = countIn(property, "count");
            if (layout.arrayLength == 0) {
                throw BadColumn{"its arrays have a count of 0"};
            }
        }
        layout.normalized = isTrue(property, "normalized");
        setNumbers("scale", property, own, layout, layout.scale);
        setNumbers("offset", property, own, layout, layout.offset);
        layout.noData = valueIn(property, "noData");
        layout.otherwise = valueIn(property, "default");
        budget_.take(layout.scale.size() + layout.offset.size(), sizeof(double), "property");
        return layout;
    }

    // A value of the schema, which every column copies. Null when there is none.
    Json valueIn(const Json& property, const char* key) {
        const Json* value = member(property, key);
        if (!value) {
            return nullptr;
        }
        std::size_t size = 0;
        addSize(*value, size);
        if (size > kMostValueBytes) {
            throw BadColumn{std::string("its ") + key + " is too large"};
        }
        budget_.take(size, 1, "property");
        return *value;
    }

  private:
    static constexpr std::size_t kMostValueBytes = std::size_t(1) << 16;
    static void addSize(const Json& value, std::size_t& size) {
        constexpr std::size_t kBytesPerValue = 64;
        size += kBytesPerValue;
        if (value.is_string()) {
            size += value.get_ref<const std::string&>().size();
        } else if (value.is_structured() && size <= kMostValueBytes) {
            for (const Json& part : value) {
                addSize(part, size);
            }
        }
    }

    void setType(const Json& property, PropertyLayout& layout) {
        const std::string type = textIn(property, "type");
        if (type == "STRING") {
            layout.kind = Kind::String;
        } else if (type == "BOOLEAN") {
            layout.kind = Kind::Boolean;
        } else if (type == "ENUM") {
            layout.kind = Kind::Enum;
            setEnum(textIn(property, "enumType"), layout);
        } else {
            const char size = type.size() == 4 ? type[3] : '\0';
            const bool isVector = type.starts_with("VEC"), isMatrix = type.starts_with("MAT");
            if (type != "SCALAR" && !((isVector || isMatrix) && size >= '2' && size <= '4')) {
                throw BadColumn{"its type " + shownName(type) + " is not known"};
            }
            const unsigned n = type == "SCALAR" ? 1u : unsigned(size - '0');
            layout.components = isMatrix ? n * n : n;
            const std::string component = textIn(property, "componentType");
            layout.number = numberType(component);
            if (!layout.number) {
                throw BadColumn{"its componentType " + shownName(component) + " is not known"};
            }
        }
    }

    void setEnum(const std::string& name, PropertyLayout& layout) {
        const Json* enums = member(schema_, "enums");
        const Json* found = enums ? member(*enums, name.c_str()) : nullptr;
        if (!found) {
            throw BadColumn{"its enumType " + shownName(name) + " is not in the schema"};
        }
        layout.number = numberType(textIn(*found, "valueType", "UINT16"));
        if (!layout.number || layout.number->integerMax == 0.0) {
            throw BadColumn{"its enumType " + shownName(name) + " has no type of integers"};
        }
        auto& names = enums_[name];
        if (!names) {
            auto made = std::make_shared<EnumNames>();
            const Json* values = member(*found, "values");
            for (std::size_t i = 0; values && values->is_array() && i < values->size(); ++i) {
                const Json* number = member((*values)[i], "value");
                if (number && number->is_number_integer()) {
                    const std::string text = textIn((*values)[i], "name");
                    budget_.take(1, sizeof(EnumNames::value_type) + 64 + text.size(), "enum");
                    made->emplace(*number, text);
                }
            }
            names = std::move(made);
        }
        layout.names = names;
    }

    static void setNumbers(const char* key, const Json& property, const Json& own,
                           const PropertyLayout& layout, std::vector<double>& out) {
        const Json* value = member(own, key);
        value = value ? value : member(property, key);
        if (!value || layout.kind != Kind::Number) {
            return;
        }
        flatten(*value, out);
        const std::uint64_t whole =
            product(layout.components, std::max<std::uint64_t>(layout.arrayLength.value_or(1), 1));
        if (out.size() != layout.components && out.size() != whole) {
            throw BadColumn{std::string("its ") + key + " has another shape than its values"};
        }
    }

    const Json& schema_;
    ByteBudget& budget_;
    std::map<std::string, std::shared_ptr<const EnumNames>> enums_;
};

// The bytes of one column, all inside their buffer views.
class BytesReader {
  public:
    BytesReader(const PropertyTableReader& reader, ByteBudget& budget)
        : reader_(reader), budget_(budget) {}

    PropertyBytes read(const PropertyLayout& layout, const Json& own, std::uint64_t rows) {
        PropertyBytes out;
        std::uint64_t elements = rows;
        if (layout.isArray && layout.arrayLength) {
            elements = product(rows, *layout.arrayLength);
        } else if (layout.isArray) {
            elements = readOffsets(own, "array", rows, out.arrays);
        }
        std::uint64_t bytes = 0;
        if (layout.kind == Kind::String) {
            bytes = readOffsets(own, "string", elements, out.strings);
        } else if (layout.kind == Kind::Boolean) {
            bytes = elements / 8 + (elements % 8 != 0 ? 1 : 0);
        } else {
            bytes = product(product(elements, layout.components), layout.number->bytes);
        }
        out.values = copy(own, "values", bytes);
        return out;
    }

  private:
    Bytes copy(const Json& own, const std::string& key, std::uint64_t bytes) {
        const auto index = countIn(own, key.c_str());
        if (!index) {
            throw BadColumn{"it has no " + key};
        }
        const Result<std::span<const std::byte>> view = reader_.view(*index);
        if (!view) {
            throw BadColumn{view.error().reason};
        }
        if (bytes > view->size()) {
            throw BadColumn{"its " + key + " take " + std::to_string(bytes) + " bytes of the " +
                            std::to_string(view->size()) + " there are"};
        }
        budget_.take(bytes, 1, "property table");
        return Bytes(view->begin(), view->begin() + std::ptrdiff_t(bytes));
    }

    // Returns the last, which is how much all parts are together.
    std::uint64_t readOffsets(const Json& own, const std::string& what, std::uint64_t parts,
                              PartOffsets& out) {
        const std::string type = textIn(own, (what + "OffsetType").c_str(), "UINT32");
        const NumberType* number = numberType(type);
        if (!number || number->isSigned) {
            throw BadColumn{"its " + what + "OffsetType is " + shownName(type)};
        }
        if (parts == std::numeric_limits<std::uint64_t>::max()) {
            throw BadColumn{"it has more values than can be counted"};
        }
        out.width = number->bytes;
        out.bytes = copy(own, what + "Offsets", product(parts + 1, out.width));
        std::uint64_t last = 0;
        for (std::uint64_t i = 0; i <= parts; ++i) {
            const std::uint64_t offset = out[i];
            if (offset < last) {
                throw BadColumn{"its " + what + "Offsets go backwards"};
            }
            last = offset;
        }
        return last;
    }

    const PropertyTableReader& reader_;
    ByteBudget& budget_;
};

class TablesReader {
  public:
    TablesReader(const PropertyTableReader& reader, Warnings& warnings, ByteBudget& budget)
        : reader_(reader), warnings_(warnings), budget_(budget) {}

    std::vector<std::shared_ptr<const FeatureTable>> read(std::string_view text) {
        std::vector<std::shared_ptr<const FeatureTable>> out;
        const Json extension = Json::parse(text, nullptr, false);
        noteOthers(extension);
        const Json* tables = member(extension, "propertyTables");
        if (!tables || !tables->is_array() || tables->empty() || !readSchema(text, extension)) {
            return out;
        }
        LayoutReader layouts(schema_, budget_);
        for (const Json& table : *tables) {
            out.push_back(readTable(table, layouts));
        }
        if (unnamed_ > 0) {
            warnings_.add(std::to_string(unnamed_) + " more flaws in the property tables");
        }
        return out;
    }

  private:
    static constexpr std::size_t kBytesPerColumn = sizeof(PropertyLayout) + sizeof(PropertyBytes);

    void flaw(const std::string& what) {
        constexpr int kMostNamed = 8;
        if (flaws_++ < kMostNamed) {
            warnings_.add(what);
        } else {
            ++unnamed_;
        }
    }

    void noteOthers(const Json& extension) {
        for (const char* key : {"propertyTextures", "propertyAttributes"}) {
            if (member(extension, key)) {
                flaw(std::string("EXT_structural_metadata's ") + key + " are not read");
            }
        }
    }

    bool readSchema(std::string_view text, const Json& extension) {
        std::string_view schemaText = jsonMember(text, "schema");
        if (const Json* schema = member(extension, "schema")) {
            schema_ = *schema;
        } else if (const std::string uri = textIn(extension, "schemaUri");
                   !uri.empty() && reader_.file) {
            const Result<Bytes> file = reader_.file(uri);
            if (!file) {
                flaw("property tables left out: the schema " + shownName(uri) + ": " +
                     shownName(file.error().reason));
                return false;
            }
            checkJsonDepth(*file);
            budget_.take(file->size(), 1 + 20, "schema"); // 40 bytes a value of two characters
            schemaFile_ = asText(*file);
            schemaText = schemaFile_;
            schema_ = Json::parse(schemaFile_, nullptr, false);
        }
        if (!schema_.is_object()) {
            flaw("property tables left out: they have no schema");
            return false;
        }
        for (const JsonMember& one : jsonMembers(jsonMember(schemaText, "classes"))) {
            classTexts_[unescaped(one.key)] = one.value;
        }
        return true;
    }

    static std::string unescaped(std::string_view key) {
        const Json text = Json::parse('"' + std::string(key) + '"', nullptr, false);
        return text.is_string() ? text.get<std::string>() : std::string(key);
    }

    // The names of a class's properties in the file's order, which a parsed object forgets.
    const std::vector<std::string>& propertiesOf(const std::string& className) {
        const auto [it, isNew] = properties_.try_emplace(className);
        const auto text = classTexts_.find(className);
        if (isNew && text != classTexts_.end()) {
            std::set<std::string> seen;
            for (const JsonMember& one : jsonMembers(jsonMember(text->second, "properties"))) {
                std::string name = unescaped(one.key);
                if (seen.insert(name).second) {
                    it->second.push_back(std::move(name));
                }
            }
        }
        return it->second;
    }

    std::shared_ptr<const FeatureTable> readTable(const Json& table, LayoutReader& layouts) {
        const std::string name = textIn(table, "class");
        const auto count = countIn(table, "count");
        const Json* classes = member(schema_, "classes");
        const Json* found = classes ? member(*classes, name.c_str()) : nullptr;
        if (!count || !found) {
            flaw("property table left out: " +
                 (count ? "its class " + shownName(name) + " is not in the schema"
                        : std::string("it has no count")));
            return nullptr;
        }
        Columns columns;
        const Json* properties = member(*found, "properties");
        const Json* own = member(table, "properties");
        const std::vector<std::string>& names = propertiesOf(name);
        budget_.take(names.size() + 1, kBytesPerColumn, "property tables");
        for (const std::string& id : names) {
            const Json* property = properties ? member(*properties, id.c_str()) : nullptr;
            if (property) {
                const Json* values = own ? member(*own, id.c_str()) : nullptr;
                addColumn(id, *property, values, *count, layouts, columns);
            }
        }
        if (own && own->is_object()) {
            for (const auto& [id, values] : own->items()) {
                if (!properties || !member(*properties, id.c_str())) {
                    flaw("property " + shownName(id) + " left out: its class does not have it");
                }
            }
        }
        const std::uint64_t rows = std::min<std::uint64_t>(*count, kNoFeature - 1);
        return columnTable(name, std::uint32_t(rows), std::move(columns));
    }

    void addColumn(const std::string& id, const Json& property, const Json* values,
                   std::uint64_t rows, LayoutReader& layouts, Columns& columns) {
        try {
            if (!values) {
                Json otherwise = layouts.valueIn(property, "default");
                if (!otherwise.is_null()) {
                    columns.push_back(constantColumn(id, std::move(otherwise)));
                }
                return;
            }
            PropertyLayout layout = layouts.read(property, *values);
            PropertyBytes bytes = BytesReader(reader_, budget_).read(layout, *values, rows);
            columns.push_back(propertyColumn(id, std::move(layout), std::move(bytes)));
        } catch (const BadColumn& bad) {
            flaw("property " + shownName(id) + " left out: " + bad.reason);
        } catch (const BadContent& bad) {
            flaw("property " + shownName(id) + " left out: " + bad.reason);
        }
    }

    const PropertyTableReader& reader_;
    Warnings& warnings_;
    ByteBudget& budget_;
    Json schema_;
    std::string schemaFile_;
    std::map<std::string, std::string_view> classTexts_;
    std::map<std::string, std::vector<std::string>> properties_;
    int flaws_ = 0;
    std::size_t unnamed_ = 0;
};

} // namespace

std::vector<std::shared_ptr<const FeatureTable>>
readPropertyTables(std::string_view extension, const PropertyTableReader& reader,
                   Warnings& warnings, ByteBudget& budget) {
    try {
        return TablesReader(reader, warnings, budget).read(extension);
    } catch (const BadContent& bad) {
        warnings.add("property tables left out: " + bad.reason);
        return {};
    }
}

} // namespace gnomon
