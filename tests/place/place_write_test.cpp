// The files: the same bytes every time, what depends on what, and what happens when it cannot.
#include "viewer/place/place.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <unistd.h>
#include <vector>

namespace gnomon {
namespace {

namespace fs = std::filesystem;

PlaceOptions of(std::size_t buildings, std::uint64_t seed = 1) {
    PlaceOptions options;
    options.buildings = buildings;
    options.seed = seed;
    return options;
}

// Relative names and bytes of all files below.
using Files = std::map<std::string, std::string>;

class PlaceFiles : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = fs::temp_directory_path() / ("gnomon_place_" + std::to_string(::getpid()));
        fs::remove_all(folder_);
        PlaceOptions options = of(60);
        options.folder = (folder_ / "first").string();
        const auto facts =
            writePlace(options, [](double fraction) { progress_.push_back(fraction); });
        ASSERT_TRUE(facts) << facts.error().message();
        firstFacts_ = *facts;
        first_ = read("first");
    }
    static void TearDownTestSuite() { fs::remove_all(folder_); }

    static Files write(const std::string& name, PlaceOptions options) {
        options.folder = (folder_ / name).string();
        const auto facts = writePlace(options);
        EXPECT_TRUE(facts) << facts.error().message();
        EXPECT_EQ(facts->buildings, options.buildings);
        return read(name);
    }
    static Files read(const std::string& name) {
        Files files;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / name))
            if (entry.is_regular_file()) {
                std::ifstream file(entry.path(), std::ios::binary);
                files[fs::relative(entry.path(), folder_ / name).string()] =
                    std::string(std::istreambuf_iterator<char>(file), {});
            }
        return files;
    }

    static inline fs::path folder_;
    static inline PlaceFacts firstFacts_;
    static inline Files first_;
    static inline std::vector<double> progress_;
};

TEST_F(PlaceFiles, AreTheSameBytesEveryTime) {
    EXPECT_EQ(write("again", of(60)), first_);
}

TEST_F(PlaceFiles, DifferWithTheSeed) {
    const Files other = write("seed", of(60, 2));
    EXPECT_NE(other.at("content/0.0.0.glb"), first_.at("content/0.0.0.glb"));
    EXPECT_NE(other.at("content/2.2.2.glb"), first_.at("content/2.2.2.glb"));
}

TEST_F(PlaceFiles, OfAnotherPlaceDifferOnlyInWhereItIs) {
    PlaceOptions pole = of(60);
    pole.at = {0, 90, 12};
    Files here = first_, there = write("pole", pole);
    for (const char* name : {"tileset.json", "place.scene.json", "lamps.geojson", "flight.json",
                             "terrain.tif", "flood.tif", "outline.geojson", "barriers.geojson"}) {
        EXPECT_NE(here.at(name), there.at(name));
        here.erase(name);
        there.erase(name);
    }
    EXPECT_EQ(here, there);
}

TEST_F(PlaceFiles, MayHoldNoBuildingOrOne) {
    write("none", of(0));
    write("one", of(1));
}

TEST_F(PlaceFiles, AreCounted) {
    EXPECT_EQ(firstFacts_.files, first_.size());
    std::uint64_t bytes = 0;
    for (const auto& [_, text] : first_)
        bytes += text.size();
    EXPECT_EQ(firstFacts_.bytes, bytes);
    EXPECT_EQ(firstFacts_.buildings, 60u);
    EXPECT_GT(firstFacts_.trees, 100u);
    EXPECT_GT(firstFacts_.triangles, 20000u);
}

TEST_F(PlaceFiles, SayWhatTheyAre) {
    const auto tileset = nlohmann::json::parse(first_.at("tileset.json"));
    EXPECT_EQ(tileset["asset"]["version"], "1.1");
    const auto& root = tileset["root"];
    EXPECT_EQ(root["refine"], "REPLACE");
    EXPECT_EQ(root["implicitTiling"]["subdivisionScheme"], "QUADTREE");
    EXPECT_EQ(root["implicitTiling"]["availableLevels"], firstFacts_.levels);
    EXPECT_GT(firstFacts_.subtrees, 1u); // child subtrees too
    const auto scene = nlohmann::json::parse(first_.at("place.scene.json"));
    EXPECT_EQ(scene["layers"][0]["tileset"], "tileset.json");
    std::set<std::string> named; // each is there
    for (const auto& layer : scene["layers"])
        for (const char* kind : {"tileset", "terrain", "stage", "barriers", "lamps", "hole"})
            if (layer.contains(kind))
                named.insert(layer[kind]);
    EXPECT_EQ(named, (std::set<std::string>{"tileset.json", "terrain.tif", "outline.geojson",
                                            "flood.tif", "barriers.geojson", "lamps.geojson"}));
    for (const std::string& name : named)
        EXPECT_TRUE(first_.count(name)) << name;
    EXPECT_GT(nlohmann::json::parse(first_.at("lamps.geojson"))["features"].size(), 8u);
    EXPECT_TRUE(scene["camera"].contains("heading"));
    EXPECT_EQ(nlohmann::json::parse(first_.at("flight.json"))["interpolation"], "smooth");
    for (const auto& [name, text] : first_)
        if (name.ends_with(".glb")) {
            ASSERT_EQ(text.substr(0, 4), "glTF") << name;
            ASSERT_EQ(text.size() % 8, 0u) << name;
        } else if (name.ends_with(".subtree")) {
            ASSERT_EQ(text.substr(0, 4), "subt") << name;
            ASSERT_EQ(text.size() % 8, 0u) << name;
        }
}

TEST_F(PlaceFiles, ReportProgressThatRisesToOne) {
    ASSERT_GT(progress_.size(), 4u);
    EXPECT_TRUE(std::is_sorted(progress_.begin(), progress_.end()));
    EXPECT_EQ(progress_.back(), 1.0);
}

TEST_F(PlaceFiles, ThatCannotBeWrittenAreAnOutputError) {
    std::ofstream(folder_ / "file") << "not a folder";
    PlaceOptions options = of(1);
    options.folder = (folder_ / "file" / "below").string();
    const auto result = writePlace(options);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::Output);
    EXPECT_NE(result.error().message().find(options.folder), std::string::npos);
    // A folder that is there, but where one of its files is in the way.
    fs::create_directories(folder_ / "blocked" / "content" / "2.0.0.glb");
    options.folder = (folder_ / "blocked").string();
    const auto blocked = writePlace(options);
    ASSERT_FALSE(blocked);
    EXPECT_EQ(blocked.error().kind, ErrorKind::Output);
    EXPECT_NE(blocked.error().message().find("2.0.0.glb"), std::string::npos);
}

TEST_F(PlaceFiles, RefuseWhatMakesNoSense) {
    PlaceOptions options = of(1);
    options.folder = (folder_ / "refused").string();
    options.at.latitudeDegrees = 91;
    EXPECT_EQ(writePlace(options).error().kind, ErrorKind::Usage);
    options = of(std::size_t(1) << 40);
    options.folder = (folder_ / "refused").string();
    EXPECT_EQ(writePlace(options).error().kind, ErrorKind::Usage);
    EXPECT_FALSE(fs::exists(folder_ / "refused"));
}

} // namespace
} // namespace gnomon
