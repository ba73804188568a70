#include "streaming/source.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include <sys/stat.h>
#include <unistd.h>

namespace gnomon {
namespace {

namespace fs = std::filesystem;

TEST(ResolveUri, FollowsRfc3986WithinTheFolder) {
    struct Case {
        const char *base, *uri, *expected;
    };
    const Case cases[] = {
        {"tileset.json", "a.b3dm", "a.b3dm"},
        {"tileset.json", "./a.b3dm", "a.b3dm"},
        {"tileset.json", "tiles/a.b3dm", "tiles/a.b3dm"},
        {"sub/tileset.json", "a.b3dm", "sub/a.b3dm"},
        {"sub/tileset.json", "../a.b3dm", "a.b3dm"},
        {"a/b/c/t.json", "../../x/./y.glb", "a/x/y.glb"},
        {"tileset.json", "x/../a.b3dm", "a.b3dm"},
        {"tileset.json", "a//b.glb", "a/b.glb"},
        {"tileset.json", "a.b3dm?foo=bar", "a.b3dm"},
        {"tileset.json", "a.b3dm?foo=bar#baz", "a.b3dm"},
        {"tileset.json", "a.b3dm#frag?not=query", "a.b3dm"},
        {"tileset.json", "a.b3dm?up=../../x", "a.b3dm"},
        {"tileset.json", "with%20space.glb", "with space.glb"},
        {"tileset.json", "with space.glb", "with space.glb"},
        {"tileset.json", "Stra%C3%9Fe.glb",
         "Stra\xc3\x9f"
         "e.glb"},
        {"tileset.json", "100%.glb", "100%.glb"},
        {"tileset.json", "a%2", "a%2"},
        {"tileset.json", "%41.glb", "A.glb"},
        {"sub/tileset.json", "%2e%2e/a.glb", "a.glb"},
        {"tileset.json", "a%23b.glb", "a#b.glb"},
        {"tileset.json", "%252e%252e/a.glb", "%2e%2e/a.glb"}, // decoded once only
        {"tileset.json", "...", "..."},
        {"tileset.json", "1:2.glb", "1:2.glb"}, // a scheme begins with a letter
    };
    for (const Case& c : cases) {
        const auto resolved = resolveUri(c.base, c.uri);
        ASSERT_TRUE(resolved) << c.uri << ": " << resolved.error().message();
        EXPECT_EQ(*resolved, c.expected) << c.base << " + " << c.uri;
    }
}

TEST(ResolveUri, RefusesWhatLeavesTheFolder) {
    using namespace std::string_literals;
    const std::string uris[] = {
        "../a.glb",
        "x/../../a.glb",
        "%2e%2e/a.glb",
        "%2E%2e/a.glb",
        ".%2e/a.glb",
        "/etc/passwd",
        "//host/a.glb",
        "file:///etc/passwd",
        "file:a.glb",
        "FILE:a.glb",
        "http://h/a",
        "https://h/a",
        "data:,x",
        "a%2fb.glb",
        "..%2fa.glb",
        "a\0b.glb"s,
        "a%00.glb",
        "a\nb.glb",
        "a%0ab.glb",
        "",
        "?query",
        "#fragment",
        ".",
        "..",
        "sub/",
        "sub/%2e%2e",
        "sub/..",
    };
    for (const std::string& uri : uris) {
        const auto resolved = resolveUri("tileset.json", uri);
        ASSERT_FALSE(resolved) << uri << " became " << *resolved;
        EXPECT_EQ(resolved.error().subject, "tileset.json");
        EXPECT_EQ(resolved.error().reason.find('\n'), std::string::npos) << "one line";
    }
}

class Folder : public ::testing::Test {
  protected:
    void SetUp() override {
        std::string name = (fs::temp_directory_path() / "gnomon-source-XXXXXX").string();
        ASSERT_NE(::mkdtemp(name.data()), nullptr);
        top = name;
        fs::create_directories(top / "root/sub");
        write(top / "root/a.bin", "inside");
        write(top / "root/sub/b.bin", "below");
        write(top / "secret.bin", "outside");
    }
    void TearDown() override { fs::remove_all(top); }
    static void write(const fs::path& file, const char* text) { std::ofstream(file) << text; }
    static std::string text(const Bytes& bytes) {
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    fs::path top;
};

TEST_F(Folder, GivesTheBytesOfFilesBelowIt) {
    const auto source = fileSource((top / "root").string());
    const auto a = source->read("a.bin");
    ASSERT_TRUE(a) << a.error().message();
    EXPECT_EQ(text(*a), "inside");
    const auto b = source->read("sub/b.bin");
    ASSERT_TRUE(b);
    EXPECT_EQ(text(*b), "below");
    EXPECT_EQ(source->describe("a.bin"), (top / "root/a.bin").string());
}

TEST_F(Folder, NamesAMissingFile) {
    const auto missing = fileSource((top / "root").string())->read("none.bin");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().subject, (top / "root/none.bin").string());
    EXPECT_EQ(missing.error().kind, ErrorKind::Input);
}

TEST_F(Folder, RefusesSymbolicLinksThatLeadOut) {
    fs::create_symlink(top / "secret.bin", top / "root/link.bin");
    fs::create_symlink("../secret.bin", top / "root/relative.bin");
    fs::create_directory_symlink(top, top / "root/up");
    fs::create_symlink("sub/b.bin", top / "root/fine.bin");
    const auto source = fileSource((top / "root").string());
    EXPECT_FALSE(source->read("link.bin"));
    EXPECT_FALSE(source->read("relative.bin"));
    EXPECT_FALSE(source->read("up/secret.bin"));
    const auto inside = source->read("fine.bin");
    ASSERT_TRUE(inside) << "a link within the folder is a file like any other";
    EXPECT_EQ(text(*inside), "below");
}

TEST_F(Folder, RefusesPathsThatWereNeverResolved) {
    const auto source = fileSource((top / "root").string());
    EXPECT_FALSE(source->read("../secret.bin"));
    EXPECT_FALSE(source->read("sub/../../secret.bin"));
    EXPECT_FALSE(source->read((top / "secret.bin").string()));
    EXPECT_FALSE(source->read(""));
}

TEST_F(Folder, DoesNotWaitForAPipeNorReadAFolder) {
    ASSERT_EQ(::mkfifo((top / "root/pipe").c_str(), 0600), 0);
    const auto source = fileSource((top / "root").string());
    EXPECT_FALSE(source->read("pipe"));
    EXPECT_FALSE(source->read("sub"));
}

TEST_F(Folder, DoesNotTakeASiblingWithTheSameBeginningForItself) {
    fs::create_directories(top / "root-other");
    write(top / "root-other/c.bin", "other");
    fs::create_symlink(top / "root-other/c.bin", top / "root/c.bin");
    EXPECT_FALSE(fileSource((top / "root").string())->read("c.bin"));
}

} // namespace
} // namespace gnomon
