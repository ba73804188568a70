// Files that are compressed with gzip though nothing says so, as tiles of terrain are on many a
// disk.
#pragma once

#include "streaming/source.h"

#include <cstdint>
#include <span>

namespace gnomon {

bool isGzip(std::span<const std::byte> bytes);
// What a tile of so many bytes may grow to: no honest one is packed tighter.
constexpr std::uint64_t mostUnpackedBytes(std::size_t packedBytes) {
    return (std::uint64_t(32) << 20) + std::uint64_t(64) * packedBytes;
}
// What is in it. Fails for more than `mostBytes`, and for what is cut short or corrupt.
Result<Bytes> gunzip(std::span<const std::byte> bytes, std::size_t mostBytes,
                     const std::string& name);

} // namespace gnomon
