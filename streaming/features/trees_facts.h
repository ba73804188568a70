// From the points of a file to trees: how high, how wide, of which form; what is missing is taken
// from what is there, and said.
#pragma once

#include "streaming/features/trees.h"
#include "streaming/features/trees_shape.h"

namespace gnomon {

struct TreeFacts {
    glm::dvec2 lonLat{0.0};
    double footMetres = 0.0; // above the ellipsoid
    double heightMetres = 0.0, crownRadiusMetres = 0.0;
    TreeForm form = TreeForm::Broad;
    std::uint64_t seed = 0; // of its looks, by its id and place
};

// One for each point that can stand somewhere; notes and what is left out go into `file`.
std::vector<TreeFacts> treesOf(FeatureFile& file, const TreeOptions& options,
                               const std::shared_ptr<const GroundHeights>& ground);

} // namespace gnomon
