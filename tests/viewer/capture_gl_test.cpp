// `gnomon capture` from end to end, on Mesa's software rasteriser.
#include "tests/viewer/files.h"
#include "tests/viewer/program.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>

using namespace gnomon;
using test::Ran;
using test::run;

namespace {

// One small place for all tests here.
class Capture : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        place_ = new test::Folder;
        ASSERT_EQ(run("demo '" + place() + "' --size 20").code, 0);
    }
    static void TearDownTestSuite() {
        delete place_;
        place_ = nullptr;
    }
    static std::string place() { return *place_ / "p"; }
    // Small pictures: llvmpipe pays by the pixel.
    static Ran capture(const std::string& output, const std::string& more,
                       const std::string& input = place(), const std::string& before = "") {
        return run("capture '" + input + "' -o '" + output +
                       "' --device cpu --size 160x90 --map-size 512 " + more,
                   before);
    }
    test::Folder folder_;

  private:
    static test::Folder* place_;
};
test::Folder* Capture::place_ = nullptr;

std::string withoutNotes(const std::string& lines) {
    std::istringstream text(lines);
    std::string rest;
    for (std::string line; std::getline(text, line);)
        if (!line.starts_with("note: "))
            rest += line + "\n";
    return rest;
}

struct Pixels {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};
Pixels pixelsOf(const std::string& path) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input)
        return {};
    Pixels pixels{input->spec().width, input->spec().height, {}};
    pixels.rgb.resize(std::size_t(3 * pixels.width * pixels.height));
    input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.rgb.data());
    return pixels;
}

} // namespace

TEST_F(Capture, WritesAPictureItsAovsAndAReport) {
    const Ran ran = capture(folder_ / "a.png", "--time 2021-06-21T14:00Z --aov "
                                               "sun,depth,normal,cascade,tile --frame-report '" +
                                                   folder_ / "r.json" + "'");
    ASSERT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(ran.out, "");
    EXPECT_EQ(folder_.files(), 7u);
    const auto report = nlohmann::json::parse(test::contentsOf(folder_ / "r.json"));
    ASSERT_EQ(report["frames"].size(), 1u);
    const auto& frame = report["frames"][0];
    EXPECT_EQ(frame["time_utc"], "2021-06-21T14:00:00Z");
    // Hour angle 36.5 degrees, declination 23.44: by the spherical triangle, west of south.
    EXPECT_NEAR(frame["sun"]["azimuth"].get<double>(), 239.5, 0.5);
    EXPECT_GT(frame["tiles"]["selected"], 0);
    EXPECT_TRUE(frame["tiles"]["missing"].empty());
    EXPECT_EQ(frame["cascades"].size(), 4u);
    EXPECT_GT(report["time_to_full_detail_ms"], 0);
    for (const auto& [name, plugin, channels] :
         {std::tuple{"a.sun.exr", "openexr", 1}, std::tuple{"a.depth.exr", "openexr", 1},
          std::tuple{"a.normal.exr", "openexr", 3}, std::tuple{"a.cascade.png", "png", 1},
          std::tuple{"a.tile.exr", "openexr", 1}}) {
        OIIO::ImageSpec spec;
        const auto input = OIIO::ImageInput::create(plugin);
        ASSERT_TRUE(input->open(folder_ / name, spec)) << name;
        EXPECT_EQ(spec.width, 160);
        EXPECT_EQ(spec.height, 90);
        EXPECT_EQ(spec.nchannels, channels);
        std::vector<float> values(std::size_t(160 * 90 * channels));
        ASSERT_TRUE(input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data()));
        if (std::string(name) == "a.tile.exr") {
            for (const float id : values) {
                ASSERT_LT(id, float(frame["tiles"]["ids"].size()));
            }
        }
        if (std::string(name) == "a.sun.exr") {
            for (const float sun : values) {
                ASSERT_TRUE(sun == -1.0f || (sun >= 0.0f && sun <= 1.0f)) << sun;
            }
        }
    }
}

TEST_F(Capture, IsTheSameToTheByteWhenRepeated) {
    ASSERT_EQ(capture(folder_ / "a.png", "--sun 220,30").code, 0);
    ASSERT_EQ(capture(folder_ / "b.png", "--sun 220,30").code, 0);
    EXPECT_EQ(test::contentsOf(folder_ / "a.png"), test::contentsOf(folder_ / "b.png"));
}

TEST_F(Capture, FollowsAFlightIntoNumberedFrames) {
    const Ran ran = capture(folder_ / "f{frame:03}.png",
                            "--camera '" + place() + "/flight.json' --frames 0-20:10");
    ASSERT_EQ(ran.code, 0) << ran.err;
    EXPECT_EQ(folder_.files(), 3u);
    EXPECT_NE(test::contentsOf(folder_ / "f000.png"), test::contentsOf(folder_ / "f020.png"));
}

