// `gnomon capture` ended in every way but its own, and on disks that refuse it.
#include "tests/faults/small_flight.h"

#include <random>

#include <sys/mount.h>

using namespace gnomon::test;
using std::chrono::milliseconds;
using std::chrono::seconds;

namespace {

class KilledFlight : public SmallFlight {};

// A file system of its own, where the system lets us have one.
class Mounted {
  public:
    Mounted(const Folder& folder, const std::string& options) : path_(folder.path()) {
        is_ = ::mount("none", path_.c_str(), "tmpfs", 0, options.c_str()) == 0;
    }
    ~Mounted() {
        if (is_)
            ::umount2(path_.c_str(), MNT_DETACH);
    }
    explicit operator bool() const { return is_; }
    bool makeReadOnly() const {
        return ::mount("none", path_.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "") == 0;
    }

  private:
    std::string path_;
    bool is_ = false;
};

} // namespace

TEST_F(KilledFlight, ResumedIsTheSameToTheByteAndNothingIsEverTorn) {
    const Folder whole, killed;
    const auto start = std::chrono::steady_clock::now();
    ASSERT_EQ(fly(tileset(), whole).wait(), 0);
    const auto full = std::chrono::steady_clock::now() - start;
    const auto reference = filesIn(whole);
    ASSERT_EQ(reference.size(), std::size_t(kFrames));
    std::mt19937 random(11);
    std::uniform_real_distribution<double> share(0.1, 0.6);
    for (int i = 0; i < 6; ++i) {
        Process run = fly(tileset(), killed, {"--resume"});
        run.wait(std::chrono::duration_cast<milliseconds>(share(random) * full));
        run.signal(SIGKILL);
        run.wait();
        auto files = filesIn(killed);
        std::erase_if(files, [](const auto& file) { return file.first.starts_with('.'); });
        EXPECT_EQ(differences(files, reference), std::vector<std::string>{});
    }
    // As if it had been killed while it wrote, which is seldom met.
    killed.write(".f03.png.4711.part", reference.at("f03.png").substr(0, 100));
    Process last = fly(tileset(), killed, {"--resume"});
    EXPECT_EQ(last.wait(), 0) << last.errors();
    EXPECT_EQ(filesIn(killed), reference);
}

TEST_F(KilledFlight, ASecondSignalEndsItAtOnceAndNothingIsTorn) {
    const Folder folder;
    Process run = fly(tileset(), folder, {"--frames", "0-100000"});
    while (folder.files() < 2 && !run.wait(milliseconds(1))) {
    }
    run.signal(SIGTERM);
    run.signal(SIGTERM);
    EXPECT_EQ(run.wait(seconds(1)), 128 + SIGTERM);
    for (const auto& [name, bytes] : filesIn(folder)) {
        if (!name.starts_with('.')) {
            EXPECT_NE(bytes.find("IEND"), std::string::npos) << name;
        }
    }
}

TEST_F(KilledFlight, AVideoThatIsInterruptedHoldsTheFramesSoFarAndOneThatIsKilledIsNotThere) {
    if (std::system("command -v ffmpeg >/dev/null") != 0)
        GTEST_SKIP() << "ffmpeg is not installed";
    const Folder folder;
    const auto film = [&](int signal) {
        Process run(arguments(tileset(), folder / "a.mp4", {"--frames", "0-100000"}));
        while (run.errors().find("/100001 frames") == std::string::npos && // it is under way
               !run.wait(milliseconds(10))) {
        }
        run.signal(signal);
        return run.wait(seconds(10));
    };
    EXPECT_EQ(film(SIGKILL), 128 + SIGKILL);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.mp4"));
    EXPECT_EQ(film(SIGINT), 128 + SIGINT);
    EXPECT_EQ(folder.files(), 1u); // what the killed one left is gone too
    EXPECT_EQ(std::system(("ffmpeg -v error -xerror -i '" + folder / "a.mp4" +
                           "' -f null - 2>&1 | "
                           "grep -q . && exit 1 || exit 0")
                              .c_str()),
              0);
}

TEST_F(KilledFlight, ADiskThatFillsUpEndsItWithCode73NamingTheFrameAndItGoesOnWhenThereIsRoom) {
    const Folder folder, whole;
    const Mounted disk(folder, "size=128k");
    if (!disk)
        GTEST_SKIP() << "no file system can be mounted here";
    Process run = fly(tileset(), folder);
    EXPECT_EQ(run.wait(), 73);
    const std::size_t there = folder.files();
    EXPECT_GT(there, 0u);
    ASSERT_LT(there, std::size_t(kFrames));
    const std::string errors = run.errors();
    EXPECT_NE(errors.find("error: frame " + std::to_string(there) + ": "), std::string::npos)
        << errors;
    EXPECT_NE(errors.find("No space left on device"), std::string::npos) << errors;
    ASSERT_EQ(fly(tileset(), whole).wait(), 0);
    EXPECT_EQ(differences(filesIn(folder), filesIn(whole)), std::vector<std::string>{});
    ASSERT_EQ(::mount("none", folder.path().c_str(), "tmpfs", MS_REMOUNT, "size=8m"), 0);
    EXPECT_EQ(fly(tileset(), folder, {"--resume"}).wait(), 0);
    EXPECT_EQ(filesIn(folder), filesIn(whole));
}

TEST_F(KilledFlight, AFolderThatCannotBeWrittenIsCode73BeforeAnythingIsOpened) {
    const Folder folder;
    const Mounted disk(folder, "size=1m");
    if (!disk || !disk.makeReadOnly())
        GTEST_SKIP() << "no file system can be mounted here";
    Process run = fly("/nowhere/tileset.json", folder);
    EXPECT_EQ(run.wait(), 73);
    EXPECT_EQ(run.errors(), "error: " + folder / "f00.png" + ": Read-only file system\n");
}

TEST_F(KilledFlight, ExistingPicturesAreReplacedWhole) {
    const Folder folder, whole;
    folder.write("f00.png", std::string(1 << 20, 'x'));
    folder.write("f10.png/inside", "a folder of that name");
    EXPECT_EQ(fly(tileset(), whole, {"--frames", "0-0"}).wait(), 0);
    EXPECT_EQ(fly(tileset(), folder, {"--frames", "0-0"}).wait(), 0);
    EXPECT_EQ(contentsOf(folder / "f00.png"), contentsOf(whole / "f00.png"));
    Process run = fly(tileset(), folder, {"--frames", "0-10:10"});
    EXPECT_EQ(run.wait(), 73);
    EXPECT_NE(run.errors().find("error: frame 10: " + folder / "f10.png" + ": Is a directory"),
              std::string::npos)
        << run.errors();
}

TEST_F(KilledFlight, APathWithALineBreakIsAPathAndItsErrorOneLine) {
    const Folder folder;
    Process run(arguments(tileset(), folder / "two\nlines.png", {"--frames", "0-0"}));
    EXPECT_EQ(run.wait(), 0) << run.errors();
    EXPECT_TRUE(std::filesystem::exists(folder / "two\nlines.png"));
    Process wrong(arguments(tileset(), folder / "no\nfolder/a.png", {"--frames", "0-0"}));
    EXPECT_EQ(wrong.wait(), 73);
    EXPECT_EQ(wrong.errors(),
              "error: " + folder / "no\\nfolder/a.png" + ": No such file or directory\n");
}
