// Trees from points with a height and a crown: a plain crown on a trunk, simpler with distance.
#pragma once

#include "streaming/content_maker.h"
#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

namespace gnomon {

struct TreeOptions {
    FeatureOptions source;
    std::optional<double> heightMetres; // of all that have none of their own
};

struct Trees {
    MadeTileset tiles;
    std::size_t count = 0;
    FeatureFile file; // without its features
    static Result<Trees> open(const std::string& path, const TreeOptions& options,
                              const std::shared_ptr<const GroundHeights>& ground);
};

} // namespace gnomon
