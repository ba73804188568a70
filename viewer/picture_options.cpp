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

} // namespace

void addScene(Command& command, SceneOptions& scene, bool required) {
    CLI::Option* inputs = command.app().add_option(
        "INPUT", scene.inputs,
        "tileset.json, a scene file, a folder with either, a model (glb, gltf, b3dm) or a raster "
        "of "
        "heights (GeoTIFF, ASC); KIND=PATH (tileset=, model=, terrain=) insists on a kind");
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
