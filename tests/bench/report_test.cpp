#include "bench/evaluate_report.h"

#include "bench/scenes.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <set>
#include <sstream>

using namespace gnomon;
using namespace gnomon::bench;

namespace {

ReportFacts facts() {
    ReportFacts f;
    f.inputs = {"city\xff/tileset.json"}; // not UTF-8: must not throw
    f.renderer = "some renderer";
    place(f.camera, {6.96, 50.94, 100.0}, {30.0, -20.0, 0.0});
    f.sun = sunFromAngles(225, 40, {6.96, 50.94, 0.0});
    f.raysPerPixel = 64;
    f.pixels = 1000;
    f.litFacing = 800;
    f.warnings = {"something"};
    return f;
}

Row row(const std::string& text, double ms) {
    Row r;
    r.technique = *parseOneTechnique(text, {});
    r.frameMs = ms;
    r.gpuMs = 0.5 * ms;
    r.depthMs = {1.0, 2.0};
    r.bytes = 16'000'000;
    r.texelMetres = {0.1, 0.4};
    Metrics& m = r.comparison.metrics;
    m.litFacing = 800;
    m.band = 0.05;
    m.falseLitAll = 0.0123;
    m.falseShadowAll = 0.00005;
    m.meanAbsolute = 0.002;
    r.lostCasters = 3;
    return r;
}

// What docs/ promises of a row.
constexpr const char* kKeys[] = {
    "name",       "bias",           "filter",          "cascades",
    "map_size",   "frame_ms",       "gpu_ms",          "depth_ms",
    "resolve_ms", "bytes",          "texel_metres",    "band",
    "false_lit",  "false_shadow",   "false_lit_all",   "false_shadow_all",
    "mae",        "rmse",           "edge_px",         "acne",
    "leak",       "penumbra_error", "peter_panning_m", "lost_casters",
    "technique"};

} // namespace

TEST(Report, JsonHasEveryKeyInEveryRowAndNullWhereNothingWasMeasured) {
    std::vector<Row> rows{row("csm+dual-peel+pcss:16,32", 100), row("single@map-size=512", 50),
                          row("paraboloid", 0), row("off", 40)};
    rows[0].resolveMs = 0.25;
    rows[1].flips = Flips{7, 1000};
    rows[2].error = Error{"paraboloid", "this scene has no lamp"};
    rows[3].comparison = {};
    const auto json = nlohmann::json::parse(reportJson(facts(), rows));
    for (const char* key : {"view", "reference", "techniques", "warnings"})
        EXPECT_TRUE(json.contains(key)) << key;
    for (const char* key : {"rays_per_pixel", "sun_diameter_deg", "pixels", "lit_facing", "ms"})
        EXPECT_TRUE(json["reference"].contains(key)) << key;
    ASSERT_EQ(json["techniques"].size(), 4u);
    for (const auto& each : json["techniques"])
        for (const char* key : kKeys)
            EXPECT_TRUE(each.contains(key)) << key;
    const auto& first = json["techniques"][0];
    EXPECT_EQ(first["name"], "csm");
    EXPECT_EQ(first["bias"], "dual-peel");
    EXPECT_EQ(first["filter"], "pcss:16,32");
    EXPECT_EQ(first["cascades"], 4);
    EXPECT_EQ(first["false_lit_all"], 0.0123);
    EXPECT_EQ(first["lost_casters"], 3);
    EXPECT_EQ(first["resolve_ms"], 0.25);
    EXPECT_TRUE(json["techniques"][1]["resolve_ms"].is_null());
    EXPECT_TRUE(first["edge_px"].is_null());
    EXPECT_FALSE(first.contains("flips"));
    EXPECT_EQ(json["techniques"][1]["flips"], 7);
    EXPECT_EQ(json["techniques"][1]["flips_asked"], 1000);
    EXPECT_EQ(json["techniques"][1]["map_size"], 512);
    EXPECT_EQ(json["techniques"][2]["name"], "paraboloid");
    EXPECT_EQ(json["techniques"][2]["error"], "this scene has no lamp");
    EXPECT_TRUE(json["techniques"][2]["frame_ms"].is_null());
    EXPECT_EQ(json["techniques"][3]["frame_ms"], 40);
    EXPECT_TRUE(json["techniques"][3]["mae"].is_null());
}

TEST(Report, TheTableIsAlignedAndInPercent) {
    const std::vector<Row> rows{row("csm+dual-peel+pcss:16,32", 100), row("single", 50)};
    std::istringstream text(reportTable(facts(), rows));
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);)
        if (line.starts_with("technique") || line.starts_with("csm") || line.starts_with("single"))
            lines.push_back(line);
    ASSERT_EQ(lines.size(), 3u);
    EXPECT_EQ(lines[0].size(), lines[1].size());
    EXPECT_EQ(lines[0].size(), lines[2].size());
    EXPECT_NE(lines[1].find(" 1.23 "), std::string::npos); // false lit
    EXPECT_NE(lines[1].find("<0.01"), std::string::npos);  // false shadow: some, but little
    EXPECT_NE(lines[2].find(" 0.50 "), std::string::npos); // half the first row's time
}

TEST(Report, TheListNamesEveryWordAndScene) {
    const std::string list = techniqueListing();
    for (const TechniqueWord& word : techniqueWords())
        EXPECT_NE(list.find(std::string("  ") + word.word + " "), std::string::npos) << word.word;
    for (const SceneDescription& scene : sceneDescriptions())
        EXPECT_NE(list.find(scene.name), std::string::npos) << scene.name;
    for (const Technique& technique : defaultTechniques({}))
        EXPECT_NE(list.find(technique.text), std::string::npos);
}

TEST(Report, FalseColoursTellTheVerdictsApart) {
    const Verdict verdicts[] = {Verdict::NotAsked,       Verdict::Right,
                                Verdict::FalseLit,       Verdict::FalseShadow,
                                Verdict::FalseLitInBand, Verdict::FalseShadowInBand};
    Picture scene{6, 1, std::vector<std::uint8_t>(18, 100)};
    const Picture out = errorPicture(scene, verdicts);
    ASSERT_EQ(out.rgb.size(), 18u);
    std::set<std::array<int, 3>> colours;
    for (std::size_t i = 0; i < 18; i += 3)
        colours.insert({out.rgb[i], out.rgb[i + 1], out.rgb[i + 2]});
    EXPECT_EQ(colours.size(), 5u); // what is not asked stays grey, as what is right
    EXPECT_EQ(out.rgb[0], out.rgb[1]);
    EXPECT_GT(out.rgb[6], out.rgb[8]);  // red
    EXPECT_GT(out.rgb[11], out.rgb[9]); // blue
}

TEST(Report, FileNamesAreSafeAndTellTechniquesApart) {
    EXPECT_EQ(fileNameOf("csm+dual-peel+pcss:16,32"), "csm+dual-peel+pcss-16-32");
    EXPECT_EQ(fileNameOf("csm+constant:0.5@map-size=512"), "csm+constant-0.5_map-size_512");
    EXPECT_EQ(fileNameOf("../a/b c"), "..-a-b-c");
}
