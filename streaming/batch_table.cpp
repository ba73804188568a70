#include "streaming/batch_table.h"

#include "streaming/column_number.h"
#include "streaming/feature_columns.h"
#include "streaming/gltf_document.h"
#include "streaming/json_slices.h"
#include "streaming/json_text.h"
#include "streaming/soup.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

namespace gnomon {

namespace {

using Json = nlohmann::json;
using Text = std::shared_ptr<const std::string>;
using Binary = std::shared_ptr<const Bytes>; // one for all columns, however many name the same

// An array in the JSON part; where each value begins is all that is kept besides the text.
class JsonColumn : public Column {
  public:
    JsonColumn(std::string name, Text text, std::vector<std::uint32_t> starts)
        : Column(std::move(name)), text_(std::move(text)), starts_(std::move(starts)) {}

    Json at(std::uint64_t row) const override {
        if (row >= starts_.size()) {
            return nullptr;
        }
        const std::string_view value = jsonValueAt(*text_, starts_[std::size_t(row)]);
        Json parsed = Json::parse(value, nullptr, false);
        return parsed.is_discarded() ? Json(nullptr) : parsed;
    }
    std::size_t bytes() const override {
        return sizeof(JsonColumn) + starts_.capacity() * sizeof(std::uint32_t);
    }

  private:
    Text text_;
    std::vector<std::uint32_t> starts_;
};

// With what all columns share, counted once.
class BatchTable : public FeatureTable {
  public:
    BatchTable(std::shared_ptr<const FeatureTable> table, std::size_t sharedBytes)
        : table_(std::move(table)), sharedBytes_(sharedBytes) {}
    std::uint32_t rows() const override { return table_->rows(); }
    std::vector<Property> row(std::uint32_t feature) const override { return table_->row(feature); }
    std::vector<FeatureClass> classes() const override { return table_->classes(); }
    std::size_t bytes() const override { return table_->bytes() + sharedBytes_; }

  private:
    std::shared_ptr<const FeatureTable> table_;
    std::size_t sharedBytes_;
};

struct Component {
    const char* name;
    std::size_t bytes;
    Json (*read)(const std::byte*);
};

constexpr std::array<Component, 8> kComponents{{{"BYTE", 1, numberAt<std::int8_t>},
                                                {"UNSIGNED_BYTE", 1, numberAt<std::uint8_t>},
                                                {"SHORT", 2, numberAt<std::int16_t>},
                                                {"UNSIGNED_SHORT", 2, numberAt<std::uint16_t>},
                                                {"INT", 4, numberAt<std::int32_t>},
                                                {"UNSIGNED_INT", 4, numberAt<std::uint32_t>},
                                                {"FLOAT", 4, numberAt<float>},
                                                {"DOUBLE", 8, numberAt<double>}}};

class BinaryColumn : public Column {
  public:
    BinaryColumn(std::string name, const Component& component, std::size_t components,
                 Binary binary, std::size_t offset)
        : Column(std::move(name)), component_(component), components_(components),
          binary_(std::move(binary)), offset_(offset) {}

    Json at(std::uint64_t row) const override {
        const std::byte* from =
            binary_->data() + offset_ + std::size_t(row) * components_ * component_.bytes;
        if (components_ == 1) {
            return component_.read(from);
        }
        Json vector = Json::array();
        for (std::size_t i = 0; i < components_; ++i) {
            vector.push_back(component_.read(from + i * component_.bytes));
        }
        return vector;
    }
    std::size_t bytes() const override { return sizeof(BinaryColumn); }

