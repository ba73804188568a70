// Files that are compressed with gzip though nothing says so, as tiles of terrain are on many a
// disk.
#pragma once

#include "streaming/source.h"

#include <span>

namespace gnomon {

bool isGzip(std::span<const std::byte> bytes);
// What is in it. Fails for more than `mostBytes`, and for what is cut short or corrupt.
Result<Bytes> gunzip(std::span<const std::byte> bytes, std::size_t mostBytes,
                     const std::string& name);

} // namespace gnomon
