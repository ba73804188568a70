// What is shown: the inputs opened, put on the Earth, and the scene's anchor. No GL here.
#pragma once

#include "geo/camera.h"
#include "geo/crs.h"
#include "geo/ellipsoid.h"
#include "geo/time.h"
#include "shadows/lamp.h"
#include "streaming/features/buildings.h"
#include "streaming/flood/water_surface.h"
#include "streaming/http/http.h"
#include "streaming/loader.h"
#include "streaming/source.h"
#include "streaming/terrain/terrain.h"
#include "viewer/layer_facts.h"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

// Long work while a scene is opened: which input, and how much of it is done, 0…1.
using SceneProgress = std::function<void(const std::string& uri, double share)>;

struct SceneOptions : LayerFacts { // of all inputs that lack the fact
    std::vector<std::string> inputs;
    // Where flat ground was asked for: what things stand on where no terrain is.
    std::optional<double> groundMetres;
    // Where the files of a scene are looked for that do not lie beside it.
    std::optional<std::string> dataFolder;
    bool unplaced = false; // to look at, not to draw: what has no place stays in its own frame
    LoaderOptions loader;
    HttpOptions http; // of inputs on the web
    // A server's passing fault is waited out so long while the scene is opened, and beyond is an
    // error of the whole. None: what cannot be had after a few attempts is left out.
    std::optional<std::chrono::duration<double>> patience;
    SceneProgress progress; // may be null
};

struct Problem {
    enum class Severity {
        Note,    // a guess that was made, said once
        Warning, // all is shown, but perhaps not as meant
        Error,   // something is left out
    } severity = Severity::Warning;
    std::string uri, reason;
};

// One input as it is streamed. A single glb or b3dm is a tileset of one tile; terrain, buildings,
// trees and barriers are tiles that are made.
struct Layer {
    std::string uri;
    std::string kind; // "tileset", "model", "terrain", "buildings", "trees" or "barriers"
    std::unique_ptr<StreamedTileset> tileset;
    // It stands only from then on, and until then. Without a time in the frame it stands.
    std::optional<UtcTime> from, until;
    bool stands(std::optional<UtcTime> time) const;
    bool placedByUser = false;
    bool onEarth = true; // always, unless SceneOptions::unplaced
    // Of what is made: its own system, and what its heights were said to be above; of a raster also
    // pixels across and down.
    std::optional<std::string> crs;
    Heights heights = Heights::Ellipsoidal;
    std::optional<std::array<int, 2>> size;
    // What it was made from, to be asked: null for other kinds.
    std::shared_ptr<const Terrain> terrain;
    std::shared_ptr<const Buildings> buildings;
};

struct WaterLook {
    WaterColors colors = WaterColors::Depth;
    std::optional<double> most; // metres or m/s of the last colour; else from the data
};

// A flood result over time. Never a caster.
struct WaterLayer {
    std::string uri;
    std::string kind; // "depth" or "stage"
    Heights heights = Heights::Ellipsoidal;
    std::shared_ptr<const WaterSurface> surface;
    WaterLook look;
    // UTC of the data's 0 where its steps are not absolute: then the scene's own time, if it has
    // one.
    double startSeconds = 0.0;
    // In the data's own reckoning; the last step when no time is known.
    double secondsAt(std::optional<UtcTime> time) const;
};

struct SunAngles {
    double azimuthDegrees = 0.0, elevationDegrees = 0.0;
};

// A scene's own camera: a view to start from, when none is asked for.
struct SceneCamera {
    Geodetic position;
    Orientation orientation;
    std::optional<double> fovDegrees;
};

struct GroundChoice {
    bool automatic = true; // from the inputs' own bases
    std::optional<double>
        heightMetres; // above the ellipsoid; with `automatic` false, none: no ground
};

struct Scene {
    std::vector<Layer> layers;
    Geodetic anchor; // centre of all layers, on their base; fixed once opened
    Transform<Ecef, Enu> ecefFromAnchor;
    double radiusMetres = 0; // of the layers' bounds about the anchor, seen from above
    double heightMetres = 0; // of what stands on the anchor's level
    std::vector<Problem> problems;
    std::vector<Lamp> lamps;
    std::vector<WaterLayer> waters;
    // What things stand on: all terrains, the finest first, then the flat ground when its height
    // was given. Null when nothing is known.
    std::shared_ptr<const GroundHeights> groundHeights;
    std::vector<std::string> credits; // to be shown, each once
    struct Painted {
        std::string uri;
        std::shared_ptr<const Drape> drape;
    };
    std::vector<Painted> imagery; // on all terrain, the last on top
    // From a scene file, or of a scene made by code:
    std::optional<UtcTime> time;
    std::optional<std::string> timeZone; // its time was told by; as in ZonedTime
    std::optional<SunAngles> sun;        // when no time is known
    std::optional<SceneCamera> camera;
    std::optional<GroundChoice> ground;
};

// Fails only when nothing at all could be opened; what else is wrong is in `problems`.
Result<Scene> openScene(const SceneOptions& options);
// The same for one input whose files are not on a disk: `input.path` is a path in `source`.
struct Input; // viewer/input.h
Result<Scene> openScene(const SceneOptions& options, std::shared_ptr<const Source> source,
                        const Input& input);

} // namespace gnomon