  private:
    const Component& component_;
    std::size_t components_;
    Binary binary_;
    std::size_t offset_;
};

// Whether a second byte makes a character with `lead`, and not one written too long, half of a
// UTF-16 pair, or beyond Unicode.
bool mayFollow(unsigned char lead, unsigned char second) {
    const unsigned least = lead == 0xe0 ? 0xa0u : lead == 0xf0 ? 0x90u : 0x80u;
    const unsigned most = lead == 0xed ? 0x9fu : lead == 0xf4 ? 0x8fu : 0xbfu;
    return second >= least && second <= most;
}

// Bytes that are no UTF-8, as older exporters leave them, are taken for Latin-1.
std::string asUtf8(std::string_view text) {
    std::string out;
    out.reserve(text.size() + text.size() / 8);
    for (std::size_t i = 0; i < text.size();) {
        const auto lead = static_cast<unsigned char>(text[i]);
        const std::size_t more = lead < 0x80   ? 0
                                 : lead < 0xc2 ? 9
                                 : lead < 0xe0 ? 1
                                 : lead < 0xf0 ? 2
                                 : lead < 0xf5 ? 3
                                               : 9;
        bool whole = more < 9 && i + more < text.size();
        for (std::size_t k = 1; whole && k <= more; ++k) {
            const auto next = static_cast<unsigned char>(text[i + k]);
            whole = k == 1 ? mayFollow(lead, next) : (next & 0xc0u) == 0x80u;
        }
        if (whole) {
            out.append(text, i, more + 1);
            i += more + 1;
        } else {
            out.push_back(char(0xc0u | lead >> 6));
            out.push_back(char(0x80u | (lead & 0x3fu)));
            ++i;
        }
    }
    return out;
}

// The table's JSON, well formed; nullopt when it cannot be made so. Throws BadContent for memory.
std::optional<std::string> wellFormed(std::string_view text, ByteBudget& budget) {
    while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) {
        text.remove_suffix(1); // padding
    }
    if (text.empty()) {
        return std::string("{}");
    }
    if (Json::accept(text)) {
        budget.take(text.size(), 1, "batch table");
        return std::string(text);
    }
    // In UTF-8 every byte may become two, and strings take twice their size while they grow.
    budget.take(text.size(), 6, "batch table");
    std::string mended = withoutNonFinite(asUtf8(text));
    return Json::accept(mended) ? std::optional(std::move(mended)) : std::nullopt;
}

class BatchTableReader {
  public:
    BatchTableReader(Text text, Binary binary, std::uint32_t rows, BatchRows rowsAre,
                     std::vector<std::string>& warnings, ByteBudget& budget)
        : text_(std::move(text)), binary_(std::move(binary)), rows_(rows), rowsAre_(rowsAre),
          warnings_(warnings), budget_(budget) {}

    Columns read() {
        eachJsonMember(*text_, [&](const JsonMember& member) { readMember(member); });
        if (unnamed_ > 0) {
            warnings_.push_back(std::to_string(unnamed_) + " more flaws in the batch table");
        }
        return std::move(columns_);
    }

  private:
    static constexpr std::size_t kBytesPerColumn = 2 * sizeof(JsonColumn);

    void readMember(const JsonMember& member) {
        try {
            // A name is kept once, and copied three times on its way.
            budget_.take(member.key.size(), 4, "its name");
        } catch (const BadContent& bad) {
            return leaveOut(std::string(member.key.substr(0, 200)), bad.reason);
        }
        const Json key = Json::parse('"' + std::string(member.key) + '"', nullptr, false);
        const std::string name = key.is_string() ? key.get<std::string>() : std::string();
        if (name == "extensions") {
            noteExtensions(member.value);
        } else if (name == "HIERARCHY") {
            flaw("the batch table's hierarchy is not read");
        } else if (name != "extras") {
            readColumn(name, member.value);
        }
    }

    void flaw(const std::string& what) {
        constexpr int kMostNamed = 8;
        if (++flaws_ <= kMostNamed) {
            warnings_.push_back(what);
        } else {
            ++unnamed_;
        }
    }
    void leaveOut(const std::string& name, const std::string& why) {
        flaw("batch table column " + shownName(name) + " left out: " + why);
    }

    void noteExtensions(std::string_view value) {
        eachJsonMember(value, [&](const JsonMember& extension) {
            flaw("the batch table's " + shownName(extension.key) + " is not read");
        });
    }

    void readColumn(const std::string& name, std::string_view value) {
        constexpr std::size_t kLongestReference = std::size_t(1) << 16; // some hundred, honestly
        const char open = value.empty() ? '\0' : value.front();
        if (open != '[' && open != '{') {
            return leaveOut(name, "it is neither an array nor a reference to one");
        }
        if (open == '{' && value.size() > kLongestReference) {
            return leaveOut(name, "it is too long for a reference");
        }
        try {
            budget_.take(1, kBytesPerColumn, "it");
            if (open == '[') {
                readArray(name, value);
            } else {
                readBinary(name, Json::parse(value, nullptr, false));
            }
        } catch (const BadContent& bad) {
            leaveOut(name, bad.reason);
        }
    }

