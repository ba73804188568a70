#include "bench/evaluate_report.h"

#include "bench/scenes.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>

namespace gnomon::bench {

namespace {

using Json = nlohmann::ordered_json;

template <class... Values>
std::string print(const char* format, Values... values) {
    char text[160];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

// ---- The table -------------------------------------------------------------------------------

std::string number(const std::optional<double>& value, const char* format) {
    return value ? print(format, *value) : "-";
}
std::string percent(double share) {
    if (share == 0.0)
        return "0";
    return share < 0.0001 ? "<0.01" : print("%.2f", 100.0 * share);
}
std::string counted(const std::optional<std::uint64_t>& value) {
    return value ? std::to_string(*value) : "-";
}

struct Column {
    const char* head;
    std::function<std::string(const Row&)> cell; // of a row that was measured
    bool needsError = true;                      // and held against rays
};

std::vector<Column> columns(std::span<const Row> rows) {
    const auto timed =
        std::find_if(rows.begin(), rows.end(), [](const Row& r) { return !r.error; });
    const double first = timed == rows.end() ? 0.0 : timed->frameMs;
    const auto metric = [](double Metrics::*value) {
        return [value](const Row& r) { return percent(r.comparison.metrics.*value); };
    };
    std::vector<Column> columns = {
        {"frame ms", [](const Row& r) { return print("%.1f", r.frameMs); }, false},
        {"ratio",
         [first](const Row& r) { return first > 0.0 ? print("%.2f", r.frameMs / first) : "-"; },
         false},
        {"gpu ms", [](const Row& r) { return print("%.1f", r.gpuMs); }, false},
        {"MB", [](const Row& r) { return print("%.1f", double(r.bytes) / 1e6); }, false},
        {"band %", metric(&Metrics::band)},
        {"lit %", metric(&Metrics::falseLit)},
        {"dark %", metric(&Metrics::falseShadow)},
        {"all lit", metric(&Metrics::falseLitAll)},
        {"all dark", metric(&Metrics::falseShadowAll)},
        {"mae", [](const Row& r) { return print("%.4f", r.comparison.metrics.meanAbsolute); }},
        {"rmse", [](const Row& r) { return print("%.4f", r.comparison.metrics.rootMeanSquare); }},
        {"edge px", [](const Row& r) { return number(r.comparison.metrics.edgePixels, "%.2f"); }},
        {"acne %", metric(&Metrics::acne)},
        {"leak %", metric(&Metrics::leak)},
        {"lost", [](const Row& r) { return counted(r.lostCasters); }},
    };
    const auto has = [&](auto wanted) { return std::any_of(rows.begin(), rows.end(), wanted); };
    const auto addOptional = [&](const char* head, const char* format,
                                 std::optional<double> Metrics::*value) {
        if (has([value](const Row& r) { return (r.comparison.metrics.*value).has_value(); }))
            columns.push_back({head, [value, format](const Row& r) {
                                   return number(r.comparison.metrics.*value, format);
                               }});
    };
    addOptional("penumbra err", "%.3f", &Metrics::penumbraError);
    addOptional("width tx", "%.1f", &Metrics::penumbraTexels);
    addOptional("panning m", "%.3f", &Metrics::peterPanningMetres);
    if (has([](const Row& r) { return r.flips.has_value(); }))
        columns.push_back(
            {"flips", [](const Row& r) { return r.flips ? std::to_string(r.flips->flips) : "-"; }});
    return columns;
}

std::string heading(const ReportFacts& f) {
    const Geodetic place = geodeticOf(f.camera.position);
    const Orientation o = orientationOf(f.camera);
    std::string text;
    for (const std::string& input : f.inputs)
        text += (text.empty() ? "" : ", ") + input;
    text += print("\nview       %.7f,%.7f,%.2f heading %.1f pitch %.1f, %d x %d, fov %.3g\n",
                  place.longitudeDegrees, place.latitudeDegrees, place.heightMetres,
                  o.headingDegrees, o.pitchDegrees, f.camera.widthPixels, f.camera.heightPixels,
                  f.camera.verticalFovRadians / kRadiansPerDegree);
    text += print("sun        azimuth %.2f elevation %.2f, %.3f degrees across\n",
                  f.sun.azimuthDegrees, f.sun.elevationDegrees, f.sunDiameterDegrees);
    text +=
        print("reference  %d rays a pixel, %llu pixels, %llu of them facing the light in range, "
              "%.1f s\n",
              f.raysPerPixel, static_cast<unsigned long long>(f.pixels),
              static_cast<unsigned long long>(f.litFacing), f.referenceMs / 1e3);
    return text + "renderer   " + f.renderer + "\n\n";
}

constexpr const char* kLegend =
    "\nratio: to the first row. lit, dark: wrongly lit and wrongly dark pixels outside the edge "
    "band (band: its\nshare), all lit, all dark: in the whole picture; of the pixels facing the "
    "sun in range. mae, rmse: of the\nlight's share. edge: between contours. acne: dark far from "
    "any shadow. leak: lit at an occluder's foot.\nlost: casters in no map. Techniques with pcss "
    "are held against the whole disc, others against its centre.\n";

// ---- JSON ------------------------------------------------------------------------------------

template <class T>
Json orNull(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json viewJson(const ReportFacts& f) {
    const Geodetic place = geodeticOf(f.camera.position);
    const Orientation o = orientationOf(f.camera);
    return {{"inputs", f.inputs},
            {"camera",
             {{"lon", place.longitudeDegrees},
              {"lat", place.latitudeDegrees},
              {"height", place.heightMetres},
              {"heading", o.headingDegrees},
              {"pitch", o.pitchDegrees},
              {"roll", o.rollDegrees},
              {"fov", f.camera.verticalFovRadians / kRadiansPerDegree},
              {"size", {f.camera.widthPixels, f.camera.heightPixels}}}},
            {"sun", {{"azimuth", f.sun.azimuthDegrees}, {"elevation", f.sun.elevationDegrees}}},
            {"renderer", f.renderer},
            {"frames_timed", f.framesTimed}};
}

// What the technique is.
Json nameJson(const Technique& t) {
    const ShadowSettings& s = t.settings;
    const std::string word = t.text.substr(0, t.text.find_first_of("@"));
    Json json = {{"technique", t.text}, {"name", t.ofLamps ? word : methodText(s)}};
    json["bias"] = nameOf(s.bias);
    json["bias_metres"] = orNull(s.biasMetres);
    json["filter"] = filterText(s);
    json["cascades"] = s.cascades;
    json["map_size"] = s.mapSize;
    return json;
}

Json rowJson(const Row& row) {
    Json json = nameJson(row.technique);
    const bool measured = !row.error;
    const Metrics& m = row.comparison.metrics;
    const bool compared = measured && m.litFacing > 0;
    const auto timed = [&](double value) { return measured ? Json(value) : Json(nullptr); };
    const auto share = [&](double value) { return compared ? Json(value) : Json(nullptr); };
    json["frame_ms"] = timed(row.frameMs);
    json["gpu_ms"] = timed(row.gpuMs);
    json["visibility_ms"] = timed(row.visibilityMs);
    json["depth_ms"] = measured ? Json(row.depthMs) : Json(nullptr);
    json["resolve_ms"] = orNull(row.resolveMs);
    json["sun_ms"] = timed(row.sunMs);
    json["bytes"] = measured ? Json(row.bytes) : Json(nullptr);
    json["texel_metres"] = measured ? Json(row.texelMetres) : Json(nullptr);
    json["lit_facing"] = compared ? Json(m.litFacing) : Json(nullptr);
    json["band"] = share(m.band);
    json["false_lit"] = share(m.falseLit);
    json["false_shadow"] = share(m.falseShadow);
    json["false_lit_all"] = share(m.falseLitAll);
    json["false_shadow_all"] = share(m.falseShadowAll);
    json["mae"] = share(m.meanAbsolute);
    json["rmse"] = share(m.rootMeanSquare);
    json["edge_px"] = orNull(m.edgePixels);
    json["acne"] = share(m.acne);
    json["leak"] = share(m.leak);
    json["penumbra_error"] = orNull(m.penumbraError);
    json["penumbra_texels"] = orNull(m.penumbraTexels);
    json["peter_panning_m"] = orNull(m.peterPanningMetres);
    json["lost_casters"] = orNull(row.lostCasters);
    if (row.flips) {
        json["flips"] = row.flips->flips;
        json["flips_asked"] = row.flips->asked;
    }
    if (row.error)
        json["error"] = row.error->reason;
    return json;
}

// ---- The list --------------------------------------------------------------------------------

std::string wordsOf(TechniqueWord::Part part, const char* heading) {
    std::string text = std::string(heading) + "\n";
    for (const TechniqueWord& word : techniqueWords())
        if (word.part == part)
            text += print("  %-16s %s\n", word.word, word.meaning);
    return text;
}

} // namespace

std::string reportTable(const ReportFacts& facts, std::span<const Row> rows) {
    const std::vector<Column> all = columns(rows);
    std::vector<std::vector<std::string>> lines{{"technique"}};
    for (const Column& column : all)
        lines[0].push_back(column.head);
    for (const Row& row : rows) {
        std::vector<std::string>& line = lines.emplace_back(1, row.technique.text);
        for (const Column& column : all) {
            const bool known =
                !row.error && (!column.needsError || row.comparison.metrics.litFacing > 0);
            line.push_back(known ? column.cell(row) : "-");
        }
    }
    std::vector<std::size_t> widths(lines[0].size(), 0);
    for (const auto& line : lines)
        for (std::size_t i = 0; i < line.size(); ++i)
            widths[i] = std::max(widths[i], line[i].size());
    std::string text = heading(facts);
    for (const auto& line : lines) {
        text += line[0] + std::string(widths[0] - line[0].size(), ' ');
        for (std::size_t i = 1; i < line.size(); ++i)
            text += std::string(2 + widths[i] - line[i].size(), ' ') + line[i];
        text += "\n";
    }
    return text + kLegend;
}

std::string reportJson(const ReportFacts& facts, std::span<const Row> rows) {
    Json json;
    json["view"] = viewJson(facts);
    json["reference"] = {{"rays_per_pixel", facts.raysPerPixel},
                         {"sun_diameter_deg", facts.sunDiameterDegrees},
                         {"pixels", facts.pixels},
                         {"lit_facing", facts.litFacing},
                         {"ms", facts.referenceMs}};
    json["techniques"] = Json::array();
    for (const Row& row : rows)
        json["techniques"].push_back(rowJson(row));
    json["warnings"] = facts.warnings;
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string techniqueListing() {
    using Part = TechniqueWord::Part;
    std::string text = "A technique is SHADOWS+BIAS+FILTER, of which the last two may be left "
                       "out, or a lamps' word.\n\n";
    text += wordsOf(Part::Shadows, "SHADOWS") + "\n" + wordsOf(Part::Bias, "BIAS") + "\n";
    text += wordsOf(Part::Filter, "FILTER") + "\n" + wordsOf(Part::Lamps, "LAMPS") + "\n";
    text += "and may go on with @KEY=VALUE, for instance "
            "csm+constant:0.5+none@map-size=512@cascades=1\n"
            "  map-size, cascades, lambda, fit, cull, blend, range, fade, light-size\n\n"
            "Compared when no --techniques are given, as --shadows and its like say else\n";
    for (const Technique& technique : defaultTechniques({}))
        text += "  " + technique.text + "\n";
    for (const Technique& technique : defaultLampTechniques({}))
        text += "  " + technique.text + " (where there are lamps)\n";
    text += "\nScenes for --scene\n";
    for (const SceneDescription& scene : sceneDescriptions())
        text += print("  %-16s ", scene.name) + scene.about + "\n";
    return text;
}

Picture visibilityPicture(int width, int height, std::span<const float> visibility) {
    Picture picture{width, height, {}};
    picture.rgb.reserve(visibility.size() * 3);
    for (const float v : visibility) {
        constexpr std::array<std::uint8_t, 3> kSky{176, 200, 226};
        const auto grey = std::uint8_t(std::lround(255.0f * std::clamp(v, 0.0f, 1.0f)));
        for (const std::uint8_t sky : kSky)
            picture.rgb.push_back(v < 0.0f ? sky : grey);
    }
    return picture;
}

Picture errorPicture(const Picture& scene, std::span<const Verdict> verdicts) {
    Picture picture = scene;
    for (std::size_t i = 0; i < verdicts.size(); ++i) {
        const std::uint8_t* rgb = &scene.rgb[3 * i];
        // Rec. 709's weights; between the extremes, so that the colours stand out.
        const double luma = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        const auto grey = std::uint8_t(std::lround(70.0 + 0.6 * luma));
        std::array<std::uint8_t, 3> colour{grey, grey, grey};
        switch (verdicts[i]) {
        case Verdict::FalseLit:
            colour = {230, 30, 20};
            break;
        case Verdict::FalseLitInBand:
            colour = {255, 170, 70};
            break;
        case Verdict::FalseShadow:
            colour = {30, 50, 255};
            break;
        case Verdict::FalseShadowInBand:
            colour = {90, 220, 255};
            break;
        case Verdict::NotAsked:
        case Verdict::Right:
            break;
        }
        std::copy(colour.begin(), colour.end(), picture.rgb.begin() + std::ptrdiff_t(3 * i));
    }
    return picture;
}

std::string fileNameOf(const std::string& technique) {
    std::string name;
    for (const char c : technique) {
        const bool kept = std::isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '-' ||
                          c == '.' || c == '_';
        name += kept ? c : c == '@' || c == '=' ? '_' : '-';
    }
    return name;
}

} // namespace gnomon::bench
