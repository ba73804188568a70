// What readers of features promise, and what is made of them: houses.
#pragma once

#include "tests/fuzz/fuzz.h"

#include "streaming/check_content.h"
#include "streaming/features/buildings.h"
#include "streaming/features/features_read.h"

namespace gnomon::fuzz {

inline void checkRaw(const std::vector<RawFeatures>& layers) {
    for (const RawFeatures& layer : layers)
        for (const Feature& feature : layer.features) {
            demand(!feature.parts.empty(), "a feature has a shape");
            for (const FeaturePart& part : feature.parts) {
                demand(!part.empty(), "a part has a ring");
                for (const FeatureRing& ring : part)
                    demand(!ring.empty(), "a ring has vertices");
            }
        }
}

inline void checkPlaced(const FeatureFile& file) {
    for (const Feature& feature : file.features)
        for (const FeaturePart& part : feature.parts)
            for (const FeatureRing& ring : part)
                for (const glm::dvec3& p : ring)
                    demand(std::abs(p.x) <= 540.0 && std::abs(p.y) <= 90.0 && !std::isinf(p.z),
                           "a vertex lies on the Earth");
}

inline void checkBuildings(const Buildings& buildings) {
    const MadeTileset made = buildings.tiles();
    constexpr std::size_t kMostTiles = 4;
    std::size_t looked = 0;
    for (const MadeTile& tile : made.tiles) {
        demand(isSound(tile.volume), "a tile's volume is finite");
        if (tile.content != ContentKind::Mesh || ++looked > kMostTiles)
            continue;
        const auto content = made.maker->make(tile.path, {});
        if (!content) {
            demandReadable(content.error());
            continue;
        }
        demand(!brokenPromise(*content), "a made tile keeps what mesh.h promises");
        for (const Mesh& mesh : content->meshes)
            for (const std::uint32_t feature : mesh.features)
                demand(feature == kNoFeature || feature < buildings.size(),
                       "a house carries a number that there is");
    }
}

// What a reader gave, all the way. `failure` is the reader's own.
inline void checkFeatures(const Failure& failure, std::vector<RawFeatures> layers,
                          FeatureFile file) {
    if (failure) {
        demandReadable(*failure);
        return;
    }
    checkRaw(layers);
    for (RawFeatures& layer : layers) {
        // The coordinate reference system is PROJ's to read and not ours to try.
        layer.crs = layer.crsName = layer.crs == "EPSG:4326" ? "EPSG:4326" : "EPSG:32632";
        if (const Failure unplaced = placeFeatures(std::move(layer), "houses", {}, file))
            demandReadable(*unplaced);
    }
    for (const Error& error : file.leftOut)
        demandReadable(error);
    for (const std::string& note : file.notes)
        demandReadable(note);
    checkPlaced(file);
    const auto buildings = Buildings::of(std::move(file), "houses", {}, nullptr);
    if (buildings)
        checkBuildings(**buildings);
    else
        demandReadable(buildings.error());
}

} // namespace gnomon::fuzz
