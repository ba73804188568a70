// How fast each format is decoded on one core: from a file's bytes to meshes as the GPU takes them,
// with all that is checked, welded, wound and cut on the way.
#pragma once

#include "geo/result.h"

#include <optional>
#include <string>
#include <vector>

namespace gnomon::bench {

struct DecodeRow {
    std::string format, from; // "made", or the data's folder
    std::size_t files = 0, bytes = 0;
    std::uint64_t triangles = 0;
    double milliseconds = 0; // of the processor's time for all of them, the median run

    double megabytesPerSecond() const {
        return milliseconds ? double(bytes) / 1e3 / milliseconds : 0;
    }
    double trianglesPerSecond() const {
        return milliseconds ? double(triangles) * 1e3 / milliseconds : 0;
    }
};

// Of made tiles, and of those in `data` (GNOMON_DATA's folder) as far as it has them.
// `scratchFolder` holds what has to be a file.
Result<std::vector<DecodeRow>> measureDecoding(const std::optional<std::string>& data,
                                               const std::string& scratchFolder, int runs);

} // namespace gnomon::bench
