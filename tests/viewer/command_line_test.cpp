// The program itself, as the shell sees it: exit codes, and what it says where.
#include "tests/viewer/files.h"
#include "tests/viewer/program.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace gnomon;
using test::Ran;
using test::run;

namespace {

void expectOneError(const Ran& ran, int code) {
    EXPECT_EQ(ran.code, code) << ran.err;
    EXPECT_EQ(ran.out, "");
    EXPECT_TRUE(ran.err.starts_with("error: ")) << ran.err;
    EXPECT_EQ(ran.err.find('\n'), ran.err.size() - 1) << ran.err;
}

} // namespace

TEST(CommandLine, HelpAndVersionGoToStdout) {
    const Ran version = run("--version");
    EXPECT_EQ(version.code, 0);
    EXPECT_TRUE(version.out.starts_with("gnomon "));
    EXPECT_EQ(version.err, "");
    EXPECT_EQ(run("--help").code, 0);
    EXPECT_NE(run("capture --help").out.find("--shadows"), std::string::npos);
}

TEST(CommandLine, WrongUsageIsCodeTwo) {
    for (const char* arguments :
         {"", "fly", "evaluate", "evaluate x --scene l-shape", "capture a",
          "capture a -o x.png --foo", "capture a -o x.gif", "capture a -o x.png --camera 1,2,3",
          "capture a -o x.png --frames 0-3", "capture a -o x.mp4", "info", "info x --offline",
          "info x --header 'no colon'", "info http://"}) {
        const Ran ran = run(arguments);
        EXPECT_EQ(ran.code, 2) << arguments << ": " << ran.err;
        EXPECT_TRUE(ran.err.starts_with("error: ")) << ran.err;
    }
}

TEST(CommandLine, AnInputThatCannotBeUsedIsCode65) {
    const test::Folder folder;
    expectOneError(run("capture '" + folder / "none" + "' -o '" + folder / "a.png" + "'"), 65);
    expectOneError(
        run("capture '" + folder.write("t.tif", "II*") + "' -o '" + folder / "a.png" + "'"), 65);
    expectOneError(
        run("capture x --camera '" + folder / "none.json" + "' -o '" + folder / "a.png" + "'"), 65);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

TEST(CommandLine, AnOutputThatCannotBeWrittenIsCode73AndKnownFirst) {
    const test::Folder folder;
    const Ran ran = run("capture '" + folder / "none" + "' -o '" + folder / "no/a.png" + "'");
    expectOneError(ran, 73);
    EXPECT_NE(ran.err.find("no/a.png"), std::string::npos);
    expectOneError(run("capture x -o '" + folder / "a.png" + "' --frame-report /proc/r.json"), 73);
}

TEST(CommandLine, DemoThenInfoTellsWhatWasWritten) {
    const test::Folder folder;
    const Ran demo = run("demo '" + folder / "p" + "' --size 3 --at 179.9999,-16.5");
    ASSERT_EQ(demo.code, 0) << demo.err;
    EXPECT_EQ(demo.out, "");
    const Ran info = run("info '" + folder / "p" + "' --json");
    ASSERT_EQ(info.code, 0) << info.err;
    const auto json = nlohmann::json::parse(info.out);
    std::vector<std::string> kinds; // as the scene names them
    for (const auto& one : json["inputs"])
        kinds.push_back(one["kind"]);
    EXPECT_EQ(kinds, (std::vector<std::string>{"tileset", "terrain", "barriers", "stage"}));
    const auto& input = json["inputs"][0];
    for (const char* key : {"uri", "kind", "version", "crs", "heights", "tiles", "subtrees",
                            "contents", "missing", "triangles", "duplicates", "closed_share",
                            "levels", "refine", "bounds", "size", "steps", "extensions", "credits"})
        EXPECT_TRUE(input.contains(key)) << key;
    EXPECT_EQ(input["kind"], "tileset");
    EXPECT_EQ(input["version"], "1.1");
    EXPECT_GT(input["bounds"]["west"], 179); // across the antimeridian
    EXPECT_LT(input["bounds"]["east"], -179);
    EXPECT_TRUE(json["problems"].empty());
    EXPECT_NE(run("info '" + folder / "p" + "'").out.find("triangles"), std::string::npos);
}

TEST(CommandLine, InfoNamesWhatIsMissingWithCodeThree) {
    const test::Folder folder;
    ASSERT_EQ(run("demo '" + folder / "p" + "' --size 3").code, 0);
    std::string victim;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "p"))
        if (entry.path().extension() == ".glb")
            victim = std::max(victim, entry.path().string());
    ASSERT_FALSE(victim.empty());
    std::filesystem::remove(victim);
    const Ran info = run("info '" + folder / "p" + "' --json");
    EXPECT_EQ(info.code, 3);
    const auto json = nlohmann::json::parse(info.out);
    ASSERT_EQ(json["inputs"][0]["missing"].size(), 1u);
    const std::string name = std::filesystem::path(victim).filename().string();
    EXPECT_NE(json["inputs"][0]["missing"][0]["uri"].get<std::string>().find(name),
              std::string::npos);
    EXPECT_NE(info.err.find(name), std::string::npos);
}

TEST(CommandLine, InfoOfNothingUsableIsStillJson) {
    const test::Folder folder;
    const Ran info = run("info '" + folder / "none" + "' --json");
    EXPECT_EQ(info.code, 65);
    const auto json = nlohmann::json::parse(info.out);
    EXPECT_TRUE(json["inputs"].empty());
    EXPECT_EQ(json["problems"][0]["severity"], "error");
}
