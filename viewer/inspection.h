// What `gnomon info` tells: what inputs are, where they are, what is in them and what is wrong.
#pragma once

#include "streaming/inventory.h"
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
};

struct Inspection {
    std::vector<InspectedInput> inputs;
    std::vector<Problem> problems;
    std::optional<ErrorKind> firstFailure;

    std::string json() const;
    std::string text() const;
};

Inspection inspect(const SceneOptions& options);

} // namespace gnomon