TEST_F(Capture, ATileThatIsGoneIsNamedAndTheRestIsDrawn) {
    std::filesystem::copy(place(), folder_ / "p", std::filesystem::copy_options::recursive);
    std::string victim;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "p"))
        if (entry.path().extension() == ".glb")
            victim = std::max(victim, entry.path().string());
    std::ofstream(victim, std::ios::binary) << "no glb";
    const Ran ran = capture(folder_ / "a.png",
                            "--sun 220,30 --sse 0.1 --frame-report '" + folder_ / "r.json" + "'",
                            folder_ / "p");
    EXPECT_EQ(ran.code, 3) << ran.err;
    const std::string name = std::filesystem::path(victim).filename().string();
    EXPECT_TRUE(withoutNotes(ran.err).starts_with("error: ")) << ran.err;
    EXPECT_NE(ran.err.find(name), std::string::npos) << ran.err;
    EXPECT_TRUE(std::filesystem::exists(folder_ / "a.png"));
    const auto report = nlohmann::json::parse(test::contentsOf(folder_ / "r.json"));
    ASSERT_EQ(report["skipped"].size(), 1u);
    EXPECT_NE(report["skipped"][0]["uri"].get<std::string>().find(name), std::string::npos);
}

TEST_F(Capture, ALateFrameIsNotPassedOffAsDone) {
    const Ran ran = capture(folder_ / "a.png", "--sun 220,30 --sse 0.1 --timeout 0");
    EXPECT_EQ(ran.code, 75) << ran.err;
    EXPECT_NE(ran.err.find("still loading: "), std::string::npos) << ran.err;
    EXPECT_EQ(folder_.files(), 0u);
}

TEST_F(Capture, AFullDiskEndsItWithCode73NamingTheFrame) {
    if (!std::filesystem::exists("/dev/full"))
        GTEST_SKIP() << "no /dev/full";
    std::filesystem::create_symlink("/dev/full", folder_ / "f1.png");
    const Ran ran = capture(folder_ / "f{frame}.png", "--sun 220,30 --frames 0-2");
    EXPECT_EQ(ran.code, 73);
    EXPECT_EQ(withoutNotes(ran.err),
              "error: frame 1: " + folder_ / "f1.png" + ": No space left on device\n");
    EXPECT_TRUE(std::filesystem::exists(folder_ / "f0.png"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "f2.png"));
}

TEST_F(Capture, ASignalEndsItAfterAWholeFrame) {
    for (const auto& [name, signal] : {std::pair{"INT", SIGINT}, std::pair{"TERM", SIGTERM}}) {
        const test::Folder folder;
        const Ran ran = capture(folder / "f{frame}.png", "--sun 220,30 --frames 0-100000", place(),
                                std::string("timeout --preserve-status -s ") + name + " 3");
        EXPECT_EQ(ran.code, 128 + signal) << ran.err;
        EXPECT_GT(folder.files(), 0u);
        for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
            EXPECT_EQ(entry.path().extension(), ".png"); // no .part
            const std::string bytes = test::contentsOf(entry.path());
            EXPECT_NE(bytes.find("IEND"), std::string::npos) << entry.path();
        }
    }
}

TEST_F(Capture, TheOverlayIsOverThePicturesEdgesAndInNoAov) {
    const std::string options = "--time '2021-06-21T16:00 Europe/Berlin' --size 480x270 --aov sun ";
    ASSERT_EQ(capture(folder_ / "with.png", options).code, 0);
    ASSERT_EQ(capture(folder_ / "without.png", options + "--no-overlay").code, 0);
    EXPECT_EQ(test::contentsOf(folder_ / "with.sun.exr"),
              test::contentsOf(folder_ / "without.sun.exr"));
    const Pixels with = pixelsOf(folder_ / "with.png"), without = pixelsOf(folder_ / "without.png");
    ASSERT_EQ(with.rgb.size(), 3u * 480 * 270);
    ASSERT_EQ(without.rgb.size(), with.rgb.size());
    int changed = 0;
    for (int y = 0; y < 270; ++y)
        for (int x = 0; x < 480; ++x) {
            const std::size_t i = std::size_t(3 * (y * 480 + x));
            const bool same = std::equal(&with.rgb[i], &with.rgb[i] + 3, &without.rgb[i]);
            changed += !same;
            const bool middle = x >= 144 && x < 336 && y >= 81 && y < 189;
            ASSERT_TRUE(same || !middle) << x << ' ' << y;
        }
    EXPECT_GT(changed, 2000);
    EXPECT_LT(changed, 480 * 270 / 3);
}

TEST_F(Capture, TheReportTellsTheOverlayApartAndNamesTheCredits) {
    const auto reportOf = [&](const std::string& options) {
        EXPECT_EQ(capture(folder_ / "a.png",
                          options + " --sun 220,30 --frame-report '" + folder_ / "r.json" + "'")
                      .code,
                  0);
        return nlohmann::json::parse(test::contentsOf(folder_ / "r.json"));
    };
    const auto with = reportOf(""), without = reportOf("--no-overlay");
    EXPECT_NE(with["settings_hash"], without["settings_hash"]);
    EXPECT_TRUE(with["credits"].is_array());
}

