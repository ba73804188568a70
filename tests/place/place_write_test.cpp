// The files: the same bytes every time, what depends on what, and what happens when it cannot.
#include "viewer/place/place.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <unistd.h>

namespace gnomon {
namespace {

namespace fs = std::filesystem;

class PlaceFiles : public ::testing::Test {
  protected:
    PlaceFiles() {
        folder_ = fs::temp_directory_path() /
                  ("gnomon_place_" + std::to_string(::getpid()) + "_" +
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
    }
    ~PlaceFiles() override { fs::remove_all(folder_); }

    PlaceFacts write(const std::string& name, PlaceOptions options) {
        options.folder = (folder_ / name).string();
        auto facts = writePlace(options);
        EXPECT_TRUE(facts) << facts.error().message();
        return *facts;
    }
    std::map<std::string, std::string> read(const std::string& name) const {
        std::map<std::string, std::string> files;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / name))
            if (entry.is_regular_file()) {
                std::ifstream file(entry.path(), std::ios::binary);
                files[fs::relative(entry.path(), folder_ / name).string()] =
                    std::string(std::istreambuf_iterator<char>(file), {});
            }
        return files;
    }
    fs::path folder_;
};

PlaceOptions of(std::size_t buildings, std::uint64_t seed = 1) {
    PlaceOptions options;
    options.buildings = buildings;
    options.seed = seed;
    return options;
}

TEST_F(PlaceFiles, AreTheSameBytesEveryTime) {
    const PlaceFacts facts = write("a", of(60));
    write("b", of(60));
    const auto a = read("a");
    EXPECT_EQ(a, read("b"));
    EXPECT_EQ(facts.files, a.size());
    std::uint64_t bytes = 0;
    for (const auto& [_, text] : a)
        bytes += text.size();
    EXPECT_EQ(facts.bytes, bytes);
    EXPECT_EQ(facts.buildings, 60u);
    EXPECT_GT(facts.trees, 100u);
    EXPECT_GT(facts.triangles, 20000u);
}

TEST_F(PlaceFiles, DifferWithTheSeed) {
    write("a", of(20, 1));
    write("b", of(20, 2));
    const auto a = read("a"), b = read("b");
    EXPECT_NE(a.at("content/0.0.0.glb"), b.at("content/0.0.0.glb"));
    EXPECT_NE(a.at("content/2.2.2.glb"), b.at("content/2.2.2.glb"));
}

TEST_F(PlaceFiles, OfAnotherPlaceDifferOnlyInWhereItIs) {
    PlaceOptions pole = of(5);
    pole.at = {0, 90, 12};
    write("a", of(5));
    write("b", pole);
    auto a = read("a"), b = read("b");
    for (const char* name : {"tileset.json", "place.scene.json", "flight.json"}) {
        EXPECT_NE(a.at(name), b.at(name));
        a.erase(name);
        b.erase(name);
    }
    EXPECT_EQ(a, b);
}

TEST_F(PlaceFiles, MayHoldNoBuildingOrOne) {
    EXPECT_EQ(write("none", of(0)).buildings, 0u);
    EXPECT_EQ(write("one", of(1)).buildings, 1u);
}

TEST_F(PlaceFiles, SayWhatTheyAre) {
    const PlaceFacts facts = write("a", of(5));
    const auto files = read("a");
    const auto tileset = nlohmann::json::parse(files.at("tileset.json"));
    EXPECT_EQ(tileset["asset"]["version"], "1.1");
    const auto& root = tileset["root"];
    EXPECT_EQ(root["refine"], "REPLACE");
    EXPECT_EQ(root["implicitTiling"]["subdivisionScheme"], "QUADTREE");
    EXPECT_EQ(root["implicitTiling"]["availableLevels"], facts.levels);
    EXPECT_GT(facts.subtrees, 1u); // children subtrees too
    const auto scene = nlohmann::json::parse(files.at("place.scene.json"));
    EXPECT_EQ(scene["layers"][0]["tileset"], "tileset.json");
    EXPECT_TRUE(scene["camera"].contains("heading"));
    EXPECT_EQ(nlohmann::json::parse(files.at("flight.json"))["interpolation"], "smooth");
    for (const auto& [name, text] : files)
        if (name.ends_with(".glb")) {
            ASSERT_EQ(text.substr(0, 4), "glTF") << name;
            ASSERT_EQ(text.size() % 8, 0u) << name;
        } else if (name.ends_with(".subtree")) {
            ASSERT_EQ(text.substr(0, 4), "subt") << name;
            ASSERT_EQ(text.size() % 8, 0u) << name;
        }
}

TEST_F(PlaceFiles, ReportProgressThatRisesToOne) {
    PlaceOptions options = of(5);
    options.folder = (folder_ / "a").string();
    double last = 0;
    ASSERT_TRUE(writePlace(options, [&](double fraction) {
        EXPECT_GE(fraction, last);
        last = fraction;
    }));
    EXPECT_EQ(last, 1.0);
}

TEST_F(PlaceFiles, ThatCannotBeWrittenAreAnOutputError) {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "file") << "not a folder";
    PlaceOptions options = of(1);
    options.folder = (folder_ / "file" / "below").string();
    const auto result = writePlace(options);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::Output);
    EXPECT_NE(result.error().message().find(options.folder), std::string::npos);
    // A folder that is there, but where one of its files is in the way.
    fs::create_directories(folder_ / "a" / "tileset.json");
    options.folder = (folder_ / "a").string();
    const auto blocked = writePlace(options);
    ASSERT_FALSE(blocked);
    EXPECT_EQ(blocked.error().kind, ErrorKind::Output);
    EXPECT_NE(blocked.error().message().find("tileset.json"), std::string::npos);
}

TEST_F(PlaceFiles, RefuseWhatMakesNoSense) {
    PlaceOptions options = of(1);
    options.folder = (folder_ / "a").string();
    options.at.latitudeDegrees = 91;
    EXPECT_EQ(writePlace(options).error().kind, ErrorKind::Usage);
    options = of(std::size_t(1) << 40);
    options.folder = (folder_ / "a").string();
    EXPECT_EQ(writePlace(options).error().kind, ErrorKind::Usage);
    EXPECT_FALSE(fs::exists(folder_ / "a"));
}

} // namespace
} // namespace gnomon
