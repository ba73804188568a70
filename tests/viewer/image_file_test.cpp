#include "tests/viewer/files.h"
#include "viewer/image_file.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

using namespace gnomon;

namespace {

Picture gradient(int width, int height) {
    Picture picture{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (const int value : {x * 255 / width, y * 255 / height, (x ^ y) & 255})
                picture.rgb.push_back(std::uint8_t(value));
    return picture;
}

struct ReadBack {
    OIIO::ImageSpec spec;
    std::vector<float> floats;
    std::vector<std::uint8_t> bytes;
};

ReadBack readBack(const char* plugin, const std::string& path) {
    ReadBack back;
    const auto input = OIIO::ImageInput::create(plugin);
    EXPECT_TRUE(input && input->open(path, back.spec)) << path;
    const std::size_t count = std::size_t(back.spec.width) * back.spec.height * back.spec.nchannels;
    back.floats.resize(count);
    back.bytes.resize(count);
    if (back.spec.format == OIIO::TypeDesc::UINT8)
        EXPECT_TRUE(input->read_image(0, 0, 0, back.spec.nchannels, OIIO::TypeDesc::UINT8,
                                      back.bytes.data()));
    else
        EXPECT_TRUE(input->read_image(0, 0, 0, back.spec.nchannels, OIIO::TypeDesc::FLOAT,
                                      back.floats.data()));
    return back;
}

} // namespace

TEST(ImageFile, PngIsReadBackToTheLastBit) {
    const test::Folder folder;
    const Picture picture = gradient(37, 23);
    ASSERT_FALSE(writeImage(picture, ImageFormat::Png, folder / "a.png"));
    const ReadBack back = readBack("png", folder / "a.png");
    EXPECT_EQ(back.spec.width, 37);
    EXPECT_EQ(back.spec.height, 23);
    EXPECT_EQ(back.spec.nchannels, 3);
    EXPECT_EQ(back.bytes, picture.rgb);
}

TEST(ImageFile, TheSamePictureGivesTheSameBytesASecondLater) {
    const test::Folder folder;
    const Picture picture = gradient(64, 64);
    const FloatPicture depth{8, 8, 1, std::vector<float>(64, 0.25f)};
    const auto writeAll = [&](const std::string& name) {
        EXPECT_FALSE(writeImage(picture, ImageFormat::Png, folder / (name + ".png")));
        EXPECT_FALSE(writeImage(picture, ImageFormat::Jpeg, folder / (name + ".jpg")));
        EXPECT_FALSE(writeExr(depth, "Y", folder / (name + ".exr")));
    };
    writeAll("a");
    std::this_thread::sleep_for(std::chrono::milliseconds(1100)); // dates have seconds
    writeAll("b");
    for (const char* ending : {".png", ".jpg", ".exr"})
        EXPECT_EQ(test::contentsOf(folder / ("a" + std::string(ending))),
                  test::contentsOf(folder / ("b" + std::string(ending))))
            << ending;
}

TEST(ImageFile, ExrKeepsEveryFloatInfinityIncluded) {
    const test::Folder folder;
    FloatPicture depth{
        3, 2, 1, {0.0f, 1e-30f, 123.456f, 1e30f, -1.0f, std::numeric_limits<float>::infinity()}};
    ASSERT_FALSE(writeExr(depth, "Y", folder / "d.exr"));
    const ReadBack back = readBack("openexr", folder / "d.exr");
    EXPECT_EQ(back.spec.format, OIIO::TypeDesc::FLOAT);
    EXPECT_EQ(back.spec.nchannels, 1);
    EXPECT_EQ(back.floats, depth.values);
    FloatPicture normal{2, 1, 3, {1, 2, 3, 4, 5, 6}};
    ASSERT_FALSE(writeExr(normal, "XYZ", folder / "n.exr"));
    const ReadBack normals = readBack("openexr", folder / "n.exr");
    EXPECT_EQ(normals.spec.channelnames, (std::vector<std::string>{"X", "Y", "Z"}));
    EXPECT_EQ(normals.floats, normal.values);
}

TEST(ImageFile, CascadesAreEightBitNumbers) {
    const test::Folder folder;
    ASSERT_FALSE(writeGreyPng({4, 1, 1, {0, 1, 4, 255}}, folder / "c.png"));
    const ReadBack back = readBack("png", folder / "c.png");
    EXPECT_EQ(back.spec.nchannels, 1);
    EXPECT_EQ(back.bytes, (std::vector<std::uint8_t>{0, 1, 4, 255}));
}

TEST(ImageFile, TheNameIsNoFormat) {
    const test::Folder folder;
    ASSERT_FALSE(writeImage(gradient(4, 4), ImageFormat::Png, folder / "odd name.dpx"));
    EXPECT_TRUE(test::contentsOf(folder / "odd name.dpx").starts_with("\x89PNG"));
}

TEST(ImageFile, WhatCannotBeWrittenIsAnOutputError) {
    const Failure failure = writeImage(gradient(4, 4), ImageFormat::Png, "/nowhere/a.png");
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->kind, ErrorKind::Output);
    EXPECT_TRUE(writeImage({}, ImageFormat::Png, "/nowhere/a.png"));
}

TEST(ImageFile, KeepsItsDescriptionBesideThePicture) {
    const test::Folder folder;
    const Picture picture = gradient(37, 23);
    for (const auto& [format, plugin] :
         {std::pair{ImageFormat::Png, "png"}, {ImageFormat::Jpeg, "jpeg"}}) {
        const std::string plain = folder / plugin, described = plain + ".described";
        ASSERT_FALSE(writeImage(picture, format, plain));
        ASSERT_FALSE(writeImage(picture, format, described, "gnomon, settings 01ab"));
        EXPECT_EQ(readDescription(format, described), "gnomon, settings 01ab");
        EXPECT_EQ(readDescription(format, plain), std::nullopt);
        EXPECT_EQ(readBack(plugin, described).bytes, readBack(plugin, plain).bytes);
    }
    EXPECT_EQ(readDescription(ImageFormat::Png, folder / "not there"), std::nullopt);
    EXPECT_EQ(readDescription(ImageFormat::Png, folder.write("text", "no png")), std::nullopt);
}

TEST(ImageFile, APictureCutShortHasNoDescription) {
    const test::Folder folder;
    for (const ImageFormat format : {ImageFormat::Png, ImageFormat::Jpeg}) {
        ASSERT_FALSE(writeImage(gradient(370, 230), format, folder / "a", "whole"));
        const std::string bytes = test::contentsOf(folder / "a");
        for (const std::size_t kept : {bytes.size() / 2, bytes.size() - 1})
            EXPECT_EQ(readDescription(format, folder.write("b", bytes.substr(0, kept))),
                      std::nullopt)
                << kept;
    }
}
