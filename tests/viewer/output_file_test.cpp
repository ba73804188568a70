#include "tests/viewer/files.h"
#include "viewer/output_file.h"

#include <gtest/gtest.h>

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
