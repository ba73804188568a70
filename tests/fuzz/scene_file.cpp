// A scene file: read only, nothing it names is opened.
// words: viewer/scene_file.cpp viewer/layer_facts.cpp
#include "tests/fuzz/fuzz.h"

#include "viewer/scene_file.h"

namespace gnomon::fuzz {

namespace {

void checkLayer(const LayerDescription& layer) {
    demand(!layer.uri.empty() && !layer.path.empty(), "a layer has a file");
    demand(!layer.raiseMetres || std::isfinite(*layer.raiseMetres), "a lift is a number");
    demand(!layer.heightMetres || std::isfinite(*layer.heightMetres), "a height is a number");
    for (const std::string& step : layer.steps)
        demand(!step.empty(), "a step has a file");
}

} // namespace

void fuzzOne(Span bytes) {
    const auto scene = parseSceneFile(std::string(textOf(bytes)), "/nowhere", "town.scene.json");
    if (!scene) {
        demandReadable(scene.error());
        return;
    }
    for (const LayerDescription& layer : scene->layers)
        checkLayer(layer);
    demand(!scene->time || std::isfinite(scene->time->seconds), "a moment is a number");
    if (scene->camera) {
        const Geodetic& at = scene->camera->position;
        demand(std::isfinite(at.longitudeDegrees) && std::abs(at.latitudeDegrees) <= 90.0 &&
                   std::isfinite(at.heightMetres),
               "a camera is somewhere");
    }
    demand(!scene->ground || !scene->ground->heightMetres ||
               std::isfinite(*scene->ground->heightMetres),
           "a ground's height is a number");
    for (const Problem& problem : scene->problems)
        demandReadable(problem.reason);
}

} // namespace gnomon::fuzz
