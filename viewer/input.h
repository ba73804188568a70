// What an INPUT of the command line is: known by its content, never by its name alone.
#pragma once

#include "geo/result.h"

#include <optional>
#include <string>

namespace gnomon {

enum class InputKind { Tileset, Model, SceneFile, Lamps, Terrain };

struct Input {
    std::string uri;  // as the user wrote it, without KIND=
    std::string path; // of the file itself: for a folder, what was found in it
    InputKind kind = InputKind::Tileset;
};

const char* nameOf(InputKind kind);

// Takes PATH or KIND=PATH. Fails, naming what was found, for everything that cannot be opened. A
// folder stands for its one scene file, else for its tileset.json; for that first when a tileset is
// `wanted`, as a scene file's layers say.
Result<Input> identifyInput(const std::string& argument, std::optional<InputKind> wanted = {});

// The whole file, refused above `maxBytes`.
Result<std::string> readTextFile(const std::string& path, std::size_t maxBytes);

// Folder and name of a file: {".", "a.json"} for "a.json".
struct SplitPath {
    std::string folder, name;
};
SplitPath splitPath(const std::string& path);

} // namespace gnomon
