#include "viewer/option_values.h"

#include "viewer/place/place.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace gnomon {

namespace {

constexpr double kMaxHeightMetres = 1e8;
constexpr int kMaxPixels = 16384; // GL 4.5 promises this much
constexpr std::int64_t kMaxFrame = 1'000'000'000;

Error usage(const std::string& option, const std::string& why) {
    return {option, why, ErrorKind::Usage};
}

std::string inWords(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.10g", value);
    return text;
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::size_t from = 0;
    for (std::size_t at; (at = text.find(separator, from)) != std::string::npos; from = at + 1)
        parts.push_back(text.substr(from, at - from));
    parts.push_back(text.substr(from));
    return parts;
}

Failure checkPosition(const std::string& option, double longitude, double latitude, double height) {
    if (std::abs(longitude) > 360)
        return usage(option, "longitude " + inWords(longitude) + " is outside -360 to 360");
    if (std::abs(latitude) > 90)
        return usage(option, "latitude " + inWords(latitude) + " is outside -90 to 90");
    if (std::abs(height) > kMaxHeightMetres)
        return usage(option, "height " + inWords(height) + " is too far from the Earth");
    return {};
}

double wrapped(double longitude) {
    const double turned = std::remainder(longitude, 360.0);
    return std::abs(longitude) <= 180 ? longitude : turned;
}

} // namespace

Result<double> parseNumber(const std::string& option, const std::string& text, double min,
                           double max) {
    double value = 0.0;
    const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (begin == end || error != std::errc() || stop != end || !std::isfinite(value))
        return usage(option, "\"" + text + "\" is not a number");
    if (value < min || value > max)
        return usage(option,
                     inWords(value) + " is outside " + inWords(min) + " to " + inWords(max));
    return value;
}

Result<std::int64_t> parseInteger(const std::string& option, const std::string& text,
                                  std::int64_t min, std::int64_t max) {
    std::int64_t value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (text.empty() || stop != end || error == std::errc::invalid_argument)
        return usage(option, "\"" + text + "\" is not a whole number");
    if (error != std::errc() || value < min || value > max)
        return usage(option,
                     text + " is outside " + std::to_string(min) + " to " + std::to_string(max));
    return value;
}

Result<std::vector<double>> parseList(const std::string& option, const std::string& text,
                                      std::size_t least, std::size_t most, const char* form) {
    const std::vector<std::string> parts = split(text, ',');
    if (parts.size() < least || parts.size() > most)
        return usage(option, "\"" + text + "\" has " + std::to_string(parts.size()) +
                                 (parts.size() == 1 ? " part" : " parts") + ", expected " + form);
    std::vector<double> values;
    for (std::string part : parts) {
        part.erase(0, std::min(part.find_first_not_of(' '), part.size()));
        part.erase(part.find_last_not_of(' ') + 1);
        const Result<double> value = parseNumber(option, part);
        if (!value)
            return value.error();
        values.push_back(*value);
    }
    return values;
}

Failure parseCamera(const std::string& text, PictureOptions& options) {
    constexpr const char* kForm = "LON,LAT,HEIGHT,HEADING,PITCH[,ROLL] or a camera path's file";
    std::error_code ignored;
    const bool numbers = text.find_first_not_of("+-.,0123456789eE ") == std::string::npos;
    if (!numbers || std::filesystem::is_regular_file(text, ignored)) {
        if (std::count(text.begin(), text.end(), ',') >= 4 && !std::filesystem::exists(text))
            return usage("--camera",
                         "\"" + text + "\" is not a list of numbers; expected " + kForm);
        options.camera = CameraFile{text};
        return {};
    }
    const auto list = parseList("--camera", text, 5, 6, kForm);
    if (!list)
        return list.error();
    const std::vector<double>& v = *list;
    if (Failure wrong = checkPosition("--camera", v[0], v[1], v[2]))
        return wrong;
    if (std::abs(v[4]) > 90)
        return usage("--camera", "pitch " + inWords(v[4]) + " is outside -90 to 90");
    options.camera =
        FixedCamera{{wrapped(v[0]), v[1], v[2]}, {v[3], v[4], v.size() == 6 ? v[5] : 0.0}};
    return {};
}

Failure parseSize(const std::string& text, int& width, int& height) {
    const std::vector<std::string> parts = split(text, 'x');
    if (parts.size() != 2)
        return usage("--size", "\"" + text + "\" is not WIDTHxHEIGHT, such as 1280x720");
    for (int i = 0; i < 2; ++i) {
        const Result<std::int64_t> pixels =
            parseInteger("--size", parts[std::size_t(i)], 1, kMaxPixels);
        if (!pixels)
            return pixels.error();
        (i == 0 ? width : height) = int(*pixels);
    }
    return {};
}

Failure parseSun(const std::string& text, PictureOptions& options) {
    const auto list = parseList("--sun", text, 2, 2, "AZIMUTH,ELEVATION in degrees");
    if (!list)
        return list.error();
    const double azimuth = (*list)[0], elevation = (*list)[1];
    if (std::abs(azimuth) > 360)
        return usage("--sun", "azimuth " + inWords(azimuth) + " is outside -360 to 360");
    if (std::abs(elevation) > 90)
        return usage("--sun", "elevation " + inWords(elevation) + " is outside -90 to 90");
    options.sun = SunAngles{azimuth < 0 ? azimuth + 360 : azimuth, elevation};
    return {};
}

