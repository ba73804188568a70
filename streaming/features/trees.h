// Trees from points with a height and a crown: a plain crown on a trunk, simpler with distance.
//
// They stand on the ground; where it has no height, on their points' own. Tiles hold at most
// kMostTreesNear trees in full detail, four times as many of each simpler one, by count and not by
// area, so that no tile is large however dense the wood.
#pragma once

#include "streaming/content_maker.h"
#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

namespace gnomon {

inline constexpr std::size_t kMostTreesNear = 400;

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
    // Of features that are read already; `name` stands for their file in messages.
    static Result<Trees> of(FeatureFile file, const std::string& name, const TreeOptions& options,
                            const std::shared_ptr<const GroundHeights>& ground);
};

} // namespace gnomon
