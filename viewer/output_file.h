// Files appear whole or not at all: written beside their place, synced, renamed.
#pragma once

#include "geo/result.h"

#include <cstddef>
#include <span>
#include <string>

namespace gnomon {

// A device, pipe or socket that is already there is written to directly.
Failure writeFile(const std::string& path, std::span<const std::byte> bytes);
Failure writeFile(const std::string& path, const std::string& text);

// For a writer of its own (a video): a name in the same folder, not there yet.
std::string temporaryNameFor(const std::string& path);
// Sync and rename. The temporary file is gone afterwards in any case.
Failure finishFile(const std::string& temporary, const std::string& path);

// Tells before the work is done whether a file can be made there at all.
Failure checkWritable(const std::string& path);

} // namespace gnomon
