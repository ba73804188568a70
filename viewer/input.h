// What an INPUT of the command line is: known by its content, never by its name alone.
#pragma once

#include "geo/result.h"
#include "streaming/flood/flood.h"
#include "streaming/http/http.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

enum class InputKind {
    Tileset,
    Model,
    SceneFile,
    Terrain,
    Imagery,
    Water,
    Buildings,
    Trees,
    Barriers,
    Lamps
};

struct Input {
    std::string uri;  // as the user wrote it, without KIND=
    std::string path; // of the file itself: for a folder, what was found in it
    InputKind kind = InputKind::Tileset;
    std::vector<std::string> steps = {};     // of water: further files, one a step of time
    std::optional<WaterKind> waterKind = {}; // as the user says, or as it was guessed
    std::string guess =
        {}; // what was taken for granted about its use, to be said; empty: nothing was
    // Of the web: `path` is a path in it, and `uri` has no keys in it. Null for files.
    std::shared_ptr<const WebSource> source = {};
};

const char* nameOf(InputKind kind);

// Takes PATH or KIND=PATH, of water also a pattern (depth=h_*.tif) for one file a step. Fails,
// naming what was found, for everything that cannot be opened. A folder stands for its one scene
// file, else for its tileset.json; for that first when a tileset is `wanted`, as a scene file's
// layers say. Of the web only tilesets, models and quantized meshes can be opened.
using OpenWeb = std::function<Result<std::shared_ptr<const WebSource>>(const std::string& url)>;
Result<Input> identifyInput(const std::string& argument, std::optional<InputKind> wanted = {},
                            const OpenWeb& openWeb = {});

// An INPUT as it may be shown: without keys.
std::string shownInput(const std::string& argument);

// The whole file, refused above `maxBytes`.
Result<std::string> readTextFile(const std::string& path, std::size_t maxBytes);

// Folder and name of a file: {".", "a.json"} for "a.json".
struct SplitPath {
    std::string folder, name;
};
SplitPath splitPath(const std::string& path);

} // namespace gnomon
