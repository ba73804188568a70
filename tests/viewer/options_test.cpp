#include "viewer/option_values.h"
#include "viewer/options.h"
#include "viewer/place/place.h"

#include <gtest/gtest.h>

using namespace gnomon;

namespace {

Result<CommandLine> parse(std::initializer_list<const char*> arguments) {
    return parseCommandLine({arguments.begin(), arguments.end()});
}

CaptureOptions captured(std::vector<std::string> more) {
    std::vector<std::string> arguments{"capture", "in", "-o", "out.png"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto parsed = parseCommandLine(arguments);
    EXPECT_TRUE(bool(parsed)) << (parsed ? "" : parsed.error().message());
    return parsed ? std::get<CaptureOptions>(*parsed) : CaptureOptions{};
}

Error refused(std::vector<std::string> more) {
    std::vector<std::string> arguments{"capture", "in", "-o", "out.png"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto parsed = parseCommandLine(arguments);
    EXPECT_FALSE(bool(parsed)) << more.front();
    return parsed ? Error{} : parsed.error();
}

} // namespace

TEST(Options, DefaultsAreThoseOfTheContract) {
    const CaptureOptions options = captured({});
    EXPECT_EQ(options.picture.scene.inputs, std::vector<std::string>{"in"});
    EXPECT_EQ(options.output, "out.png");
    EXPECT_EQ(options.picture.widthPixels, 1280);
    EXPECT_EQ(options.picture.heightPixels, 720);
    EXPECT_EQ(options.picture.frame.maximumScreenSpaceError, 8.0);
    EXPECT_EQ(options.picture.timeoutSeconds, 60.0);
    EXPECT_EQ(options.framesPerSecond, 30.0);
    EXPECT_EQ(options.picture.scene.loader.memoryBytes, std::size_t(1024) << 20);
    EXPECT_TRUE(options.picture.frame.groundAuto);
    EXPECT_EQ(options.picture.frame.shadows.method, ShadowMethod::Cascades);
    EXPECT_EQ(options.picture.frame.shadows.filter, ShadowFilter::Pcss);
    EXPECT_EQ(options.picture.frame.shadows.cascades, 4);
    const auto view = parse({"view", "in"});
    ASSERT_TRUE(bool(view));
    EXPECT_EQ(std::get<ViewOptions>(*view).picture.frame.maximumScreenSpaceError, 16.0);
}

TEST(Options, NegativeNumbersInListsAreNotTakenForOptions) {
    const CaptureOptions options = captured(
        {"--camera", "-75.5,39.1,-175,30,-30", "--sun", "-140,-3.5", "--place", "-75,-39,-1,90"});
    const auto& camera = std::get<FixedCamera>(options.picture.camera);
    EXPECT_EQ(camera.position.longitudeDegrees, -75.5);
    EXPECT_EQ(camera.position.latitudeDegrees, 39.1);
    EXPECT_EQ(camera.position.heightMetres, -175);
    EXPECT_EQ(camera.orientation.headingDegrees, 30);
    EXPECT_EQ(camera.orientation.pitchDegrees, -30);
    EXPECT_EQ(camera.orientation.rollDegrees, 0);
    const auto& sun = std::get<SunAngles>(options.picture.sun);
    EXPECT_EQ(sun.azimuthDegrees, 220);
    EXPECT_EQ(sun.elevationDegrees, -3.5);
    ASSERT_TRUE(options.picture.scene.placement);
    EXPECT_EQ(options.picture.scene.placement->origin.latitudeDegrees, -39);
    EXPECT_EQ(options.picture.scene.placement->headingDegrees, 90);
    const auto demo = parse({"demo", "d", "--at", "-180,-90,-5"});
    ASSERT_TRUE(bool(demo));
    EXPECT_EQ(std::get<DemoOptions>(*demo).at.latitudeDegrees, -90);
}

TEST(Options, EqualSignsAndOrderDoNotMatter) {
    const auto parsed =
        parse({"capture", "--size=640x480", "-o", "o.png", "a", "--fov", "60", "b"});
    ASSERT_TRUE(bool(parsed)) << parsed.error().message();
    const auto& options = std::get<CaptureOptions>(*parsed);
    EXPECT_EQ(options.picture.scene.inputs, (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(options.picture.widthPixels, 640);
    EXPECT_EQ(options.picture.heightPixels, 480);
    EXPECT_EQ(options.picture.fovDegrees, 60.0);
}

TEST(Options, CameraMayBeAFile) {
    const CaptureOptions options = captured({"--camera", "flight.json"});
    EXPECT_EQ(std::get<CameraFile>(options.picture.camera).path, "flight.json");
}

TEST(Options, ATechniqueIsOneWord) {
    const ShadowSettings shadows =
        captured({"--shadows", "single+frontface+pcss:8,24"}).picture.frame.shadows;
    EXPECT_EQ(shadows.method, ShadowMethod::Single);
    EXPECT_EQ(shadows.filter, ShadowFilter::Pcss);
    EXPECT_EQ(shadows.blockerSamples, 8);
    EXPECT_EQ(shadows.filterSamples, 24);
    EXPECT_EQ(captured({"--shadows", "csm+pcf:5"}).picture.frame.shadows.pcfWidth, 5);
    const ShadowSettings dual =
        captured({"--shadows", "csm+dual-peel:0.25+jitter4"}).picture.frame.shadows;
    EXPECT_EQ(dual.bias, ShadowBias::DualPeel);
    EXPECT_EQ(dual.biasMetres, 0.25);
    EXPECT_EQ(dual.filter, ShadowFilter::Jitter);
}

TEST(Options, WhatIsSaidBesidesATechniqueWinsInAnyOrder) {
    for (const auto& arguments :
         {std::vector<std::string>{"--shadows", "csm+frontface+pcss", "--filter", "none"},
          std::vector<std::string>{"--filter", "none", "--shadows", "csm+frontface+pcss"}})
        EXPECT_EQ(captured(arguments).picture.frame.shadows.filter, ShadowFilter::None);
    for (const auto& arguments :
         {std::vector<std::string>{"--shadows", "single+constant:2+none", "--bias", "midpoint"},
          std::vector<std::string>{"--bias", "midpoint", "--shadows", "single+constant:2+none"}}) {
        const ShadowSettings shadows = captured(arguments).picture.frame.shadows;
        EXPECT_EQ(shadows.bias, ShadowBias::Midpoint);
        EXPECT_FALSE(shadows.biasMetres);
    }
}

TEST(Options, TheSunIsSetByTimeOrByAngles) {
    const auto time = captured({"--time", "2021-07-14T18:00 Europe/Berlin"});
    EXPECT_EQ(formatUtc(std::get<UtcTime>(time.picture.sun)), "2021-07-14T16:00:00Z");
    // Together, in either order: the time moves the flood, the sun stands still.
    for (const auto& both :
         {std::vector<std::string>{"--time", "2021-07-14T18:00Z", "--sun", "1,2"},
          std::vector<std::string>{"--sun", "1,2", "--time", "2021-07-14T18:00Z"}}) {
        const auto options = captured(both);
        EXPECT_EQ(formatUtc(std::get<UtcTime>(options.picture.sun)), "2021-07-14T18:00:00Z");
        ASSERT_TRUE(options.picture.fixedSun);
        EXPECT_EQ(options.picture.fixedSun->elevationDegrees, 2);
    }
}

TEST(Options, GroundIsAutoNoneOrAHeight) {
    EXPECT_FALSE(captured({"--ground", "none"}).picture.frame.groundAuto);
    EXPECT_FALSE(captured({"--ground", "none"}).picture.frame.groundHeightMetres);
    EXPECT_EQ(captured({"--ground", "-2.5"}).picture.frame.groundHeightMetres, -2.5);
    EXPECT_FALSE(captured({}).picture.groundGiven);
    EXPECT_TRUE(captured({"--ground", "auto"}).picture.groundGiven);
}

TEST(Options, FramesMayHaveAnEndAndAStep) {
    const auto range = captured({"--frames", "10-20:5"}).frames;
    ASSERT_TRUE(range);
    EXPECT_EQ(range->first, 10);
    EXPECT_EQ(range->last, 20);
    EXPECT_EQ(range->step, 5);
    EXPECT_EQ(captured({"--frames", "7"}).frames->last, 7);
}

TEST(Options, DemoSizesAreNamedOrCounted) {
    const auto size = [](const char* text) {
        const auto parsed = parse({"demo", "d", "--size", text});
        return parsed ? std::get<DemoOptions>(*parsed).buildings : 0;
    };
    EXPECT_EQ(size("small"), kSmallPlaceBuildings);
    EXPECT_EQ(size("city"), kCityPlaceBuildings);
    EXPECT_EQ(size("123"), 123u);
    EXPECT_EQ(size("0"), 0u);
    EXPECT_EQ(size("huge"), 0u);
}

struct Wrong {
    const char *option, *value;
    friend std::ostream& operator<<(std::ostream& out, const Wrong& wrong) {
        return out << wrong.option << " '" << wrong.value << "'";
    }
};

class WrongValue : public testing::TestWithParam<Wrong> {};

TEST_P(WrongValue, IsAUsageErrorOfOneLineThatNamesTheOption) {
    const Wrong wrong = GetParam();
    const Error error = refused({wrong.option, wrong.value});
    EXPECT_EQ(error.kind, ErrorKind::Usage);
    EXPECT_EQ(error.subject, wrong.option);
    EXPECT_FALSE(error.reason.empty());
    EXPECT_EQ(error.message().find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Options, WrongValue,
    testing::Values(Wrong{"--camera", "1,2,3"}, Wrong{"--camera", "1,2,3,4,5,6,7"},
                    Wrong{"--camera", "1,2,3,4,x"}, Wrong{"--camera", "1,91,3,4,5"},
                    Wrong{"--camera", "1,2,3,4,95"}, Wrong{"--camera", "1,2,nan,4,5"},
                    Wrong{"--camera", "1,2,1e999,4,5"}, Wrong{"--camera", "1,2,,4,5"},
                    Wrong{"--sun", "1"}, Wrong{"--sun", "1,91"}, Wrong{"--sun", "inf,1"},
                    Wrong{"--size", "640"}, Wrong{"--size", "0x5"}, Wrong{"--size", "640x480x2"},
                    Wrong{"--size", "-1x5"}, Wrong{"--size", "99999x5"}, Wrong{"--fov", "0"},
                    Wrong{"--fov", "180"}, Wrong{"--fov", "4o"}, Wrong{"--time", "yesterday"},
                    Wrong{"--shadows", "foo"}, Wrong{"--shadows", "csm+dual"},
                    Wrong{"--shadows", "csm+pcf:3+frontface"},
                    Wrong{"--shadows", "csm+frontface+pcf:3+x"}, Wrong{"--shadows", ""},
                    Wrong{"--bias", "slope:0.1"}, Wrong{"--bias", "dual-peel:-0.1"},
                    Wrong{"--bias", "x"}, Wrong{"--fit", "x"}, Wrong{"--cull", "x"},
                    Wrong{"--filter", "pcf:99"}, Wrong{"--cascades", "0"}, Wrong{"--cascades", "6"},
                    Wrong{"--cascades", "2.5"}, Wrong{"--map-size", "511"},
                    Wrong{"--split-lambda", "1.1"}, Wrong{"--shadow-range", "0"},
                    Wrong{"--ground", "x"}, Wrong{"--sse", "0"}, Wrong{"--memory", "1"},
                    Wrong{"--timeout", "-1"}, Wrong{"--frames", "5-2"}, Wrong{"--frames", "1-2:0"},
                    Wrong{"--frames", "a"}, Wrong{"--fps", "0"}, Wrong{"--aov", "sun,foo"},
                    Wrong{"--place", "1,2"}, Wrong{"--up", "x"}, Wrong{"--heights", "geoid"},
                    Wrong{"--crs", ""}, Wrong{"--device", "gpu"}));

TEST(Options, OfTheWebAreKeptAsTheyAreGiven) {
    const CaptureOptions options =
        captured({"--header", "X-Key: 1", "--header", "Authorization: Bearer a,b c", "--cache", "d",
                  "--offline", "--allow-host", "a.lan", "--allow-host", "10.0.0.1"});
    const HttpOptions& http = options.picture.scene.http;
    EXPECT_EQ(http.headers, (std::vector<std::string>{"X-Key: 1", "Authorization: Bearer a,b c"}));
    EXPECT_EQ(http.cacheFolder, "d");
    EXPECT_TRUE(http.offline);
    EXPECT_EQ(http.allowedHosts, (std::vector<std::string>{"a.lan", "10.0.0.1"}));
    EXPECT_FALSE(captured({}).picture.scene.http.cacheFolder) << "nothing is kept unasked";
    for (const char* wrong : {"nothing", "A b: c", "Range: bytes=0-1", "A: b\nC: d"}) {
        const Error error = refused({"--header", wrong});
        EXPECT_EQ(error.subject, "--header");
        EXPECT_EQ(error.message().find(wrong), std::string::npos) << "it may be a key";
    }
    EXPECT_EQ(refused({"--cache", ""}).subject, "--cache");
    for (const char* command : {"view", "info", "evaluate"})
        EXPECT_TRUE(parse({command, "in", "--header", "X-Key: 1"})) << command;
}

TEST(Options, WhatIsNotThereIsRefusedAndNotSwallowed) {
    for (const char* option : {"--offline", "--cache", "--header", "--shadow-error", "--foo"}) {
        const Error error = refused({option});
        EXPECT_EQ(error.kind, ErrorKind::Usage);
        EXPECT_EQ(error.subject, option);
    }
    for (const auto& arguments : {std::vector<std::string>{},
                                  {"evaluate", "x", "--techniques", "foo"},
                                  {"foo"},
                                  {"capture"},
                                  {"capture", "a"},
                                  {"capture", "-o", "x.png"},
                                  {"info"},
                                  {"demo"},
                                  {"demo", "a", "b"}}) {
        const auto parsed = parseCommandLine(arguments);
        ASSERT_FALSE(bool(parsed));
        EXPECT_EQ(parsed.error().kind, ErrorKind::Usage);
        EXPECT_EQ(parsed.error().message().find('\n'), std::string::npos);
    }
}

TEST(Options, HelpHasAnExampleForEveryCommand) {
    for (const char* command : {"view", "capture", "info", "evaluate", "demo"}) {
        const auto parsed = parse({command, "--help"});
        ASSERT_TRUE(bool(parsed));
        const std::string& text = std::get<HelpText>(*parsed).text;
        EXPECT_NE(text.find("Example"), std::string::npos);
        EXPECT_NE(text.find(std::string("gnomon ") + command), std::string::npos);
    }
    const auto version = parse({"--version"});
    ASSERT_TRUE(bool(version));
    EXPECT_TRUE(std::get<HelpText>(*version).text.starts_with("gnomon "));
}

TEST(Options, TheZoneOfTheTimeIsKept) {
    EXPECT_EQ(captured({"--time", "2021-07-14T18:00 Europe/Berlin"}).picture.timeZone,
              "Europe/Berlin");
    EXPECT_EQ(captured({"--time", "2021-07-14T18:00+02:00"}).picture.timeZone, "+02:00");
    EXPECT_FALSE(captured({"--time", "2021-07-14T18:00Z"}).picture.timeZone);
}

TEST(Options, TheOverlayIsThereUnlessItIsNotWanted) {
    EXPECT_TRUE(captured({}).overlay);
    EXPECT_FALSE(captured({"--no-overlay"}).overlay);
}

TEST(Options, ShardsAreCountedFromOne) {
    EXPECT_FALSE(captured({}).shard);
    EXPECT_FALSE(captured({}).resume);
    EXPECT_TRUE(captured({"--resume"}).resume);
    const auto shard = captured({"--shard", "3/8"}).shard;
    ASSERT_TRUE(shard);
    EXPECT_EQ(shard->number, 3);
    EXPECT_EQ(shard->count, 8);
    for (const char* wrong :
         {"0/8", "9/8", "3", "3/", "/8", "3/8/1", "1/0", "a/b", "-1/8", "1.5/8"})
        EXPECT_EQ(refused({"--shard", wrong}).kind, ErrorKind::Usage) << wrong;
    EXPECT_NE(refused({"--shard", "0/8"}).reason.find("from 1 to 8"), std::string::npos);
}
