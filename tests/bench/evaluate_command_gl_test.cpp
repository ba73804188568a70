// `gnomon evaluate` as the shell sees it, and its options.
#include "tests/viewer/files.h"
#include "tests/viewer/program.h"
#include "viewer/options.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace gnomon;
using test::Ran;
using test::run;

namespace {

Result<CommandLine> parse(const std::vector<const char*>& arguments) {
    std::vector<std::string> all{"evaluate"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return parseCommandLine(all);
}
EvaluateOptions parsed(const std::vector<const char*>& arguments) {
    auto line = parse(arguments);
    EXPECT_TRUE(bool(line)) << (line ? "" : line.error().message());
    return line ? std::get<EvaluateOptions>(*line) : EvaluateOptions{};
}

constexpr const char* kSmall = "evaluate --scene l-shape --size 160x90 --rays 4 --frames-timed 1 "
                               "--device cpu ";

} // namespace

TEST(EvaluateOptions, TechniquesStartFromTheOptionsWhateverTheOrder) {
    const EvaluateOptions o = parsed({"a", "--techniques", "csm+dual-peel+pcss:4,8,single",
                                      "--map-size", "1024", "--bias", "slope", "b"});
    EXPECT_EQ(o.picture.scene.inputs, (std::vector<std::string>{"a", "b"}));
    ASSERT_EQ(o.techniques.size(), 2u);
    EXPECT_EQ(o.techniques[0].settings.mapSize, 1024);
    EXPECT_EQ(o.techniques[0].settings.bias, ShadowBias::DualPeel);
    EXPECT_EQ(o.techniques[1].settings.bias, ShadowBias::Slope);
    EXPECT_EQ(o.raysPerPixel, 64);
    EXPECT_EQ(o.framesTimed, 7);
    EXPECT_FALSE(o.countFlips);
    EXPECT_GT(parsed({"a"}).techniques.size(), 9u);
    EXPECT_EQ(parsed({"a", "--shadows", "single+slope+none"}).techniques.front().text,
              "single+slope+none");
}

TEST(EvaluateOptions, APathIsAFileOrNothing) {
    EXPECT_TRUE(parsed({"a", "--path"}).countFlips);
    EXPECT_FALSE(parsed({"a", "--path"}).pathFile);
    EXPECT_EQ(parsed({"a", "--path", "--json"}).pathFile, std::nullopt);
    EXPECT_EQ(parsed({"a", "--path", "f.json"}).pathFile, "f.json");
    EXPECT_EQ(parsed({"--path=f.json", "a"}).picture.scene.inputs.size(), 1u);
}

TEST(EvaluateOptions, WrongUsageIsSaid) {
    for (const auto& arguments :
         std::vector<std::vector<const char*>>{{},
                                               {"a", "--scene", "l-shape"},
                                               {"a", "--techniques", ""},
                                               {"a", "--techniques", "nonsense"},
                                               {"a", "--techniques", "csm@map-size=1"},
                                               {"a", "--rays", "0"},
                                               {"a", "--rays", "many"},
                                               {"a", "--frames-timed", "0"},
                                               {"a", "--images", ""},
                                               {"a", "--nonsense"}}) {
        const auto line = parse(arguments);
        ASSERT_FALSE(bool(line));
        EXPECT_EQ(line.error().kind, ErrorKind::Usage);
    }
    EXPECT_TRUE(parsed({"--list"}).list); // needs nothing else
}

TEST(Evaluate, ListsWithoutDrawing) {
    const Ran ran = run("evaluate --list", "DISPLAY= EGL_PLATFORM=none");
    EXPECT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(ran.err, "");
    for (const char* word : {"csm", "dual-atomic", "pcss-ratio", "paraboloid", "l-shape"})
        EXPECT_NE(ran.out.find(word), std::string::npos) << word;
}

TEST(Evaluate, JsonPicturesAndPlotOfASmallScene) {
    const test::Folder folder;
    const Ran ran = run(std::string(kSmall) +
                        "--techniques csm+receiver-plane+pcss:16,32,csm+constant:1+none,paraboloid "
                        "--json --images '" +
                        folder / "new/images" + "' --plot '" + folder / "p.svg" +
                        "' --frame-report '" + folder / "r.json" + "'");
    ASSERT_EQ(ran.code, 0) << ran.err;
    EXPECT_NE(ran.err.find("warning: paraboloid: this scene has no lamp"), std::string::npos);
    const auto json = nlohmann::json::parse(ran.out);
    ASSERT_EQ(json["techniques"].size(), 3u);
    const auto& good = json["techniques"][0];
    const auto& bad = json["techniques"][1];
    EXPECT_LT(good["false_lit"], 1e-3);
    EXPECT_LT(good["false_shadow"], 1e-3);
    EXPECT_GT(bad["false_lit_all"].get<double>(), good["false_lit_all"].get<double>());
    EXPECT_TRUE(json["techniques"][2].contains("error"));
    EXPECT_EQ(json["reference"]["rays_per_pixel"], 4);
    EXPECT_EQ(json["view"]["camera"]["size"], (nlohmann::json{160, 90}));
    for (const char* name :
         {"reference.png", "reference_hard.png", "csm+receiver-plane+pcss-16-32.png",
          "csm+receiver-plane+pcss-16-32_error.png", "csm+constant-1+none_error.png"})
        EXPECT_GT(std::filesystem::file_size(folder / "new/images" + "/" + name), 100u) << name;
    const auto report = nlohmann::json::parse(test::contentsOf(folder / "r.json"));
    EXPECT_EQ(report["frames"].size(), 3u); // a technique each
    EXPECT_NE(test::contentsOf(folder / "p.svg").find("csm+constant:1+none"), std::string::npos);
}

TEST(Evaluate, TheTableGoesToStdoutAndAPathAddsFlips) {
    const Ran ran = run(std::string(kSmall) + "--techniques csm+receiver-plane+none --path");
    ASSERT_EQ(ran.code, 0) << ran.err;
    EXPECT_NE(ran.out.find("flips"), std::string::npos);
    EXPECT_NE(ran.out.find("csm+receiver-plane+none"), std::string::npos);
    EXPECT_NE(ran.out.find("edge px"), std::string::npos);
}

TEST(Evaluate, ExitCodesTellWhatIsWrong) {
    const test::Folder folder;
    EXPECT_EQ(run("evaluate").code, 2);
    EXPECT_EQ(run("evaluate --scene nonsense").code, 2);
    EXPECT_EQ(run("evaluate '" + folder / "none" + "'").code, 65);
    EXPECT_EQ(run("evaluate --scene l-shape --plot '" + folder / "no/p.svg" + "'").code, 73);
    EXPECT_EQ(run("evaluate --scene l-shape --images /proc/no").code, 73);
    EXPECT_EQ(run("evaluate --scene l-shape --path '" + folder / "none.json" + "'").code, 65);
    const Ran stopped = run("evaluate --scene l-shape --device cpu --size 1280x720 --rays 4096",
                            "timeout --preserve-status -s INT 2");
    EXPECT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_EQ(stopped.out, "");
}
