#include "viewer/options.h"

#include "viewer/option_values.h"
#include "viewer/place/place.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <functional>
#include <memory>

namespace gnomon {

namespace {

constexpr double kViewScreenSpaceError = 16.0;
constexpr double kCaptureScreenSpaceError = 8.0;
constexpr double kHighestFramesPerSecond = 1000.0;
constexpr double kLongestSeconds = 1e6;

// Options of one command. The library only splits the arguments; every value is read by us, so that
// each mistake is told in the same way. The first mistake is kept.
class Command {
  public:
    using Read = std::function<Failure(const std::string&)>;

    Command(CLI::App& app, Failure& failure) : app_(app), failure_(failure) {}

    CLI::Option* option(const std::string& names, const std::string& value, const std::string& help,
                        Read read) {
        CLI::Option* added = app_.add_option_function<std::string>(
            names,
            [this, read = std::move(read)](const std::string& text) {
                if (!failure_)
                    failure_ = read(text);
            },
            help);
        added->type_name(value)->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
        return added;
    }
    void number(const std::string& name, const std::string& value, const std::string& help,
                double min, double max, std::function<void(double)> set) {
        option(name, value, help,
               [name, min, max, set = std::move(set)](const std::string& text) -> Failure {
                   const Result<double> number = parseNumber(name, text, min, max);
                   if (!number)
                       return number.error();
                   set(*number);
                   return {};
               });
    }
    void integer(const std::string& name, const std::string& value, const std::string& help,
                 std::int64_t min, std::int64_t max, std::function<void(std::int64_t)> set) {
        option(name, value, help,
               [name, min, max, set = std::move(set)](const std::string& text) -> Failure {
                   const Result<std::int64_t> number = parseInteger(name, text, min, max);
                   if (!number)
                       return number.error();
                   set(*number);
                   return {};
               });
    }
    CLI::App& app() { return app_; }

