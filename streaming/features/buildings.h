// Buildings: footprints put up on the ground by a height, or surfaces in space as they are. Each
// keeps its id and attributes; footprints become closed solids with an underside.
#pragma once

#include "streaming/content_maker.h"
#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

#include <memory>

namespace gnomon {

struct BuildingOptions {
    FeatureOptions source;
    std::optional<double> heightMetres;         // of all that have none of their own
    std::optional<std::string> heightAttribute; // else the usual names are looked for
};

struct BuildingFound {
    std::string id;
    std::vector<std::pair<std::string, AttributeValue>> attributes;
    double groundMetres = 0, topMetres = 0; // above the ellipsoid
    bool heightAssumed = false;             // none in the file: the stated or the default height
};

class Buildings {
  public:
    virtual ~Buildings() = default;
    static Result<std::shared_ptr<const Buildings>>
    open(const std::string& path, const BuildingOptions& options,
         const std::shared_ptr<const GroundHeights>& ground);

    virtual MadeTileset tiles() const = 0;
    // The building whose footprint holds the place, the highest of several.
    virtual std::optional<BuildingFound> at(glm::dvec2 lonLat) const = 0;
    virtual std::size_t size() const = 0;
    virtual const FeatureFile& file() const = 0; // its features may have been dropped; facts stay
};

} // namespace gnomon
