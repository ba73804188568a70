// A scene file names layers and says what their own files lack; see docs for the format. Paths are
// relative to the scene file.
#pragma once

#include "viewer/input.h"
#include "viewer/scene.h"

namespace gnomon {

struct LayerDescription : LayerFacts {
    std::string uri;                // as written, for messages
    std::string path;               // to open
    std::vector<std::string> steps; // further files, one a step of time
    InputKind kind = InputKind::Tileset;
};

struct SceneFile {
    std::vector<LayerDescription> layers;
    std::optional<UtcTime> time;
    std::optional<std::string> timeZone; // as in ZonedTime
    std::optional<SceneCamera> camera;
    std::optional<GroundChoice> ground;
    std::vector<Problem> problems; // what was ignored
};

// What does not lie beside the scene file is looked for in `dataFolder`.
Result<SceneFile> readSceneFile(const std::string& path,
                                const std::optional<std::string>& dataFolder = {});
// `folder` is where relative paths start; `name` is for messages.
Result<SceneFile> parseSceneFile(const std::string& text, const std::string& folder,
                                 const std::string& name,
                                 const std::optional<std::string>& dataFolder = {});

} // namespace gnomon
