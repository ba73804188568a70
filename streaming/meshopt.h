// EXT_meshopt_compression (and KHR_meshopt_compression where it says the same): buffer views that
// are kept compressed. The counts are checked before anything is allocated, as the library writes
// what it was told to expect; the indices that come out are checked where they are used, as all
// indices are.
#pragma once

#include "streaming/soup.h"
#include "streaming/source.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace gnomon {

struct MeshoptView {
    std::span<const std::byte> bytes; // compressed
    std::uint64_t count = 0, strideBytes = 0;
    std::string mode;   // ATTRIBUTES, TRIANGLES, INDICES
    std::string filter; // empty: NONE
};

// The view's `count * strideBytes` bytes. Throws BadContent.
Bytes decodeMeshopt(const MeshoptView& view, ByteBudget& budget);

} // namespace gnomon
