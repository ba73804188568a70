// A scene file names layers and says what their own files lack; see docs for the format. Paths are
// relative to the scene file.
#pragma once

#include "viewer/input.h"
#include "viewer/scene.h"

namespace gnomon {

struct LayerDescription {
    std::string uri;               // as written, for messages
    std::string path;              // to open
    std::optional<InputKind> kind; // as the scene file says it
    std::optional<std::string> crs;
    std::optional<Heights> heights;
    std::optional<Placement> placement;
    std::optional<ModelUp> up;
    std::optional<double> raiseMetres;
};

struct SceneFile {
    std::vector<LayerDescription> layers;
    std::optional<UtcTime> time;
    std::optional<SceneCamera> camera;
    std::optional<GroundChoice> ground;
    std::vector<Problem> problems; // layers of a kind that cannot be opened
};

Result<SceneFile> readSceneFile(const std::string& path);
// `folder` is where relative paths start; `name` is for messages.
Result<SceneFile> parseSceneFile(const std::string& text, const std::string& folder,
                                 const std::string& name);

} // namespace gnomon
