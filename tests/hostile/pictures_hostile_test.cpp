// HOSTILE.md, items 13 to 16: compressed meshes and pictures that lie about their size or kind.
#include "streaming/draco.h"
#include "streaming/image.h"
#include "tests/hostile/confined.h"
#include "tests/hostile/families.h"
#include "tests/hostile/family_files.h"
#include "tests/streaming/draco_builder.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <random>

namespace gnomon::test {

namespace {

constexpr std::uint64_t kPlenty = std::uint64_t(512) << 20;

std::string dracoRefusal(const std::string& bytes, const DracoExpectation& expected) {
    const Bytes exact = bytesOf(bytes);
    ByteBudget budget(kPlenty / 2);
    try {
        decodeDraco(exact, std::vector<std::uint32_t>{0}, expected, budget);
    } catch (const BadContent& bad) {
        return bad.reason;
    }
    return {};
}

std::string imageRefusal(const std::string& file) {
    const Bytes exact = bytesOf(file);
    ByteBudget budget(kPlenty);
    try {
        decodeImage(exact, budget);
    } catch (const BadContent& bad) {
        return bad.reason;
    }
    return {};
}

// With what a file of a megabyte has to itself.
std::string smallBudgetRefusal(const std::string& file) {
    const auto content = [&] {
        GlbBuilder builder = richGlb();
        builder.root["images"][0] = {{"bufferView", builder.view(file.data(), file.size())}};
        return decode(builder);
    }();
    return content ? "" : content.error().reason;
}

void expectRefused(const std::string& reason, const std::string& words) {
    EXPECT_NE(reason.find(words), std::string::npos) << "\"" << reason << "\", not " << words;
}

// A picture as another library's format; empty where this build cannot write it.
std::string writtenAs(const std::string& format) {
    const Outcome outcome = runConfined([&] {
        const OneFile file("a." + format);
        const std::vector<std::uint8_t> pixels(16 * 16 * 3, 77);
        const auto out = OIIO::ImageOutput::create(format);
        if (!out || !out->open(file.path(), OIIO::ImageSpec(16, 16, 3, OIIO::TypeDesc::UINT8)) ||
            !out->write_image(OIIO::TypeDesc::UINT8, pixels.data()) || !out->close())
            return std::string();
        return contentsOf(file.path());
    });
    return outcome.said;
}

} // namespace

TEST(HostilePictures, Item13DracoHeadersThatClaimMoreThanTheAccessorsAreRefusedUnread) {
    std::string bomb = "DRACO";
    bomb += {2, 2, 1, 0, 0, 0};                       // mesh, sequential
    bomb += {'\xff', '\xff', '\xff', '\xff', '\x0f'}; // 2^32 - 1 faces
    bomb += {'\xff', '\xff', '\xff', '\xff', '\x0f'}; // and points
    bomb += std::string(66, '\0');
    expectRefused(dracoRefusal(bomb, {100, 100}), "claims 4294967295 faces");
    // Accessors that lie along with it meet the memory that is left.
    const std::uint64_t most = std::uint64_t(1) << 32;
    expectRefused(dracoRefusal(bomb, {most, most}), "memory");
    std::string fewPoints = bomb;
    fewPoints.replace(16, 5, std::string("\x64\0\0\0\0", 5));
    expectRefused(dracoRefusal(fewPoints, {100, 100}), "and 100 points where");
    bomb[8] = 1; // edgebreaker
    expectRefused(dracoRefusal(bomb, {100, 100}), "claims");
}

TEST(HostilePictures, Item13FlippedDracoGivesAnErrorOrIndicesInRange) {
    std::mt19937 random(9);
    int decoded = 0;
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        const DracoEncoded encoded = dracoEncode(6, method, 11);
        for (int trial = 0; trial < 3000; ++trial) {
            std::string bad = encoded.bytes;
            for (int k = 0; k < 1 + trial % 3; ++k)
                bad[random() % bad.size()] = char(random());
            ByteBudget budget(kPlenty / 2);
            try {
                const Bytes exact = bytesOf(bad);
                const DracoMesh mesh =
                    decodeDraco(exact, std::vector<std::uint32_t>{encoded.position},
                                {encoded.points, encoded.faces}, budget);
                ++decoded;
                for (const std::uint32_t i : mesh.indices)
                    ASSERT_LT(i, mesh.points);
                ASSERT_EQ(mesh.attributes.at(0).values.size(),
                          std::size_t(mesh.points) * std::size_t(mesh.attributes[0].components));
            } catch (const BadContent&) {
            } catch (const std::exception&) { // bad_alloc, length_error: decodeContent's to catch
            }
        }
    }
    EXPECT_GT(decoded, 50);
}

