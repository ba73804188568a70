// The command line, parsed: what each command is asked to do. Nothing is opened or drawn here.
#pragma once

#include "bench/techniques.h"
#include "viewer/frame.h"
#include "viewer/scene.h"

#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace gnomon {

struct FixedCamera {
    Geodetic position;
    Orientation orientation;
};
struct CameraFile {
    std::string path;
};

inline constexpr double kDefaultFovDegrees = 45.0;

// What view and capture share.
struct PictureOptions {
    SceneOptions scene;
    std::optional<std::string> benchScene; // a built-in scene by its name, in place of inputs
    FrameOptions frame;
    std::variant<std::monostate, FixedCamera, CameraFile> camera; // monostate: fit the scene
    std::optional<double> fovDegrees;
    int widthPixels = 1280, heightPixels = 720;
    bool sizeGiven = false;                               // else a built-in scene may say
    std::variant<std::monostate, UtcTime, SunAngles> sun; // monostate: the scene's, or a fixed one
    std::optional<SunAngles>
        fixedSun; // beside a time, which then moves only the flood and the like
    std::optional<std::string> timeZone; // of --time; as in ZonedTime
    bool groundGiven = false;            // else the scene file may say
    double timeoutSeconds = 60.0;        // a frame
    std::optional<std::string> frameReport;
    bool verbose = false;
};

struct ViewOptions {
    PictureOptions picture;
    std::optional<double> quitAfterSeconds;
    std::optional<std::string> screenshot;
};

// Frames first, first + step … up to last.
struct FrameRange {
    std::int64_t first = 0, last = 0, step = 1;
};

// Of the frames asked for the number-th, and every count-th after it; numbers begin with 1.
struct Shard {
    std::int64_t number = 1, count = 1;
};

struct CaptureOptions {
    PictureOptions picture;
    std::string output;
    std::optional<FrameRange> frames;
    double framesPerSecond = 30.0;
    std::optional<double> durationSeconds;
    std::vector<Aov> aovs;
    bool overlay = true; // time, legends, scale and credits over the picture
    std::optional<Shard> shard;
    bool resume = false;       // frames that are there already, drawn with these settings, are left
    std::optional<int> device; // a GPU by its number, -1 for the software rasteriser
};

struct InfoOptions {
    SceneOptions scene;
    bool json = false;
    std::optional<glm::dvec2> at; // longitude, latitude: also what is there
    std::optional<UtcTime> time;  // then
};

struct DemoOptions {
    std::string folder;
    std::size_t buildings = 0;
    Geodetic at;
    std::uint64_t seed = 1;
};

struct EvaluateOptions {
    PictureOptions picture;
    std::optional<std::string> sceneName; // a built-in scene, in place of inputs
    std::vector<bench::Technique> techniques;
    bool techniquesGiven = false; // else the usual ones, and lamps' where there are lamps
    int raysPerPixel = 64;
    int framesTimed = 7;
    bool json = false;
    bool list = false; // only says what there is
    std::optional<std::string> imagesFolder, plotFile;
    bool countFlips = false;
    std::optional<std::string> pathFile; // along a camera path, else along a small motion
    std::optional<int> device;           // as CaptureOptions::device
};

// --help or --version: text for stdout, and done.
struct HelpText {
    std::string text;
};

using CommandLine =
    std::variant<HelpText, ViewOptions, CaptureOptions, InfoOptions, EvaluateOptions, DemoOptions>;

// `arguments` without the program's name.
Result<CommandLine> parseCommandLine(const std::vector<std::string>& arguments);

} // namespace gnomon
