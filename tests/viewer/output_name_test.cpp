#include "viewer/capture_plan.h"
#include "viewer/output_name.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace gnomon;

namespace {

std::string named(const std::string& text, std::int64_t frame) {
    const auto name = OutputName::parse(text);
    return name ? name->of(frame) : "error";
}

Result<std::vector<PlannedFrame>> planned(const std::string& output, double flightSeconds,
                                          std::optional<FrameRange> range = {},
                                          std::optional<double> duration = {}) {
    CaptureOptions options;
    options.frames = range;
    options.durationSeconds = duration;
    const auto name = OutputName::parse(output);
    EXPECT_TRUE(bool(name));
    return planFrames(options, *name, flightSeconds);
}

} // namespace

TEST(OutputName, NumbersFramesAsAsked) {
    EXPECT_EQ(named("a.png", 7), "a.png");
    EXPECT_EQ(named("a{frame}.png", 7), "a7.png");
    EXPECT_EQ(named("x/{frame:04}/a.jpg", 7), "x/0007/a.jpg");
    EXPECT_EQ(named("{frame:04d}.PNG", 12345), "12345.PNG");
    const auto name = OutputName::parse("d.d/a{frame:03}.png");
    ASSERT_TRUE(bool(name));
    EXPECT_EQ(name->beside(5, "sun.exr"), "d.d/a005.sun.exr");
}

TEST(OutputName, KnowsTheFormatByTheEnding) {
    EXPECT_EQ(OutputName::parse("a.png")->format(), OutputFormat::Png);
    EXPECT_EQ(OutputName::parse("a.JPEG")->format(), OutputFormat::Jpeg);
    EXPECT_TRUE(OutputName::parse("a.mp4")->isVideo());
    EXPECT_TRUE(OutputName::parse("a.mkv")->isVideo());
    for (const char* bad : {"a", "a.tif", "", ".png", "a.png/", "a{frame}.mp4", "a{frame:}.png",
                            "a{frame:x}.png", "a{frame.png", "{frame}{frame}.png"}) {
        const auto name = OutputName::parse(bad);
        ASSERT_FALSE(bool(name)) << bad;
        EXPECT_EQ(name.error().kind, ErrorKind::Usage);
    }
}

TEST(CapturePlan, AFlightOfTwoSecondsAtThirtyHasSixtyFrames) {
    const auto frames = planned("a.mp4", 2.0);
    ASSERT_TRUE(bool(frames));
    ASSERT_EQ(frames->size(), 60u);
    EXPECT_EQ(frames->back().index, 59);
    EXPECT_DOUBLE_EQ(frames->back().seconds, 59.0 / 30.0);
    EXPECT_EQ(planned("a.mp4", 2.0, {}, 1.0)->size(), 30u);
}

TEST(CapturePlan, FramesKeepTheirPlaceInTheFlight) {
    const auto frames = planned("a{frame}.png", 2.0, FrameRange{10, 20, 5});
    ASSERT_TRUE(bool(frames));
    ASSERT_EQ(frames->size(), 3u);
    EXPECT_EQ(frames->at(1).index, 15);
    EXPECT_DOUBLE_EQ(frames->at(1).seconds, 0.5);
}

TEST(CapturePlan, OnePictureHoldsOneFrame) {
    EXPECT_EQ(planned("a.png", 2.0)->size(), 1u);
    EXPECT_EQ(planned("a.png", 2.0, FrameRange{30, 30, 1})->front().seconds, 1.0);
    EXPECT_FALSE(bool(planned("a.png", 2.0, FrameRange{0, 1, 1})));
    EXPECT_FALSE(bool(planned("a.png", 2.0, {}, 1.0)));
    EXPECT_FALSE(bool(planned("a.mp4", 0.0)));
    EXPECT_FALSE(bool(planned("a{frame}.png", 1e9)));
}

TEST(CapturePlan, ShardsTakeTurnsAndLeaveNoFrameOut) {
    const auto name = OutputName::parse("a{frame}.png");
    CaptureOptions options;
    options.frames = FrameRange{10, 30, 2};
    const auto whole = planFrames(options, *name, 0.0);
    ASSERT_EQ(whole->size(), 11u);
    for (const std::int64_t count : {1, 3, 11, 20}) {
        std::vector<std::int64_t> seen;
        for (std::int64_t number = 1; number <= count; ++number) {
            options.shard = Shard{number, count};
            const auto part = planFrames(options, *name, 0.0);
            ASSERT_TRUE(bool(part));
            EXPECT_LE(part->size(), std::size_t((11 + count - 1) / count));
            for (const PlannedFrame& frame : *part) {
                seen.push_back(frame.index);
                EXPECT_DOUBLE_EQ(frame.seconds, double(frame.index) / 30.0);
            }
        }
        std::sort(seen.begin(), seen.end());
        ASSERT_EQ(seen.size(), whole->size()) << count;
        for (std::size_t i = 0; i < seen.size(); ++i)
            EXPECT_EQ(seen[i], whole->at(i).index);
    }
}

TEST(CapturePlan, AVideoIsNeitherShardedNorResumed) {
    CaptureOptions options;
    options.shard = Shard{1, 2};
    for (const char* output : {"a.mp4", "a.png"}) {
        const auto frames = planFrames(options, *OutputName::parse(output), 2.0);
        ASSERT_FALSE(bool(frames)) << output;
        EXPECT_EQ(frames.error().subject, "--shard");
        EXPECT_EQ(frames.error().kind, ErrorKind::Usage);
    }
    options.shard.reset();
    options.resume = true;
    EXPECT_EQ(planFrames(options, *OutputName::parse("a.mkv"), 2.0).error().subject, "--resume");
    EXPECT_TRUE(bool(planFrames(options, *OutputName::parse("a{frame}.png"), 2.0)));
}
