// Opens a tileset or a model and finds where it stands; and what every layer, however it is opened,
// tells the scene.
#pragma once

#include "viewer/input.h"
#include "viewer/scene.h"

namespace gnomon {

struct HeightRange {
    double base = 0.0, top = 0.0;
};

struct OpenedLayer {
    Layer layer;
    Sphere bounds;
    std::optional<Geodetic> origin;     // of its own frame, when that stands upright on the Earth
    std::optional<HeightRange> heights; // above the ellipsoid
};

// What is passed along while a scene is opened.
struct Opening {
    const LoaderOptions& loader;
    bool unplaced; // SceneOptions::unplaced
    bool several;  // inputs: what is said of them need not apply to each
    std::vector<Problem>& problems;
    std::vector<std::string>& credits;
    const SceneProgress& progress;
    // Passing faults are waited out until then, and an error beyond; none: see SceneOptions.
    std::optional<std::chrono::steady_clock::time_point> deadline = {};

    void note(const std::string& uri, const std::string& reason) {
        problems.push_back({Problem::Severity::Note, uri, reason});
    }
    void warn(const std::string& uri, const std::string& reason) {
        problems.push_back({Problem::Severity::Warning, uri, reason});
    }
    void leftOut(const Error& error) {
        problems.push_back({Problem::Severity::Error, error.subject, error.reason});
    }
};

// `path` is one in `source`.
Result<OpenedLayer> openTileset(const Input& input, const std::shared_ptr<const Source>& source,
                                const std::string& path, const LayerFacts& facts, Opening& opening);

// Of the contents looked at first; none when there are none.
Result<std::optional<HeightRange>> heightsOf(StreamedTileset& tileset, Point<Ecef> centre,
                                             const Opening& opening);

} // namespace gnomon
