// Buildings: footprints put up on the ground by a height, or surfaces in space as they are. Each
// keeps its id and attributes; footprints become closed solids with an underside.
//
// A height that the file gives counts from the lowest ground under the outline (so OpenStreetMap
// and CityGML define it), one that is assumed from the mean. Outlines with heights of their own
// vertices: those are the roof's or the ground's, whichever fits the ground and the height better;
// without a ground they are the ground's.
#pragma once

#include "streaming/content_maker.h"
#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

#include <cstdint>
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
    // Of features that are read already; `name` stands for their file in messages.
    static Result<std::shared_ptr<const Buildings>>
    of(FeatureFile file, const std::string& name, const BuildingOptions& options,
       const std::shared_ptr<const GroundHeights>& ground);

    // Coarse tiles hold the largest buildings, finer ones add those that are smaller.
    virtual MadeTileset tiles() const = 0;
    // The building whose footprint holds the place, the highest of several.
    virtual std::optional<BuildingFound> at(glm::dvec2 lonLat) const = 0;
    // By the number that its vertices carry (Mesh::features), below size().
    virtual BuildingFound building(std::uint32_t feature) const = 0;
    virtual std::size_t size() const = 0;
    virtual const FeatureFile& file() const = 0; // its features may have been dropped; facts stay
};

} // namespace gnomon
