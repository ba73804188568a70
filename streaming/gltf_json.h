// What of a glTF's JSON tinygltf is to read: no buffers, no images, nothing that nobody would look
// up in its model. It turns three bytes of text into hundreds of its own, so what is left is
// counted against the budget before it sees any of it.
#pragma once

#include "streaming/soup.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>

namespace gnomon {

// The most that a parsed document takes for a character of its text ("{},{},{}").
inline constexpr std::uint64_t kBytesPerJsonCharacter = 32;

// Moves what it keeps out of `root`. Throws BadContent.
std::string jsonForModel(nlohmann::json& root, ByteBudget& budget);

} // namespace gnomon