  private:
    CLI::App& app_;
    Failure& failure_;
};

Failure named(const std::string& option, const Error& error) {
    return Error{option, error.subject.empty() ? error.reason : error.subject + " " + error.reason,
                 ErrorKind::Usage};
}

template <class T>
Failure take(Result<T> parsed, T& into) {
    if (!parsed)
        return parsed.error();
    into = std::move(*parsed);
    return {};
}

void addScene(Command& command, SceneOptions& scene, bool required) {
    CLI::Option* inputs = command.app().add_option(
        "INPUT", scene.inputs,
        "tileset.json, a folder with one, a model (glb, gltf, b3dm), a raster of heights (GeoTIFF, "
        "ASC) or a scene file; KIND=PATH (tileset=, model=, terrain=) insists on a kind");
    inputs->type_name("")->option_text("...")->expected(required ? 1 : 0, 1 << 16);
    if (required)
        inputs->required();
    command.option("--crs", "EPSG:n", "coordinate reference system of inputs that name none",
                   [&scene](const std::string& text) -> Failure {
                       if (text.empty())
                           return Error{"--crs", "is empty", ErrorKind::Usage};
                       scene.crs = text;
                       return {};
                   });
    command.option("--heights", "KIND",
                   "ellipsoidal or egm96: what their heights are above "
                   "[ellipsoidal]",
                   [&scene](const std::string& text) { return parseHeights(text, scene.heights); });
    command.option("--place", "LON,LAT,H[,HEADING]",
                   "where the origin of a model or tileset in a frame of its own stands",
                   [&scene](const std::string& text) -> Failure {
                       Result<Placement> place = parsePlace(text);
                       if (!place)
                           return place.error();
                       scene.placement = *place;
                       return {};
                   });
    command.number("--raise", "M", "lifts what is placed so", -1e6, 1e6,
                   [&scene](double metres) { scene.raiseMetres = metres; });
    command.option("--up", "AXIS", "y, z or auto: which of its axes is up [auto]",
                   [&scene](const std::string& text) { return parseUp(text, scene.up); });
    // A tile is held decoded and, about as large, on the GPU: half of the memory for each.
    const auto halfOf = [](std::int64_t mb) { return std::size_t(mb) << 19; };
    scene.loader.memoryBytes = halfOf(1024);
    command.integer("--memory", "MB", "for tiles, decoded and on the GPU, at most [1024]", 16,
                    1 << 20,
                    [&scene, halfOf](std::int64_t mb) { scene.loader.memoryBytes = halfOf(mb); });
}

void addCamera(Command& command, PictureOptions& picture) {
    command.option("--camera", "VIEW",
                   "LON,LAT,HEIGHT,HEADING,PITCH[,ROLL] in degrees and metres above the "
                   "ellipsoid, or the file of a camera path [fits the scene]",
                   [&picture](const std::string& text) { return parseCamera(text, picture); });
    command.number("--fov", "DEG", "vertical field of view [45]", 0.01, 179,
                   [&picture](double degrees) { picture.fovDegrees = degrees; });
    command.option("--size", "WxH", "of the picture in pixels [1280x720]",
                   [&picture](const std::string& text) {
                       picture.sizeGiven = true;
                       return parseSize(text, picture.widthPixels, picture.heightPixels);
                   });
    command.option("--time", "TIME",
                   "moment that sets the sun: ISO 8601, with Z, an offset or a zone's name",
                   [&picture](const std::string& text) -> Failure {
                       const Result<UtcTime> moment = parseTime(text);
                       if (!moment)
                           return named("--time", moment.error());
                       picture.sun = *moment;
                       return {};
                   });
    command.option("--sun", "AZIMUTH,ELEVATION", "degrees, azimuth clockwise from north",
                   [&picture](const std::string& text) -> Failure {
                       if (std::holds_alternative<UtcTime>(picture.sun))
                           return Error{"--sun", "--time sets the sun already", ErrorKind::Usage};
                       return parseSun(text, picture);
                   });
}

// " [0.85]"
std::string byDefault(double value) {
    char text[32];
    std::snprintf(text, sizeof text, " [%g]", value);
    return text;
}

void addShadows(Command& command, PictureOptions& picture) {
    ShadowSettings& shadows = picture.frame.shadows;
    // --shadows may name a whole technique; what is said besides wins, whatever the order. So the
    // library is told to call it first: options are handled in the order they are added.
    command.option("--shadows", "TECHNIQUE",
                   "off, csm, single, plane-optimal, perspective; or a whole technique, "
                   "shadows+bias+filter: csm+receiver-plane+pcss:16,32 (gnomon evaluate --list "
                   "tells of each); for lamps paraboloid or cube [csm]",
                   [&shadows](const std::string& text) { return parseShadows(text, shadows); });
    command.option("--bias", "BIAS",
                   "constant[:M], slope, normal, receiver-plane, frontface, midpoint, "
                   "dual-peel[:M] or dual-atomic[:M] [receiver-plane]",
                   [&shadows](const std::string& text) -> Failure {
                       const Failure wrong = parseShadowBias(text, shadows);
                       return wrong ? named("--bias", *wrong) : Failure{};
                   });
    command.option("--cull", "FACES", "none, front or back [by bias and mesh]",
                   [&shadows](const std::string& text) -> Failure {
                       const Result<ShadowCull> cull = parseShadowCull(text);
                       if (!cull)
                           return named("--cull", cull.error());
                       shadows.cull = *cull;
                       return {};
                   });
    command.option("--filter", "FILTER",
                   "none, bilinear, jitter4, pcf:1..9, pcss[:BLOCKERS,SAMPLES] or pcss-ratio "
                   "[pcss:16,32]",
                   [&shadows](const std::string& text) -> Failure {
                       const Failure wrong = parseShadowFilter(text, shadows);
                       return wrong ? named("--filter", *wrong) : Failure{};
                   });
    command.integer("--cascades", "N", "1 to 5 [4]", 1, kMaxCascades,
                    [&shadows](std::int64_t n) { shadows.cascades = int(n); });
    command.integer("--map-size", "TEXELS", "across each shadow map, 512 to 8192 [2048]", 512, 8192,
                    [&shadows](std::int64_t n) { shadows.mapSize = int(n); });
    command.number("--split-lambda", "L",
                   "0 (even) to 1 (logarithmic) splits" + byDefault(shadows.splitLambda), 0, 1,
                   [&shadows](double lambda) { shadows.splitLambda = lambda; });
    command.option(
        "--fit", "FIT",
        "stable: cascades stand still while the camera moves; tight: fitted to what is seen, "
        "sharper [tight for a single picture, else stable]",
        [&shadows](const std::string& text) -> Failure {
            const Result<ShadowFit> fit = parseShadowFit(text);
            if (!fit)
                return named("--fit", fit.error());
            shadows.fit = *fit;
            return {};
        });
    command.number("--shadow-range", "M", "how far from the eye shadows reach [fitted]", 1e-3, 1e8,
                   [&shadows](double metres) { shadows.rangeMetres = metres; });
    command.number("--fade", "M", "over the last of which they fade [a tenth of the range]", 0, 1e8,
                   [&shadows](double metres) { shadows.fadeMetres = metres; });
    command.number("--blend", "FRACTION", "of a cascade that is mixed with the next [0.1]", 0, 1,
                   [&shadows](double fraction) { shadows.blendFraction = fraction; });
    command.number("--light-size", "DEG", "diameter of the sun [0.533]", 0, 90,
                   [&shadows](double degrees) { shadows.lightDiameterDegrees = degrees; });
}

void addPicture(Command& command, PictureOptions& picture, double screenSpaceError) {
    picture.frame.maximumScreenSpaceError = screenSpaceError;
    addCamera(command, picture);
    addShadows(command, picture);
    command.option("--ground", "GROUND",
                   "flat ground: auto, none or its height above the ellipsoid in metres [auto]",
                   [&picture](const std::string& text) { return parseGround(text, picture); });
    command.number("--sse", "PIXELS",
                   "error a tile may show before it is refined [" +
                       std::to_string(int(screenSpaceError)) + "]",
                   0.01, 1e6,
                   [&picture](double pixels) { picture.frame.maximumScreenSpaceError = pixels; });
    command.number("--timeout", "S", "for the tiles of a frame [60]", 0, kLongestSeconds,
                   [&picture](double seconds) { picture.timeoutSeconds = seconds; });
    command.option("--frame-report", "FILE.json", "what each frame needed and cost",
                   [&picture](const std::string& text) -> Failure {
                       if (text.empty())
                           return Error{"--frame-report", "is empty", ErrorKind::Usage};
                       picture.frameReport = text;
                       return {};
                   });
    command.app().add_flag("--verbose", picture.verbose, "say more on the way");
}

// In place of inputs.
void addBenchScene(Command& command, PictureOptions& picture) {
    addScene(command, picture.scene, false);
    command.option("--scene", "NAME",
                   "a built-in scene in place of inputs (gnomon evaluate --list names them)",
                   [&picture](const std::string& text) -> Failure {
                       picture.benchScene = text;
                       return {};
                   });
}

Failure checkInputs(const PictureOptions& picture, bool required) {
    const bool inputs = !picture.scene.inputs.empty();
    if (inputs && picture.benchScene)
        return Error{"--scene", "is given in place of inputs, not besides them", ErrorKind::Usage};
    if (required && !inputs && !picture.benchScene)
        return Error{"INPUT", "is required, or --scene", ErrorKind::Usage};
    return {};
}

void addView(Command& command, ViewOptions& view) {
    addBenchScene(command, view.picture);
    addPicture(command, view.picture, kViewScreenSpaceError);
    command.number("--quit-after", "S", "close the window after so many seconds", 0,
                   kLongestSeconds, [&view](double seconds) { view.quitAfterSeconds = seconds; });
    command.option("--screenshot", "FILE", "write the last picture when it closes",
                   [&view](const std::string& text) -> Failure {
                       view.screenshot = text;
                       return {};
                   });
    command.app().footer("Example:\n  gnomon view city/tileset.json --time '2024-06-21T18:00 "
                         "Europe/Amsterdam'");
}

void addDevice(Command& command, std::optional<int>& device) {
    command.option("--device", "N|cpu",
                   "which GPU draws, or the software rasteriser [the first GPU]",
                   [&device](const std::string& text) -> Failure {
                       constexpr std::int64_t kMostDevices = 1024;
                       const Result<std::int64_t> number =
                           text == "cpu" ? Result<std::int64_t>(-1)
                                         : parseInteger("--device", text, 0, kMostDevices);
                       if (!number)
                           return number.error();
                       device = int(*number);
                       return {};
                   });
}

void addCapture(Command& command, CaptureOptions& capture) {
    command
        .option("-o,--output", "OUT",
                "a picture (.png, .jpg), one a frame ({frame} or {frame:04} in the name), or a "
                "video (.mp4, .mkv)",
                [&capture](const std::string& text) -> Failure {
                    capture.output = text;
                    return {};
                })
        ->required();
    addBenchScene(command, capture.picture);
    addPicture(command, capture.picture, kCaptureScreenSpaceError);
    command.app().add_flag_callback(
        "--no-overlay", [] {}, "nothing is written over the picture; nor is it without");
    command.option("--frames", "A-B[:STEP]", "which frames [all of the camera path]",
                   [&capture](const std::string& text) -> Failure {
                       const Result<FrameRange> range = parseFrames(text);
                       if (!range)
                           return range.error();
                       capture.frames = *range;
                       return {};
                   });
    command.number("--fps", "N", "frames a second [30]", 0.001, kHighestFramesPerSecond,
                   [&capture](double fps) { capture.framesPerSecond = fps; });
    command.number("--duration", "S", "seconds to capture [the camera path's own]", 0,
                   kLongestSeconds,
                   [&capture](double seconds) { capture.durationSeconds = seconds; });
    command.option(
        "--aov", "LIST", "also write, beside OUT: sun, depth, normal, cascade, tile",
        [&capture](const std::string& text) { return take(parseAovs(text), capture.aovs); });
    addDevice(command, capture.device);
    command.app().footer(
        "Examples:\n"
        "  gnomon capture city/tileset.json -o city.png --time '2024-06-21T18:00 "
        "Europe/Amsterdam'\n"
        "  gnomon capture place -o flight.mp4 --camera place/flight.json --fps 25");
}

void addInfo(Command& command, InfoOptions& info) {
    addScene(command, info.scene, true);
    command.app().add_flag("--json", info.json, "as JSON");
    command.app().footer("Example:\n  gnomon info city/tileset.json --json");
}

void addEvaluate(Command& command, EvaluateOptions& evaluate, std::optional<std::string>& list) {
    addScene(command, evaluate.picture.scene, false);
    const auto keep = [&command](const char* name, const char* value, const char* help,
                                 auto& into) {
        command.option(name, value, help, [name, &into](const std::string& text) -> Failure {
            if (text.empty())
                return Error{name, "is empty", ErrorKind::Usage};
            into = text;
            return {};
        });
    };
    keep("--scene", "NAME", "a built-in scene in place of inputs (--list names them)",
         evaluate.sceneName);
    keep("--techniques", "LIST",
         "techniques with commas between: csm+dual-peel+pcss:16,32,single; each may go on with "
         "@KEY=VALUE: csm+constant:0.5+none@map-size=512. What one does not say is as the options "
         "below have it [about fifteen, --list names them]",
         list);
    command.integer("--rays", "N", "to the sun's disc for each pixel of the reference [64]", 1,
                    1 << 16, [&evaluate](std::int64_t n) { evaluate.raysPerPixel = int(n); });
    command.integer("--frames-timed", "N", "of each technique; their median counts [7]", 1, 10000,
                    [&evaluate](std::int64_t n) { evaluate.framesTimed = int(n); });
    command.app().add_flag("--json", evaluate.json, "as JSON");
    keep("--images", "DIR",
         "write reference.png, and <technique>.png and <technique>_error.png of each",
         evaluate.imagesFolder);
    keep("--plot", "FILE.svg", "draw time against error", evaluate.plotFile);
    command
        .option(
            "--path", "[FILE]",
            "also count what flickers while the camera moves: along the camera path in FILE, or "
            "of --camera, or by small steps; without FILE it comes after the inputs",
            [&evaluate](const std::string& text) -> Failure {
                evaluate.countFlips = true;
                if (!text.empty())
                    evaluate.pathFile = text;
                return {};
            })
        ->expected(0, 1);
    command.app().add_flag("--list", evaluate.list,
                           "say which techniques and scenes there are, and no more");
    addPicture(command, evaluate.picture, kViewScreenSpaceError);
    addDevice(command, evaluate.device);
    command.app().footer(
        "Examples:\n"
        "  gnomon evaluate city/tileset.json --sun 228,26 --images errors --plot errors.svg\n"
        "  gnomon evaluate --scene l-shape --techniques csm+constant:0.5+none,csm+dual-peel+none "
        "--json");
}

// What only the options together tell.
Failure completeEvaluate(EvaluateOptions& evaluate, const std::optional<std::string>& list) {
    if (evaluate.list)
        return {};
    const bool inputs = !evaluate.picture.scene.inputs.empty();
    if (inputs && evaluate.sceneName)
        return Error{"--scene", "is given in place of inputs, not besides them", ErrorKind::Usage};
    if (!inputs && !evaluate.sceneName)
        return Error{"INPUT", "is required, or --scene", ErrorKind::Usage};
    const ShadowSettings& base = evaluate.picture.frame.shadows;
    if (!list) {
        evaluate.techniques = bench::defaultTechniques(base);
        return {};
    }
    Result<std::vector<bench::Technique>> techniques = bench::parseTechniques(*list, base);
    if (!techniques)
        return named("--techniques", techniques.error());
    evaluate.techniques = std::move(*techniques);
    evaluate.techniquesGiven = true;
    return {};
}

void addDemo(Command& command, DemoOptions& demo) {
    const PlaceOptions place;
    demo.buildings = place.buildings;
    demo.at = place.at;
    demo.seed = place.seed;
    command.app()
        .add_option("DIR", demo.folder, "the folder to write, made if it is not there")
        ->type_name("")
        ->required();
    command.option(
        "--size", "SIZE", "small, city or a number of buildings [small]",
        [&demo](const std::string& text) { return take(parseDemoSize(text), demo.buildings); });
    command.option("--at", "LON,LAT[,H]", "where on the Earth [6.96,50.94,100]",
                   [&demo](const std::string& text) { return take(parseAt(text), demo.at); });
    command.option("--seed", "N", "another city for every number [1]",
                   [&demo](const std::string& text) -> Failure {
                       const auto seed = parseInteger("--seed", text, 0,
                                                      std::numeric_limits<std::int64_t>::max());
                       if (!seed)
                           return seed.error();
                       demo.seed = std::uint64_t(*seed);
                       return {};
                   });
    command.app().footer("Example:\n  gnomon demo place --size city && gnomon view place");
}

class HelpFormatter : public CLI::Formatter {
  public:
    std::string make_usage(const CLI::App* app, std::string name) const override {
        if (!app->get_subcommands({}).empty())
            return "\nUsage: " + name + " COMMAND ...\n";
        std::string usage = "\nUsage: " + name;
        for (const CLI::Option* positional :
             app->get_options([](const CLI::Option* option) { return option->get_positional(); }))
            usage += " " + positional->get_name(true) +
                     (positional->get_items_expected_max() > 1 ? "..." : "");
        return usage + " [OPTIONS]\n";
    }
};

// Everything a parse fills; on the heap, since the options' callbacks point into it.
struct Parser {
    CLI::App app{"Real city tiles under the real sun, with measured shadows.", "gnomon"};
    Failure failure;
    ViewOptions view;
    CaptureOptions capture;
    InfoOptions info;
    EvaluateOptions evaluate;
    std::optional<std::string> techniques; // of evaluate
    DemoOptions demo;
    std::vector<std::unique_ptr<Command>> commands;

