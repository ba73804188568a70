// A fuzz target is one file that defines fuzzOne(): it hands hostile bytes to one reader and holds
// what comes back against what the reader promises, so that a wrong answer is found like a crash.
//
// Built with GNOMON_FUZZ the targets are libFuzzer programs; else a plain main() plays the files
// under corpus/<target>/ through them, in which every finding is kept (tests.cmake).
#pragma once

#include "geo/bounds.h"
#include "geo/result.h"
#include "streaming/soup.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon::fuzz {

using Span = std::span<const std::byte>;

// Must come back, whatever the bytes are.
void fuzzOne(Span bytes);

inline void demand(bool holds, const char* what) {
    if (!holds) {
        std::fprintf(stderr, "broken promise: %s\n", what);
        std::abort();
    }
}

inline bool isPlainLine(std::string_view text) {
    return std::none_of(text.begin(), text.end(),
                        [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

// One line that says something, short enough to be read.
inline void demandReadable(const std::string& message) {
    if (!isPlainLine(message) || message.empty() || message.size() > 4096) {
        std::fprintf(stderr, "message: <%s>\n", message.substr(0, 8192).c_str());
        demand(false, "a message is one readable line");
    }
}
inline void demandReadable(const Error& error) {
    demandReadable(error.message());
    demandReadable(error.reason);
}

// For readers whose errors are thrown inside streaming/: nothing else may come out.
template <class Read>
void catchBadContent(const Read& read) {
    try {
        read();
    } catch (const BadContent& bad) {
        demandReadable(bad.reason);
    }
}

inline bool isFinite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool isFinite(const OrientedBox& box) {
    return isFinite(box.centre.xyz) && isFinite(box.halfAxes[0]) && isFinite(box.halfAxes[1]) &&
           isFinite(box.halfAxes[2]);
}

inline bool isSound(const BoundingVolume& volume) {
    if (const auto* sphere = std::get_if<Sphere>(&volume))
        return isFinite(sphere->centre.xyz) && std::isfinite(sphere->radiusMetres) &&
               sphere->radiusMetres >= 0.0;
    if (const auto* box = std::get_if<OrientedBox>(&volume))
        return isFinite(*box);
    const auto& region = std::get<Region>(volume);
    return isFinite(region.box) && std::abs(region.southDegrees) <= 90.0 &&
           std::abs(region.northDegrees) <= 90.0 && region.southDegrees <= region.northDegrees &&
           std::isfinite(region.westDegrees) && std::isfinite(region.eastDegrees) &&
           std::isfinite(region.minHeightMetres) && std::isfinite(region.maxHeightMetres) &&
           region.minHeightMetres <= region.maxHeightMetres;
}

inline std::string_view textOf(Span bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline Span bytesOf(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

// What stands between zero bytes, which no text has: several files in one input.
inline std::vector<Span> partsOf(Span bytes) {
    std::vector<Span> parts;
    for (;;) {
        const auto zero = std::find(bytes.begin(), bytes.end(), std::byte(0));
        const auto length = std::size_t(zero - bytes.begin());
        parts.push_back(bytes.first(length));
        if (zero == bytes.end())
            return parts;
        bytes = bytes.subspan(length + 1);
    }
}

// A path inside a source: nothing in it leads out.
inline bool staysInside(std::string_view path) {
    if (path.empty() || path.front() == '/' || !isPlainLine(path))
        return false;
    while (!path.empty()) {
        const std::size_t slash = std::min(path.find('/'), path.size());
        const std::string_view segment = path.substr(0, slash);
        if (segment.empty() || segment == "." || segment == "..")
            return false;
        path.remove_prefix(std::min(slash + 1, path.size()));
    }
    return true;
}

} // namespace gnomon::fuzz
