#include "tests/viewer/files.h"
#include "viewer/output_file.h"

#include <gtest/gtest.h>

#include <csignal>

#include <sys/resource.h>

using namespace gnomon;

TEST(OutputFile, ReplacesAFileAndLeavesNothingElse) {
    const test::Folder folder;
    folder.write("a.txt", "old");
    EXPECT_FALSE(writeFile(folder / "a.txt", std::string("new")));
    EXPECT_EQ(test::contentsOf(folder / "a.txt"), "new");
    EXPECT_EQ(folder.files(), 1u);
}

TEST(OutputFile, AFullDiskIsAnOutputErrorThatNamesTheFile) {
    if (!std::filesystem::exists("/dev/full"))
        GTEST_SKIP() << "no /dev/full";
    const test::Folder folder;
    std::filesystem::create_symlink("/dev/full", folder / "full.png");
    const Failure failure = writeFile(folder / "full.png", std::string("x"));
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, ErrorKind::Output);
    EXPECT_EQ(failure->subject, folder / "full.png");
    EXPECT_EQ(failure->reason, "No space left on device");
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "full.png"));
    EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST(OutputFile, WhatCannotBeWrittenIsKnownBefore) {
    const test::Folder folder;
    for (const std::string& path :
         {folder / "none/a.png", folder.path(), std::string("/proc/a.png")}) {
        const Failure failure = checkWritable(path);
        ASSERT_TRUE(failure) << path;
        EXPECT_EQ(failure->kind, ErrorKind::Output);
        EXPECT_EQ(failure->subject, path);
        EXPECT_TRUE(writeFile(path, std::string("x")));
    }
    EXPECT_FALSE(checkWritable(folder / "a.png"));
    EXPECT_EQ(folder.files(), 0u);
}

TEST(OutputFile, NamesWithLineBreaksAreNames) {
    const test::Folder folder;
    EXPECT_FALSE(writeFile(folder / "a\nb.txt", std::string("x")));
    EXPECT_EQ(test::contentsOf(folder / "a\nb.txt"), "x");
}

TEST(OutputFile, WhatKilledWritersLeftIsTakenAwayAndNothingElse) {
    const test::Folder folder;
    folder.write(".a.png.4711.part", "half");
    folder.write(".b.png.4711.part", "another's");
    folder.write(".a.png.part", "no process");
    folder.write("a.png.4711.part", "not hidden");
    folder.write("a.png", "whole");
    const auto alive = TemporaryFile::create(folder / "c.png");
    ASSERT_TRUE(bool(alive));
    removeAbandoned({folder / "a.png", folder / "c.png", folder / "none/d.png"});
    EXPECT_FALSE(std::filesystem::exists(folder / ".a.png.4711.part"));
    EXPECT_TRUE(std::filesystem::exists(alive->name()));
    EXPECT_EQ(folder.files(), 5u);
}

TEST(OutputFile, ATemporaryFileThatIsNotFinishedIsGone) {
    const test::Folder folder;
    {
        auto file = TemporaryFile::create(folder / "a.txt");
        ASSERT_TRUE(bool(file));
        EXPECT_FALSE(file->write(std::as_bytes(std::span("abc", 3))));
        EXPECT_EQ(folder.files(), 1u);
    }
    EXPECT_EQ(folder.files(), 0u);
}

TEST(OutputFile, ADiskThatIsFullLeavesTheOldFileAsItWas) {
    // A file size limit fails a write midway, as a disk does that fills up.
    const test::Folder folder;
    folder.write("a.bin", "old");
    struct rlimit before {};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    struct rlimit small = before;
    small.rlim_cur = 1000;
    ::setrlimit(RLIMIT_FSIZE, &small);
    const Failure failure = writeFile(folder / "a.bin", std::string(5000, 'x'));
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, ErrorKind::Output);
    EXPECT_EQ(test::contentsOf(folder / "a.bin"), "old");
    EXPECT_EQ(folder.files(), 1u);
}
