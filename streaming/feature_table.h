// What a tile says of the things in it: one row a feature (a building, a tree), one column a
// property. From b3dm and i3dm batch tables and from glTF's EXT_structural_metadata, one table;
// Mesh::features names the row of each vertex. Values stay as bytes until somebody asks for a row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace gnomon {

// As JSON would hold it; arrays, matrices and objects as their JSON text in Json.
struct JsonText {
    std::string text;
};
using PropertyValue =
    std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, JsonText>;

struct Property {
    std::string name;
    PropertyValue value; // monostate: the file says there is none (noData, null)
};

class FeatureTable {
  public:
    virtual ~FeatureTable() = default;
    virtual std::uint32_t rows() const = 0;
    // In the file's order. Empty for a row that is not there.
    virtual std::vector<Property> row(std::uint32_t feature) const = 0;
    virtual std::size_t bytes() const = 0;
};

} // namespace gnomon