TEST(HostilePictures, Item14ClaimsBeyondTheLimitAreRefusedUnread) {
    expectRefused(imageRefusal(pngOf(2, 1, 1, "ab", 8193)), "8193 x 1");
    expectRefused(imageRefusal(pngOf(2, 1, 1, "ab", 0x7fffffff)), "pixels");
    expectRefused(imageRefusal(pngOf(2, 1, 1, "ab", 0)), "pixels");
    std::string jpeg = "\xff\xd8\xff\xc0"; // start of frame: 65535 x 65535
    jpeg += std::string("\0\x11\x08\xff\xff\xff\xff\3", 8) + std::string(60, '\1');
    expectRefused(imageRefusal(jpeg), "65535 x 65535");
    const std::string large = pngOf(8000, 8, 1, std::string(64000, 'a'), 8000);
    EXPECT_EQ(imageRefusal(large), ""); // large, but no lie
    std::string tall = large;
    tall[22] = 0x1f; // 8000 rows of which 8 are there
    tall[23] = 0x40;
    EXPECT_NE(imageRefusal(tall), "");
}

TEST(HostilePictures, Item14MoreThan200PixelBytesAByteAreRefusedWhereTheyAreMany) {
    const auto bomb = [](const std::string& name) {
        for (const Bomb& b : bombs())
            if (b.name == name)
                return b.bytes;
        return std::string();
    };
    expectRefused(imageRefusal(bomb("8192 x 8192 zeros")), "in only");
    EXPECT_EQ(imageRefusal(bomb("8192 x 512 zeros")), "") << "16 MB harm nobody";
    expectRefused(imageRefusal(bomb("as many scans as fit")), "scans");
    for (const char* name : {"50 million pixels of 8 bytes, interlaced",
                             "50 million pixels in colour", "50 million pixels"})
        EXPECT_NE(smallBudgetRefusal(bomb(name)), "") << name;
}

TEST(HostilePictures, Item15BytesThatAreNotWhatTheyAreDeclaredAsAreRefused) {
    // The library would open all of these by their content, whatever their name.
    std::size_t written = 0;
    for (const char* format : {"bmp", "tga", "dpx", "iff", "pnm", "tif", "sgi", "ico", "rla", "hdr",
                               "gif", "exr", "targa", "cineon", "softimage"}) {
        const std::string bytes = writtenAs(format);
        if (bytes.empty())
            continue;
        ++written;
        EXPECT_EQ(imageRefusal(bytes), "image is neither PNG, JPEG nor WebP") << format;
        GlbBuilder builder = richGlb();
        builder.root["images"][0] = {{"bufferView", builder.view(bytes.data(), bytes.size())},
                                     {"mimeType", "image/png"}};
        const auto content = decode(builder);
        ASSERT_FALSE(content) << format;
        expectRefused(content.error().reason, "image 0: image is neither");
    }
    EXPECT_GE(written, 8u);
    for (const std::string& other : {std::string("<html><body>Not found</body></html>"),
                                     std::string(), std::string("\x89PNG"), std::string(4, '\0')})
        EXPECT_NE(imageRefusal(other), "") << other;
    // A JPEG that calls itself PNG is a picture all the same.
    const std::string jpeg = encodedPicture("jpeg");
    GlbBuilder builder = richGlb();
    builder.root["images"][0] = {{"bufferView", builder.view(jpeg.data(), jpeg.size())},
                                 {"mimeType", "image/png"}};
    EXPECT_TRUE(decode(builder));
}

TEST(HostilePictures, Item16TruncatedPicturesAndDracoAreErrors) {
    const std::string png = pngOf(4, 4, 4, std::string(64, 'q'));
    for (std::size_t length = 0; length < png.size(); ++length)
        EXPECT_NE(imageRefusal(png.substr(0, length)), "") << length;
    for (const char* format : {"jpeg", "webp"}) {
        const std::string whole = encodedPicture(format);
        ASSERT_EQ(imageRefusal(whole), "") << format;
        // The last bytes may be padding, or a mark that nothing follows.
        for (std::size_t length = 0; length + 2 < whole.size(); ++length)
            EXPECT_NE(imageRefusal(whole.substr(0, length)), "") << format << " " << length;
    }
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
        const DracoEncoded encoded = dracoEncode(5, method, 11);
        for (std::size_t length = 0; length < encoded.bytes.size(); ++length)
            EXPECT_NE(
                dracoRefusal(encoded.bytes.substr(0, length), {encoded.points, encoded.faces}), "")
                << method << " " << length;
    }
}

TEST(HostilePictures, Item16AWrongChecksumIsAnError) {
    std::string png = pngOf(4, 4, 4, std::string(64, 'q'));
    png[60] ^= 1;
    expectRefused(imageRefusal(png), "checksum");
}

} // namespace gnomon::test
