// Points with a level, from a table or features: for point_flood.cpp.
#pragma once

#include "streaming/flood/flood.h"

#include <glm/vec2.hpp>

#include <optional>
#include <string>
#include <vector>

namespace gnomon {

struct LevelPoint {
    glm::dvec2 position; // in the file's coordinates
    double value = 0.0;
    std::string name; // its own, else its number; short
};

struct LevelTable {
    std::vector<LevelPoint> points;
    std::string column; // that the values are from
    std::optional<std::string> crs;
    std::vector<std::string> notes;
};

bool looksLikeLevelTable(const std::string& path);
Result<LevelTable> readLevelTable(const std::string& path, const FloodOptions& options);

} // namespace gnomon
