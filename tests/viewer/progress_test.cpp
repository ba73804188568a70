#include "viewer/messages.h"
#include "viewer/progress.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

using namespace gnomon;
using namespace std::chrono_literals;

namespace {

struct Stream {
    char* text = nullptr;
    std::size_t size = 0;
    std::FILE* file = open_memstream(&text, &size);
    ~Stream() {
        std::fclose(file);
        std::free(text);
    }
    std::string said() {
        std::fflush(file);
        return {text, size};
    }
};

} // namespace

TEST(Progress, PlainLinesComeEveryFewSecondsAndTellTheTimeLeft) {
    Stream stream;
    const auto start = ProgressBar::Clock::now();
    ProgressBar bar("frames", stream.file, false);
    bar.update(1, 100, start + 1s);
    EXPECT_EQ(stream.said(), "");
    bar.update(10, 100, start + 10s);
    EXPECT_EQ(stream.said(), "10/100 frames, 1 min 30 s left\n");
    bar.update(11, 100, start + 11s);
    EXPECT_EQ(stream.said(), "10/100 frames, 1 min 30 s left\n");
    bar.update(100, 100, start + 12s);
    EXPECT_EQ(stream.said(), "10/100 frames, 1 min 30 s left\n100/100 frames\n");
}

TEST(Progress, ShortJobsSayNothingInPlainLines) {
    Stream stream;
    ProgressBar bar("frames", stream.file, false);
    for (std::size_t i = 1; i <= 3; ++i)
        bar.update(i, 3);
    bar.finish();
    EXPECT_EQ(stream.said(), "");
}

TEST(Progress, ATerminalGetsABarOnOneLine) {
    Stream stream;
    const auto start = ProgressBar::Clock::now();
    ProgressBar bar("frames", stream.file, true);
    bar.update(1, 2, start + 4s);
    bar.update(2, 2, start + 8s);
    bar.finish();
    EXPECT_EQ(stream.said(), "\r\x1b[K[###############               ] 1/2 frames, 4 s left"
                             "\r\x1b[K[##############################] 2/2 frames\n");
}

TEST(Progress, TimesAreWrittenAsPeopleSayThem) {
    EXPECT_EQ(ProgressBar::inWords(59s), "59 s");
    EXPECT_EQ(ProgressBar::inWords(61s), "1 min 01 s");
    EXPECT_EQ(ProgressBar::inWords(3720s), "1 h 02 min");
    EXPECT_EQ(ProgressBar::inWords(-5s), "0 s");
}

TEST(Messages, NamesWithLineBreaksStayOnOneLine) {
    EXPECT_EQ(oneLine("a\nb\x1b[2Jc"), "a\\nb\\x1b[2Jc");
    EXPECT_EQ(oneLine("Köln"), "Köln");
    testing::internal::CaptureStderr();
    sayError({"a\nb.png", "No space left on device"});
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "error: a\\nb.png: No space left on device\n");
}

TEST(Messages, ExitCodesAreThoseOfTheContract) {
    EXPECT_EQ(exitCodeOf(ErrorKind::Usage), 2);
    EXPECT_EQ(exitCodeOf(ErrorKind::Input), 65);
    EXPECT_EQ(exitCodeOf(ErrorKind::Output), 73);
    EXPECT_EQ(exitCodeOf(ErrorKind::Transient), 75);
    EXPECT_EQ(exit_code::kSkipped, 3);
}