TEST_F(Capture, ResumesWhereFramesAreMissingCutShortOrDrawnOtherwise) {
    const std::string frames = "--camera '" + place() + "/flight.json' --frames 0-30:10 ";
    const auto report = [&] { return nlohmann::json::parse(test::contentsOf(folder_ / "r.json")); };
    const auto resume = [&](const std::string& more) {
        const Ran ran = capture(folder_ / "f{frame:02}.png", frames + "--resume --frame-report '" +
                                                                 folder_ / "r.json" + "' " + more);
        EXPECT_EQ(ran.code, 0) << ran.err;
        return report();
    };
    EXPECT_EQ(resume("")["frames"].size(), 4u); // nothing is there yet
    const std::string gone = test::contentsOf(folder_ / "f10.png");
    const std::string cut = test::contentsOf(folder_ / "f20.png");
    std::filesystem::remove(folder_ / "f10.png");
    std::ofstream(folder_ / "f20.png", std::ios::binary) << cut.substr(0, cut.size() / 2);
    const auto old = std::filesystem::last_write_time(folder_ / "f00.png");

    auto second = resume("");
    EXPECT_EQ(second["kept"], (std::vector<int>{0, 30}));
    ASSERT_EQ(second["frames"].size(), 2u);
    EXPECT_EQ(second["frames"][0]["index"], 10);
    EXPECT_EQ(second["frames"][1]["index"], 20);
    EXPECT_EQ(test::contentsOf(folder_ / "f10.png"), gone);
    EXPECT_EQ(test::contentsOf(folder_ / "f20.png"), cut);
    EXPECT_EQ(std::filesystem::last_write_time(folder_ / "f00.png"), old);

    EXPECT_EQ(resume("")["kept"].size(), 4u);
    EXPECT_TRUE(report()["frames"].empty());
    EXPECT_EQ(resume("--no-overlay")["frames"].size(), 4u); // other settings
    EXPECT_EQ(resume("--no-overlay --aov sun")["frames"].size(), 4u);
    std::filesystem::remove(folder_ / "f30.sun.exr");
    EXPECT_EQ(resume("--no-overlay --aov sun")["frames"].size(), 1u);
}

TEST_F(Capture, DoesNotTakeAnIncompleteFrameForDone) {
    std::filesystem::copy(place(), folder_ / "p", std::filesystem::copy_options::recursive);
    std::string victim;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "p"))
        if (entry.path().extension() == ".glb")
            victim = std::max(victim, entry.path().string());
    const std::string whole = test::contentsOf(victim);
    std::ofstream(victim, std::ios::binary) << "no glb";
    const std::string options = "--sun 220,30 --sse 0.1 --resume --frames 0-0";
    EXPECT_EQ(capture(folder_ / "f{frame}.png", options, folder_ / "p").code, 3);
    EXPECT_EQ(capture(folder_ / "f{frame}.png", options, folder_ / "p").code, 3); // and tries again
    std::ofstream(victim, std::ios::binary) << whole;
    EXPECT_EQ(capture(folder_ / "f{frame}.png", options, folder_ / "p").code, 0);
    const auto done = std::filesystem::last_write_time(folder_ / "f0.png");
    const Ran again = capture(folder_ / "f{frame}.png", options, folder_ / "p");
    EXPECT_EQ(again.code, 0);
    EXPECT_NE(again.err.find("1 frames are there already"), std::string::npos) << again.err;
    EXPECT_EQ(std::filesystem::last_write_time(folder_ / "f0.png"), done);
}

TEST_F(Capture, ShardsTogetherDrawEveryFrameOnceAndTheSame) {
    const std::string frames = "--camera '" + place() + "/flight.json' --frames 0-40:10 ";
    ASSERT_EQ(capture(folder_ / "whole{frame}.png", frames).code, 0);
    EXPECT_EQ(folder_.files(), 5u);
    const test::Folder parts;
    ASSERT_EQ(capture(parts / "f{frame}.png", frames + "--shard 1/2").code, 0);
    EXPECT_EQ(parts.files(), 3u);
    ASSERT_EQ(capture(parts / "f{frame}.png", frames + "--shard 2/2").code, 0);
    EXPECT_EQ(parts.files(), 5u);
    for (const char* index : {"0", "10", "20", "30", "40"})
        EXPECT_EQ(test::contentsOf(parts / "f" + index + ".png"),
                  test::contentsOf(folder_ / "whole" + index + ".png"))
            << index;
    const Ran idle = capture(parts / "f{frame}.png", frames + "--shard 8/8");
    EXPECT_EQ(idle.code, 0) << idle.err;
    EXPECT_EQ(parts.files(), 5u);
}
