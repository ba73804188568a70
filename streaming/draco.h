// KHR_draco_mesh_compression and 3DTILES_draco_point_compression: one Draco buffer to indices and
// raw attribute values.
//
// The library believes the counts in its header (87 bytes may ask for 8 GB), makes room for as many
// attributes as are described and hands out indices it never checked. So the header is read here
// first, the attributes' values are asked of the budget once they are described, and every index is
// checked afterwards.
#pragma once

#include "streaming/soup.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon {

struct DracoAttribute {
    int components = 0;
    // Largest value of the integer type it is stored in (255 for unsigned bytes); 0 for floats.
    double integerMax = 0.0;
    bool isSigned = false;
    std::vector<double> values; // `components` a point, not normalised
};

struct DracoMesh {
    std::uint32_t points = 0;
    std::vector<std::uint32_t> indices;
    std::vector<DracoAttribute> attributes; // in the order asked for
};

// What the glTF accessors announce.
struct DracoExpectation {
    std::uint64_t points = 0;
    std::uint64_t faces = 0;
};

// `uniqueIds` are the attributes wanted. Throws BadContent.
DracoMesh decodeDraco(std::span<const std::byte> bytes, std::span<const std::uint32_t> uniqueIds,
                      const DracoExpectation& expected, ByteBudget& budget);

// A cloud of exactly `points`; without indices. Throws BadContent.
DracoMesh decodeDracoPoints(std::span<const std::byte> bytes,
                            std::span<const std::uint32_t> uniqueIds, std::uint32_t points,
                            ByteBudget& budget);

} // namespace gnomon
