// SHA-256 (FIPS 180-4): names for what the cache holds, since addresses may have keys in them that
// must not lie on a disk, and nobody may make two addresses with one name.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace gnomon {

using Digest = std::array<std::uint8_t, 32>;

Digest sha256(std::string_view text);

} // namespace gnomon
