// What a table of features promises.
#pragma once

#include "tests/fuzz/fuzz.h"

#include "streaming/feature_table.h"
#include "streaming/mesh.h"

#include <nlohmann/json.hpp>

namespace gnomon::fuzz {

inline void checkRow(const FeatureTable& table, std::uint32_t row) {
    const std::vector<Property> properties = table.row(row);
    (void)idOf(properties, row);
    for (const Property& property : properties) {
        const std::string json = jsonOf(property.value);
        demand(nlohmann::json::accept(json), "a value is JSON");
        if (const double* number = std::get_if<double>(&property.value))
            demand(!std::isnan(*number) || json == "null", "no number is no value");
    }
}

inline void checkTable(const FeatureTable& table) {
    constexpr std::uint32_t kMostRows = 32;
    const std::uint32_t rows = table.rows();
    for (std::uint32_t i = 0; i < std::min(rows, kMostRows); ++i)
        checkRow(table, i);
    if (rows > 0)
        checkRow(table, rows - 1);
    demand(rows == kNoFeature || table.row(rows).empty(), "a row that is not there is empty");
    demand(table.row(kNoFeature).empty(), "no feature has no properties");
    std::uint64_t classRows = 0;
    for (const FeatureClass& kind : table.classes())
        classRows += kind.rows;
    demand(classRows >= rows, "every row is of a class");
}

} // namespace gnomon::fuzz
