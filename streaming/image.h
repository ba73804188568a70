// PNG, JPEG and WebP from memory to 8-bit RGBA. The first bytes decide what it is, not a name or a
// declared type, and the size is read from them before anything is allocated or a library sees
// them.
#pragma once

#include "streaming/soup.h"

#include <cstddef>
#include <span>

namespace gnomon {

inline constexpr int kMaxImageSide = 8192;

enum class ImageFormat { Unknown, Png, Jpeg, Webp, Ktx2 };
ImageFormat sniffImage(std::span<const std::byte> bytes);

// Throws BadContent.
Image decodeImage(std::span<const std::byte> bytes, ByteBudget& budget);

} // namespace gnomon
