// What every decoder's work is held against before anybody else sees it: that a content keeps what
// mesh.h promises. The GPU and the rays index with these numbers unchecked.
#pragma once

#include "streaming/mesh.h"

#include <optional>
#include <string>

namespace gnomon {

// The first promise that is broken, in one line; none when all are kept.
std::optional<std::string> brokenPromise(const TileContent& content);

} // namespace gnomon
