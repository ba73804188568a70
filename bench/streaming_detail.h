// From the start of the program to a picture with all its tiles: over local files and over loopback
// HTTP, each run a process of its own, so that its peak of memory is its own too.
#pragma once

#include "geo/result.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gnomon::bench {

struct DetailInput {
    std::string gnomon;                // the program
    std::optional<std::string> server; // tests' fault_server; none: files only
    std::string folder;                // with a tileset.json
    std::string camera;                // as --camera takes it
    std::vector<std::string> options;  // further ones of gnomon capture
    std::string scratchFolder;
    int runs = 3;
};

struct DetailRow {
    std::string from; // "files", "loopback"
    double fullDetailMs = 0;
    std::uint64_t selected = 0, loaded = 0; // tiles, of the camera and of the casters
    double peakMegabytes = 0;               // resident, 10^6 bytes

    double loadedPerSelected() const { return selected ? double(loaded) / double(selected) : 0.0; }
};

// The medians of the runs. Fails when a picture is not complete.
Result<std::vector<DetailRow>> measureDetail(const DetailInput& input);

} // namespace gnomon::bench
