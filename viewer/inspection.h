// What `gnomon info` tells: what inputs are, where they are, what is in them and what is wrong.
#pragma once

#include "streaming/inventory.h"
#include "viewer/feature_at.h"
#include "viewer/scene.h"

#include <string>
#include <vector>

namespace gnomon {

struct InspectedInput {
    std::string uri, kind;
    std::optional<std::string> crs; // none: in a frame of its own
    std::string heights = "ellipsoidal";
    std::optional<std::array<int, 2>> size; // of rasters, in pixels
    TilesetFacts tileset;
    Inventory inventory;
    std::vector<Error> missing;
    // What only some kinds have, by the names that the JSON gives them: cells, counts.
    std::vector<std::pair<std::string, double>> numbers;
    std::vector<std::string> steps;  // of water
    std::vector<WaterTotals> totals; // of each step
};

// What is at one place, at one moment; metres above the ellipsoid. None: there is none.
struct InspectedPlace {
    std::optional<double> ground, waterLevel, depth, speed;
    bool interpolated = false;             // the water: between observed points
    std::optional<BuildingFound> building; // of what was put up here
    std::optional<TileFeature> feature;    // else: of tiles as they are
    std::string tileset;                   // then: the input it is in
};

struct Inspection {
    std::vector<InspectedInput> inputs;
    std::vector<Problem> problems;
    std::optional<InspectedPlace> at;
    std::optional<ErrorKind> firstFailure;

    std::string json() const;
    std::string text() const;
};

struct InspectionOptions {
    std::optional<glm::dvec2> at; // longitude, latitude
    std::optional<UtcTime> time;  // then; else the last step of the water
};
Inspection inspect(const SceneOptions& options, const InspectionOptions& also = {});

} // namespace gnomon
