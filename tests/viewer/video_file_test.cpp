#include "tests/viewer/files.h"
#include "viewer/video_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

using namespace gnomon;

namespace {

std::string outputOf(const std::string& command) {
    std::string text;
    std::FILE* pipe = ::popen(command.c_str(), "r");
    std::array<char, 256> part{};
    while (pipe && std::fgets(part.data(), part.size(), pipe))
        text += part.data();
    if (pipe)
        ::pclose(pipe);
    return text;
}

bool haveFfmpeg() {
    return !outputOf("command -v ffmpeg && command -v ffprobe").empty();
}

Picture plain(int width, int height, std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
    Picture picture{width, height, {}};
    for (int i = 0; i < width * height; ++i)
        picture.rgb.insert(picture.rgb.end(), {red, green, blue});
    return picture;
}

void writeVideo(const std::string& path, const VideoFormat& format, int frames) {
    auto video = VideoFile::create(path, format);
    ASSERT_TRUE(bool(video)) << video.error().message();
    for (int i = 0; i < frames; ++i)
        ASSERT_FALSE(
            (*video)->add(plain(format.width, format.height, std::uint8_t(20 * i), 100, 200)));
    const Failure failure = (*video)->finish();
    ASSERT_FALSE(failure) << failure->message();
}

// Says no to what follows when there is no ffmpeg to ask.
#define NEEDS_FFMPEG                                                                               \
    if (!haveFfmpeg())                                                                             \
    GTEST_SKIP() << "ffmpeg is not installed"

} // namespace

TEST(VideoFile, HoldsEveryFrameAndOddSizesBecomeEven) {
    NEEDS_FFMPEG;
    const test::Folder folder;
    for (const auto& [name, container] :
         {std::pair{"a.mp4", Container::Mp4}, std::pair{"a.mkv", Container::Matroska}}) {
        writeVideo(folder / name, {container, 65, 33, 25}, 10);
        const std::string facts =
            outputOf("ffprobe -v error -count_frames -show_entries "
                     "stream=codec_name,width,height,pix_fmt,r_frame_rate,nb_read_frames -of csv "
                     "'" +
                     folder / name + "'");
        EXPECT_EQ(facts, "stream,h264,66,34,yuv420p,25/1,10\n");
    }
    EXPECT_EQ(folder.files(), 2u); // no temporary file is left
}

TEST(VideoFile, ColoursComeBack) {
    NEEDS_FFMPEG;
    const test::Folder folder;
    auto video = VideoFile::create(folder / "c.mp4", {Container::Mp4, 64, 64, 30});
    ASSERT_TRUE(bool(video));
    ASSERT_FALSE((*video)->add(plain(64, 64, 200, 60, 30)));
    ASSERT_FALSE((*video)->finish());
    const std::string raw =
        outputOf("ffmpeg -v error -i '" + folder / "c.mp4" +
                 "' -vf scale=in_color_matrix=bt709:flags=accurate_rnd -f rawvideo -pix_fmt rgb24 "
                 "- | od -An -tu1 -N3");
    int red = 0, green = 0, blue = 0;
    ASSERT_EQ(std::sscanf(raw.c_str(), "%d %d %d", &red, &green, &blue), 3) << raw;
    EXPECT_NEAR(red, 200, 4);
    EXPECT_NEAR(green, 60, 4);
    EXPECT_NEAR(blue, 30, 4);
}

TEST(VideoFile, TheSameFramesGiveTheSameBytes) {
    NEEDS_FFMPEG;
    const test::Folder folder;
    writeVideo(folder / "a.mp4", {Container::Mp4, 64, 48, 30}, 5);
    writeVideo(folder / "b.mp4", {Container::Mp4, 64, 48, 30}, 5);
    EXPECT_EQ(test::contentsOf(folder / "a.mp4"), test::contentsOf(folder / "b.mp4"));
}

TEST(VideoFile, WhatIsNotFinishedLeavesNothing) {
    NEEDS_FFMPEG;
    const test::Folder folder;
    {
        auto video = VideoFile::create(folder / "a.mp4", {Container::Mp4, 64, 48, 30});
        ASSERT_TRUE(bool(video));
        ASSERT_FALSE((*video)->add(plain(64, 48, 1, 2, 3)));
    }
    EXPECT_EQ(folder.files(), 0u);
}

TEST(VideoFile, WithoutFfmpegItIsAnOutputErrorThatSaysSo) {
    const test::Folder folder;
    const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
    ::setenv("PATH", folder.path().c_str(), 1);
    const auto video = VideoFile::create(folder / "a.mp4", {Container::Mp4, 64, 48, 30});
    ::setenv("PATH", path.c_str(), 1);
    ASSERT_FALSE(bool(video));
    EXPECT_EQ(video.error().kind, ErrorKind::Output);
    EXPECT_NE(video.error().reason.find("ffmpeg"), std::string::npos);
}

// A stand-in that dies at once, as ffmpeg does when it cannot go on.
TEST(VideoFile, AnEncoderThatDiesIsAnErrorAndNotASignal) {
    const test::Folder folder, programs;
    const std::string program =
        programs.write("ffmpeg", "#!/bin/sh\necho 'Unknown encoder libx264' >&2\nexit 1\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
    ::setenv("PATH", (programs.path() + ":" + path).c_str(), 1);
    auto video = VideoFile::create(folder / "a.mp4", {Container::Mp4, 640, 480, 30});
    ::setenv("PATH", path.c_str(), 1);
    ASSERT_TRUE(bool(video)) << video.error().message();
    Failure failure;
    for (int i = 0; i < 50 && !failure; ++i)
        failure = (*video)->add(plain(640, 480, 1, 2, 3));
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, ErrorKind::Output);
    EXPECT_NE(failure->reason.find("Unknown encoder"), std::string::npos) << failure->reason;
    video->reset();
    EXPECT_EQ(folder.files(), 0u);
}
