#include "viewer/frame_report.h"

#include "streaming/http/url.h"
#include "viewer/input.h"
#include "viewer/option_values.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace gnomon {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kMegabyte = 1e6;

Json cameraJson(const Camera& camera) {
    const Geodetic place = geodeticOf(camera.position);
    const Orientation o = orientationOf(camera);
    return {{"lon", place.longitudeDegrees},
            {"lat", place.latitudeDegrees},
            {"height", place.heightMetres},
            {"heading", o.headingDegrees},
            {"pitch", o.pitchDegrees},
            {"roll", o.rollDegrees},
            {"fov", camera.verticalFovRadians / kRadiansPerDegree},
            {"size", {camera.widthPixels, camera.heightPixels}}};
}

Json cascadesJson(const std::vector<CascadeFacts>& cascades) {
    Json list = Json::array();
    for (const CascadeFacts& c : cascades)
        list.push_back({{"near", c.nearMetres},
                        {"far", c.farMetres},
                        {"texel_metres", c.texelMetres},
                        {"casters", c.casters},
                        {"redrawn", true}});
    return list;
}

Json frameJson(const ReportedFrame& frame) {
    const FrameFacts& f = frame.facts;
    Json json = {{"index", frame.index}};
    json["time_utc"] = frame.time ? Json(formatUtc(*frame.time)) : Json(nullptr);
    json["camera"] = cameraJson(frame.camera);
    json["sun"] = {{"azimuth", frame.sun.azimuthDegrees},
                   {"elevation", frame.sun.elevationDegrees}};
    json["tiles"] = {{"selected", f.tilesSelected},
                     {"loaded", f.tilesLoaded},
                     {"missing", f.missing},
                     {"late", f.late}};
    if (std::any_of(f.lateReasons.begin(), f.lateReasons.end(),
                    [](const std::string& reason) { return !reason.empty(); }))
        json["tiles"]["late_reasons"] = f.lateReasons;
    if (!frame.tileNames.empty())
        json["tiles"]["ids"] = frame.tileNames;
    json["complete"] = f.complete;
    json["sse"] = f.screenSpaceError;
    json["bytes"] = {{"decoded", f.decodedBytes}, {"gpu", f.gpuBytes}, {"most", f.mostTileBytes}};
    json["triangles"] = f.triangles;
    json["draws"] = f.draws;
    json["cpu_ms"] = {{"select", f.selectMs}, {"upload", f.uploadMs}, {"total", f.totalMs}};
    json["gpu_ms"] = {{"depth", f.depthMs},       {"visibility", f.visibilityMs},
                      {"sun", f.sunMs},           {"lamps", f.lampMs},
                      {"shading", f.compositeMs}, {"total", f.gpuTotalMs}};
    if (f.resolveMs > 0.0)
        json["gpu_ms"]["resolve"] = f.resolveMs;
    if (f.waterTriangles > 0) {
        json["water_triangles"] = f.waterTriangles;
        json["gpu_ms"]["water"] = f.waterMs;
    }
    json["cascades"] = cascadesJson(f.cascades);
    json["files"] = frame.files;
    return json;
}

// FNV-1a, 64 bits.
std::string hashOf(const std::string& text) {
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
    char hex[17];
    std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(hash));
    return hex;
}

struct SunText {
    std::ostringstream& out;
    void operator()(std::monostate) const { out << "default"; }
    void operator()(const UtcTime& time) const { out << "utc " << time.seconds; }
    void operator()(const SunAngles& sun) const {
        out << "angles " << sun.azimuthDegrees << ' ' << sun.elevationDegrees;
    }
};

struct CameraText {
    std::ostringstream& out;
    void operator()(std::monostate) const { out << "fit"; }
    void operator()(const FixedCamera& c) const {
        out << c.position.longitudeDegrees << ' ' << c.position.latitudeDegrees << ' '
            << c.position.heightMetres << ' ' << c.orientation.headingDegrees << ' '
            << c.orientation.pitchDegrees << ' ' << c.orientation.rollDegrees;
    }
    void operator()(const CameraFile& file) const {
        constexpr std::size_t kMaxBytes = std::size_t(64) << 20;
        const Result<std::string> text = readTextFile(file.path, kMaxBytes);
        out << (text ? *text : file.path);
    }
};

void describe(std::ostringstream& out, const ShadowSettings& s) {
    out << describe(s) << ' ' << int(s.lamps) << ' ' << s.lampEdgeTexels << ' ' << s.cascades << ' '
        << s.mapSize << ' ' << s.splitLambda << ' ' << s.rangeMetres.value_or(-1) << ' '
        << s.fadeMetres.value_or(-1) << ' ' << s.blendFraction << ' ' << s.lightDiameterDegrees
        << '\n';
}