    void readArray(const std::string& name, std::string_view value) {
        // Every value but the last has a comma behind it.
        const std::size_t most = std::min<std::size_t>(rows_, value.size() / 2);
        budget_.take(most, sizeof(std::uint32_t), "it");
        std::vector<std::uint32_t> starts;
        starts.reserve(most);
        std::size_t count = 0;
        eachJsonElement(value, [&](std::string_view element) {
            if (count++ < rows_) {
                starts.push_back(std::uint32_t(element.data() - text_->data()));
            }
        });
        starts.shrink_to_fit();
        if (count < rows_ || (count > rows_ && rowsAre_ == BatchRows::Told)) {
            flaw("batch table column " + shownName(name) + " has " + std::to_string(count) +
                 " values for " + std::to_string(rows_) + " features");
        }
        columns_.push_back(std::make_unique<JsonColumn>(name, text_, std::move(starts)));
    }

    void readBinary(const std::string& name, const Json& reference) {
        const auto text = [&](const char* key) {
            const auto it = reference.find(key);
            return it != reference.end() && it->is_string() ? it->get<std::string>()
                                                            : std::string();
        };
        const auto offset = reference.find("byteOffset");
        if (offset == reference.end() || !offset->is_number_unsigned()) {
            return leaveOut(name, "it has no byteOffset");
        }
        const std::string type = text("type"), componentType = text("componentType");
        const auto component =
            std::find_if(kComponents.begin(), kComponents.end(),
                         [&](const Component& c) { return componentType == c.name; });
        if (component == kComponents.end()) {
            return leaveOut(name, "its componentType is none");
        }
        const std::size_t components = type == "SCALAR" ? 1
                                       : type == "VEC2" ? 2
                                       : type == "VEC3" ? 3
                                       : type == "VEC4" ? 4
                                                        : 0;
        if (components == 0) {
            return leaveOut(name, "its type is none");
        }
        const std::uint64_t from = offset->get<std::uint64_t>();
        const std::uint64_t size = std::uint64_t(rows_) * components * component->bytes;
        if (from > binary_->size() || size > binary_->size() - from) {
            return leaveOut(name, "it lies outside the binary part");
        }
        columns_.push_back(std::make_unique<BinaryColumn>(name, *component, components, binary_,
                                                          std::size_t(from)));
    }

    Text text_;
    Binary binary_;
    std::uint32_t rows_;
    BatchRows rowsAre_;
    std::vector<std::string>& warnings_;
    ByteBudget& budget_;
    Columns columns_;
    int flaws_ = 0;
    std::size_t unnamed_ = 0;
};

} // namespace

std::shared_ptr<const FeatureTable> readBatchTable(std::span<const std::byte> json,
                                                   std::span<const std::byte> binary,
                                                   std::uint32_t batchLength,
                                                   std::vector<std::string>& warnings,
                                                   ByteBudget& budget, BatchRows rowsAre) {
    if (batchLength == 0) {
        return nullptr;
    }
    const std::uint32_t rows = std::min(batchLength, kNoFeature - 1);
    const auto unusable = [&](const std::string& why) {
        warnings.push_back("batch table left out: " + why);
        return columnTable("", rows, {});
    };
    if (json.size() > std::numeric_limits<std::uint32_t>::max() / 2) {
        return unusable("it is larger than 2 GB");
    }
    std::optional<std::string> text;
    try {
        checkJsonDepth(json);
        text = wellFormed(asText(json), budget);
        budget.take(binary.size(), 1, "batch table");
    } catch (const BadContent& bad) {
        return unusable(bad.reason);
    }
    if (!text || jsonValueAt(*text, std::min(text->find_first_not_of(" \t\r\n"), text->size()))
                         .substr(0, 1) != "{") {
        return unusable("it is no JSON object");
    }
    std::size_t sharedBytes = text->capacity() + binary.size();
    auto sharedText = std::make_shared<const std::string>(std::move(*text));
    auto sharedBinary = std::make_shared<const Bytes>(binary.begin(), binary.end());
    Columns columns = BatchTableReader(std::move(sharedText), std::move(sharedBinary), rows,
                                       rowsAre, warnings, budget)
                          .read();
    if (columns.empty()) {
        sharedBytes = 0;
    }
    return std::make_shared<BatchTable>(columnTable("", rows, std::move(columns)), sharedBytes);
}

std::shared_ptr<const FeatureTable> readBatchTable(std::span<const std::byte> json,
                                                   std::span<const std::byte> binary,
                                                   std::uint32_t batchLength,
                                                   std::vector<std::string>& warnings) {
    ByteBudget budget(std::uint64_t(1) << 30);
    return readBatchTable(json, binary, batchLength, warnings, budget);
}

} // namespace gnomon
