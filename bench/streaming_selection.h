// How long selection takes a tile it looks at, by the size of the tree and the kind of volumes.
#pragma once

#include "bench/streaming_tree.h"

#include <cstdint>

namespace gnomon::bench {

struct SelectionRow {
    std::size_t tiles = 0; // in the tree
    VolumeKind kind = VolumeKind::Boxes;
    std::string view;
    std::uint32_t visited = 0;
    std::size_t drawn = 0;
    double frameMicroseconds = 0; // of the processor's time, the median run
    double tileMicroseconds() const { return visited ? frameMicroseconds / visited : 0.0; }
};

// The first runs fill the caches and are not counted, as in a flight.
Result<std::vector<SelectionRow>> measureSelection(std::size_t tiles, VolumeKind kind, int runs);

// Time this thread has had a processor, in microseconds: what others do at the same time is not in
// it.
double threadMicroseconds();
double median(std::vector<double> values); // 0 of none

} // namespace gnomon::bench