void describe(std::ostringstream& out, const SceneOptions& scene) {
    for (const std::string& input : scene.inputs)
        out << "input " << input << '\n';
    out << "crs " << scene.crs.value_or("") << ' '
        << int(scene.heights.value_or(Heights::Ellipsoidal)) << '\n';
    if (scene.placement)
        out << "place " << scene.placement->origin.longitudeDegrees << ' '
            << scene.placement->origin.latitudeDegrees << ' '
            << scene.placement->origin.heightMetres << ' ' << scene.placement->headingDegrees
            << '\n';
    out << "up " << int(scene.up.value_or(ModelUp::Auto)) << " raise "
        << scene.raiseMetres.value_or(0.0) << '\n';
    const auto whole = [](const auto& choice) { return choice ? int(*choice) : -1; };
    const auto number = [](const std::optional<double>& value) { return value.value_or(-1.0); };
    const auto moment = [](const std::optional<UtcTime>& time) {
        return time ? time->seconds : -1.0;
    };
    out << "layers " << number(scene.heightMetres) << ' ' << number(scene.widthMetres) << ' '
        << scene.heightAttribute.value_or("") << ' ' << moment(scene.from) << ' '
        << moment(scene.until) << ' ' << whole(scene.waterKind) << ' '
        << scene.variable.value_or("") << ' ' << moment(scene.start) << ' '
        << number(scene.stepSeconds) << ' ' << number(scene.dryMetres) << ' ' << whole(scene.colors)
        << ' ' << number(scene.most) << ' ' << whole(scene.look) << ' '
        << scene.dataFolder.value_or("") << ' ' << number(scene.groundMetres) << '\n';
}

} // namespace

namespace {

std::string description(const PictureOptions& options) {
    std::ostringstream out;
    out.precision(17);
    out << GNOMON_VERSION << '\n';
    out << "scene " << options.benchScene.value_or("") << '\n';
    describe(out, options.scene);
    const FrameOptions& frame = options.frame;
    describe(out, frame.shadows);
    out << frame.maximumScreenSpaceError << '\n';
    out << frame.groundAuto << ' ' << frame.groundHeightMetres.value_or(-1e300) << '\n';
    out << options.widthPixels << 'x' << options.heightPixels << ' '
        << options.fovDegrees.value_or(kDefaultFovDegrees) << '\n';
    std::visit(SunText{out}, options.sun);
    if (options.fixedSun)
        out << " fixed " << options.fixedSun->azimuthDegrees << ' '
            << options.fixedSun->elevationDegrees;
    out << '\n';
    std::visit(CameraText{out}, options.camera);
    return out.str();
}

} // namespace

std::string settingsHash(const PictureOptions& options) {
    return hashOf(description(options));
}

std::string settingsHash(const CaptureOptions& options) {
    std::ostringstream out;
    out.precision(17);
    out << description(options.picture) << "\nfps " << options.framesPerSecond << " overlay "
        << options.overlay << ' ' << options.picture.timeZone.value_or("") << " aov";
    for (const Aov aov : options.aovs)
        out << ' ' << nameOf(aov);
    return hashOf(out.str());
}

double peakResidentMegabytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:"))
            return std::strtod(line.c_str() + 6, nullptr) * 1024.0 / kMegabyte;
    return 0.0;
}

std::string FrameReport::json() const {
    Json json = {{"version", GNOMON_VERSION}, {"renderer", renderer}};
    json["settings_hash"] = settingsHash;
    json["frames"] = Json::array();
    std::size_t peakGpuBytes = 0;
    for (const ReportedFrame& frame : frames) {
        json["frames"].push_back(frameJson(frame));
        peakGpuBytes = std::max(peakGpuBytes, frame.facts.gpuBytes);
    }
    if (!kept.empty())
        json["kept"] = kept;
    json["credits"] = credits;
    json["skipped"] = Json::array();
    for (const Error& error : skipped)
        json["skipped"].push_back({{"uri", textWithoutSecrets(error.subject)},
                                   {"reason", textWithoutSecrets(error.reason)}});
    json["time_to_full_detail_ms"] = fullDetailMs ? Json(*fullDetailMs) : Json(nullptr);
    json["peak_rss_mb"] = peakResidentMegabytes();
    json["peak_gpu_mb"] = double(peakGpuBytes) / kMegabyte;
    // Names from outside may be no UTF-8.
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

} // namespace gnomon
