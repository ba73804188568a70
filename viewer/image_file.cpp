#include "viewer/image_file.h"

#include "viewer/output_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace gnomon {

namespace {

// Encoded in memory and written by us: so that a full disk is noticed whatever the encoder does
// with errors.
Failure encode(const char* plugin, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
               const void* pixels, const std::string& path) {
    const auto failed = [&](const std::string& why) {
        return Error{path, "cannot be encoded: " + why, ErrorKind::Output};
    };
    const auto output = OIIO::ImageOutput::create(plugin);
    if (!output)
        return failed(OIIO::geterror());
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    if (!output->set_ioproxy(&memory))
        return failed(std::string(plugin) + " cannot be written to memory");
    // The name only tells the plugin its own kind.
    const std::string name = std::string("picture.") + plugin;
    if (!output->open(name, spec) || !output->write_image(type, pixels) || !output->close())
        return failed(output->geterror());
    return writeFile(path, std::as_bytes(std::span(bytes)));
}

const char* pluginOf(ImageFormat format) {
    return format == ImageFormat::Png ? "png" : "jpeg";
}

// What was cut short (our own pictures never are, their copies may be) lacks its last mark.
bool endsWhole(ImageFormat format, const std::string& path) {
    using namespace std::string_literals;
    const std::string mark =
        format == ImageFormat::Png ? "\0\0\0\0IEND\xAE\x42\x60\x82"s : "\xFF\xD9"s;
    std::ifstream file(path, std::ios::binary);
    std::string end(mark.size(), '\0');
    file.seekg(-std::streamoff(mark.size()), std::ios::end);
    return file.read(end.data(), std::streamsize(end.size())) && end == mark;
}

bool isWhole(int width, int height, int channels, std::size_t values) {
    return width > 0 && height > 0 && values == std::size_t(width) * height * channels;
}

} // namespace

Failure writeImage(const Picture& picture, ImageFormat format, const std::string& path,
                   const std::string& description) {
    if (!isWhole(picture.width, picture.height, 3, picture.rgb.size()))
        return Error{path, "there is no picture to write", ErrorKind::Output};
    OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    if (format == ImageFormat::Jpeg)
        spec.attribute("Compression", "jpeg:95");
    if (!description.empty())
        spec.attribute("ImageDescription", description);
    return encode(pluginOf(format), spec, OIIO::TypeDesc::UINT8, picture.rgb.data(), path);
}

std::optional<std::string> readDescription(ImageFormat format, const std::string& path) {
    const auto input = OIIO::ImageInput::create(pluginOf(format));
    OIIO::ImageSpec spec;
    if (!input || !input->open(path, spec)) {
        OIIO::geterror(); // taken, or it is printed at the end
        return {};
    }
    const std::string description = spec.get_string_attribute("ImageDescription");
    if (description.empty() || !endsWhole(format, path))
        return {};
    return description;
}

Failure writeExr(const FloatPicture& picture, const std::string& channelNames,
                 const std::string& path) {
    if (!isWhole(picture.width, picture.height, picture.channels, picture.values.size()) ||
        int(channelNames.size()) != picture.channels)
        return Error{path, "there is no picture to write", ErrorKind::Output};
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::FLOAT);
    for (int c = 0; c < picture.channels; ++c)
        spec.channelnames[std::size_t(c)] = channelNames.substr(std::size_t(c), 1);
    spec.attribute("compression", "zip");
    // The plugin would write the time of day otherwise, and no two files were the same.
    spec.attribute("DateTime", "1970:01:01 00:00:00");
    return encode("openexr", spec, OIIO::TypeDesc::FLOAT, picture.values.data(), path);
}

Failure writeGreyPng(const FloatPicture& picture, const std::string& path) {
    if (!isWhole(picture.width, picture.height, 1, picture.values.size()))
        return Error{path, "there is no picture to write", ErrorKind::Output};
    std::vector<std::uint8_t> grey(picture.values.size());
    std::transform(picture.values.begin(), picture.values.end(), grey.begin(), [](float value) {
        return std::uint8_t(std::lround(std::clamp(value, 0.0f, 255.0f)));
    });
    OIIO::ImageSpec spec(picture.width, picture.height, 1, OIIO::TypeDesc::UINT8);
    return encode("png", spec, OIIO::TypeDesc::UINT8, grey.data(), path);
}

} // namespace gnomon
