// Pictures to files. The same picture gives the same bytes.
#pragma once

#include "viewer/frame.h"

#include <string>

namespace gnomon {

enum class ImageFormat { Png, Jpeg };

Failure writeImage(const Picture& picture, ImageFormat format, const std::string& path);
// EXR with 32-bit floats, losslessly packed. `channelNames`: a letter a channel, "Y" or "XYZ".
Failure writeExr(const FloatPicture& picture, const std::string& channelNames,
                 const std::string& path);
// One 8-bit channel; values are rounded and clamped to 0…255.
Failure writeGreyPng(const FloatPicture& picture, const std::string& path);

} // namespace gnomon
