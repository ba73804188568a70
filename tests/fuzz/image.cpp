// PNG, JPEG and WebP.
#include "tests/fuzz/fuzz.h"

#include "streaming/image.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    const ImageFormat format = sniffImage(bytes);
    catchBadContent([&] {
        constexpr std::uint64_t kMost = std::uint64_t(64) << 20;
        ByteBudget budget(kMost);
        const Image image = decodeImage(bytes, budget);
        demand(format == ImageFormat::Png || format == ImageFormat::Jpeg ||
                   format == ImageFormat::Webp,
               "only what the first bytes say is read");
        demand(image.width >= 1 && image.height >= 1 && image.width <= kMaxImageSide &&
                   image.height <= kMaxImageSide,
               "an image has a size");
        const std::uint64_t pixels = std::uint64_t(image.width) * std::uint64_t(image.height);
        demand(image.rgba.size() == pixels * 4, "an image has its pixels");
        demand(kMost - budget.left() >= pixels * 4, "pixels are taken from the budget");
    });
}

} // namespace gnomon::fuzz