Failure parseGround(const std::string& text, PictureOptions& options) {
    FrameOptions& frame = options.frame;
    options.groundGiven = true;
    frame.groundAuto = text == "auto";
    frame.groundHeightMetres.reset();
    if (text == "auto" || text == "none")
        return {};
    const Result<double> height =
        parseNumber("--ground", text, -kMaxHeightMetres, kMaxHeightMetres);
    if (!height)
        return usage("--ground", "\"" + text + "\" is neither auto, none nor a height in metres");
    frame.groundHeightMetres = *height;
    return {};
}

Failure parseShadows(const std::string& text, ShadowSettings& settings) {
    const Failure wrong = parseTechnique(text, settings);
    return wrong ? Failure(usage("--shadows", wrong->subject + " " + wrong->reason)) : Failure{};
}

Failure parseHeights(const std::string& text, std::optional<Heights>& heights) {
    if (text != "ellipsoidal" && text != "egm96")
        return usage("--heights", "\"" + text + "\" is neither ellipsoidal nor egm96");
    heights = text == "egm96" ? Heights::Egm96 : Heights::Ellipsoidal;
    return {};
}

Failure parseUp(const std::string& text, std::optional<ModelUp>& up) {
    if (text != "auto" && text != "y" && text != "z")
        return usage("--up", "\"" + text + "\" is not auto, y or z");
    up = text == "auto" ? ModelUp::Auto : text == "y" ? ModelUp::Y : ModelUp::Z;
    return {};
}

Result<Placement> parsePlace(const std::string& text) {
    const auto list = parseList("--place", text, 3, 4, "LON,LAT,HEIGHT[,HEADING]");
    if (!list)
        return list.error();
    const std::vector<double>& v = *list;
    if (Failure wrong = checkPosition("--place", v[0], v[1], v[2]))
        return *wrong;
    return Placement{{wrapped(v[0]), v[1], v[2]}, v.size() == 4 ? v[3] : 0.0};
}

Result<Shard> parseShard(const std::string& text) {
    constexpr std::int64_t kMostShards = 1'000'000;
    const std::vector<std::string> parts = split(text, '/');
    if (parts.size() != 2)
        return usage("--shard", "\"" + text + "\" is not i/n");
    const Result<std::int64_t> count = parseInteger("--shard", parts[1], 1, kMostShards);
    if (!count)
        return count.error();
    const Result<std::int64_t> number = parseInteger("--shard", parts[0], 0, kMostShards);
    if (!number)
        return number.error();
    if (*number < 1 || *number > *count)
        return usage("--shard",
                     "\"" + text + "\": they are numbered from 1 to " + std::to_string(*count));
    return Shard{*number, *count};
}

Result<FrameRange> parseFrames(const std::string& text) {
    const std::vector<std::string> withStep = split(text, ':');
    const std::vector<std::string> ends = split(withStep[0], '-');
    if (withStep.size() > 2 || ends.size() > 2)
        return usage("--frames", "\"" + text + "\" is not A-B or A-B:STEP");
    FrameRange range;
    const Result<std::int64_t> first = parseInteger("--frames", ends[0], 0, kMaxFrame);
    if (!first)
        return first.error();
    range.first = range.last = *first;
    if (ends.size() == 2) {
        const Result<std::int64_t> last = parseInteger("--frames", ends[1], 0, kMaxFrame);
        if (!last)
            return last.error();
        range.last = *last;
    }
    if (range.last < range.first)
        return usage("--frames", "\"" + text + "\" ends before it begins");
    if (withStep.size() == 2) {
        const Result<std::int64_t> step = parseInteger("--frames", withStep[1], 1, kMaxFrame);
        if (!step)
            return step.error();
        range.step = *step;
    }
    return range;
}

namespace {

struct AovName {
    Aov aov;
    const char* name;
};
constexpr std::array kAovs = {AovName{Aov::Sun, "sun"}, AovName{Aov::Depth, "depth"},
                              AovName{Aov::Normal, "normal"}, AovName{Aov::Cascade, "cascade"},
                              AovName{Aov::Tile, "tile"}};

} // namespace

const char* nameOf(Aov aov) {
    for (const AovName& each : kAovs)
        if (each.aov == aov)
            return each.name;
    return "";
}

Result<std::vector<Aov>> parseAovs(const std::string& text) {
    std::vector<Aov> aovs;
    for (const std::string& word : split(text, ',')) {
        const auto found = std::find_if(kAovs.begin(), kAovs.end(),
                                        [&](const AovName& each) { return word == each.name; });
        if (found == kAovs.end())
            return usage("--aov",
                         "no \"" + word + "\"; there are sun, depth, normal, cascade and tile");
        if (std::find(aovs.begin(), aovs.end(), found->aov) == aovs.end())
            aovs.push_back(found->aov);
    }
    return aovs;
}

Result<std::size_t> parseDemoSize(const std::string& text) {
    if (text == "small")
        return kSmallPlaceBuildings;
    if (text == "city")
        return kCityPlaceBuildings;
    constexpr std::int64_t kMost = 2'000'000; // writePlace's own limit
    const Result<std::int64_t> number = parseInteger("--size", text, 1, kMost);
    if (!number)
        return usage("--size", "\"" + text +
                                   "\" is not small, city or a number of buildings "
                                   "from 1 to 2000000");
    return std::size_t(*number);
}

Result<Geodetic> parseAt(const std::string& text) {
    const auto list = parseList("--at", text, 2, 3, "LON,LAT[,HEIGHT]");
    if (!list)
        return list.error();
    const std::vector<double>& v = *list;
    const double height = v.size() == 3 ? v[2] : 0.0;
    if (Failure wrong = checkPosition("--at", v[0], v[1], height))
        return *wrong;
    return Geodetic{wrapped(v[0]), v[1], height};
}

} // namespace gnomon
