#include "viewer/picture_options.h"

#include "viewer/option_values.h"

#include <CLI/CLI.hpp>

#include <cstdio>

namespace gnomon {

namespace {

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
    command.option(
        "--time", "TIME",
        "moment that sets the sun and the flood: ISO 8601, with Z, an offset or a zone's name",
        [&picture](const std::string& text) -> Failure {
            const Result<ZonedTime> moment = parseZonedTime(text);
            if (!moment)
                return named("--time", moment.error());
            if (const SunAngles* angles = std::get_if<SunAngles>(&picture.sun))
                picture.fixedSun = *angles;
            picture.sun = moment->utc;
            picture.timeZone = moment->zone;
            return {};
        });
    command.option("--sun", "AZIMUTH,ELEVATION",
                   "degrees, azimuth clockwise from north; with a time too, that moves the flood "
                   "alone",
                   [&picture](const std::string& text) -> Failure {
                       const auto before = picture.sun;
                       if (const Failure wrong = parseSun(text, picture))
                           return wrong;
                       if (std::holds_alternative<UtcTime>(before)) {
                           picture.fixedSun = std::get<SunAngles>(picture.sun);
                           picture.sun = before;
                       }
                       return {};
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

// A value that one of the parsers of viewer/layer_facts.h understands.
template <class T, class Parse>
void addNamed(Command& command, const char* option, const char* value, const char* help,
              std::optional<T>& into, const Parse& parse) {
    command.option(option, value, help,
                   [option, value, &into, parse](const std::string& text) -> Failure {
                       into = parse(text);
                       if (into)
                           return {};
                       return Error{option, "\"" + text + "\" is not " + value, ErrorKind::Usage};
                   });
}

// What layers' own files lack; in a scene file each layer has its own.
void addLayers(Command& command, SceneOptions& scene) {
    constexpr double kHighest = 10000.0;
    command.number("--height", "M", "of buildings, trees and barriers that have none of their own",
                   0.01, kHighest, [&scene](double metres) { scene.heightMetres = metres; });
    command.option("--variable", "NAME", "of a flood result that holds several",
                   [&scene](const std::string& text) -> Failure {
                       scene.variable = text;
                       return {};
                   });
    command.option("--start", "TIME", "of the first step of water that tells no times",
                   [&scene](const std::string& text) -> Failure {
                       const Result<UtcTime> moment = parseTime(text);
                       if (!moment)
                           return named("--start", moment.error());
                       scene.start = *moment;
                       return {};
                   });
    addNamed(command, "--step", "1h, 15min, 300s", "between its steps", scene.stepSeconds,
             durationSeconds);
    command.number("--dry", "M", "water no deeper than this is not shown [0.01]", 0, 100,
                   [&scene](double metres) { scene.dryMetres = metres; });
    addNamed(command, "--water", "depth, speed or natural", "how water looks [depth]", scene.colors,
             waterColorsNamed);
    command.number("--water-most", "M", "depth or speed of the last colour [from the data]", 1e-6,
                   1e6, [&scene](double most) { scene.most = most; });
    addNamed(command, "--terrain", "plain, ramp or ramp-unlit", "how terrain looks [plain]",
             scene.look, terrainLookNamed);
}

void addWeb(Command& command, HttpOptions& http) {
    command.repeated("--header", "'NAME: VALUE'",
                     "sent to the servers that INPUT names, and to no others; may be given several "
                     "times",
                     [&http](const std::string& text) -> Failure {
                         if (Failure wrong = checkHttpHeader(text))
                             return wrong;
                         http.headers.push_back(text);
                         return {};
                     });
    command.option("--cache", "DIR",
                   "keep what comes from the web there, for the next run and for --offline "
                   "[nothing is kept]",
                   [&http](const std::string& text) -> Failure {
                       if (text.empty())
                           return Error{"--cache", "is empty", ErrorKind::Usage};
                       http.cacheFolder = text;
                       return {};
                   });
    command.app().add_flag("--offline", http.offline,
                           "take everything from the cache, however old, and ask no server");
    command.repeated("--allow-host", "HOST",
                     "let tilesets name this host although it is in a private network or on this "
                     "machine, as those may be that INPUT names; may be given several times",
                     [&http](const std::string& text) -> Failure {
                         if (text.empty())
                             return Error{"--allow-host", "is empty", ErrorKind::Usage};
                         http.allowedHosts.push_back(text);
                         return {};
                     });
}

} // namespace

void addScene(Command& command, SceneOptions& scene, bool required) {
    CLI::Option* inputs = command.app().add_option(
        "INPUT", scene.inputs,
        "tileset.json, a scene file, a folder with either, a model (glb, gltf, b3dm), a raster "
        "(GeoTIFF, ASC, NetCDF), footprints (GeoJSON, GeoPackage, Shapefile, CityJSON), terrain "
        "(layer.json) or a flood result; tilesets, models and layer.json also by http:// or "
        "https://; KIND=PATH insists on a kind: terrain=, imagery=, depth=, "
        "stage=, buildings=, trees=, barriers=, lamps=, tileset=, model=");
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
    command.option("--data", "DIR", "where the files of a scene are that do not lie beside it",
                   [&scene](const std::string& text) -> Failure {
                       scene.dataFolder = text;
                       return {};
                   });
    addLayers(command, scene);
    addWeb(command, scene.http);
    constexpr std::size_t kMebibyte = std::size_t(1) << 20;
    scene.loader.memoryBytes = 1024 * kMebibyte;
    command.integer(
        "--memory", "MB", "for tiles, decoded and on the GPU, at most [1024]", 16, 1 << 20,
        [&scene](std::int64_t mb) { scene.loader.memoryBytes = std::size_t(mb) * kMebibyte; });
}

void addBenchScene(Command& command, PictureOptions& picture) {
    addScene(command, picture.scene, false);
    command.option("--scene", "NAME",
                   "a built-in scene in place of inputs (gnomon evaluate --list names them)",
                   [&picture](const std::string& text) -> Failure {
                       picture.benchScene = text;
                       return {};
                   });
}

void addPicture(Command& command, PictureOptions& picture, double screenSpaceError) {
    picture.frame.maximumScreenSpaceError = screenSpaceError;
    addCamera(command, picture);
    addShadows(command, picture);
    command.option("--ground", "GROUND",
                   "flat ground: auto, none or its height above the ellipsoid in metres [auto]",
                   [&picture](const std::string& text) {
                       const Failure wrong = parseGround(text, picture);
                       picture.scene.groundMetres = picture.frame.groundHeightMetres;
                       return wrong;
                   });
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

} // namespace gnomon
