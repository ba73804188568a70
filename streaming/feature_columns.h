// Tables made of columns: what batch tables and property tables have in common. Private to
// streaming/; shows the JSON library.
#pragma once

#include "streaming/feature_table.h"

#include <nlohmann/json.hpp>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

class Column {
  public:
    explicit Column(std::string name) : name_(std::move(name)) {}
    virtual ~Column() = default;
    const std::string& name() const { return name_; }
    // `row` is one of the table's.
    virtual nlohmann::json at(std::uint64_t row) const = 0;
    virtual std::size_t bytes() const = 0; // all it holds

  private:
    std::string name_;
};

using Columns = std::vector<std::unique_ptr<const Column>>;
std::shared_ptr<const FeatureTable> columnTable(std::string className, std::uint32_t rows,
                                                Columns columns);

// The shortest decimal that is this float, as people wrote it: 0.1, not 0.100000001490116.
double asWritten(float value);

// For messages: one line, not endless.
std::string shownName(std::string_view name);

} // namespace gnomon
