// Pictures to files. The same picture gives the same bytes.
#pragma once

#include "viewer/frame.h"

#include <optional>
#include <string>

namespace gnomon {

enum class ImageFormat { Png, Jpeg };

// `description` goes into the file, for those who look there; readDescription gives it back.
Failure writeImage(const Picture& picture, ImageFormat format, const std::string& path,
                   const std::string& description = {});
// Nothing when the file is not there, is no whole picture, or has none.
std::optional<std::string> readDescription(ImageFormat format, const std::string& path);
// EXR with 32-bit floats, losslessly packed. `channelNames`: a letter a channel, "Y" or "XYZ".
Failure writeExr(const FloatPicture& picture, const std::string& channelNames,
                 const std::string& path);
// One 8-bit channel; values are rounded and clamped to 0…255.
Failure writeGreyPng(const FloatPicture& picture, const std::string& path);

} // namespace gnomon
