// What a raster or a file of features is probably for, from what it holds and how it is named: to
// be said to the user, who may say otherwise.
#pragma once

#include "geo/result.h"

#include <string>

namespace gnomon {

enum class RasterUse { Terrain, Imagery, Depth, Stage };
struct RasterGuess {
    RasterUse use = RasterUse::Terrain;
    std::string because; // in words: "its name says dem"
};
// Fails, in one line, for what GDAL cannot read as a raster.
Result<RasterGuess> guessRasterUse(const std::string& path);

enum class FeatureUse { Buildings, Trees, Barriers, Lamps };
struct FeatureGuess {
    FeatureUse use = FeatureUse::Buildings;
    std::string because;
};
// Fails, in one line, for what cannot be read or tells nothing.
Result<FeatureGuess> guessFeatureUse(const std::string& path);

} // namespace gnomon
