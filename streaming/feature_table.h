// What a tile says of the things in it: one row a feature (a building, a tree), one column a
// property. From b3dm, i3dm and pnts batch tables and from glTF's EXT_structural_metadata, one
// table; Mesh::features names the row of each vertex. Values stay as bytes until somebody asks for
// a row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace gnomon {

// As JSON would hold it; arrays, matrices and objects as their JSON text.
struct JsonText {
    std::string text;
    bool operator==(const JsonText&) const = default;
};
using PropertyValue =
    std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, JsonText>;

struct Property {
    std::string name;
    PropertyValue value; // monostate: the file says there is none (noData, null)
};

// The rows of one kind; a batch table has one class without a name.
struct FeatureClass {
    std::string name;
    std::uint64_t rows = 0;
    std::vector<std::string> properties; // in the file's order
};

class FeatureTable {
  public:
    virtual ~FeatureTable() = default;
    virtual std::uint32_t rows() const = 0;
    // In the file's order. Empty for a row that is not there.
    virtual std::vector<Property> row(std::uint32_t feature) const = 0;
    virtual std::vector<FeatureClass> classes() const = 0;
    virtual std::size_t bytes() const = 0;
};

// Tables one behind another, for contents that have several: the rows of `tables[i]` begin at the
// sum of the rows before. Null tables count as none; null when all are. At most 2^32 - 2 rows:
// what is beyond has none.
std::shared_ptr<const FeatureTable>
joinedTables(std::vector<std::shared_ptr<const FeatureTable>> tables);

// What people call the feature: the first property that is named as identifiers are ("id",
// "gml_id", …, in any letter case; else any that ends in "id") and has a value; without one, the
// row's number.
std::string idOf(const std::vector<Property>& row, std::uint32_t feature);

// One value as JSON text.
std::string jsonOf(const PropertyValue& value);

} // namespace gnomon
