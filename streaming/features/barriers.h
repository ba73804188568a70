// Barriers: walls, dykes and sandbags along lines, or raised areas, which may stand from a time on,
// or until one.
//
// A crest follows the ground at a height above it, or lies at a level, or where the vertices are;
// the solids are closed and reach into the ground. Without ground heights they stand on the
// ellipsoid.
#pragma once

#include "geo/time.h"
#include "streaming/content_maker.h"
#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

namespace gnomon {

struct BarrierOptions {
    FeatureOptions source;
    std::optional<double> heightMetres, widthMetres; // of all that have none of their own
    std::optional<UtcTime> from, until;              // likewise
};

// Those that stand over the same time.
struct BarrierGroup {
    MadeTileset tiles;
    std::optional<UtcTime> from, until; // none: always
    std::size_t count = 0;
};

struct Barriers {
    std::vector<BarrierGroup> groups;
    FeatureFile file; // without its features
    static Result<Barriers> open(const std::string& path, const BarrierOptions& options,
                                 const std::shared_ptr<const GroundHeights>& ground);
    // Of features that are read already; `name` stands for their file in messages.
    static Result<Barriers> of(FeatureFile file, const std::string& name,
                               const BarrierOptions& options,
                               const std::shared_ptr<const GroundHeights>& ground);
};

} // namespace gnomon
