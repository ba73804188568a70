// The command line, parsed: what each command is asked to do. Nothing is opened or drawn here.
#pragma once

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
struct SunAngles {
    double azimuthDegrees = 0.0, elevationDegrees = 0.0;
};

inline constexpr double kDefaultFovDegrees = 45.0;

// What view and capture share.
struct PictureOptions {
    SceneOptions scene;
    FrameOptions frame;
    std::variant<std::monostate, FixedCamera, CameraFile> camera; // monostate: fit the scene
    std::optional<double> fovDegrees;
    int widthPixels = 1280, heightPixels = 720;
    std::variant<std::monostate, UtcTime, SunAngles> sun; // monostate: the scene's, or a fixed one
    bool groundGiven = false;                             // else the scene file may say
    double timeoutSeconds = 60.0;                         // a frame
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

struct CaptureOptions {
    PictureOptions picture;
    std::string output;
    std::optional<FrameRange> frames;
    double framesPerSecond = 30.0;
    std::optional<double> durationSeconds;
    std::vector<Aov> aovs;
    std::optional<int> device; // a GPU by its number, -1 for the software rasteriser
};

struct InfoOptions {
    SceneOptions scene;
    bool json = false;
};

struct DemoOptions {
    std::string folder;
    std::size_t buildings = 0;
    Geodetic at;
    std::uint64_t seed = 1;
};

// --help or --version: text for stdout, and done.
struct HelpText {
    std::string text;
};

using CommandLine = std::variant<HelpText, ViewOptions, CaptureOptions, InfoOptions, DemoOptions>;

// `arguments` without the program's name.
Result<CommandLine> parseCommandLine(const std::vector<std::string>& arguments);

} // namespace gnomon
