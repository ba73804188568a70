#include "viewer/options.h"

#include "viewer/option_values.h"
#include "viewer/picture_options.h"
#include "viewer/place/place.h"

#include <CLI/CLI.hpp>

#include <cmath>
#include <limits>
#include <memory>

namespace gnomon {

namespace {

constexpr double kViewScreenSpaceError = 16.0;
constexpr double kCaptureScreenSpaceError = 8.0;
constexpr double kHighestFramesPerSecond = 1000.0;

template <class T>
Failure take(Result<T> parsed, T& into) {
    if (!parsed)
        return parsed.error();
    into = std::move(*parsed);
    return {};
}

Failure checkWeb(const HttpOptions& http) {
    if (http.offline && !http.cacheFolder)
        return Error{"--offline", "needs the folder that was filled before: --cache DIR",
                     ErrorKind::Usage};
    return {};
}

Failure checkInputs(const PictureOptions& picture, bool required) {
    if (Failure wrong = checkWeb(picture.scene.http))
        return wrong;
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
        "--no-overlay", [&capture] { capture.overlay = false; },
        "leave away what is written over the picture: time, legends, scale, north, credits");
    command.option("--frames", "A-B[:STEP]", "which frames [all of the camera path]",
                   [&capture](const std::string& text) -> Failure {
                       const Result<FrameRange> range = parseFrames(text);
                       if (!range)
                           return range.error();
                       capture.frames = *range;
                       return {};
                   });
    command.option(
        "--shard", "i/n",
        "of these frames the i-th and every n-th after it, i from 1 to n: a part of the work for "
        "each of n machines ($SLURM_ARRAY_TASK_ID/8 in --array=1-8)",
        [&capture](const std::string& text) -> Failure {
            const Result<Shard> shard = parseShard(text);
            if (!shard)
                return shard.error();
            capture.shard = *shard;
            return {};
        });
    command.app().add_flag("--resume", capture.resume,
                           "leave frames that are there whole and were drawn with these settings");
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
    command.option("--at", "LON,LAT", "also tells ground, water and building there",
                   [&info](const std::string& text) -> Failure {
                       const auto numbers = parseList("--at", text, 2, 2, "LON,LAT");
                       if (!numbers)
                           return numbers.error();
                       if (std::abs((*numbers)[0]) > 360 || std::abs((*numbers)[1]) > 90)
                           return Error{"--at", "is off the Earth", ErrorKind::Usage};
                       info.at = glm::dvec2((*numbers)[0], (*numbers)[1]);
                       return {};
                   });
    command.option("--time", "TIME", "the moment that --at asks for [the last step]",
                   [&info](const std::string& text) -> Failure {
                       const Result<UtcTime> moment = parseTime(text);
                       if (!moment)
                           return named("--time", moment.error());
                       info.time = *moment;
                       return {};
                   });
    command.app().footer("Examples:\n"
                         "  gnomon info city/tileset.json --json\n"
                         "  gnomon info terrain=dem.tif depth=flood.tif --at 6.96,50.94");
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
    if (Failure wrong = checkWeb(evaluate.picture.scene.http))
        return wrong;
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
        addDemo(add("demo", "writes the built-in place: terrain, city, trees, a flood, a flight"),
                demo);
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
    if (command == "info") {
        if (Failure wrong = checkWeb(parser->info.scene.http))
            return *wrong;
        return CommandLine(std::move(parser->info));
    }
    if (command == "evaluate") {
        if (Failure wrong = completeEvaluate(parser->evaluate, parser->techniques))
            return *wrong;
        return CommandLine(std::move(parser->evaluate));
    }
    return CommandLine(std::move(parser->demo));
}

} // namespace gnomon
