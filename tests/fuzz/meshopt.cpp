// A buffer view that meshoptimizer compressed: mode and filter, stride / 4, count, its bytes.
#include "tests/fuzz/fuzz.h"

#include "streaming/meshopt.h"

#include <array>

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    constexpr std::size_t kHead = 4;
    if (bytes.size() < kHead)
        return;
    static const std::array<const char*, 4> kModes{"ATTRIBUTES", "TRIANGLES", "INDICES", "OTHER"};
    static const std::array<const char*, 5> kFilters{"", "NONE", "OCTAHEDRAL", "QUATERNION",
                                                     "EXPONENTIAL"};
    const auto byte = [&](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); };
    MeshoptView view;
    view.mode = kModes[byte(0) % kModes.size()];
    view.filter = kFilters[byte(0) / 16 % kFilters.size()];
    view.strideBytes = byte(1);
    view.count = byte(2) | byte(3) << 8;
    // A copy, so that reading beyond the end is reading beyond an allocation.
    const std::vector<std::byte> exact(bytes.begin() + kHead, bytes.end());
    view.bytes = exact;
    catchBadContent([&] {
        ByteBudget budget(std::uint64_t(64) << 20);
        const Bytes out = decodeMeshopt(view, budget);
        demand(out.size() == view.count * view.strideBytes, "all the view's bytes");
    });
}

} // namespace gnomon::fuzz