    Command& add(const char* name, const char* help) {
        CLI::App* sub = app.add_subcommand(name, help);
        commands.push_back(std::make_unique<Command>(*sub, failure));
        return *commands.back();
    }

    Parser() {
        app.set_version_flag("--version", "gnomon " GNOMON_VERSION);
        app.require_subcommand(1);
        app.formatter(std::make_shared<HelpFormatter>()); // the commands inherit it
        app.footer("gnomon COMMAND --help tells more.\n\nExample:\n"
                   "  gnomon demo place && gnomon view place");
        addView(add("view", "a window"), view);
        addCapture(add("capture", "a picture, a picture a frame, or a video"), capture);
        addInfo(add("info", "what an input is, where it is, what is in it, what is wrong with it"),
                info);
        addEvaluate(add("evaluate", "each shadow technique: its time, its memory and its error "
                                    "against rays"),
                    evaluate, techniques);
        addDemo(add("demo", "writes the built-in place: terrain, city, trees, a flight"), demo);
    }
};

std::string oneLineOf(const char* what) {
    std::string text = what;
    for (char& c : text)
        if (c == '\n')
            c = ' ';
    return text;
}

Error unexpected(const CLI::App& app) {
    const std::vector<std::string> rest = app.remaining(true);
    const std::string first = rest.empty() ? "" : rest.front();
    const auto chosen = app.get_subcommands();
    if (chosen.empty())
        return {first, "no such command; there are view, capture, info, evaluate and demo",
                ErrorKind::Usage};
    const std::string name = first.substr(0, first.find('='));
    return {first.starts_with("-") ? name : first,
            std::string(first.starts_with("-") ? "unknown option" : "not expected here") +
                " (gnomon " + chosen.front()->get_name() + " --help)",
            ErrorKind::Usage};
}

// The library's words for a missing value or argument begin with its name.
Error usageOf(const CLI::ParseError& e) {
    std::string text = oneLineOf(e.what());
    const auto colon = text.find(": ");
    const auto space = text.find(' ');
    if (colon != std::string::npos && colon < space)
        return {text.substr(0, colon), text.substr(colon + 2), ErrorKind::Usage};
    if (dynamic_cast<const CLI::RequiredError*>(&e) && text.ends_with(" is required"))
        return {text.substr(0, text.size() - std::string(" is required").size()), "is required",
                ErrorKind::Usage};
    return {"gnomon", text, ErrorKind::Usage};
}

} // namespace

Result<CommandLine> parseCommandLine(const std::vector<std::string>& arguments) {
    const auto parser = std::make_unique<Parser>();
    CLI::App& app = parser->app;
    try {
        app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
    } catch (const CLI::CallForVersion& e) {
        return CommandLine(HelpText{std::string(e.what()) + "\n"});
    } catch (const CLI::Success&) {
        return CommandLine(HelpText{app.help()});
    } catch (const CLI::ExtrasError&) {
        return unexpected(app);
    } catch (const CLI::RequiredError& e) {
        if (app.get_subcommands().empty())
            return app.remaining(true).empty()
                       ? Error{"gnomon",
                               "which command? there are view, capture, info, evaluate and demo "
                               "(gnomon --help)",
                               ErrorKind::Usage}
                       : unexpected(app);
        return usageOf(e);
    } catch (const CLI::ParseError& e) {
        return usageOf(e);
    }
    if (parser->failure)
        return *parser->failure;
    const std::string command = app.get_subcommands().front()->get_name();
    if (command == "view") {
        if (Failure wrong = checkInputs(parser->view.picture, false))
            return *wrong;
        return CommandLine(std::move(parser->view));
    }
    if (command == "capture") {
        if (Failure wrong = checkInputs(parser->capture.picture, true))
            return *wrong;
        return CommandLine(std::move(parser->capture));
    }
    if (command == "info")
        return CommandLine(std::move(parser->info));
    if (command == "evaluate") {
        if (Failure wrong = completeEvaluate(parser->evaluate, parser->techniques))
            return *wrong;
        return CommandLine(std::move(parser->evaluate));
    }
    return CommandLine(std::move(parser->demo));
}

} // namespace gnomon
