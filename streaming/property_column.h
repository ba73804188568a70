// One column of a property table: what the schema says of it, and its bytes. Private to
// property_table.cpp, which checks all of it before.
#pragma once

#include "streaming/feature_columns.h"
#include "streaming/source.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

// "INT8" … "FLOAT64".
struct NumberType {
    const char* name;
    std::size_t bytes;
    double integerMax; // 0 for floats
    bool isSigned;
    nlohmann::json (*read)(const std::byte*);
};
const NumberType* numberType(const std::string& name); // null for another name

using EnumNames = std::map<nlohmann::json, std::string>;

struct PropertyLayout {
    enum class Kind { Number, String, Boolean, Enum } kind = Kind::Number;
    const NumberType* number = nullptr; // of Number and Enum
    unsigned components = 1;            // of a vector or matrix, column by column
    bool isArray = false;
    std::optional<std::uint64_t> arrayLength; // of every row; else rows differ
    bool normalized = false;
    std::vector<double> scale, offset; // empty, or one a component, or one each in an array
    nlohmann::json noData, otherwise;  // raw; and what stands for it. Null: there is none
    std::shared_ptr<const EnumNames> names;
};

// Where the parts of something of variable length begin, and the last ends.
struct PartOffsets {
    Bytes bytes;
    std::size_t width = 0; // of each: 1, 2, 4 or 8
    std::uint64_t operator[](std::uint64_t i) const;
};

struct PropertyBytes {
    Bytes values;
    PartOffsets arrays, strings; // where the layout asks for them
};

std::unique_ptr<const Column> propertyColumn(std::string name, PropertyLayout layout,
                                             PropertyBytes bytes);
// A property the table leaves out, with the schema's value for that.
std::unique_ptr<const Column> constantColumn(std::string name, nlohmann::json value);

} // namespace gnomon
