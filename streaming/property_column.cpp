#include "streaming/property_column.h"

#include "streaming/column_number.h"
#include "streaming/gltf_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

using Json = nlohmann::json;

// A row of a list longer than this is nothing to look at; its length is told instead.
constexpr std::uint64_t kMostShown = 4096;

template <class T>
constexpr NumberType integer(const char* name) {
    return {name, sizeof(T), double(std::numeric_limits<T>::max()), std::is_signed_v<T>,
            numberAt<T>};
}

constexpr std::array<NumberType, 10> kNumberTypes{{integer<std::int8_t>("INT8"),
                                                   integer<std::uint8_t>("UINT8"),
                                                   integer<std::int16_t>("INT16"),
                                                   integer<std::uint16_t>("UINT16"),
                                                   integer<std::int32_t>("INT32"),
                                                   integer<std::uint32_t>("UINT32"),
                                                   integer<std::int64_t>("INT64"),
                                                   integer<std::uint64_t>("UINT64"),
                                                   {"FLOAT32", 4, 0.0, true, numberAt<float>},
                                                   {"FLOAT64", 8, 0.0, true, numberAt<double>}}};

// As numberAt() reads them: a file may write a float with more digits, or as the double it is.
void roundToFloats(Json& value) {
    if (value.is_array()) {
        for (Json& part : value) {
            roundToFloats(part);
        }
    } else if (value.is_number()) {
        const double v = value.get<double>();
        if (std::abs(v) <= double(std::numeric_limits<float>::max())) {
            value = asWritten(float(v));
        }
    }
}

class PropertyColumn : public Column {
  public:
    PropertyColumn(std::string name, PropertyLayout layout, PropertyBytes bytes)
        : Column(std::move(name)), layout_(std::move(layout)), bytes_(std::move(bytes)) {
        if (layout_.number && layout_.number->read == &numberAt<float>) {
            roundToFloats(layout_.noData);
        }
    }

    Json at(std::uint64_t row) const override {
        const Json raw = rawAt(row);
        if (!layout_.noData.is_null() && raw == layout_.noData) {
            return layout_.otherwise;
        }
        if (layout_.kind != PropertyLayout::Kind::Number || !isScaled()) {
            return raw;
        }
        Json value = raw;
        std::size_t component = 0;
        scale(value, component);
        return value;
    }
    std::size_t bytes() const override {
        return sizeof(PropertyColumn) + bytes_.values.capacity() + bytes_.arrays.bytes.capacity() +
               bytes_.strings.bytes.capacity();
    }

  private:
    bool isScaled() const {
        return layout_.normalized || !layout_.scale.empty() || !layout_.offset.empty();
    }

    Json rawAt(std::uint64_t row) const {
        if (!layout_.isArray) {
            return element(row);
        }
        const std::uint64_t length = layout_.arrayLength.value_or(0);
        const std::uint64_t first = layout_.arrayLength ? row * length : bytes_.arrays[row];
        const std::uint64_t end = layout_.arrayLength ? first + length : bytes_.arrays[row + 1];
        if (end - first > kMostShown) {
            return "(" + std::to_string(end - first) + " values)";
        }
        Json array = Json::array();
        for (std::uint64_t i = first; i < end; ++i) {
            array.push_back(element(i));
        }
        return array;
    }

    Json element(std::uint64_t i) const {
        switch (layout_.kind) {
        case PropertyLayout::Kind::Boolean:
            return ((unsigned(bytes_.values[i / 8]) >> (i % 8)) & 1u) != 0;
        case PropertyLayout::Kind::String: {
            const std::uint64_t from = bytes_.strings[i], to = bytes_.strings[i + 1];
            return std::string(reinterpret_cast<const char*>(bytes_.values.data()) + from,
                               std::size_t(to - from));
        }
        case PropertyLayout::Kind::Enum: {
            Json value = number(i);
            const auto name = layout_.names->find(value);
            return name != layout_.names->end() ? Json(name->second) : value;
        }
        case PropertyLayout::Kind::Number:
            break;
        }
        if (layout_.components == 1) {
            return number(i);
        }
        Json vector = Json::array();
        for (unsigned c = 0; c < layout_.components; ++c) {
            vector.push_back(number(i * layout_.components + c));
        }
        return vector;
    }

    Json number(std::uint64_t i) const {
        return layout_.number->read(bytes_.values.data() + i * layout_.number->bytes);
    }

    // Number by number in the order of the file; `component` counts them.
    void scale(Json& value, std::size_t& component) const {
        if (value.is_array()) {
            for (Json& part : value) {
                scale(part, component);
            }
        } else if (value.is_number()) {
            double v = value.get<double>();
            if (layout_.normalized && layout_.number->integerMax > 0.0) {
                v = normalizeInteger(v, layout_.number->integerMax, layout_.number->isSigned);
            }
            const auto of = [&](const std::vector<double>& list, double without) {
                return list.empty() ? without : list[component % list.size()];
            };
            value = v * of(layout_.scale, 1.0) + of(layout_.offset, 0.0);
            ++component;
        }
    }

    PropertyLayout layout_;
    PropertyBytes bytes_;
};

class ConstantColumn : public Column {
  public:
    ConstantColumn(std::string name, Json value)
        : Column(std::move(name)), value_(std::move(value)) {}
    Json at(std::uint64_t) const override { return value_; }
    std::size_t bytes() const override { return sizeof(ConstantColumn); }

  private:
    Json value_;
};

} // namespace

const NumberType* numberType(const std::string& name) {
    const auto it = std::find_if(kNumberTypes.begin(), kNumberTypes.end(),
                                 [&](const NumberType& type) { return name == type.name; });
    return it != kNumberTypes.end() ? &*it : nullptr;
}

std::uint64_t PartOffsets::operator[](std::uint64_t i) const {
    std::uint64_t value = 0;
    for (std::size_t k = width; k-- > 0;) {
        value = value << 8 | std::to_integer<std::uint64_t>(bytes[std::size_t(i) * width + k]);
    }
    return value;
}

std::unique_ptr<const Column> propertyColumn(std::string name, PropertyLayout layout,
                                             PropertyBytes bytes) {
    return std::make_unique<PropertyColumn>(std::move(name), std::move(layout), std::move(bytes));
}

std::unique_ptr<const Column> constantColumn(std::string name, Json value) {
    return std::make_unique<ConstantColumn>(std::move(name), std::move(value));
}

} // namespace gnomon
