#include "streaming/image.h"

#include "glb_builder.h"

#include <gtest/gtest.h>

#include <random>

namespace gnomon {

using namespace test;

namespace {

constexpr std::uint64_t kPlenty = std::uint64_t(512) << 20;

std::string reasonOf(const std::string& file) {
    ByteBudget budget(kPlenty);
    const Bytes bytes = bytesOf(file);
    try {
        decodeImage(bytes, budget);
    } catch (const BadContent& bad) {
        return bad.reason;
    }
    return {};
}

Image imageOf(const std::string& file) {
    ByteBudget budget(kPlenty);
    const Bytes bytes = bytesOf(file);
    return decodeImage(bytes, budget);
}

// The JPEG in a Mars tile; nothing when the data is not here.
std::string marsJpeg() {
    const auto tile = readData("tiles-mars-terrain-replace/root.b3dm");
    const std::size_t start = tile ? tile->find("\xff\xd8\xff") : std::string::npos;
    if (start == std::string::npos) {
        return {};
    }
    const std::size_t end = tile->rfind("\xff\xd9");
    return tile->substr(start, end + 2 - start);
}

} // namespace

TEST(ImageFile, PngOfOneToFourChannelsBecomesRgba) {
    using Rgba = std::vector<std::uint8_t>;
    EXPECT_EQ(imageOf(pngOf(2, 1, 1, "ab")).rgba, (Rgba{'a', 'a', 'a', 255, 'b', 'b', 'b', 255}));
    EXPECT_EQ(imageOf(pngOf(1, 2, 2, "abcd")).rgba, (Rgba{'a', 'a', 'a', 'b', 'c', 'c', 'c', 'd'}));
    EXPECT_EQ(imageOf(pngOf(2, 1, 3, "abcdef")).rgba,
              (Rgba{'a', 'b', 'c', 255, 'd', 'e', 'f', 255}));
    // Alpha stays apart from the colours.
    EXPECT_EQ(imageOf(pngOf(1, 1, 4, std::string("\xf0\x10\x20\x40", 4))).rgba,
              (Rgba{0xf0, 0x10, 0x20, 0x40}));
}

// Every picture of one colour, lossless: five codes of one symbol each (green, red, blue, alpha,
// distance), and then no bits at all for the pixels.
std::string webpOf(int width, int height, std::array<std::uint8_t, 4> rgba, bool hasAlpha) {
    std::string image = "\x2f";
    put(image,
        std::uint32_t(width - 1) | std::uint32_t(height - 1) << 14 | (hasAlpha ? 1u << 28 : 0u));
    std::vector<bool> bits{false, false, false}; // no transform, no cache, no further codes
    for (const unsigned symbol :
         {unsigned(rgba[1]), unsigned(rgba[0]), unsigned(rgba[2]), unsigned(rgba[3]), 0u}) {
        bits.insert(bits.end(), {true, false, true}); // simple, of one symbol, of eight bits
        for (int i = 0; i < 8; ++i)
            bits.push_back((symbol >> i & 1u) != 0);
    }
    for (std::size_t i = 0; i < bits.size(); i += 8) {
        unsigned byte = 0;
        for (std::size_t k = 0; k < 8 && i + k < bits.size(); ++k)
            byte |= unsigned(bits[i + k]) << k;
        image.push_back(char(byte));
    }
    image.resize((image.size() + 1) / 2 * 2 + 2); // what the decoder reads ahead
    std::string out = "RIFF";
    put(out, std::uint32_t(4 + 8 + image.size()));
    out += "WEBPVP8L";
    put(out, std::uint32_t(image.size()));
    return out + image;
}

TEST(ImageFile, ColoursOfWebpAreNotMultipliedByTheirAlpha) {
    using Rgba = std::vector<std::uint8_t>;
    EXPECT_EQ(imageOf(webpOf(2, 1, {200, 100, 50, 128}, true)).rgba,
              (Rgba{200, 100, 50, 128, 200, 100, 50, 128}));
    EXPECT_EQ(imageOf(webpOf(1, 2, {200, 100, 50, 0}, true)).rgba,
              (Rgba{200, 100, 50, 0, 200, 100, 50, 0}));
    const Image opaque = imageOf(webpOf(1, 2, {200, 100, 50, 255}, false));
    EXPECT_EQ(opaque.height, 2);
    EXPECT_EQ(opaque.rgba, (Rgba{200, 100, 50, 255, 200, 100, 50, 255}));
}

TEST(ImageFile, WebpIsLookedAtBeforeAnythingIsAllocated) {
    const std::string good = webpOf(2048, 2048, {1, 2, 3, 4}, true);
    EXPECT_EQ(reasonOf(good), "");
    EXPECT_EQ(reasonOf(webpOf(8193, 1, {1, 2, 3, 4}, true)),
              "image of 8193 x 1 pixels; 1 to 8192 a side are read");
    EXPECT_NE(reasonOf(webpOf(8192, 8192, {1, 2, 3, 4}, true)).find("in only"), std::string::npos);
    const Bytes bytes = bytesOf(good);
    ByteBudget little(std::uint64_t(2048) * 2048 * 8); // the pixels, and the decoder's own
    EXPECT_THROW(decodeImage(bytes, little), BadContent);
}

TEST(ImageFile, WebpThatIsCutShortBadOrAnimatedIsNamed) {
    const std::string good = webpOf(8, 8, {1, 2, 3, 4}, true);
    ASSERT_EQ(reasonOf(good), "");
    for (std::size_t length = 12; length < good.size(); ++length)
        EXPECT_EQ(reasonOf(good.substr(0, length)), "WebP image cut short") << length;
    std::string bad = good;
    bad[20] = 'x'; // the lossless image's mark
    EXPECT_NE(reasonOf(bad).find("WebP image"), std::string::npos);
    bad = good;
    bad[25] = '\xff'; // transforms, which are not there
    EXPECT_NE(reasonOf(bad).find("WebP image"), std::string::npos);
    std::string animated = "RIFF";
    put(animated, 4 + 18 + 14);
    animated += "WEBPVP8X";
    put(animated, 10);
    animated += std::string("\x02\0\0\0\7\0\0\7\0\0", 10) + "ANIM";
    put(animated, 6);
    animated += std::string(6, '\0');
    EXPECT_EQ(reasonOf(animated), "animated WebP image, which is not supported");
}

TEST(ImageFile, RowsGoFromTopToBottom) {
    const Image image = imageOf(pngOf(1, 3, 1, "xyz"));
    EXPECT_EQ(image.width, 1);
    EXPECT_EQ(image.height, 3);
    EXPECT_EQ(image.rgba[0], 'x');
    EXPECT_EQ(image.rgba[8], 'z');
}

TEST(ImageFile, TheFirstBytesDecideWhatItIs) {
    const auto sniff = [](const std::string& text) { return sniffImage(bytesOf(text)); };
    EXPECT_EQ(sniff(pngOf(1, 1, 1, "a")), ImageFormat::Png);
    EXPECT_EQ(sniff("\xff\xd8\xff\xe0"), ImageFormat::Jpeg);
    EXPECT_EQ(sniff("RIFF....WEBP"), ImageFormat::Webp);
    EXPECT_EQ(sniff(""), ImageFormat::Unknown);
    for (const char* other : {"SDPX", "GIF89a", "BM", "II*", "#?RADIANCE", "FORM"}) {
        EXPECT_EQ(reasonOf(other + std::string(200, 'x')), "image is neither PNG, JPEG nor WebP");
    }
}

TEST(ImageFile, ChunksThatArePaintedOverAreLeftOut) {
    std::string png = pngOf(1, 1, 1, "a");
    png.insert(33, pngChunk("iCCP", "a profile that is no profile")); // libpng would complain
    testing::internal::CaptureStderr();
    EXPECT_EQ(imageOf(png).rgba[0], 'a');
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ImageFile, JpegIsRead) {
    const std::string jpeg = marsJpeg();
    if (jpeg.empty()) {
        GTEST_SKIP() << "tiles-mars-terrain-replace is not here";
    }
    const Image image = imageOf(jpeg);
    EXPECT_EQ(image.width, 256);
    EXPECT_EQ(image.height, 256);
    double sum = 0.0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        sum += image.rgba[i];
        ASSERT_EQ(image.rgba[i + 3], 255);
    }
    EXPECT_GT(sum / (256 * 256), 20.0); // there is something on it
    EXPECT_NE(reasonOf(jpeg.substr(0, jpeg.size() / 2)), "");
}

TEST(ImageFile, FlippedBytesNeverCrashNorPrint) {
    const std::string jpeg = marsJpeg();
    std::mt19937 random(17);
    testing::internal::CaptureStderr();
    for (const std::string& good : {jpeg, pngOf(16, 16, 3, std::string(768, 'k'))}) {
        for (int trial = 0; trial < 300 && !good.empty(); ++trial) {
            std::string bad = good;
            for (int k = 0; k < 3; ++k) {
                bad[random() % bad.size()] = char(random());
            }
            reasonOf(bad);
        }
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

} // namespace gnomon
